"""Contact laws: the force between two points from their penetration and its rate.

A law is one small compiled function ``(parameters, p, v, v0) -> (F, dF/dp, dF/dv)`` with the
penetration p > 0 [m], its rate v [m/s], the speed of approach v0 with which this contact began
[m/s], and the force F [N], positive in compression. The compiled time loop picks it by its code:
those of this module are small numbers; that of a user-defined law is the address of its compiled
function. So the loop is compiled once, and knows any number of laws. A law of the case file needs
its keys in `case.contacts` and, here, its branch in `law_force` and its line in `law_of`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from types import FunctionType
from typing import Any

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba.core.errors import NumbaError
from numba.extending import intrinsic

from impactfem.case.contacts import (
    ContactLaw,
    HertzDampLaw,
    HertzLaw,
    JankowskiLaw,
    KelvinVoigtLaw,
    UnilateralLaw,
)
from impactfem.coupling import restitution as relations
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault, InputError

Force = Callable[[Array, float, float, float], tuple[float, float, float]]

_TYPES: Any = numba.types
_REAL = _TYPES.float64
_SIGNATURE = _TYPES.UniTuple(_REAL, 3)(_TYPES.Array(_REAL, 1, "C"), _REAL, _REAL, _REAL)
_FORM = (
    "expected a function (parameters, p, v, v0) that returns the three numbers F, dF/dp and dF/dv, "
    "in plain Python with math or numpy that numba can compile"
)


_compiled: Any = lru_cache(maxsize=256)(numba.cfunc(_SIGNATURE, error_model="numpy"))


def compile_force(name: str, force: Force) -> Any:
    """The compiled function of a law; its `address` is the code of the law.

    Division by zero in it gives an infinity or nan, not an error. The address holds as long as the
    object that is returned. What is no such function, or numba cannot compile, is refused.
    """
    where = f"contact law {name!r}"
    if not isinstance(force, FunctionType):
        raise InputError([Fault(where, "force", force, _FORM)])
    try:
        return _compiled(force)
    except (NumbaError, TypeError) as error:
        reason = str(error).strip().partition("\n")[0]
        raise InputError([Fault(where, "force", reason, _FORM)]) from error


def _typed_call(
    typing: Any, address: Any, parameters: Any, p: Any, v: Any, v0: Any
) -> tuple[Any, Any] | None:
    """Call the function at an address, with the types of `_SIGNATURE`."""
    if not isinstance(parameters, _TYPES.Array) or parameters.layout != "C":
        return None
    signature = _SIGNATURE.return_type(_TYPES.int64, parameters, *_SIGNATURE.args[1:])

    def generate(context: Any, builder: Any, called: Any, values: Any) -> Any:
        returned = context.get_value_type(called.return_type)
        function = ir.FunctionType(returned, [value.type for value in values[1:]])
        return builder.call(builder.inttoptr(values[0], function.as_pointer()), values[1:])

    return signature, generate


_call: Any = intrinsic(_typed_call)

UNILATERAL = -1
"""No law: what touches does not penetrate, whatever force that takes."""
KELVIN_VOIGT = 0
KELVIN_VOIGT_NO_TENSION = 1
HERTZ = 2
JANKOWSKI = 3
N_PARAMETERS = 4


@dataclass(frozen=True)
class Law:
    """A contact law for one pair, ready for the loop."""

    name: str  #: what it is, in the words of the case file
    code: int  #: which compiled law; above JANKOWSKI, the address of a user-defined one
    #: Its parameters, shape (N_PARAMETERS,): the stiffness K [N/m or N/m^1.5], then those of the
    #: law's function.
    parameters: Array
    asked: float  #: the restitution requested [-]
    epsilon: float  #: the restitution that two free masses get from it [-]
    xi: float  #: its damping ratio [-]; nan for a law that has none
    mass: float  #: effective mass of the two points [kg]

    @property
    def stiffness(self) -> float:
        """The stiffness K [N/m or N/m^1.5]."""
        return float(self.parameters[0])

    @property
    def linear(self) -> bool:
        """Whether the elastic force goes with p; else with p^1.5."""
        return self.code in (KELVIN_VOIGT, KELVIN_VOIGT_NO_TENSION)

    @property
    def stiffness_unit(self) -> str:
        """Unit of the stiffness."""
        if self.code == UNILATERAL:
            return ""
        return "N/m" if self.linear else "N/m^1.5"

    def duration(self, speed: float) -> float:
        """Duration of an impact of two free masses with a speed of approach v₀ [m/s], in [s].

        Kelvin-Voigt, at any speed: until p = 0, π / Ω_D, or until the force is zero where it may
        not pull. Hertz: 2.9433 p_max / v₀ with p_max = (5 m v₀² / (4 K))^(2/5), that of the elastic
        impact (Goldsmith 1960, Impact, section 4.2); Hertz-damp and Hunt-Crossley last up to 1.5
        times as long at ε = 0.1, Jankowski up to 2 % less. Unilateral contact has none, nan.
        """
        K, m = self.stiffness, self.mass
        if self.linear:
            tension = self.code == KELVIN_VOIGT
            return relations.kelvin_voigt_phase(self.xi, tension=tension) / float(np.sqrt(K / m))
        if self.code == UNILATERAL:
            return float("nan")
        if speed <= 0.0:
            return float("inf")
        return float(2.94328 * (1.25 * m / K) ** 0.4 * speed**-0.2)

    def onset_force(self, speed: float) -> float:
        """Force with which contact begins [N]: C v₀ for Kelvin-Voigt, zero for the others."""
        if self.code == UNILATERAL:
            return float("nan")
        return law_force(self.code, self.parameters, 1e-300, speed, speed)[0]

    def part(self, share: float) -> Law:
        """The law of a part of the area of contact: of its stiffness, its dashpot and its mass.

        Penetration, speeds and restitution are those of the whole.
        """
        parameters = self.parameters.copy()
        # K and C go with the area; the others are ratios and speeds.
        parameters[: 2 if self.linear or self.code == JANKOWSKI else 1] *= share
        return replace(self, parameters=parameters, mass=share * self.mass)

    def describe(self) -> str:
        """The law in words and numbers, for other programs and people."""
        if self.code == UNILATERAL:
            return self.name
        return (
            f"{self.name}: stiffness {self.stiffness:.9g} {self.stiffness_unit}, "
            f"restitution requested {self.asked:.6g}, of two free masses {self.epsilon:.6g}, "
            f"effective mass {self.mass:.9g} kg"
        )


def law_of(name: str, entry: ContactLaw, mass: float) -> Law:
    """The law of a pair with an effective mass [kg] by its keys in the case file.

    Raises:
        ValueError: Values of the keys are still to be calibrated, or it says nothing of damping.
    """
    if isinstance(entry, KelvinVoigtLaw):
        if entry.stiffness == "calibrated" or entry.restitution == "calibrated":
            raise ValueError(
                f"the contact law {name} still asks for calibrated values; "
                "impactfem.stages.calibrate.selection.with_calibrated_contact puts them in"
            )
        if (xi := entry.damping_ratio) is None:
            if entry.restitution is None:
                raise ValueError(f"the contact law {name} has no restitution and no damping_ratio")
            xi = relations.kelvin_voigt_xi(entry.restitution, tension=entry.tension)
        return kelvin_voigt(entry.stiffness, xi, mass, tension=entry.tension)
    if isinstance(entry, UnilateralLaw):
        nan, none = float("nan"), np.full(N_PARAMETERS, np.nan)
        return Law("unilateral", UNILATERAL, none, nan, nan, nan, mass)
    if isinstance(entry, HertzLaw):
        return hertz(entry.stiffness, mass)
    exact = entry.relation == "exact"
    if isinstance(entry, JankowskiLaw):
        return jankowski(entry.stiffness, entry.restitution, mass, exact=exact)
    make = hertz_damp if isinstance(entry, HertzDampLaw) else hunt_crossley
    slowest = entry.slowest_approach
    return make(entry.stiffness, entry.restitution, mass, exact=exact, slowest=slowest)


def effective_mass(m1: float, m2: float = math.inf) -> float:
    """Effective mass m₁ m₂ / (m₁ + m₂) of two masses in contact, or one and a wall [kg]."""
    return 1.0 / (1.0 / m1 + 1.0 / m2)


def kelvin_voigt(K: float, xi: float, mass: float, *, tension: bool = True) -> Law:
    """The Kelvin-Voigt law of a pair: F = K p + C v, C = 2 ξ √(K m) (paper, equations 2 and 3).

    K is the penalty stiffness [N/m], ξ the damping ratio at contact [-], m the effective mass of
    the pair [kg]. The force jumps at onset to C v₀ and, with tension as in the paper, pulls at the
    end.
    """
    epsilon = relations.kelvin_voigt(xi, tension=tension)
    code = KELVIN_VOIGT if tension else KELVIN_VOIGT_NO_TENSION
    name = "kelvin-voigt" if tension else "kelvin-voigt without tension"
    C = 2.0 * xi * np.sqrt(K * mass)
    return Law(name, code, _parameters(K, C), epsilon, epsilon, xi, mass)


def hertz(K: float, mass: float) -> Law:
    """Hertz's elastic contact: F = K p^1.5 (Hertz 1881; Goldsmith 1960, Impact).

    K is in N/m^1.5, the effective mass of the pair in kg.
    """
    return Law("hertz", HERTZ, _parameters(K, 0.0), 1.0, 1.0, np.nan, mass)


def hertz_damp(
    K: float, epsilon: float, mass: float, *, exact: bool = False, slowest: float = 1e-3
) -> Law:
    """Hertz contact with damping: F = K p^1.5 (1 + χ v / v₀), χ = 3/4 (1 - ε²).

    Muthukumar and DesRoches 2006, Earthquake Engineering and Structural Dynamics 35, 811-828,
    after Lankarani and Nikravesh 1990. Their χ equates the loss to the drop of the kinetic energy
    with the elastic path, good for ε near 1.

    Args:
        K: Stiffness [N/m^1.5].
        epsilon: Restitution requested, 0 < ε <= 1 [-].
        mass: Effective mass of the pair [kg].
        exact: Take the χ that returns ε exactly instead of the published one.
        slowest: Least v₀ that the law takes into account [m/s]: a contact that begins at rest
            would be damped without bound.
    """
    chi = relations.exact_chi(epsilon) if exact else 0.75 * (1.0 - epsilon**2)
    return _damped_hertz("hertz-damp", K, chi, epsilon, mass, slowest)


def hunt_crossley(
    K: float, epsilon: float, mass: float, *, exact: bool = False, slowest: float = 1e-3
) -> Law:
    """Hunt and Crossley's law: F = K p^1.5 (1 + χ v / v₀), χ = 3/2 (1 - ε).

    Hunt and Crossley 1975, Journal of Applied Mechanics 42, 440-445; good for ε near 1. With
    `exact` it is the same law as `hertz_damp`. Arguments as there.
    """
    chi = relations.exact_chi(epsilon) if exact else 1.5 * (1.0 - epsilon)
    return _damped_hertz("hunt-crossley", K, chi, epsilon, mass, slowest)


def jankowski(K: float, epsilon: float, mass: float, *, exact: bool = False) -> Law:
    """Jankowski's law: F = β p^1.5 + c v while approaching, F = β p^1.5 while parting.

    With c = 2 ξ √(β √p m) and ξ = 9 √5 / 2 (1 - ε²) / (ε (ε (9π - 16) + 16)) (Jankowski 2005 and
    2006, Earthquake Engineering and Structural Dynamics 34, 595-611, and 35, 517-524). Arguments as
    for `hertz_damp`.
    """
    if exact:
        xi = relations.exact_jankowski_xi(epsilon)
    else:
        lost = 4.5 * np.sqrt(5.0) * (1.0 - epsilon**2)
        xi = float(lost / (epsilon * (epsilon * (9.0 * np.pi - 16.0) + 16.0)))
    parameters = _parameters(K, 2.0 * xi * np.sqrt(K * mass))
    return Law("jankowski", JANKOWSKI, parameters, epsilon, relations.jankowski(xi), xi, mass)


def _damped_hertz(
    name: str, K: float, chi: float, epsilon: float, mass: float, slowest: float
) -> Law:
    parameters = _parameters(K, chi, slowest)
    return Law(name, HERTZ, parameters, epsilon, relations.damped_hertz(chi), np.nan, mass)


def _parameters(*values: float) -> Array:
    parameters = np.zeros(N_PARAMETERS)
    parameters[: len(values)] = values
    return parameters


@numba.njit(cache=True)
def law_force(
    code: int, parameters: Array, p: float, v: float, v0: float
) -> tuple[float, float, float]:
    """F, dF/dp and dF/dv of the law with this code; zero without penetration."""
    if p <= 0.0:
        return 0.0, 0.0, 0.0
    if code in (KELVIN_VOIGT, KELVIN_VOIGT_NO_TENSION):
        # F = K p + C v pulls near the end of the contact (paper, equation 2), or is clipped there.
        K, C = parameters[0], parameters[1]
        F = K * p + C * v
        if code == KELVIN_VOIGT_NO_TENSION and F <= 0.0:
            return 0.0, 0.0, 0.0
        return F, K, C
    if code == HERTZ:
        # F = max(0, K p^1.5 (1 + χ v / v₀)); elastic with χ = 0.
        K, chi = parameters[0], parameters[1]
        elastic = K * p * np.sqrt(p)
        mu = 0.0
        if chi != 0.0:
            mu = chi / max(v0, parameters[2])
        factor = 1.0 + mu * v
        if factor <= 0.0:
            return 0.0, 0.0, 0.0
        return elastic * factor, 1.5 * K * np.sqrt(p) * factor, elastic * mu
    if code == JANKOWSKI:
        # F = β p^1.5 + 2 ξ √(β m) p^0.25 v while v > 0, else β p^1.5.
        beta, c = parameters[0], parameters[1]
        F, k = beta * p * np.sqrt(p), 1.5 * beta * np.sqrt(p)
        if v <= 0.0:
            return F, k, 0.0
        root = np.sqrt(np.sqrt(p))
        return F + c * root * v, k + 0.25 * c * root / p * v, c * root
    F, k, c = _call(code, parameters, p, v, v0)
    return F, k, c
