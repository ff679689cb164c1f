"""What tables and figures ask of `design.nc`: sets of floor spectra with their labels."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.spectra.product import FloorSpectrumSet, Station
from impactfem.stages.stores import names_of

Array = NDArray[np.float64]

VERTICES = "design_vertices"
"""Name of the table of the vertices that govern."""
EACH = "the vertices that govern under each motion"
"""The points beside the probes under motions of an ensemble, in words."""
ALONE = (
    "envelope of the PROBES ALONE, which is not that of the whole floor: without fields over the "
    "floors it is not known how much of a floor its probes have"
)


class DesignView:
    """The sets of floor spectra of a store of the stage `design`.

    Args:
        store: The open store.
    """

    def __init__(self, store: xr.Dataset) -> None:
        self.store = store
        self.building = str(store.attrs["building"])
        self.direction = str(store.attrs["shown_direction"])
        self.title = str(store.attrs["title"])
        self.inputs = str(store.attrs["inputs"])

    @cached_property
    def stations(self) -> tuple[Station, ...]:
        """The floors, with the points that are enveloped under the case's own motion."""
        return self._stations([self._vertex_words(counts) for counts in self.vertex_counts])

    @cached_property
    def member_stations(self) -> tuple[Station, ...]:
        """The floors, with the points that are enveloped under the motions of an ensemble."""
        words = (EACH,) if self.places else ()
        return self._stations([words] * self.store.sizes["station"])

    @cached_property
    def vertex_counts(self) -> NDArray[np.int64]:
        """Number of vertices that govern, shape (n_stations, n_directions); zero without any."""
        store = self.store
        counts = np.zeros((store.sizes["station"], len(self.directions)), dtype=np.int64)
        if "vertex" in store.dims:
            for s, direction in zip(
                store["vertex_station"].values, store["vertex_direction"].values, strict=True
            ):
                counts[int(s), self.directions.index(str(direction))] += 1
        return counts

    def points(self, station: int, direction: int) -> tuple[str, ...]:
        """The points whose envelope is taken along a direction: probes, and how many vertices."""
        probes = str(self.store["station_points"].values[station]).split(", ")
        count = self.vertex_counts[station, direction]
        if not count:
            return tuple(probes)
        return (*probes, f"{_vertices(int(count))} of tables/{VERTICES}.csv")

    def number_of_points(self, station: int, direction: int) -> int:
        """How many points there are, probes and vertices."""
        probes = str(self.store["station_points"].values[station]).split(", ")
        return len(probes) + int(self.vertex_counts[station, direction])

    def member_points(self, station: int) -> tuple[str, ...]:
        """The points whose envelope is taken under the motions of an ensemble."""
        return self.member_stations[station].points

    @property
    def directions(self) -> tuple[str, ...]:
        """Directions in which something moves."""
        return tuple(str(name) for name in self.store["direction"].values)

    @property
    def enveloped(self) -> str:
        """What is enveloped on each floor, in words."""
        if not self.places:
            return ALONE
        least = min(float(self.reached(s, x)[1].min()) for s, x in self.places)
        return (
            "envelope of the probes and of the vertices of the floor that govern; under the case's "
            f"motion these have at least {100.0 * least:.3g} % of the envelope of all vertices at "
            "every frequency, sampled alike"
        )

    @property
    def members_enveloped(self) -> str:
        """What is enveloped on each floor under the motions of an ensemble, in words."""
        if not self.places:
            return ALONE
        count = int(self.store["candidates"].values.sum())
        part = 100.0 * (1.0 - float(self.store.attrs["missed"]))
        return (
            f"envelope of the probes and of {EACH}: the fewest that have {part:g} % of what "
            f"{count} have, which are the largest ones of their floors under the case's own"
        )

    @property
    def method(self) -> str:
        """How the spectra under the case's own motion were computed, in words."""
        return self._method(self.enveloped)

    def _method(self, enveloped: str) -> str:
        highest = float(self.store.attrs["maximum_frequency"])
        text = (
            "pseudo-acceleration of oscillators at points of the floor; 3D model of shells and "
            "beams under ground motion and impact forces, meant up to "
            f"{highest:g} Hz; {enveloped}"
        )
        elsewhere = names_of(self.store, "elsewhere")
        if elsewhere:
            text += f"; on no floor: {', '.join(elsewhere)}"
        if self.places:
            text += f"; see tables/design_coverage.csv and tables/{VERTICES}.csv"
        return text

    @cached_property
    def places(self) -> list[tuple[int, int]]:
        """Floors and directions in which a vertex moves, as numbers."""
        size = len(self.stations), len(self.directions)
        return [(s, x) for s, x in np.ndindex(*size) if self.vertex_counts[s, x]]

    def reached(self, station: int, direction: int) -> tuple[Array, Array]:
        """What the vertices that govern have of the envelope of all vertices of a floor.

        Both from the same fields. For a store with fields, and a floor that moves.

        Returns:
            Frequencies [Hz], and as the last one infinity for the peak acceleration; the parts of
            the envelopes [-].
        """
        store = self.store
        parts = []
        for name in ("psa", "zpa"):
            reached, whole = (
                np.atleast_1d(store[f"{which}_{name}"].values[station, direction])
                for which in ("reached", "whole")
            )
            parts.append(np.divide(reached, whole, out=np.ones_like(whole), where=whole > 0.0))
        frequency = np.append(store["whole_frequency"].values, np.inf)
        return np.asarray(frequency, dtype=np.float64), np.concatenate(parts)

    @cached_property
    def case(self) -> FloorSpectrumSet:
        """The spectra under the case's own motion."""
        return self._set("psa", "zpa", ("that of the case",), self.method)

    @cached_property
    def members(self) -> FloorSpectrumSet | None:
        """Those of the members of an ensemble; None without one."""
        if "member_psa" not in self.store:
            return None
        names = tuple(str(name) for name in self.store["motion"].values)
        made = self._set("member_psa", "member_zpa", names, self._method(self.members_enveloped))
        return replace(made, stations=self.member_stations)

    def governing(self, damping: int, station: int, direction: int, frequency: int) -> str:
        """The point with the largest ordinate under the case's own motion."""
        point = int(self.store["governing"].values[damping, station, direction, frequency])
        return str(self.store["point"].values[point])

    def probes_peak(self, damping: int, station: int, direction: int) -> float:
        """Peak of the envelope of the probes alone under the case's own motion [m/s2]."""
        return float(self.store["probes_psa"].values[damping, station, direction].max())

    def whole(self, damping: int, station: int, direction: int) -> tuple[Array, Array] | None:
        """Frequencies [Hz] and the envelope of all vertices of a floor [m/s2].

        None where there are no fields over the floors, or for another damping.
        """
        if "whole_psa" not in self.store:
            return None
        if not np.isclose(float(self.store["whole_damping"]), self.case.damping[damping]):
            return None
        frequency = np.asarray(self.store["whole_frequency"].values, dtype=np.float64)
        return frequency, self.store["whole_psa"].values[station, direction]

    def vertices(self, station: int) -> int:
        """Number of vertices of a floor whose spectra `whole` envelopes."""
        return int(self.store["vertices"].values[station])

    def _stations(self, vertices: list[tuple[str, ...]]) -> tuple[Station, ...]:
        """The floors, with their probes and words for their vertices."""
        store = self.store
        rows = zip(
            store["station_floor"].values,
            store["station_points"].values,
            store["elevation"].values,
            vertices,
            strict=True,
        )
        return tuple(
            Station(self.building, str(floor), (*str(probes).split(", "), *words), float(z))
            for floor, probes, z, words in rows
        )

    def _vertex_words(self, counts: NDArray[np.int64]) -> tuple[str, ...]:
        """The vertices of a floor that govern, in words."""
        named = zip(counts, self.directions, strict=True)
        return tuple(f"{_vertices(int(count))} along {one}" for count, one in named if count)

    def _set(self, psa: str, zpa: str, motions: tuple[str, ...], method: str) -> FloorSpectrumSet:
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
            method=method,
        )


def _vertices(count: int) -> str:
    return "1 vertex" if count == 1 else f"{count} vertices"
