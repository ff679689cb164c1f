"""The wall experiment with the stick of the building, on the penalty law."""

from __future__ import annotations

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from impactfem.coupling.contact import kelvin_voigt
from impactfem.coupling.pounding import End, Pair, System, Update, simulate
from impactfem.stages.calibrate.experiment import WallExperiment
from impactfem.stages.calibrate.history import WallHistory
from impactfem.sticks.stick import Stick

Array = NDArray[np.float64]


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
