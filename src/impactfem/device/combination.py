"""Combination of largest responses, which do not happen at the same time.

Of modes, all rules but the sum of absolute values are R² = Σ Σ ε_ij R_i R_j, with ε_ii = 1.

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

Of modes with the anchors:

Modes above the amplified range move in step with the anchors, hence with each other: the part α of
their response is added with its sign, the rest, √(1 - α²), is combined as if it were periodic.

Gupta (1990), Response Spectrum Method in Seismic Analysis and Design of Structures, and US NRC
Regulatory Guide 1.92, revisions 2 (2006) and 3 (2012), C.1.3:

    α = ln(f / f₁) / ln(f₂ / f₁) in [0, 1],
    f₁ = S_max / (2π S_v,max),    f₂ = (f₁ + 2 f_r) / 3                                     (1)

with the largest ordinate S_max, the largest pseudo-velocity S_v,max, and the frequency f_r from
which on the spectrum stays at its zero-period acceleration.

Lindley and Yow (1980), and the same guide:

    α = ZPA / S(f) in [0, 1]                                                               (2)

Below the frequency of the largest ordinate the ratio rises again although nothing there is rigid: α
is zero there.
"""

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from impactfem.device.spectrum import AnchorSpectrum, NotRigidError
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError

Combination = Literal["abs", "srss", "cqc", "dsc", "dsc-abs", "ten-percent", "grouping"]
CLOSE = 0.1 * (1.0 + 1e-9)
"""Two modes are close whose frequencies differ by this part of the lower one."""
UNSIGNED = ("dsc-abs", "ten-percent", "grouping")
"""Rules that take |R_i R_j|."""


def correlation(
    rule: Combination, frequency: Array, damping: Array, duration: float | None = None
) -> Array:
    """Coefficients ε_ij of a rule, shape (m, m); arguments as in `combine_modes`.

    Raises:
        ImpactfemError: The rule has no coefficients, the double sum has no duration, or CQC has a
            mode without damping.
    """
    ω = 2.0 * np.pi * np.asarray(frequency, dtype=np.float64)
    ξ = np.asarray(damping, dtype=np.float64)
    if rule == "srss":
        return np.eye(ω.size)
    if rule == "cqc":
        if not np.all(ξ > 0.0):
            raise ImpactfemError(
                "CQC needs damped modes; take another combination for undamped ones"
            )
        r, a, b = ω[None, :] / ω[:, None], ξ[:, None], ξ[None, :]
        top = 8.0 * np.sqrt(a * b) * (a + r * b) * r**1.5
        bottom = (1.0 - r**2) ** 2 + 4.0 * a * b * r * (1.0 + r**2) + 4.0 * (a**2 + b**2) * r**2
        return np.asarray(top / bottom, dtype=np.float64)
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
        group = np.zeros(ω.size, dtype=np.int64)
        number, start = -1, -np.inf
        for i in np.argsort(ω, kind="stable"):
            if ω[i] > start * (1.0 + CLOSE):
                number, start = number + 1, ω[i]
            group[i] = number
        return np.where(np.equal.outer(group, group), 1.0, 0.0)
    known = ", ".join(get_args(Combination))
    raise ImpactfemError(f"the rule {rule!r} has no coefficients; known are {known}")


def combine_modes(
    responses: Array,
    frequency: Array,
    damping: Array,
    rule: Combination = "cqc",
    duration: float | None = None,
) -> Array:
    """Combine largest responses of modes with their signs, shape (..., m).

    Of frequencies [Hz] and damping ratios [-] of shape (m,); the double sum needs t_d [s].

    Raises:
        ImpactfemError: The rule is unknown, or lacks a value.
    """
    R = np.asarray(responses, dtype=np.float64)
    if rule not in get_args(Combination):
        known = ", ".join(get_args(Combination))
        raise ImpactfemError(f"the combination of modes is one of {known}: got {rule!r}")
    if rule == "abs":
        return np.asarray(np.sum(np.abs(R), axis=-1))
    ε = correlation(rule, frequency, damping, duration)
    if rule in UNSIGNED:
        R = np.abs(R)
    # Round-off may leave a negative square where modes cancel.
    square = np.einsum("...i,ij,...j->...", R, ε, R)
    return np.asarray(np.sqrt(np.maximum(square, 0.0)), dtype=np.float64)


