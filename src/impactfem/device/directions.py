"""Combination of responses to several inputs: directions, rotations and supports."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]

InputRule = Literal["srss", "abs", "100-40-40"]
SupportRule = Literal["srss", "abs", "algebraic"]
"""As the first two of InputRule where supports move independently; "algebraic" where they move
together, so that the responses of a mode are added with their signs before modes are combined."""

PLANES = (("x", "ry"), ("y", "rx"), ("z",), ("rz",))
"""Components that one motion of a building brings about together: swaying along x comes with a
rotation about y."""


def combine_inputs(responses: Array, rule: InputRule) -> Array:
    """Combine responses to inputs that have their largest values at different times.

    Args:
        responses: Not negative, shape (n_i, ...), one for each input.
        rule: "srss"; "abs"; "100-40-40": the largest with 40 % of each other one, whichever is
            which (ASCE 4-98, section 3.2.7).

    Returns:
        Shape (...).

    Raises:
        ImpactfemError: The rule is unknown.
    """
    if rule == "srss":
        return np.asarray(np.sqrt(np.sum(responses**2, axis=0)), dtype=np.float64)
    if rule == "abs":
        return np.asarray(np.sum(np.abs(responses), axis=0))
    if rule == "100-40-40":
        size = np.abs(responses)
        return np.asarray(0.6 * np.max(size, axis=0) + 0.4 * np.sum(size, axis=0))
    raise ImpactfemError(
        f"inputs are combined by one of {', '.join(get_args(InputRule))}: got {rule!r}"
    )
