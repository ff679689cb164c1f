"""The stick beside the 3D model in front of the same wall, in numbers (figure 7 of the paper)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.stages.calibrate.history import WallHistory
from impactfem.stages.calibrate.impact import SEPARATION, THRESHOLD, FloorImpacts, floor_impacts
from impactfem.system.errors import ImpactfemError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WallComparison:
    """How the stick differs from the model it stands for, at one floor.

    Args:
        stick: Impacts of the stick's floor.
        model: Impacts of the model's floor.
        rebound_overshoot: Largest displacement away from the wall after the first impact, the
            stick's over the model's, less 1 [-]; None when one of them does not swing back
            behind its position at rest and turn there within its window.
        return_overshoot: The same of the largest displacement towards the wall after that [-];
            None when one of them has not turned again by the end of its window.
    """

    stick: FloorImpacts
    model: FloorImpacts
    rebound_overshoot: float | None
    return_overshoot: float | None

    @property
    def delay(self) -> float:
        """First impact of the stick less that of the model, positive when later [s]."""
        return self.stick.first_complete().start - self.model.first_complete().start

    @property
    def approach_ratio(self) -> float:
        """Approach velocity of the stick over the model's [-]."""
        return self.stick.first_complete().approach / self.model.first_complete().approach

    @property
    def impulse_ratio(self) -> float:
        """Largest impulse of the stick's first impact over the model's [-]."""
        return (
            self.stick.first_complete().largest_impulse
            / self.model.first_complete().largest_impulse
        )

    @property
    def duration_ratio(self) -> float:
        """Duration of the stick's first impact over the model's [-]."""
        return self.stick.first_complete().duration / self.model.first_complete().duration

    @property
    def second_impulse_ratio(self) -> float:
        """Largest impulse of the stick's second impact over its first; 0 without a second [-]."""
        second = self.stick.second
        return (
            second.largest_impulse / self.stick.first_complete().largest_impulse if second else 0.0
        )


def compare(
    stick: WallHistory,
    model: WallHistory,
    floor: int,
    *,
    separation: float = SEPARATION,
    threshold: float = THRESHOLD,
) -> WallComparison:
    """Compare two runs of the same experiment at one floor.

    Args:
        stick: Histories of the stick.
        model: Histories of the model, with any time step.
        floor: Number of the floor.
        separation: See `floor_impacts`.
        threshold: See `floor_impacts`.

    Raises:
        ImpactfemError: The floor is not in both, or their gaps differ.
        SolutionError: One of them has no complete first impact.
    """
    if not np.isclose(stick.gap, model.gap, rtol=1e-9, atol=0.0):
        raise ImpactfemError(
            "stick and model must stand before the same wall to be compared, got gaps of "
            f"{1e3 * stick.gap:.6g} and {1e3 * model.gap:.6g} mm"
        )
    found = [
        floor_impacts(history, floor, separation=separation, threshold=threshold)
        for history in (stick, model)
    ]
    peaks = [
        _peaks(history.displacement[:, history.column(floor)], impacts.first_complete().last)
        for history, impacts in zip((stick, model), found, strict=True)
    ]
    return WallComparison(
        stick=found[0],
        model=found[1],
        rebound_overshoot=_overshoot(peaks[0][0], peaks[1][0]),
        return_overshoot=_overshoot(peaks[0][1], peaks[1][1]),
    )


def _peaks(u: Array, last: int) -> tuple[float | None, float | None]:
    """Where a floor turns after an impact: away from the wall, then towards it [m]."""
    far = last + int(np.argmin(u[last:]))
    if far == u.size - 1 or u[far] >= 0.0:
        return None, None
    near = far + int(np.argmax(u[far:]))
    return float(u[far]), None if near == u.size - 1 else float(u[near])


def _overshoot(stick: float | None, model: float | None) -> float | None:
    return None if stick is None or model is None else stick / model - 1.0