InputRule = Literal["srss", "abs", "100-40-40"]
SupportRule = Literal["srss", "abs", "algebraic"]
"""As the first two of InputRule where supports move independently; "algebraic" where they move
together, so that the responses of a mode are added with their signs before modes are combined."""

PLANES = (("x", "ry"), ("y", "rx"), ("z",), ("rz",))
"""Components that one motion of a building brings about together: swaying along x comes with a
rotation about y."""


def combine_inputs(responses: Array, rule: InputRule) -> Array:
    """Combine responses to inputs that have their largest values at different times.

    They are not negative, shape (n_i, ...), one for each input. "100-40-40" is the largest with 40
    % of each other one, whichever is which (ASCE 4-98, section 3.2.7).

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


@dataclass(frozen=True)
class Gupta:
    """Equation (1).

    Raises:
        ImpactfemError: The frequencies do not ascend.
    """

    f1: float | None = None  #: f₁ [Hz]; from the spectrum when None
    f2: float | None = None  #: f₂ [Hz]; from the spectrum when None

    def __post_init__(self) -> None:
        f1 = 0.0 if self.f1 is None else self.f1
        f2 = math.inf if self.f2 is None else self.f2
        if not f1 < f2 or (self.f1 is not None and not self.f1 > 0.0):
            raise ImpactfemError(
                f"Gupta's frequencies {self.f1!r} Hz and {self.f2!r} Hz: expected 0 < f1 < f2"
            )

    def corners(self, spectrum: AnchorSpectrum, damping: float) -> tuple[float, float]:
        """f₁ and f₂ of a spectrum at a damping ratio [Hz].

        Raises:
            NotRigidError: The spectrum ends before it is rigid, or f₁ is not below f₂.
        """
        f1, f2 = self.f1, self.f2
        if f1 is None:
            S = spectrum.curve(damping)
            f1 = float(np.max(S) / np.max(S / spectrum.frequency))
        if f2 is None:
            f2 = (f1 + 2.0 * spectrum.rigid_from(damping)) / 3.0
        if not f1 < f2:
            raise NotRigidError(
                f"the {spectrum.label}: Gupta's f1 = {f1:.4g} Hz is not below f2 = {f2:.4g} Hz;"
                " expected both frequencies to be given"
            )
        return f1, f2

    def fraction(
        self, spectrum: AnchorSpectrum, frequency: Array, damping: Array, ordinates: Array
    ) -> Array:
        """α of modes, shape (m,); arguments as in :meth:`LindleyYow.fraction`."""
        del ordinates
        corners = np.array([self.corners(spectrum, float(xi)) for xi in damping]).reshape(-1, 2)
        f1, f2 = corners.T
        return np.asarray(np.clip(np.log(frequency / f1) / np.log(f2 / f1), 0.0, 1.0))


@dataclass(frozen=True)
class LindleyYow:
    """Equation (2)."""

    def fraction(
        self, spectrum: AnchorSpectrum, frequency: Array, damping: Array, ordinates: Array
    ) -> Array:
        """α of modes under a spectrum, shape (m,) [-].

        Frequencies [Hz], dampings [-] and pseudo-accelerations S of the modes have shape (m,).
        """
        peak = np.array([spectrum.frequency[np.argmax(spectrum.curve(float(x)))] for x in damping])
        ratio = np.divide(
            spectrum.zpa, ordinates, out=np.ones_like(ordinates), where=ordinates > 0.0
        )
        return np.where(frequency < peak, 0.0, np.minimum(ratio, 1.0))


RigidResponse = Gupta | LindleyYow


@dataclass(frozen=True)
class Rules:
    """How responses are combined."""

    modes: Combination = "cqc"  #: combination of modes
    duration: float | None = None  #: of the strong motion, for the double sum [s]
    rigid: RigidResponse | None = None  #: rigid part of the modes; none when None
    #: whether R_m of `device.spectrum_analysis`, what the modes in use do not carry,
    #: is added
    missing_mass: bool = True
    #: modes above it count as missing mass [Hz]; all are used when None
    maximum_frequency: float | None = None
    #: combination of the same component of several anchors: "srss" when they move independently,
    #: "algebraic" when they move together, or "abs"
    supports: SupportRule = "srss"
    rotations: InputRule = "srss"  #: combination of a rotation with the translation it comes with
    directions: InputRule = "srss"  #: combination of these pairs
    displacements: InputRule = "srss"  #: combination of the displacements of the anchors
    whole: InputRule = "srss"  #: combination of these with all the rest: "srss" or "abs"
