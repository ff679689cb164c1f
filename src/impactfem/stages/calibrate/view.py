"""What figures, tables and checks ask of `calibrate.nc`: histories, impacts and damping cases."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.stages.calibrate.history import WallHistory
from impactfem.stages.calibrate.impact import FloorImpacts, WallImpact, floor_impacts
from impactfem.stages.stores import CasesView

Array = NDArray[np.float64]


class WallView(CasesView):
    """A store of the stage `calibrate`.

    Args:
        store: The open store.
    """

    def __init__(self, store: xr.Dataset) -> None:
        super().__init__(store)
        self.side = str(store.attrs["side"])
        self.gap = float(store.attrs["gap"])
        self.separation = float(store.attrs["separation"])
        self.floors = tuple(int(floor) for floor in store["floor"].values)

    @cached_property
    def model(self) -> WallHistory:
        """Histories of the 3D model."""
        return self._history("")

    @cached_property
    def stick(self) -> WallHistory:
        """Histories of the stick."""
        return self._history("stick_")

    @cached_property
    def model_impacts(self) -> list[FloorImpacts]:
        """Impacts of the 3D model by floor, bottom to top."""
        return self._impacts(self.model)

    @cached_property
    def stick_impacts(self) -> list[FloorImpacts]:
        """Impacts of the stick by floor, bottom to top."""
        return self._impacts(self.stick)

    @property
    def top(self) -> int:
        """Number of the top one of the floors that may hit, which gives the parameters."""
        return self.floors[-1]

    @property
    def hitting(self) -> list[int]:
        """Numbers of the floors of the 3D model that hit the wall, bottom to top."""
        return [found.floor for found in self.model_impacts if found.impacts]

    @property
    def first_impact(self) -> WallImpact:
        """First impact of the top floor of the 3D model.

        Raises:
            SolutionError: It has none that ends in the window: the stage writes no such store.
        """
        return self.model_impacts[-1].first_complete()

    def focus(self) -> tuple[float, float]:
        """Start and end of what is shown of the first impact of all floors that hit [s]."""
        firsts = [found.impacts[0] for found in self.model_impacts if found.impacts]
        near = [i for i in firsts if i.start < self.first_impact.end + self.separation]
        start, end = min(i.start for i in near), max(i.end for i in near)
        margin = 0.4 * (end - start)
        return max(self.time[0], start - margin), min(self.time[-1], end + margin)

    @property
    def half_wave(self) -> float:
        """Frequency whose half wave lasts as long as the first impact, 1 / (2 Δt_c) [Hz]."""
        return 0.5 / float(self.store["impact_duration"].values[0])

    def damping_ratios(self, frequency: float) -> Array:
        """The building's damping ratio at a frequency [Hz] in each case, shape (n_cases,) [-]."""
        return np.array([self.damping(k).ratio(frequency) for k in range(len(self.cases))])

    def of_floor(self, floor: int) -> NDArray[np.bool_]:
        """Which contact constraints are on the edge of a floor, shape (m,)."""
        return np.asarray(self.store["constraint_floor"].values == floor)

    def line_load(self, floor: int) -> Array:
        """Line load at the vertices of an edge at the times of `step`, shape (n_step, m) [N/m].

        P_i / w_i, with the force P_i and the length w_i of vertex i; straight between vertices.
        """
        mine = self.of_floor(floor)
        length = self.store["constraint_length"].values[mine]
        return np.asarray(self.store["constraint_force"].values[:, mine] / length, dtype=np.float64)

    def _history(self, prefix: str) -> WallHistory:
        names = ("displacement", "velocity", "force", "opening")
        displacement, velocity, force, opening = (self._values(f"{prefix}{name}") for name in names)
        return WallHistory(
            floors=self.floors,
            mass=self._values("floor_mass"),
            gap=self.gap,
            time_step=self.time_step,
            displacement=displacement,
            velocity=velocity,
            force=force,
            opening=opening,
        )

    def _impacts(self, history: WallHistory) -> list[FloorImpacts]:
        return [floor_impacts(history, k, separation=self.separation) for k in self.floors]


def running_impulse(history: WallHistory, floor: int) -> Array:
    """∫ F dt of a floor from the start on, by the trapezoidal rule, shape (n_t,) [N s]."""
    F = history.force[:, history.column(floor)]
    steps = 0.5 * history.time_step * (F[:-1] + F[1:])
    return np.concatenate([np.zeros(1), np.cumsum(steps)])
