"""The contact law of one pair: what every law has, and the registry of laws by name.

A law is a frozen dataclass that inherits from `Law`. Its fields are the keys of the law in the case
file, the stiffness first, and the effective mass of the pair. It needs the compiled function
``force`` (see `law_function`) and a ``type``, the name by which it is registered. Restitution and
duration of the collision of two free masses follow by integration unless a closed form is given.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar, Self

import numba
import numpy as np

from impactfem.case.further_laws import add_law
from impactfem.coupling.free_impact import FreeImpact, free_impact
from impactfem.coupling.law_function import address_of, advance_state, law_force
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault, InputError

LAWS: dict[str, type[Law]] = {}
"""Classes of contact laws by the name of their type; a class enters when it is defined."""
_NEAR = 1e-6  # part of p or v₀ over which differences are taken
_LIKE = 1e-3  # error of a derivative that is accepted
TYPICAL_SPEED = 0.3
"""Approach velocity for the restitution of a law without a closed form [m/s]."""


@dataclass(frozen=True)
class Law:
    """A contact law for one pair."""

    type: ClassVar[str] = ""  #: name in the case file
    stiffness_unit: ClassVar[str] = "N/m"  #: unit of the stiffness
    n_state: ClassVar[int] = 0  #: number of state variables besides the approach velocity
    jumps: ClassVar[bool] = False  #: the force begins with a jump at p = 0
    unilateral: ClassVar[bool] = False  #: impenetrable, without a force law
    #: Fields that are proportional to the area of contact, besides the mass.
    per_area: ClassVar[tuple[str, ...]] = ("stiffness",)
    #: Section of the case file with the fields as keys, for a law that `case.contacts` has not.
    Keys: ClassVar[Any]
    force: ClassVar[Any]  #: static method (parameters, p, v, state) -> (F, dF/dp, dF/dv)
    #: Static method (parameters, p, v, state) that updates state[1:]; None without memory.
    advance: ClassVar[Any] = None

    stiffness: float  #: K [stiffness_unit]
    mass: float = field(kw_only=True)  #: effective mass of the two points [kg]

    def __init_subclass__(cls) -> None:
        if "type" in vars(cls):
            LAWS[cls.type] = cls
        if "Keys" in vars(cls):
            add_law(cls.Keys)

    @classmethod
    def of_case(cls, name: str, entry: Any, mass: float) -> Self:
        """Make the law of a pair from the keys in the case file and the effective mass [kg].

        Raises:
            ValueError: A value of the law with this name is not known yet.
        """
        keys = {one.name: getattr(entry, one.name) for one in fields(cls) if one.name != "mass"}
        return cls(**keys, mass=mass)

    @property
    def name(self) -> str:
        """Name of the law in results."""
        return self.type

    @property
    def parameters(self) -> tuple[float, ...]:
        """Parameters of ``force``, the stiffness first."""
        return tuple(getattr(self, one.name) for one in fields(self) if one.name != "mass")

    @property
    def addresses(self) -> tuple[int, int]:
        """Addresses of the compiled ``force`` and ``advance``; 0 for none."""
        kind = type(self)
        advance = kind.advance
        return (
            address_of(self.name, "force", kind.force),
            0 if advance is None else address_of(self.name, "advance", advance),
        )

    @property
    def epsilon(self) -> float:
        """Restitution of two free masses [-]."""
        return self.restitution_at(TYPICAL_SPEED)

    @property
    def target_restitution(self) -> float:
        """Restitution that is requested [-]."""
        return self.epsilon

    @property
    def xi(self) -> float:
        """Damping ratio [-]; nan for a law that has none."""
        return math.nan

    @property
    def dashpot(self) -> float:
        """Constant C of a linear dashpot [N s/m]; nan for a law that has none."""
        return math.nan

    def at(self, p: float, v: float, state: Sequence[float]) -> tuple[float, float, float]:
        """Return F [N], dF/dp and dF/dv in a state; state[0] is the approach velocity [m/s]."""
        values = np.array(self.parameters, dtype=float)
        F, k, c = law_force(self.addresses[0], values, p, v, np.array(state, dtype=float))
        return F, k, c

    def _free_impact(self, speed: float) -> FreeImpact:
        return free_impact(self.addresses, self.parameters, self.n_state, self.mass, speed)

    def restitution_at(self, speed: float) -> float:
        """Restitution of two free masses with an approach velocity [m/s], by integration [-]."""
        return self._free_impact(speed).restitution if speed > 0.0 else math.nan

    def duration(self, speed: float) -> float:
        """Duration of an impact of two free masses with an approach velocity [m/s], in [s].

        Infinite at speed zero, nan if the velocity is not known.
        """
        if math.isnan(speed):
            return math.nan
        return self._free_impact(speed).duration if speed > 0.0 else math.inf

    def onset_force(self, speed: float) -> float:
        """Force at the begin of contact with an approach velocity [m/s], in [N]."""
        if math.isnan(speed):
            return math.nan
        return self.at(1e-300, speed, (speed, *(0.0,) * self.n_state))[0]

    def dissipated(self, gap: Array, rate: Array) -> float:
        """Energy that the law dissipates along a motion of one contact, ∮ F(p, v) dp [J].

        Trapezoidal rule over the part of each step in which there is contact. Where contact begins
        or ends within a step, the force is the law's at p = 0. Gap [m] and rate [m/s], shape (n,)
        each, begin before the contact.
        """
        values, addresses = np.array(self.parameters, dtype=float), self.addresses
        return float(_dissipated(*addresses, values, -gap, -rate, np.zeros(1 + self.n_state)))

    def part(self, share: float) -> Self:
        """Return the law of a part of the area of contact.

        Penetration, velocities and restitution are those of the whole.
        """
        changed = {name: share * getattr(self, name) for name in (*self.per_area, "mass")}
        return replace(self, **changed)

    def check(self, speed: float = TYPICAL_SPEED) -> None:
        """Test the law along a collision of two free masses with an approach velocity [m/s].

        The force is implicit in the time loop, by Newton's method: F must not fall with p or v, and
        the derivatives must be right.

        Raises:
            InputError: A number or the force is not usable, with the reason.
        """
        file = f"contact law {self.name!r}"
        faults = []
        if not self.parameters or not np.isfinite(self.parameters).all():
            expected = "expected finite numbers, the stiffness first"
            faults.append(Fault(file, "parameters", self.parameters, expected))
        for key, value in (("mass", self.mass), ("speed", speed)):
            if not 0.0 < value < np.inf:
                faults.append(Fault(file, key, value, "expected a number greater than 0"))
        if faults:
            raise InputError(faults)
        impact = self._free_impact(speed)
        if not np.isfinite(impact.duration):
            masses = f"two free masses of {self.mass:g} kg at {speed:g} m/s"
            expected = f"expected a force that separates {masses}"
            raise InputError([Fault(file, "force", None, expected)])
        # Derivatives in the states of the collision; at a kink, the difference on either side.
        for p, v, state in impact.states:
            F, k, c = self.at(p, v, state)
            for symbol, given, dp, dv in (("p", k, _NEAR * p, 0.0), ("v", c, 0.0, _NEAR * speed)):
                after = (self.at(p + dp, v + dv, state)[0] - F) / (dp + dv)
                before = (F - self.at(p - dp, v - dv, state)[0]) / (dp + dv)
                size = _LIKE * (max(abs(after), abs(before)) + abs(F) / (p if dp else speed))
                if not min(abs(given - after), abs(given - before)) <= size:
                    wrong = f"dF/d{symbol} = {given:.6g}, expected the change of F, {after:.6g}"
                elif max(after, before) < -size:
                    wrong = f"F falls with {symbol}; expected a force that does not"
                else:
                    continue
                raise InputError([Fault(file, "force", f"p = {p:.6g} m, v = {v:.6g} m/s", wrong)])

    def describe(self) -> str:
        """Return the law in words and numbers, for other programs and people."""
        return (
            f"{self.name}: stiffness {self.stiffness:.9g} {self.stiffness_unit}, "
            f"restitution requested {self.target_restitution:.6g}, of two free masses "
            f"{self.epsilon:.6g}, effective mass {self.mass:.9g} kg"
        )


def effective_mass(m1: float, m2: float = math.inf) -> float:
    """Return m₁ m₂ / (m₁ + m₂) of two masses in contact, or of one and a wall [kg]."""
    return 1.0 / (1.0 / m1 + 1.0 / m2)


@numba.njit(cache=True)
def _dissipated(
    force: int, advance: int, parameters: Array, p: Array, v: Array, state: Array
) -> float:
    energy = 0.0
    # The motion counts as open at the first time.
    advance_state(advance, parameters, min(p[0], 0.0), v[0], state)
    for k in range(p.size - 1):
        if k > 0:
            advance_state(advance, parameters, p[k], v[k], state)
        if p[k] <= 0.0 and p[k + 1] <= 0.0:
            continue
        p0, p1 = max(p[k], 0.0), max(p[k + 1], 0.0)
        F0 = law_force(force, parameters, max(p0, 1e-300), v[k], state)[0]
        F1 = law_force(force, parameters, max(p1, 1e-300), v[k + 1], state)[0]
        energy += (p1 - p0) * 0.5 * (F0 + F1)
    return energy
