"""The experiment: a building drawn aside, let go, and stopped by a rigid wall."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.case.wall_impact import Pull
from impactfem.reduction.side import Side
from impactfem.system.errors import ImpactfemError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WallExperiment:
    """A building in front of a rigid wall, without ground motion (paper, section 3.2.2).

    One floor is drawn aside, see `impactfem.reduction.pull`; at t = 0 what held it is gone
    and the building, at rest, is free. The wall is a plane at the gap g from the undeformed
    building, n the unit vector towards it: a point with displacement u touches where n · u = g.

    Args:
        floors: Numbers of the floors that may hit the wall, each once.
        displaced_floor: Number of the floor that is displaced.
        displacement: Its displacement along n, negative away from the wall; under a load that of
            its mass centre [m].
        gap: Gap g at rest [m].
        duration: Length of the window in time [s].
        time_step: Time step [s].
        side: Side of the building on which the wall stands: "x-", "x+", "y-" or "y+".
        pull: How the floor is drawn aside.

    Raises:
        ImpactfemError: A value makes no experiment: the wall stands inside the displaced building,
            for instance.
    """

    floors: tuple[int, ...]
    displaced_floor: int
    displacement: float
    gap: float
    duration: float
    time_step: float
    side: Side = "y+"
    pull: Pull = "whole_floor"

    def __post_init__(self) -> None:
        if not self.floors or len(set(self.floors)) < len(self.floors):
            raise ImpactfemError(
                f"the wall needs floors that may hit it, each named once, got {self.floors}"
            )
        if self.side not in ("x-", "x+", "y-", "y+"):
            raise ImpactfemError(f"the wall stands on side x-, x+, y- or y+, got {self.side!r}")
        if not self.gap >= 0.0:
            raise ImpactfemError(f"the gap to the wall must not be negative, got {self.gap:g} m")
        if not 0.0 < self.time_step < self.duration:
            raise ImpactfemError(
                "the experiment needs a time step above 0 and below its duration, got "
                f"{self.time_step:g} s and {self.duration:g} s"
            )
        if not np.isfinite(self.displacement):
            raise ImpactfemError(
                f"the displacement of floor {self.displaced_floor} must be a number, got "
                f"{self.displacement}"
            )
        if self.displacement > self.gap:
            raise ImpactfemError(_inside(self.displaced_floor, self.displacement, self.gap))

    @property
    def normal(self) -> Array:
        """Unit vector n towards the wall, shape (3,)."""
        n = np.zeros(3)
        n["xy".index(self.side[0])] = 1.0 if self.side[1] == "+" else -1.0
        return n

    @property
    def n_t(self) -> int:
        """Number of times; the last is the whole step nearest to the end of the window."""
        return round(self.duration / self.time_step) + 1

    def check_start(self, displacement: Array) -> None:
        """See that the wall stands outside the displaced building.

        What draws one floor aside displaces the others, too, and those above it more.

        Args:
            displacement: Displacements along n of the points that may hit, the largest of each
                floor, in the order of `floors`, shape (n_floors,) [m].

        Raises:
            ImpactfemError: A floor starts behind the wall.
        """
        worst = int(np.argmax(displacement))
        if displacement[worst] > self.gap:
            raise ImpactfemError(
                _inside(self.floors[worst], float(displacement[worst]), self.gap)
                + f", when floor {self.displaced_floor} is displaced by "
                f"{1e3 * self.displacement:.4g} mm"
            )


def _inside(floor: int, displacement: float, gap: float) -> str:
    return (
        f"the wall starts inside the building: floor {floor} is displaced by "
        f"{1e3 * displacement:.4g} mm towards it, the gap is {1e3 * gap:.4g} mm"
    )
