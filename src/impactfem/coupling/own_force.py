"""The force of a contact law that a user writes: compiled, and called by its address.

The compiled time loop picks a law by its code. The codes of `contact` are small numbers; that of a
law of one's own is the address of its compiled function, which is far above them. So the loop is
compiled once, and knows any number of laws.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from types import FunctionType
from typing import Any

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba.core.errors import NumbaError
from numba.extending import intrinsic
from numpy.typing import NDArray

from impactfem.system.errors import Fault, InputError

Array = NDArray[np.float64]
Force = Callable[[Array, float, float, float], tuple[float, float, float]]

_TYPES: Any = numba.types
_REAL = _TYPES.float64
_SIGNATURE = _TYPES.UniTuple(_REAL, 3)(_TYPES.Array(_REAL, 1, "C"), _REAL, _REAL, _REAL)
_FORM = (
    "expected a function (parameters, p, v, v0) that returns the three numbers F, dF/dp and dF/dv, "
    "in plain Python with math or numpy that numba can compile"
)


def compile_force(name: str, force: Force) -> Any:
    """The compiled function of a law; its `address` is the code of the law.

    Division by zero in it gives an infinity or nan, not an error. The address holds as long as the
    object that is returned. A function is compiled once; the same one for all pairs is best.

    Args:
        name: Name of the law, for messages.
        force: ``(parameters, p, v, v0) -> (F, dF/dp, dF/dv)``.

    Raises:
        InputError: It is no such function, or numba cannot compile it.
    """
    where = f"contact law {name!r}"
    if not isinstance(force, FunctionType):
        raise InputError([Fault(where, "force", force, _FORM)])
    try:
        return _compiled(force)
    except (NumbaError, TypeError) as error:
        reason = str(error).strip().partition("\n")[0]
        raise InputError([Fault(where, "force", reason, _FORM)]) from error


@lru_cache(maxsize=256)
def _compiled(force: FunctionType) -> Any:
    return numba.cfunc(_SIGNATURE, error_model="numpy")(force)


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


@numba.njit(cache=True)
def own_force(
    address: int, parameters: Array, p: float, v: float, v0: float
) -> tuple[float, float, float]:
    """Force and derivatives of the law whose compiled function is at this address."""
    F, k, c = _call(address, parameters, p, v, v0)
    return F, k, c
