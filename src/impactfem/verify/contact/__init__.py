"""Contact: collisions of masses that benchmarks and tests share."""

from __future__ import annotations

import numpy as np

from impactfem.coupling.contact import Law
from impactfem.coupling.pounding import End, Pair, Response, System, Update, simulate
from impactfem.sticks.stick import Stick, mass_on_spring

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
    """Two free masses [kg], 1 towards 2 at rest, followed until the law has let them go.

    Args:
        law: The contact law.
        m1: First mass.
        m2: Second mass.
        speed: Speed of approach [m/s].
        dt: Time step [s].
        phase: Part of a step after which the gap closes, 0 to 1 [-].
        update: How the contact force is taken.
    """
    one, other = mass_on_spring("1", m1, 0.0), mass_on_spring("2", m2, 0.0)
    pair = Pair("1-2", End.of_floor(one, 1), End.of_floor(other, 1), Y, speed * dt * phase, law)
    # Heavily damped Hertz contacts part slowly.
    patience = 1.5 if law.linear else 1.5 / law.epsilon
    n_t = int(np.ceil(patience * law.duration(speed) / dt)) + 3
    ground, v0 = np.zeros((n_t, 3)), speed * np.eye(12)[1]
    return simulate(System((one, other), (pair,)), ground, dt, update=update, v0=v0)


def against_wall(mass: Stick, law: Law, gap: float, speed: float, dt: float, n_t: int) -> Response:
    """One mass of `mass_on_spring` that moves towards a rigid wall, n_t steps of dt [s]."""
    system = System((mass,), (Pair("wall", End.of_floor(mass, 1), None, Y, gap, law),))
    return simulate(system, np.zeros((n_t, 3)), dt, v0=speed * np.eye(6)[1])
