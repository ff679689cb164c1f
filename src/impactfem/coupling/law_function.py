"""Force functions of contact laws: compiled to machine code, and called by their address.

A law has a function ``force(parameters, p, v, state) -> (F, dF/dp, dF/dv)`` of the penetration
p > 0 [m], its rate v [m/s] and its state; the force F [N] is positive in compression. ``state[0]``
is the approach velocity v₀ of the contact, which the time loop keeps. A law with memory has more
entries, and a second function ``advance(parameters, p, v, state)`` that updates them once a step.

The time loop calls both by their addresses. It is therefore compiled once for all laws.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any

import numba
from llvmlite import ir  # type: ignore[import-untyped]
from numba.core.errors import NumbaError
from numba.extending import intrinsic

from impactfem.system.arrays import Array
from impactfem.system.errors import Fault, InputError

Force = Callable[[Array, float, float, Array], tuple[float, float, float]]
Advance = Callable[[Array, float, float, Array], None]

# Nothing is allocated: see `march`.
_LOOP: Any = {"cache": True, "_nrt": False}

_TYPES: Any = numba.types
_REAL = _TYPES.float64
_ROW = _TYPES.Array(_REAL, 1, "C")
_FORCE = _TYPES.UniTuple(_REAL, 3)(_ROW, _REAL, _REAL, _ROW)
_ADVANCE = _TYPES.void(_ROW, _REAL, _REAL, _ROW)
_EXPECTED = {
    "force": "expected a function (parameters, p, v, state) that returns the three numbers F, "
    "dF/dp and dF/dv, in plain Python with math or numpy that numba can compile",
    "advance": "expected a function (parameters, p, v, state) that changes state[1:], in plain "
    "Python with math or numpy that numba can compile",
}


def address_of(law: str, key: str, function: Force | Advance) -> int:
    """Return the address of the compiled ``force`` or ``advance`` of a law; compile it once.

    Division by zero in the function gives an infinity or nan, not an error.

    Raises:
        InputError: It is not such a function, or numba cannot compile it.
    """
    where = f"contact law {law!r}"
    if not isinstance(function, FunctionType):
        raise InputError([Fault(where, key, function, _EXPECTED[key])])
    try:
        return int(_compiled(function, key).address)
    except (NumbaError, TypeError) as error:
        reason = str(error).strip().partition("\n")[0]
        raise InputError([Fault(where, key, reason, _EXPECTED[key])]) from error


@cache
def _compiled(function: FunctionType, key: str) -> Any:
    # Never released: the address of a function that is gone could belong to another function.
    signature = _FORCE if key == "force" else _ADVANCE
    cache = function.__module__.startswith("impactfem.")
    return numba.cfunc(signature, error_model="numpy", cache=cache)(function)


def _typed_call(signature: Any) -> Any:
    """Return an intrinsic that calls the function at an address, with the types of a signature."""

    def call(
        typing: Any, address: Any, parameters: Any, p: Any, v: Any, state: Any
    ) -> tuple[Any, Any] | None:
        if not all(isinstance(x, _TYPES.Array) and x.layout == "C" for x in (parameters, state)):
            return None
        typed = signature.return_type(_TYPES.int64, parameters, _REAL, _REAL, state)

        def generate(context: Any, builder: Any, called: Any, values: Any) -> Any:
            returned = context.get_value_type(called.return_type)
            function = ir.FunctionType(returned, [value.type for value in values[1:]])
            return builder.call(builder.inttoptr(values[0], function.as_pointer()), values[1:])

        return typed, generate

    return intrinsic(call)


_call_force: Any = _typed_call(_FORCE)
call_advance: Any = _typed_call(_ADVANCE)


@numba.njit(**_LOOP)
def law_force(
    address: int, parameters: Array, p: float, v: float, state: Array
) -> tuple[float, float, float]:
    """Return F, dF/dp and dF/dv of the law at an address; zero without penetration."""
    if p <= 0.0:
        return 0.0, 0.0, 0.0
    F, k, c = _call_force(address, parameters, p, v, state)
    return F, k, c


@numba.njit(**_LOOP)
def advance_state(address: int, parameters: Array, p: float, v: float, state: Array) -> None:
    """Update the state of a contact from the motion at the end of a step.

    The approach velocity is the rate of the last time without penetration. Address 0 is that of a
    law without further memory.
    """
    if p <= 0.0:
        state[0] = max(v, 0.0)
    if address != 0:
        call_advance(address, parameters, p, v, state)
