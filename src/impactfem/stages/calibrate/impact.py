"""Impacts of a floor on the wall, what they say of the penalty law, and how two models compare.

The evaluation knows histories, not the model that they come from: a floor's force may be smooth, a
chain of pulses as nonsmooth contact gives it, or pull at its end as the penalty law does.
"""

import math
from dataclasses import dataclass

import numpy as np

from impactfem.coupling.restitution import kelvin_voigt_phase, kelvin_voigt_xi
from impactfem.stages.calibrate.experiment import SEPARATION, WallHistory
from impactfem.system.errors import SolutionError
from impactfem.system.quantity import quantity, results, si

THRESHOLD = 1e-6
"""Forces up to this part of the largest one of all floors are those of a solver's residual [-]."""


@results
class WallImpact:
    """One impact of one floor."""

    floor: int  #: number of the floor
    mass: float  #: its mass M [kg]
    first: int  #: index of the first time with a force
    last: int  #: index of the last time with a force
    start: float = si("s", "start, gap closes", name="impact_time")
    end: float = si("s", "end, gap opens", name="impact_end")
    #: Above `impulse`, ∫ F dt over the impact, if the force pulls at the end.
    largest_impulse: float = si(
        "N s", "impulse, largest value P of ∫ F dt (equation 5)", shown="kN s", name="impulse"
    )
    impulse: float = si(
        "N s", "at end, impulse over the whole impact", shown="kN s", name="impulse_at_end"
    )
    peak_force: float = si("N", "peak, largest force", shown="MN")
    #: At the last time before the force.
    approach: float = si(
        "m/s",
        "approach, velocity u̇⁻ of the mass centre before the impact",
        name="approach_velocity",
    )
    #: At the first time after the force.
    rebound: float = si(
        "m/s", "rebound, velocity of the mass centre after the impact", name="rebound_velocity"
    )
    work: float = si("J", "work, ∫ F du on the mass centre", shown="kJ")
    pulses: int = si("", "pulses, force pulses joined to this impact")
    complete: bool = si("", "over, the impact ends within the window")

    @property
    @quantity("s", "duration, Δt_c of the impact", shown="ms", name="impact_duration")
    def duration(self) -> float:
        """Duration Δt_c [s]."""
        return self.end - self.start

    @property
    @quantity(
        "-", "epsilon, restitution by the largest impulse (equation 5)", name="impact_epsilon"
    )
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

    def _epsilon(self, impulse: float) -> float:
        return impulse / (self.mass * self.approach) - 1.0 if self.approach > 0.0 else math.nan


@dataclass(frozen=True)
class FloorImpacts:
    """What one floor did at the wall."""

    floor: int  #: number of the floor
    impacts: tuple[WallImpact, ...]  #: its impacts in order of time, none when it never touched
    gap: float  #: gap at rest [m]
    #: Smallest distance from the wall: of the floor's nearest point where the history has it, else
    #: of its mass centre as if it were at the edge [m].
    closest: float
    window: float  #: time of the last sample [s]

    @property
    def number(self) -> int:
        """Number of impacts."""
        return len(self.impacts)

    @property
    def second(self) -> WallImpact | None:
        """The second impact; None when there was none."""
        return self.impacts[1] if self.number > 1 else None

    def first_complete(self) -> WallImpact:
        """The first impact; SolutionError where there is none, or it is not over in the window."""
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
    history: WallHistory, floor: int, *, separation: float = SEPARATION
) -> FloorImpacts:
    """Find the impacts of a floor.

    A pulse is a run of times with |F| above `THRESHOLD` of the largest; pulses with less than
    `separation` without force between them are one impact. The impulse is P = Σ Δt (F₀ + F₁)/2 from
    the last time before the force to the first after it, all forces counted. Where the history has
    the distance to the wall, start and end are where it is zero by its rate just outside the
    impact: in the step in which the force begins or ends, or the one before, as a force may be a
    step late. Else they are the middles of these steps, and the duration is known to one step.

    `separation` is the shortest time without force between two impacts [s]. ImpactfemError where
    the floor is none of the history's, SolutionError where there is a force from the start on: the
    wall stands inside the building.
    """
    j = history.column(floor)
    F, dt = history.force[:, j], history.time_step
    touching = np.abs(F) > THRESHOLD * np.max(np.abs(history.force))
    if touching[0]:
        raise SolutionError(
            f"the wall starts inside the building: floor {floor} carries {F[0]:.4g} N at t = 0"
        )
    edges = np.flatnonzero(np.diff(np.concatenate([[False], touching, [False]]).astype(np.int8)))
    first, last = edges[::2], edges[1::2] - 1
    # In steps. Tolerance: a whole number of steps is rounded when divided by the step.
    apart = separation / dt * (1.0 - 1e-9)
    before = np.append(np.inf, first[1:] - 1 - last[:-1])[: first.size]
    begins = np.flatnonzero(before >= apart)
    ends = np.append(begins[1:], first.size)[: begins.size]
    distance = history.gap - history.displacement[:, j]
    if history.opening is not None:
        distance = history.opening[:, j]
    return FloorImpacts(
        floor=floor,
        impacts=tuple(
            _impact(history, j, int(first[begin]), int(last[end - 1]), int(end - begin), apart)
            for begin, end in zip(begins, ends, strict=True)
        ),
        gap=history.gap,
        closest=float(np.min(distance)),
        window=dt * (F.size - 1),
    )


