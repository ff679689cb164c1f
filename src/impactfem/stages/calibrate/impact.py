"""Impacts of a floor on the wall: when, how long, which impulse, and what the floor lost.

The evaluation knows histories, not the model that they come from: a floor's force may be smooth, a
chain of pulses as nonsmooth contact gives it, or pull at its end as the penalty law does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.stages.calibrate.history import WallHistory
from impactfem.system.errors import ImpactfemError, SolutionError

Array = NDArray[np.float64]
SEPARATION = 5e-3
"""Pulses less than this apart are one impact [s]: a slab's waves take some ms, its return 0.1 s."""
THRESHOLD = 1e-6
"""Forces up to this part of the largest one of all floors are those of a solver's residual [-]."""


@dataclass(frozen=True)
class WallImpact:
    """One impact of one floor.

    Args:
        floor: Number of the floor.
        mass: Its mass M [kg].
        first: Index of the first time with a force.
        last: Index of the last time with a force.
        pulses: Number of pulses that were taken together.
        start: Time when the gap closed [s].
        end: Time when it opened again [s].
        impulse: Time integral of the force over the impact, ∫ F dt [N s].
        largest_impulse: Largest value that the integral has on its way, P of the paper's equation
            5 [N s]; above `impulse` when the force pulls at the end.
        peak_force: Largest force [N].
        approach: Velocity u̇⁻ of the mass centre at the last time before the force [m/s].
        rebound: Velocity of the mass centre at the first time after it, away from the wall [m/s].
        work: Energy that the force took from the motion of the mass centre, ∫ F du [J].
        complete: Whether the force is seen to be over before the window ends.
    """

    floor: int
    mass: float
    first: int
    last: int
    pulses: int
    start: float
    end: float
    impulse: float
    largest_impulse: float
    peak_force: float
    approach: float
    rebound: float
    work: float
    complete: bool

    @property
    def duration(self) -> float:
        """Duration Δt_c [s]."""
        return self.end - self.start

    @property
    def epsilon(self) -> float:
        """Restitution ε = P / (M u̇⁻) - 1, P the largest impulse (paper, equation 5) [-].

        With a penalty law that pulls at its end, this is more than the restitution of the law: a
        free mass on Kelvin-Voigt contact gets exp(-ξ Ω t) at the time of F = 0, not of p = 0.
        """
        return self._epsilon(self.largest_impulse)

    @property
    def epsilon_at_end(self) -> float:
        """The same with the impulse at the end of the impact: that of a free mass exactly [-]."""
        return self._epsilon(self.impulse)

    @property
    def kinetic_energy_lost(self) -> float:
        """Kinetic energy that the floor lost by the motion of its mass centre [J].

        ½ M (u̇⁻² - u̇⁺²), the work of the building's own forces during the impact included.
        """
        return 0.5 * self.mass * (self.approach**2 - self.rebound**2)

    def _epsilon(self, impulse: float) -> float:
        return impulse / (self.mass * self.approach) - 1.0 if self.approach > 0.0 else math.nan


@dataclass(frozen=True)
class FloorImpacts:
    """What one floor did at the wall.

    Args:
        floor: Number of the floor.
        impacts: Its impacts in order of time, none when it never touched.
        gap: Gap at rest [m].
        closest: Smallest distance from the wall: of the floor's nearest point where the history
            has it, else of its mass centre as if it were at the edge [m].
        window: Time of the last sample [s].
    """

    floor: int
    impacts: tuple[WallImpact, ...]
    gap: float
    closest: float
    window: float

    @property
    def number(self) -> int:
        """Number of impacts."""
        return len(self.impacts)

    @property
    def second(self) -> WallImpact | None:
        """The second impact; None when there was none."""
        return self.impacts[1] if self.number > 1 else None

    def first_complete(self) -> WallImpact:
        """The first impact, seen to its end.

        Raises:
            SolutionError: The floor did not touch, or its first impact is not over in the window.
        """
        if not self.impacts:
            raise SolutionError(
                f"no impact: floor {self.floor} does not touch the wall within "
                f"{self.window:.4g} s; it gets as near as {1e3 * self.closest:.4g} mm, of a gap "
                f"of {1e3 * self.gap:.4g} mm; a smaller gap, a larger displacement or a longer "
                "duration would help"
            )
        impact = self.impacts[0]
        if not impact.complete:
            raise SolutionError(
                f"the impact of floor {self.floor} that begins at {impact.start:.4g} s is still "
                f"going on when the window ends, at {self.window:.4g} s; a longer duration would "
                "help"
            )
        return impact


