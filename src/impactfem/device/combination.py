"""Combination of the largest responses of modes, which do not happen at the same time.

All rules but the sum of absolute values are R² = Σ Σ ε_ij R_i R_j, with ε_ii = 1.

"srss"          ε_ij = 0.
"cqc"           Der Kiureghian (1981), Earthq. Eng. Struct. Dyn. 9, 419-435, stationary response to
                white noise; with r = ω_j / ω_i
                ε_ij = 8 √(ξ_i ξ_j) (ξ_i + r ξ_j) r^(3/2)
                       / [(1 - r²)² + 4 ξ_i ξ_j r (1 + r²) + 4 (ξ_i² + ξ_j²) r²].
"dsc"           Double sum of Rosenblueth and Elorduy, as in US NRC Regulatory Guide 1.92, for a
                strong motion of the duration t_d; with ω' = ω √(1 - ξ²), ξ' = ξ + 2 / (t_d ω)
                ε_ij = 1 / [1 + ((ω'_i - ω'_j) / (ξ'_i ω_i + ξ'_j ω_j))²].
"dsc-abs"       The same with |R_i R_j|: revision 1 (1976) of the guide.
"ten-percent"   |R_i R_j| where frequencies differ by 10 % of the lower one at most; the same guide.
"grouping"      |R_i R_j| in a group, which begins at the lowest mode that is in none and goes up
                to 1.1 times its frequency; the same guide.
"abs"           R = Σ |R_i|.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]

Combination = Literal["abs", "srss", "cqc", "dsc", "dsc-abs", "ten-percent", "grouping"]
CLOSE = 0.1 * (1.0 + 1e-9)
"""Two modes are close whose frequencies differ by this part of the lower one."""
UNSIGNED = ("dsc-abs", "ten-percent", "grouping")
"""Rules that take |R_i R_j|."""


def correlation(
    rule: Combination, frequency: Array, damping: Array, duration: float | None = None
) -> Array:
    """Coefficients ε_ij of a rule.

    Args:
        rule: Any of the rules but "abs".
        frequency: Of the modes, shape (m,) [Hz].
        damping: Of the modes, shape (m,) [-].
        duration: t_d of the double sum [s].

    Returns:
        Shape (m, m), symmetric, ones on the diagonal.

    Raises:
        ImpactfemError: The rule has no coefficients, the double sum has no duration, or CQC has a
            mode without damping.
    """
    ω = 2.0 * np.pi * np.asarray(frequency, dtype=np.float64)
    ξ = np.asarray(damping, dtype=np.float64)
    if rule == "srss":
        return np.eye(ω.size)
    if rule == "cqc":
        return _complete_quadratic(ω, ξ)
    if rule in ("dsc", "dsc-abs"):
        if duration is None or not duration > 0.0:
            raise ImpactfemError(
                f"the double sum needs the duration of the strong motion, got {duration!r} s"
            )
        ω_d, rate = ω * np.sqrt(1.0 - ξ**2), ξ * ω + 2.0 / duration
        return np.asarray(
            1.0 / (1.0 + (np.subtract.outer(ω_d, ω_d) / np.add.outer(rate, rate)) ** 2)
        )
    if rule == "ten-percent":
        lower = np.minimum.outer(ω, ω)
        return np.where(np.abs(np.subtract.outer(ω, ω)) <= CLOSE * lower, 1.0, 0.0)
    if rule == "grouping":
        group = _groups(ω)
        return np.where(np.equal.outer(group, group), 1.0, 0.0)
    raise ImpactfemError(f"the rule {rule!r} has no coefficients; known are {_known()}")


def combine_modes(
    responses: Array,
    frequency: Array,
    damping: Array,
    rule: Combination = "cqc",
    duration: float | None = None,
) -> Array:
    """Combine responses of modes.

    Args:
        responses: Largest response of each mode with its sign, shape (..., m).
        frequency: Of the modes, shape (m,) [Hz].
        damping: Of the modes, shape (m,) [-].
        rule: The rule.
        duration: t_d of the double sum [s].

    Returns:
        R, shape (...).

    Raises:
        ImpactfemError: The rule is unknown, or lacks a value.
    """
    R = np.asarray(responses, dtype=np.float64)
    if rule not in get_args(Combination):
        raise ImpactfemError(f"the combination of modes is one of {_known()}: got {rule!r}")
    if rule == "abs":
        return np.asarray(np.sum(np.abs(R), axis=-1))
    ε = correlation(rule, frequency, damping, duration)
    if rule in UNSIGNED:
        R = np.abs(R)
    # Round-off may leave a negative square where modes cancel.
    square = np.einsum("...i,ij,...j->...", R, ε, R)
    return np.asarray(np.sqrt(np.maximum(square, 0.0)), dtype=np.float64)


def _complete_quadratic(ω: Array, ξ: Array) -> Array:
    if not np.all(ξ > 0.0):
        raise ImpactfemError("CQC needs damped modes; take another combination for undamped ones")
    r = ω[None, :] / ω[:, None]
    a, b = ξ[:, None], ξ[None, :]
    top = 8.0 * np.sqrt(a * b) * (a + r * b) * r**1.5
    bottom = (1.0 - r**2) ** 2 + 4.0 * a * b * r * (1.0 + r**2) + 4.0 * (a**2 + b**2) * r**2
    return np.asarray(top / bottom, dtype=np.float64)


def _groups(ω: Array) -> npt.NDArray[np.int64]:
    """Number of the group of each mode, shape (m,)."""
    group = np.zeros(ω.size, dtype=np.int64)
    number, start = -1, -np.inf
    for i in np.argsort(ω, kind="stable"):
        if ω[i] > start * (1.0 + CLOSE):
            number, start = number + 1, ω[i]
        group[i] = number
    return group


def _known() -> str:
    return ", ".join(get_args(Combination))
