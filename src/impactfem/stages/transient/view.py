"""What figures and tables ask of `transient.nc`: its floors, edges, line and loads by number."""

from __future__ import annotations

import math
import re
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.stages.stores import StoreView

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

XYZ = "xyz"
QUIET = 0.01
"""Peak acceleration over the largest one along the same axis up to which a point is at rest."""


class TransientView(StoreView):
    """A store of the stage `transient`, read along the direction that is shown.

    Args:
        store: The open store.
    """

    def __init__(self, store: xr.Dataset) -> None:
        super().__init__(store)
        self.direction = str(store.attrs["shown_direction"])
        self.maximum_frequency = float(store.attrs["maximum_frequency"])
        self.reduced = str(store.attrs["solver"]) != "full"
        self.names = [str(name) for name in store["probe"].values]
        self._component = XYZ.index(self.direction)

    @property
    def damping(self) -> float:
        """Damping ratio of the spectra that are shown, the first."""
        return float(self.store["damping"].values[0])

    @cached_property
    def known(self) -> Flags:
        """Frequencies of the spectra up to the one that the 3D model is meant for."""
        return np.asarray(self.frequency <= self.maximum_frequency * (1.0 + 1e-9))

    @cached_property
    def centres(self) -> dict[int, int]:
        """Probe at the mass centre of each floor, by its number, from the lowest."""
        return self._numbered("centre")

    @cached_property
    def edges(self) -> dict[int, int]:
        """Probe at the middle of each impact edge, by the floor's number, from the lowest."""
        return self._numbered("edge")

    @cached_property
    def line(self) -> list[int]:
        """Probes of the line across a floor, from the impact edge."""
        return list(self._numbered("line").values())

    @property
    def top(self) -> int:
        """Number of the floor with the line: the highest that may be struck."""
        if not self.line:
            return max(self.centres)
        away = np.abs(self.position[:, 2] - self.position[self.line[0], 2])
        return min(self.centres, key=lambda floor: float(away[self.centres[floor]]))

    @cached_property
    def position(self) -> Array:
        """Of the probes, shape (n_probes, 3) [m]."""
        return self._values("probe_position")

    @cached_property
    def distance(self) -> Array:
        """Distance d from the impact edge of each probe of the line, shape (n_line,) [m]."""
        where = self.position[self.line]
        return np.asarray(np.linalg.norm(where - where[:1], axis=1))

    @property
    def inward(self) -> float:
        """1 or −1: the sense of the shown direction from the impact edge; 0 when it is across."""
        if len(self.line) < 2:
            return 0.0
        along = self.position[self.line[-1]] - self.position[self.line[0]]
        part = along[self._component] / np.linalg.norm(along)
        return math.copysign(1.0, part) if abs(part) > 0.5 else 0.0

    @cached_property
    def loads(self) -> dict[int, int]:
        """Column of the impact force of each floor, by its number, from the lowest."""
        return _by_floor(self.store["edge"].values)

    @cached_property
    def force(self) -> Array:
        """Impact forces, positive in compression, shape (n_t, n_edges) [N]."""
        return self._values("edge_force")

    @property
    def main_impact(self) -> tuple[float, float] | None:
        """Start and end of the impact with the largest force [s]; None without an impact."""
        both = np.atleast_1d(self.store.attrs["main_impact"])
        return (float(both[0]), float(both[1])) if both.size == 2 else None

    @property
    def forces_note(self) -> str:
        """Why a floor moves before it is hit, as the end of a caption; "" without an impact."""
        if self.main_impact is None:
            return ""
        return (
            " Before the main impact the samples of its force alternate about zero (figure 11), "
            "and move the floor."
        )

    @property
    def shown_distances(self) -> list[int]:
        """Every other probe of the line, its ends among them: as many as curves can be told."""
        last = len(self.line) - 1
        shown = np.unique(np.rint(np.linspace(0.0, last, min(5, last + 1))).astype(int))
        return [int(k) for k in shown]

    def acceleration(self, probe: int) -> Array:
        """Absolute acceleration of a probe, shape (n_t,) [m/s2]."""
        return self._history("acceleration", probe)

    def displacement(self, probe: int) -> Array:
        """Displacement of a probe relative to the ground, shape (n_t,) [m]."""
        return self._history("displacement", probe)

    def psa(self, probe: int) -> Array:
        """Pseudo-acceleration of a probe, shape (n_f,) [m/s2]."""
        return self._spectrum("psa", probe)

    def band(self, probe: int) -> Array:
        """Half width of the error band of `psa`, shape (n_f,) [m/s2]."""
        return self._spectrum("psa_band", probe)

    def sd(self, probe: int) -> Array:
        """Spectral displacement of a probe, shape (n_f,) [m]."""
        return self._spectrum("sd", probe)

    @property
    def band_note(self) -> str:
        """What tells the error band, in brackets; "" where the store does not say."""
        note = self.store["psa_band"].attrs.get("note")
        return "" if note is None else f" ({note})"

    def sd_band(self, probe: int) -> Array:
        """Half width of the error band of `sd`: PSa = ω² Sd, shape (n_f,) [m]."""
        return np.asarray(self.band(probe) / (2.0 * math.pi * self.frequency) ** 2)

    def pfa(self, probe: int) -> float:
        """Peak acceleration of a probe [m/s2]."""
        return float(self.store["pfa"].values[probe, self._component])

    def pfa_band(self, probe: int) -> float:
        """Half width of its error band [m/s2]."""
        return float(self.store["pfa_band"].values[probe, self._component])

    @cached_property
    def between(self) -> Array:
        """Peak acceleration between the samples, of the histories as the oscillators saw them.

        Over that at the samples, shape (n_probes, 3) [-]; nan where a point is at rest.
        """
        return self._where_moving(self._values("pfa_interpolated"), self._values("pfa"))

    @cached_property
    def ends(self) -> Array:
        """PSa at the highest known frequency, over the peak acceleration that it tends to.

        Shape (n_probes, 3) [-]; nan where a point is at rest, as in `between`.
        """
        last = int(np.flatnonzero(self.known)[-1])
        psa = np.asarray(self.store["psa"].values[0, :, :, last], dtype=np.float64)
        return self._where_moving(psa, self._values("pfa_interpolated"))

    def _where_moving(self, values: Array, over: Array) -> Array:
        pfa = self._values("pfa")
        moves = pfa > QUIET * pfa.max(axis=0)
        return np.divide(values, over, out=np.full(over.shape, np.nan), where=moves)

    @cached_property
    def transfer_loads(self) -> dict[int, int]:
        """Number of the load in the transfer functions by the floor; empty without them."""
        if "transfer_load" not in self.store.variables:
            return {}
        return _by_floor(self.store["transfer_load"].values)

    @cached_property
    def transfer_frequency(self) -> Array:
        """Frequencies of the transfer functions, shape (n_tf,) [Hz]."""
        return self._values("transfer_frequency")

    def transfer_bound(self, floor: int, probe: int) -> Array:
        """Rigorous bound on the error of `transfer`, shape (n_tf,) [1/kg]; infinite if unknown."""
        chosen = (slice(None), self.transfer_loads[floor], probe, self._component)
        if "transfer_bound" not in self.store.variables:
            return np.full(len(self.transfer_frequency), np.inf)
        return np.asarray(self.store["transfer_bound"].values[chosen], dtype=np.float64)

    def transfer(self, floor: int, probe: int) -> Array:
        """|acceleration / force| of a probe over the load on a floor, shape (n_tf,) [1/kg]."""
        chosen = (slice(None), self.transfer_loads[floor], probe, self._component)
        re = self.store["transfer_re"].values[chosen]
        im = self.store["transfer_im"].values[chosen]
        return np.asarray(np.hypot(re, im))

    def _numbered(self, family: str) -> dict[int, int]:
        found = {
            int(match[1]): index
            for index, name in enumerate(self.names)
            if (match := re.fullmatch(rf"{family}_([1-9][0-9]*)", name)) is not None
        }
        return dict(sorted(found.items()))

    def _history(self, name: str, probe: int) -> Array:
        chosen = self.store[name][:, probe, self._component]
        return np.asarray(chosen.values, dtype=np.float64)

    def _spectrum(self, name: str, probe: int) -> Array:
        chosen = self.store[name][0, probe, self._component]
        return np.asarray(chosen.values, dtype=np.float64)


