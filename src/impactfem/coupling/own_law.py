"""User-defined contact laws, in addition to those of `contact`: written and run in Python."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import scipy.integrate

from impactfem.coupling.contact import N_PARAMETERS, Force, Law, compile_force, law_force
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault, InputError

SHORTEST, DOUBLINGS = 1e-9, 60
"""Shortest time scale of an impact that is looked for [s], and how often it is doubled."""
LONGEST = 1e4
"""Longest impact, in its own time scale."""
STATES = 16
"""Number of states of a collision at which the derivatives are compared."""
_NEAR = 1e-6  # part of p or v₀ over which differences are taken
_LIKE = 1e-3


@dataclass(frozen=True)
class OwnLaw(Law):
    """A user-defined contact law for one pair; `own_law` makes it."""

    unit: str  #: unit of its first parameter, the stiffness
    compiled: Any  #: its compiled function, whose address is the code of the law

    @property
    def linear(self) -> bool:
        """Not taken to be: nothing but its force is known."""
        return False

    @property
    def stiffness_unit(self) -> str:
        """Unit of the stiffness."""
        return self.unit

    def duration(self, speed: float) -> float:
        """Duration of an impact of two free masses at v₀ [m/s], until p = 0, by integration [s]."""
        if speed <= 0.0:
            return float("inf")
        return _part(self.compiled, tuple(self.parameters), self.mass, speed).time

    def restitution(self, speed: float) -> float:
        """Restitution of two free masses at v₀ [m/s], by integration [-]."""
        return _part(self.compiled, tuple(self.parameters), self.mass, speed).epsilon


@dataclass(frozen=True)
class _Parting:
    """Two free masses that have collided: when p = 0 again, at which ε, and states on the way."""

    time: float
    epsilon: float
    states: tuple[tuple[float, float], ...]


def own_law(
    name: str,
    force: Force,
    parameters: Sequence[float],
    mass: float,
    *,
    speed: float = 0.3,
    asked: float | None = None,
    unit: str = "N/m",
) -> OwnLaw:
    """A contact law from a function.

    The function gets the parameters, the penetration p > 0 [m], its rate v [m/s] and the speed of
    approach v₀ with which this contact began [m/s], and returns the force F [N], positive in
    compression, with its derivatives to p and v. It is compiled by numba. In the time loop the
    force is implicit, by Newton's method: F may not fall with p or v, and the derivatives must be
    right. Both are tested along a collision of two free masses.

    Args:
        name: Its name, for tables.
        force: ``(parameters, p, v, v0) -> (F, dF/dp, dF/dv)``.
        parameters: Its parameters, one to four, the stiffness first.
        mass: Effective mass of the pair [kg].
        speed: Speed of approach at which it is tested and its restitution is reported [m/s].
        asked: Restitution requested [-]; that of two free masses when None.
        unit: Unit of the stiffness.

    Raises:
        InputError: The function or a number is not usable; says why.
    """
    file = f"contact law {name!r}"
    faults = []
    if not 1 <= len(parameters) <= N_PARAMETERS or not np.isfinite(parameters).all():
        expected = f"expected one to {N_PARAMETERS} finite numbers, the stiffness first"
        faults.append(Fault(file, "parameters", tuple(parameters), expected))
    for key, value in (("mass", mass), ("speed", speed)):
        if not 0.0 < value < np.inf:
            faults.append(Fault(file, key, value, "expected a number above 0"))
    if faults:
        raise InputError(faults)
    compiled = compile_force(name, force)
    values = np.zeros(N_PARAMETERS)
    values[: len(parameters)] = parameters
    code = int(compiled.address)
    parting = _part(compiled, tuple(values), mass, speed)
    if not np.isfinite(parting.time):
        expected = f"expected a force that parts two free masses of {mass:g} kg at {speed:g} m/s"
        raise InputError([Fault(file, "force", None, expected)])
    # The derivatives in the states of the collision; on either side of a kink will do.
    for p, v in parting.states:
        F, k, c = law_force(code, values, p, v, speed)
        for symbol, given, dp, dv in (("p", k, _NEAR * p, 0.0), ("v", c, 0.0, _NEAR * speed)):
            after = (law_force(code, values, p + dp, v + dv, speed)[0] - F) / (dp + dv)
            before = (F - law_force(code, values, p - dp, v - dv, speed)[0]) / (dp + dv)
            size = _LIKE * (max(abs(after), abs(before)) + abs(F) / (p if dp else speed))
            if not min(abs(given - after), abs(given - before)) <= size:
                wrong = f"dF/d{symbol} = {given:.6g}, expected {after:.6g}, as F changes there"
            elif max(after, before) < -size:
                wrong = f"F falls with {symbol}; expected a force that does not"
            else:
                continue
            raise InputError([Fault(file, "force", f"p = {p:.6g} m, v = {v:.6g} m/s", wrong)])
    return OwnLaw(
        name=name,
        code=code,
        parameters=values,
        asked=parting.epsilon if asked is None else asked,
        epsilon=parting.epsilon,
        xi=float("nan"),
        mass=mass,
        unit=unit,
        compiled=compiled,
    )


@lru_cache(maxsize=4096)
def _part(compiled: Any, parameters: tuple[float, ...], mass: float, v0: float) -> _Parting:
    """Two free masses from touch to p = 0, by integration of m p'' = -F(p, p').

    In the variables x = p / (v₀ T) and τ = t / T, where T is the time in which the force on masses
    that go on with v₀ reaches m v₀ / T. The key is the compiled function itself, not its address:
    an address may be used again.
    """
    code, values = int(compiled.address), np.array(parameters)
    # Within a factor of two.
    scales = SHORTEST * 2.0 ** np.arange(DOUBLINGS)
    within = (law_force(code, values, v0 * T, v0, v0)[0] * T >= mass * v0 for T in scales)
    T = next((float(T) for T, enough in zip(scales, within, strict=True) if enough), np.inf)

    def rates(_: float, y: Array) -> list[float]:
        F = law_force(code, values, max(v0 * T * y[0], 1e-300), v0 * y[1], v0)[0]
        return [y[1], -F * T / (mass * v0)]

    def apart(_: float, y: Array) -> float:
        return float(y[0])

    apart.terminal, apart.direction = True, -1.0  # type: ignore[attr-defined]
    if not np.isfinite(T):
        return _Parting(np.inf, np.nan, ())
    found = scipy.integrate.solve_ivp(
        rates, (0.0, LONGEST), [0.0, 1.0], "DOP853", events=apart, rtol=1e-9, atol=1e-12
    )
    if found.status != 1 or not np.isfinite(found.y).all():
        return _Parting(np.inf, np.nan, ())
    inside = np.flatnonzero(found.y[0] > 1e-6)
    chosen = inside[np.linspace(0, inside.size - 1, min(STATES, inside.size)).astype(int)]
    states = tuple((v0 * T * float(x), v0 * float(s)) for x, s in found.y[:, chosen].T)
    return _Parting(T * float(found.t[-1]), -float(found.y[1, -1]), states)
