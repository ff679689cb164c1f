"""Collision of two free masses under a contact law, by integration.

With the effective mass m of the pair, m p'' = -F(p, p') from p = 0, p' = v₀ until p = 0 again.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

from impactfem.coupling.law_function import advance_state, law_force
from impactfem.system.arrays import Array

SHORTEST, DOUBLINGS = 1e-9, 60
"""Shortest time scale of an impact [s], and the number of times that it is doubled."""
LONGEST = 1e4
"""Longest impact, in multiples of its time scale."""
STATES = 16
"""Number of states of a collision at which the derivatives are compared."""
MEMORY_STEP = 0.01
"""Longest step under a law with memory, in time scales: its state changes after each step."""
_State = tuple[float, float, tuple[float, ...]]


@dataclass(frozen=True)
class FreeImpact:
    """Result of the collision of two free masses."""

    duration: float  #: time until p = 0 again [s]; infinite if the masses do not separate
    restitution: float  #: separation over approach velocity [-]
    #: States (p, v, state of the law) on the way.
    states: tuple[_State, ...]


@lru_cache(maxsize=4096)
def free_impact(
    addresses: tuple[int, int],
    parameters: tuple[float, ...],
    n_state: int,
    mass: float,
    v0: float,
) -> FreeImpact:
    """Integrate the collision of two free masses with an approach velocity v₀ > 0 [m/s].

    The law has the addresses of its functions, their parameters, and n_state variables besides v₀;
    the effective mass is in kg.

    The variables are x = p / (v₀ T) and τ = t / T, where T is the time in which the force on masses
    that keep the velocity v₀ reaches m v₀ / T.
    """
    values, (force, advance) = np.array(parameters, dtype=float), addresses
    state = np.zeros(1 + n_state)
    advance_state(advance, values, 0.0, v0, state)
    none = FreeImpact(np.inf, np.nan, ())
    # The time scale, within a factor of two.
    scales = (SHORTEST * 2.0 ** np.arange(DOUBLINGS)).tolist()
    large = (T for T in scales if law_force(force, values, v0 * T, v0, state)[0] * T >= mass * v0)
    if (T := next(large, None)) is None:
        return none

    def rates(_: float, y: Array) -> Array:
        F = law_force(force, values, max(v0 * T * y[0], 1e-300), v0 * y[1], state)[0]
        return np.array([y[1], -F * T / (mass * v0)])

    step = MEMORY_STEP if n_state else np.inf
    solver = DOP853(rates, 0.0, np.array([0.0, 1.0]), LONGEST, rtol=1e-9, atol=1e-12, max_step=step)
    states: list[_State] = []
    while solver.status == "running" and np.isfinite(solver.y).all():
        solver.step()
        x, w = map(float, solver.y)
        if x <= 0.0 and solver.step_size:
            end, dense = _root(solver)
            return FreeImpact(T * end, -float(dense[1]), _spread(states))
        advance_state(advance, values, v0 * T * x, v0 * w, state)
        if x > 1e-6:
            states.append((v0 * T * x, v0 * w, tuple(state.tolist())))
    return none


def _root(solver: DOP853) -> tuple[float, Array]:
    """Return the time in the last step at which x = 0, and (x, x') there."""
    dense = solver.dense_output()
    end = float(brentq(lambda t: dense(t)[0], solver.t_old, solver.t, xtol=1e-15, rtol=1e-14))
    return end, dense(end)


def _spread(states: list[_State]) -> tuple[_State, ...]:
    chosen = np.linspace(0, len(states) - 1, min(STATES, len(states))).astype(int)
    return tuple(states[k] for k in chosen)