def floor_impacts(
    history: WallHistory,
    floor: int,
    *,
    separation: float = SEPARATION,
    threshold: float = THRESHOLD,
) -> FloorImpacts:
    """Find the impacts of a floor.

    A pulse is a run of times with |F| above the threshold; pulses with less than `separation`
    without force between them are one impact. The impulse is P = Σ Δt (F₀ + F₁)/2 from the last
    time before the force to the first after it, all forces counted. Where the history has the
    distance to the wall, start and end are where it is zero by its rate just outside the impact: in
    the step in which the force begins or ends, or the one before, as a force may be a step late.
    Else they are the middles of these steps, and the duration is known to one step.

    Args:
        history: The histories.
        floor: Number of the floor.
        separation: Shortest time without force between two impacts [s].
        threshold: Part of the largest force of all floors that counts as none [-].

    Raises:
        ImpactfemError: The floor is none of the history's, or an argument is out of its range.
        SolutionError: There is a force from the start on: the wall stands inside the building.
    """
    if not separation >= 0.0 or not 0.0 <= threshold < 1.0:
        raise ImpactfemError(
            "separation must be at least 0 s and threshold from 0 to below 1, got "
            f"{separation:g} s and {threshold:g}"
        )
    j = history.column(floor)
    F = history.force[:, j]
    n_t = F.size
    dt = history.time_step
    touching = np.abs(F) > threshold * np.max(np.abs(history.force))
    if touching[0]:
        raise SolutionError(
            f"the wall starts inside the building: floor {floor} carries {F[0]:.4g} N at t = 0"
        )
    runs = _runs(touching, separation / dt)
    opening = history.opening
    distance = history.gap - history.displacement[:, j] if opening is None else opening[:, j]
    return FloorImpacts(
        floor=floor,
        impacts=tuple(
            _impact(
                history,
                j,
                run,
                # Whether another pulse of the same impact could come is known only so much later.
                complete=run[1] + 1 < n_t and (n_t - 1 - run[1]) * dt >= separation,
            )
            for run in runs
        ),
        gap=history.gap,
        closest=float(np.min(distance)),
        window=dt * (n_t - 1),
    )


def _runs(touching: NDArray[np.bool_], separation: float) -> list[tuple[int, int, int]]:
    """First and last index of each impact, and its number of pulses; separation in steps."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], touching, [False]]).astype(np.int8)))
    runs: list[tuple[int, int, int]] = []
    for first, after in edges.reshape(-1, 2).tolist():
        # Tolerance: a separation of a whole number of steps is rounded when divided by the step.
        if runs and first - 1 - runs[-1][1] < separation * (1.0 - 1e-9):
            begin, _, pulses = runs.pop()
            runs.append((begin, after - 1, pulses + 1))
        else:
            runs.append((first, after - 1, 1))
    return runs


def _impact(
    history: WallHistory, j: int, run: tuple[int, int, int], *, complete: bool
) -> WallImpact:
    first, last, pulses = run
    low, high = first - 1, min(last + 1, history.force.shape[0] - 1)
    F = history.force[low : high + 1, j]
    mean_force = 0.5 * (F[:-1] + F[1:])
    impulse = history.time_step * np.cumsum(mean_force)
    displacement = history.displacement[low : high + 1, j]
    start, end = _limits(history, j, first, last)
    return WallImpact(
        floor=history.floors[j],
        mass=float(history.mass[j]),
        first=first,
        last=last,
        pulses=pulses,
        start=start,
        end=end,
        impulse=float(impulse[-1]),
        largest_impulse=float(np.max(impulse)),
        peak_force=float(np.max(F)),
        approach=float(history.velocity[low, j]),
        rebound=float(-history.velocity[high, j]),
        work=float(np.sum(mean_force * np.diff(displacement))),
        complete=complete,
    )


def _limits(history: WallHistory, j: int, first: int, last: int) -> tuple[float, float]:
    """Start and end of an impact [s]."""
    n_t = history.force.shape[0]
    # In steps: from the time first - 1 to the start, and back from the time last + 1 to the end.
    before, after = 0.5, 0.5
    if history.opening is not None:
        g = history.opening[:, j]
        if first >= 2:
            before = _steps_to_wall(g[first - 1], g[first - 2], (-1.0, 1.0), before)
        if last + 2 < n_t:
            after = _steps_to_wall(g[last + 1], g[last + 2], (0.0, 2.0), after)
    end = last + 1 - after if last + 1 < n_t else float(last)
    return history.time_step * (first - 1 + before), history.time_step * end


def _steps_to_wall(near: float, far: float, limits: tuple[float, float], unknown: float) -> float:
    """Steps from the nearer of two distances in free motion to zero distance, by their difference.

    `unknown` when the floor was not nearing the wall, or leaving it.
    """
    return float(np.clip(near / (far - near), *limits)) if far > near else unknown
