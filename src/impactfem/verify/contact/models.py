"""Small models that benchmarks share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.coupling.contact import Law
from impactfem.coupling.pounding import End, Pair, Response, System, Update, simulate
from impactfem.sticks.stick import Stick, mass_on_spring
from impactfem.verify.row import Row

Y = np.array([0.0, 1.0, 0.0])


def collision(
    law: Law,
    m1: float,
    m2: float,
    speed: float,
    dt: float,
    *,
    phase: float = 0.0,
    update: Update = "implicit",
) -> Response:
    """Two free masses, 1 towards 2 at rest, followed until the law has let them go.

    Args:
        law: The contact law.
        m1: First mass [kg].
        m2: Second mass [kg].
        speed: Speed of approach [m/s].
        dt: Time step [s].
        phase: Part of a step after which the gap closes, 0 to 1 [-].
        update: How the contact force is taken.
    """
    one, other = mass_on_spring("1", m1, 0.0), mass_on_spring("2", m2, 0.0)
    pair = Pair("1-2", End.of_floor(one, 1), End.of_floor(other, 1), Y, speed * dt * phase, law)
    system = System((one, other), (pair,))
    v0 = np.zeros(12)
    v0[1] = speed
    # Heavily damped Hertz contacts part slowly.
    patience = 1.5 if law.linear else 1.5 / law.epsilon
    n_t = int(np.ceil(patience * law.duration(speed) / dt)) + 3
    return simulate(system, np.zeros((n_t, 3)), dt, update=update, v0=v0)


def against_wall(mass: Stick, law: Law, gap: float, speed: float, dt: float, n_t: int) -> Response:
    """One mass of `mass_on_spring` that moves towards a rigid wall.

    Args:
        mass: The mass.
        law: The contact law.
        gap: Gap at rest [m].
        speed: Initial speed towards the wall [m/s].
        dt: Time step [s].
        n_t: Number of times.
    """
    system = System((mass,), (Pair("wall", End.of_floor(mass, 1), None, Y, gap, law),))
    v0 = np.zeros(6)
    v0[1] = speed
    return simulate(system, np.zeros((n_t, 3)), dt, v0=v0)


def fitted_order(steps: NDArray[np.float64], errors: NDArray[np.float64]) -> float:
    """Slope of log(error) over log(step)."""
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


def order_at_least(
    name: str,
    quantity: str,
    bound: float,
    sizes: NDArray[np.float64],
    errors: NDArray[np.float64],
    source: str,
    margin: float = 0.1,
) -> Row:
    """Row of a fitted order against a lower bound from theory.

    Args:
        name: The benchmark.
        quantity: What the errors are of.
        bound: Least order.
        sizes: Steps or sizes of elements.
        errors: Errors with them.
        source: Where the bound comes from.
        margin: What may be missing to the bound in a fit over these sizes.
    """
    what = f"fitted order of {quantity}, at least {bound:g}"
    order = fitted_order(sizes, errors)
    return Row(name, what, bound, order, "-", margin, source, at_least=True)