def _by_floor(names: NDArray[np.object_]) -> dict[int, int]:
    """Place of each load by the number of its floor; loads are called "floor 8"."""
    return dict(sorted((int(str(name).split()[-1]), k) for k, name in enumerate(names)))


def stick_station(sticks: xr.Dataset, building: str, floor: int) -> int | None:
    """The station of a building's floor in `pounding.nc`; None when it has none."""
    mine = sticks["station_building"].values == building
    found = np.flatnonzero(mine & (sticks["station_floor"].values == floor))
    return int(found[0]) if found.size else None


def stick_history(sticks: xr.Dataset, name: str, station: int, direction: str) -> Array | None:
    """A history of a station, shape (n_t,); None when the sticks do not move along it."""
    components = [str(c) for c in sticks["component"].values]
    if direction not in components:
        return None
    chosen = sticks[name][:, station, components.index(direction)]
    return np.asarray(chosen.values, dtype=np.float64)


def stick_psa(sticks: xr.Dataset, station: int, direction: str) -> Array | None:
    """Pseudo-acceleration of a station at the first damping; None without that direction."""
    directions = [str(d) for d in sticks["direction"].values]
    if direction not in directions:
        return None
    chosen = sticks["psa"][0, station, directions.index(direction)]
    return np.asarray(chosen.values, dtype=np.float64)
