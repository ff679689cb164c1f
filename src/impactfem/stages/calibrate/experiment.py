"""The experiment: a building drawn aside, let go, and stopped by a rigid wall; and its stick there.

What floors do in front of the wall is a `WallHistory`, whatever model computed it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg

from impactfem.case.calibration import Pull
from impactfem.coupling.laws import KelvinVoigt
from impactfem.coupling.pounding import End, Pair, System, Update, simulate
from impactfem.sticks.stick import Stick
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError

if TYPE_CHECKING:
    from impactfem.reduction.wall import Side

SEPARATION = 5e-3
"""Pulses less than this apart are one impact [s]: a slab's waves take some ms, its return 0.1 s."""


@dataclass(frozen=True)
class WallExperiment:
    """A building in front of a rigid wall, without ground motion (paper, section 3.2.2).

    One floor is drawn aside, see `impactfem.reduction.wall`; at t = 0 what held it is gone
    and the building, at rest, is free. The wall is a plane at the gap g from the undeformed
    building, n the unit vector towards it: a point with displacement u touches where n · u = g.
    """

    floors: tuple[int, ...]  #: numbers of the floors that may hit the wall, each once
    displaced_floor: int  #: number of the floor that is displaced
    #: Its displacement along n, negative away from the wall; under a load that of its mass centre
    #: [m].
    displacement: float
    gap: float  #: gap g at rest [m]
    duration: float  #: length of the window in time [s]
    time_step: float  #: time step [s]
    side: Side = "y+"  #: side of the building on which the wall stands: "x-", "x+", "y-" or "y+"
    pull: Pull = "whole_floor"  #: how the floor is drawn aside
    theta: float = 0.5  #: θ of the time stepping of the 3D model, from ½ to 1
    unilateral_scheme: str = "moreau"  #: its scheme of contact, "moreau" or "massless"
    separation: float = SEPARATION  #: shortest time without force between two impacts [s]

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
        """Refuse a wall that stands inside the displaced building.

        What draws one floor aside displaces the others, too, and those above it more. Of each floor
        of `floors` the largest displacement along n of its points counts, shape (n_floors,) [m].
        """
        worst = int(np.argmax(displacement))
        if displacement[worst] > self.gap:
            raise ImpactfemError(
                f"the wall starts inside the building: floor {self.floors[worst]} is displaced by "
                f"{1e3 * displacement[worst]:.4g} mm towards it, the gap is "
                f"{1e3 * self.gap:.4g} mm, when floor {self.displaced_floor} is displaced by "
                f"{1e3 * self.displacement:.4g} mm"
            )


@dataclass(frozen=True, eq=False)
class WallHistory:
    """Histories of the floors that may hit the wall, at times 0, Δt, 2 Δt, ...

    Displacements and velocities are those along n, positive towards the wall; a force pushes its
    floor away from the wall when it is positive. An impulse P over the step that ends at a time
    stands there as the force P / Δt.
    """

    floors: tuple[int, ...]  #: numbers of the floors
    mass: Array  #: their masses, shape (n_floors,) [kg]
    gap: float  #: gap at rest [m]
    time_step: float  #: time step Δt [s]
    displacement: Array  #: of the mass centres, shape (n_t, n_floors) [m]
    velocity: Array  #: of the mass centres, shape (n_t, n_floors) [m/s]
    force: Array  #: resultants of the contact forces on the floors, shape (n_t, n_floors) [N]
    #: Distance of the wall from the nearest point of each floor, negative where it penetrates,
    #: shape (n_t, n_floors) [m]; None when it is not known.
    opening: Array | None = None

    def column(self, floor: int) -> int:
        """Index of the floor with this number; ImpactfemError where it may not hit."""
        if floor not in self.floors:
            known = ", ".join(map(str, self.floors))
            raise ImpactfemError(f"floor {floor} is none of those that may hit the wall: {known}")
        return self.floors.index(floor)


def static_state(stick: Stick, experiment: WallExperiment) -> Array:
    """Displacements of the stick whose floor is drawn aside, shape (n,) [m, rad].

    The floor is rigid and keeps the rotation that its storeys give it, as a slab does that is held
    along n alone. A force along n at the stick's axis does not turn it about the axis, so holding
    the whole floor, an even load on it and a force at its mass centre are the same.

    With j the row that takes n · u of the floor's mass centre, K u = λ jᵀ and j u = d:
    u = d K⁻¹ jᵀ / (j K⁻¹ jᵀ).
    """
    j = experiment.normal @ stick.translation(stick.floor_master(experiment.displaced_floor))
    u = scipy.linalg.solve(stick.K, j, assume_a="pos")
    return np.asarray(experiment.displacement * u / (j @ u), dtype=np.float64)


def wall_system(
    stick: Stick, experiment: WallExperiment, *, K: float, xi: float, tension: bool = True
) -> System:
    """The stick, and the pairs of its floors with the wall; arguments as `run_stick`.

    Contact is at the height of the mass centres and central: the resultant on a floor has no
    moment about a vertical axis. The wall has no mass to yield: equation 3 of the paper is then
    C = 2 ξ √(K M), M the mass of the floor.
    """
    n, centre = experiment.normal, (0.0, 0.0, 0.0)
    pairs = []
    for floor in experiment.floors:
        end = End.of_floor(stick, floor)
        law = KelvinVoigt(K, xi, mass=stick.point_mass(end.master, centre, n), tension=tension)
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
    """Run the experiment with the stick on the penalty law, K_Ceq [N/m] and ξ_c [-].

    With `tension` the contact may pull at its end, as in the paper; the update is "implicit", or
    "lagged": one step late, as equation 2 of the paper prints it. ImpactfemError where the stick
    has no such floor, or the wall starts inside the building; SolutionError where the contact
    forces do not converge, or lagged ones create energy.
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
