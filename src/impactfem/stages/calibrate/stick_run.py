"""The wall experiment with the stick of the building, on the penalty law."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from impactfem.coupling.contact import kelvin_voigt
from impactfem.coupling.pounding import End, Pair, System, Update, simulate
from impactfem.stages.calibrate.experiment import WallExperiment
from impactfem.stages.calibrate.history import WallHistory
from impactfem.stages.calibrate.impact import SEPARATION, THRESHOLD, FloorImpacts, floor_impacts
from impactfem.sticks.stick import Stick
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


def static_state(stick: Stick, experiment: WallExperiment) -> Array:
    """Displacements of the stick whose floor is drawn aside.

    The floor is rigid and keeps the rotation that its storeys give it, as a slab does that is held
    along n alone. A force along n at the stick's axis does not turn it about the axis, so holding
    the whole floor, an even load on it and a force at its mass centre are the same.

    With j the row that takes n · u of the floor's mass centre, K u = λ jᵀ and j u = d:
    u = d K⁻¹ jᵀ / (j K⁻¹ jᵀ).

    Args:
        stick: The stick.
        experiment: Gives the floor, its displacement d and the direction n.

    Returns:
        Shape (n,) [m, rad].

    Raises:
        ImpactfemError: The stick has no such floor.
    """
    j = experiment.normal @ stick.translation(stick.floor_master(experiment.displaced_floor))
    u = scipy.linalg.solve(stick.K, j, assume_a="pos")
    return np.asarray(experiment.displacement * u / (j @ u), dtype=np.float64)


def wall_system(
    stick: Stick, experiment: WallExperiment, *, K: float, xi: float, tension: bool = True
) -> System:
    """The stick, and the pairs of its floors with the wall.

    Contact is at the height of the mass centres and central: the resultant on a floor has no
    moment about a vertical axis. The wall has no mass to yield: equation 3 of the paper is then
    C = 2 ξ √(K M), M the mass of the floor.

    Args:
        stick: The stick.
        experiment: Gives the floors, the gap and the direction.
        K: Penalty stiffness K_Ceq [N/m].
        xi: Damping ratio at contact ξ_c [-].
        tension: Whether the contact may pull at its end, as in the paper.

    Raises:
        ImpactfemError: The stick has no such floor.
    """
    n = experiment.normal
    pairs = []
    for floor in experiment.floors:
        master = stick.floor_master(floor)
        law = kelvin_voigt(K, xi, stick.point_mass(master, (0.0, 0.0, 0.0), n), tension=tension)
        end = End(stick.name, master, (0.0, 0.0, 0.0), floor)
        pairs.append(Pair(f"{stick.name}.floor_{floor}-wall", end, None, n, experiment.gap, law))
    return System((stick,), tuple(pairs))


def run_stick(
    stick: Stick,
    experiment: WallExperiment,
    *,
    K: float,
    xi: float,
    tension: bool = True,
    update: Update = "implicit",
) -> WallHistory:
    """Run the experiment with the stick.

    Args:
        stick: The stick.
        experiment: What is done.
        K: Penalty stiffness K_Ceq [N/m].
        xi: Damping ratio at contact ξ_c [-].
        tension: Whether the contact may pull at its end, as in the paper.
        update: Whether the contact force is "implicit", or "lagged" one step as equation 2 of the
            paper prints it.

    Raises:
        ImpactfemError: The stick has no such floor, or the wall starts inside the building.
        SolutionError: The contact forces do not converge, or lagged ones create energy.
    """
    system = wall_system(stick, experiment, K=K, xi=xi, tension=tension)
    # Pairs turn n · u of the stick into a change of the gap, of the other sign.
    along = -system.J
    u0 = static_state(stick, experiment)
    experiment.check_start(along @ u0)
    at_rest = np.zeros((experiment.n_t, 3))
    response = simulate(system, at_rest, experiment.time_step, update=update, u0=u0)
    return WallHistory(
        floors=experiment.floors,
        mass=np.array([pair.law.mass for pair in system.pairs], dtype=np.float64),
        gap=experiment.gap,
        time_step=experiment.time_step,
        displacement=response.u @ along.T,
        velocity=response.v @ along.T,
        force=response.force,
        opening=response.gap,
    )