def _impact(
    history: WallHistory, j: int, first: int, last: int, pulses: int, apart: float
) -> WallImpact:
    """The impact of a floor from its first to its last time with a force."""
    n_t, dt = history.force.shape[0], history.time_step
    low, high = first - 1, min(last + 1, n_t - 1)
    F = history.force[low : high + 1, j]
    mean_force = 0.5 * (F[:-1] + F[1:])
    impulse = dt * np.cumsum(mean_force)
    # In steps: from the time first - 1 to the start, and back from the time last + 1 to the end.
    before, after = 0.5, 0.5
    if history.opening is not None:
        g = history.opening[:, j]
        if first >= 2:
            before = _steps_to_wall(g[first - 1], g[first - 2], (-1.0, 1.0), before)
        if last + 2 < n_t:
            after = _steps_to_wall(g[last + 1], g[last + 2], (0.0, 2.0), after)
    return WallImpact(
        floor=history.floors[j],
        mass=float(history.mass[j]),
        first=first,
        last=last,
        pulses=pulses,
        start=dt * (first - 1 + before),
        end=dt * (last + 1 - after if last + 1 < n_t else last),
        impulse=float(impulse[-1]),
        largest_impulse=float(np.max(impulse)),
        peak_force=float(np.max(F)),
        approach=float(history.velocity[low, j]),
        rebound=float(-history.velocity[high, j]),
        work=float(np.sum(mean_force * np.diff(history.displacement[low : high + 1, j]))),
        # Whether another pulse of the same impact could come is known only so much later.
        complete=last + 1 < n_t and n_t - 1 - last >= apart,
    )


def _steps_to_wall(near: float, far: float, limits: tuple[float, float], unknown: float) -> float:
    """Steps from the nearer of two distances in free motion to zero; `unknown` at rest."""
    return float(np.clip(near / (far - near), *limits)) if far > near else unknown


@results
class PenaltyParameters:
    """What makes a mass on Kelvin-Voigt contact behave like the floor at the wall."""

    epsilon: float = si("-", "epsilon, restitution coefficient ε (equation 5)")
    xi_c: float = si("-", "xi_c, damping ratio of the contact (equation 4)")
    K_Ceq: float = si("N/m", "K_Ceq, contact stiffness (equation 6)")
    tension: bool  #: whether the contact may pull at its end


def penalty_parameters(
    impact: WallImpact, *, tension: bool = True, at_end: bool = False
) -> PenaltyParameters:
    """Parameters of the penalty law from the impulse, approach velocity and duration of an impact.

        ε = P / (M u̇⁻) - 1                     (5)
        ξ_c = -ln ε / √(π² + ln² ε)             (4)
        K_Ceq = M / (1 - ξ_c²) (π / Δt_c)²      (6)

    P is the largest impulse, as in the paper. Where the wall only pushes, that is the one at the
    end of the impact; where the force pulls at its end, as that of the law itself, only the impulse
    at the end gives the ε and ξ_c back with which a free mass was computed, and Δt_c the K_Ceq.

    A law that may not pull has other relations of ε, ξ_c and the duration; theirs are used with
    `tension` false: K_Ceq = M (φ / Δt_c)² with the law's phase φ, in equation 6 π / √(1 - ξ_c²).

    All three take the floor for a free mass, but the forces of its building act during the impact.
    In the paper's experiment they push it towards the wall, because the floors below move on
    while it is stopped: they add to the impulse and lengthen the impact, so that ε comes out
    larger and K_Ceq smaller than those of a law with which the stick runs. A mass on one spring
    behind a gap is pulled back instead: ε comes out smaller.

    Args:
        impact: A complete impact.
        tension: Whether the contact of the law may pull at its end.
        at_end: Take the impulse at the end of the impact for P, not the largest.

    Raises:
        SolutionError: The floor did not approach the wall, or ε is not above 0 and at most 1.
    """
    momentum = impact.mass * impact.approach
    if not impact.approach > 0.0:
        raise SolutionError(
            f"the approach velocity of floor {impact.floor} before its impact at "
            f"{impact.start:.4g} s is {impact.approach:.4g} m/s, not positive: its mass centre "
            "does not move towards the wall, and equation 5 gives no restitution"
        )
    epsilon = impact.epsilon_at_end if at_end else impact.epsilon
    impulse = impact.impulse if at_end else impact.largest_impulse
    if not 0.0 < epsilon <= 1.0:
        raise SolutionError(
            f"equation 5 gives the restitution {epsilon:.4g} for floor {impact.floor}, expected "
            f"above 0 and at most 1: impulse {1e-3 * impulse:.4g} kN s, momentum "
            f"before the impact {1e-3 * momentum:.4g} kN s; the longer the impact, the more of the "
            "impulse is that of the building's own forces"
        )
    xi_c = kelvin_voigt_xi(epsilon, tension=tension)
    phase = kelvin_voigt_phase(xi_c, tension=tension)
    K_Ceq = impact.mass * (phase / impact.duration) ** 2
    return PenaltyParameters(epsilon, xi_c, K_Ceq, tension)


