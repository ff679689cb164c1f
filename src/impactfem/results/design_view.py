"""What tables and figures ask of `design.nc`: sets of floor spectra with their labels."""

from __future__ import annotations

import json
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.results.store_view import StoreView
from impactfem.spectra.product import FloorSpectrumSet, Station

Array = NDArray[np.float64]


class DesignView(StoreView):
    """A store of the stage `design`.

    Args:
        store: The open store.
    """

    def __init__(self, store: xr.Dataset) -> None:
        super().__init__(store)
        self.direction = str(store.attrs["shown_direction"])
        self.title = str(store.attrs["title"])
        self.inputs = str(store.attrs["inputs"])

    @cached_property
    def stations(self) -> tuple[Station, ...]:
        """The floors."""
        store = self.store
        rows = zip(
            store["station_floor"].values,
            store["station_points"].values,
            store["elevation"].values,
            strict=True,
        )
        return tuple(
            Station(self.building, str(floor), tuple(str(points).split(", ")), float(z))
            for floor, points, z in rows
        )

    @property
    def directions(self) -> tuple[str, ...]:
        """Directions in which something moves."""
        return tuple(str(name) for name in self.store["direction"].values)

    @property
    def method(self) -> str:
        """How the spectra were computed, in words."""
        highest = float(self.store.attrs["maximum_frequency"])
        text = (
            "pseudo-acceleration of oscillators at points of the floor, envelope of the points; "
            "3D model of shells and beams under ground motion and impact forces, meant up to "
            f"{highest:g} Hz"
        )
        elsewhere = json.loads(self.store.attrs["elsewhere"])
        if elsewhere:
            text += f"; on no floor: {', '.join(elsewhere)}"
        if "whole_psa" in self.store:
            text += "; tables/design_coverage.csv has the envelope of all vertices of the floor"
        return text

    @cached_property
    def case(self) -> FloorSpectrumSet:
        """The spectra under the case's own motion."""
        return self._set("psa", "zpa", ("that of the case",))

    @cached_property
    def members(self) -> FloorSpectrumSet | None:
        """Those of the members of an ensemble; None without one."""
        if "member_psa" not in self.store:
            return None
        names = tuple(str(name) for name in self.store["motion"].values)
        return self._set("member_psa", "member_zpa", names)

    def governing(self, damping: int, station: int, direction: int, frequency: int) -> str:
        """The point with the largest ordinate under the case's own motion."""
        probe = int(self.store["governing"].values[damping, station, direction, frequency])
        return str(self.store["probe"].values[probe])

    def whole(self, damping: int, station: int, direction: int) -> tuple[Array, Array] | None:
        """Frequencies [Hz] and the envelope of all vertices of a floor [m/s2].

        None where there are no fields over the floors, or for another damping.
        """
        if "whole_psa" not in self.store:
            return None
        field = self.store["whole_psa"]
        if not np.isclose(float(field.attrs["damping"]), self.case.damping[damping]):
            return None
        frequency = np.asarray(self.store["whole_frequency"].values, dtype=np.float64)
        return frequency, np.asarray(field.values[station, direction], dtype=np.float64)

    def vertices(self, station: int) -> int:
        """Number of vertices of a floor whose spectra `whole` envelopes."""
        return int(self.store["vertices"].values[station])

    def _set(self, psa: str, zpa: str, motions: tuple[str, ...]) -> FloorSpectrumSet:
        store = self.store
        one = len(motions) == 1 and "motion" not in store[psa].dims
        curves, ends = store[psa].values, store[zpa].values
        return FloorSpectrumSet(
            frequency=np.asarray(store["frequency"].values, dtype=np.float64),
            damping=np.asarray(store["damping"].values, dtype=np.float64),
            stations=self.stations,
            directions=self.directions,
            psa=curves[None] if one else curves,
            zpa=ends[None] if one else ends,
            motions=motions,
            title=self.title,
            method=self.method,
        )