@results
class WallComparison:
    """Differences between the stick and the 3D model at one floor."""

    stick: FloorImpacts  #: impacts of the stick's floor
    model: FloorImpacts  #: impacts of the 3D model's floor
    #: None if one of them does not swing back behind its position at rest and turn there.
    rebound_overshoot: float | None = si(
        "-", "rebound overshoot, displacement after the impact, stick / 3D - 1"
    )
    #: None if one of them has not turned again by the end of the window.
    return_overshoot: float | None = si(
        "-", "return overshoot, displacement on the return to the wall, stick / 3D - 1"
    )

    @property
    @quantity(
        "s", "delay, first impact of the stick after that of the 3D model", name="stick_delay"
    )
    def delay(self) -> float:
        """First impact of the stick less that of the 3D model, positive if later [s]."""
        return self.stick.first_complete().start - self.model.first_complete().start

    @property
    @quantity("-", "impulse ratio, first impact, stick / 3D")
    def stick_impulse_ratio(self) -> float:
        """Largest impulse of the first impact, stick / 3D model [-]."""
        stick, model = self.stick.first_complete(), self.model.first_complete()
        return stick.largest_impulse / model.largest_impulse

    @property
    @quantity("-", "duration ratio, first impact, stick / 3D")
    def stick_duration_ratio(self) -> float:
        """Duration of the first impact, stick / 3D model [-]."""
        return self.stick.first_complete().duration / self.model.first_complete().duration

    @property
    @quantity("N s", "second impulse, stick", shown="kN s")
    def second_impulse(self) -> float | None:
        """Impulse of the stick's second impact [N s]; None without one in the window."""
        return self.stick.second.largest_impulse if self.stick.second else None

    @property
    @quantity("s", "second impact, stick")
    def second_impact_time(self) -> float | None:
        """Time of the stick's second impact [s]; None without one in the window."""
        return self.stick.second.start if self.stick.second else None

    @property
    @quantity("N s", "second impulse, 3D model", shown="kN s")
    def second_impulse_3d(self) -> float | None:
        """Impulse of the second impact of the 3D model [N s]; None without one in the window."""
        return self.model.second.largest_impulse if self.model.second else None


def compare(
    stick: WallHistory, model: WallHistory, floor: int, *, separation: float = SEPARATION
) -> WallComparison:
    """Compare the histories of stick and model, each with any time step, at one floor.

    ImpactfemError where it is not in both, SolutionError where one has no complete first impact.
    """
    found = [floor_impacts(history, floor, separation=separation) for history in (stick, model)]
    # Where they turn after the impact: away from the wall, then towards it [m].
    turns = np.full((2, 2), np.nan)
    for k, (history, impacts) in enumerate(zip((stick, model), found, strict=True)):
        u, last = history.displacement[:, history.column(floor)], impacts.first_complete().last
        far = last + int(np.argmin(u[last:]))
        if far < u.size - 1 and u[far] < 0.0:
            near = far + int(np.argmax(u[far:]))
            turns[k] = u[far], u[near] if near < u.size - 1 else np.nan
    rebound, back = (
        float(u_stick / u_model) - 1.0 if np.isfinite([u_stick, u_model]).all() else None
        for u_stick, u_model in turns.T
    )
    return WallComparison(found[0], found[1], rebound, back)
