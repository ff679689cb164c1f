"""Damping of a linear structure: a law that gives the modal damping d, or the d themselves.

With φᵀ M φ = 1 and φᵀ K φ = λ = ω², a law says d = φᵀ C φ = 2 ξ ω of each mode by its frequency,
and C = Σ d_i M φ_i φ_iᵀ M. In modal coordinates that is a vector. Sources: Caughey and O'Kelly,
Classical normal modes in damped linear dynamic systems, Journal of Applied Mechanics 32 (1965) 583;
Chopra, Dynamics of Structures, 4th edition, sections 11.4.2 and 11.4.3.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
import scipy.linalg

from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError

PROPORTIONAL = 1e-11
"""Damping couples modes i and j where φᵢᵀ C φⱼ is above this part of √(φᵢᵀ C φᵢ φⱼᵀ C φⱼ)."""


class Damping(Protocol):
    """Damping of a body."""

    def modal(self, eigenvalue: Array) -> Array:
        """φᵀ C φ of modes with φᵀ M φ = 1 and φᵀ K φ = λ: its diagonal, or all of it [1/s]."""


@dataclass(frozen=True, eq=False)
class ModalDamping:
    """Damping that is known in modal coordinates, such as that of parts."""

    matrix: Array  #: φᵀ C φ, shape (r, r) [1/s].

    def modal(self, eigenvalue: Array) -> Array:
        """The diagonal, shape (r,), where no modes are coupled; else the matrix [1/s]."""
        diagonal = np.diag(self.matrix)
        size = np.sqrt(np.abs(np.outer(diagonal, diagonal)))
        off = np.abs(self.matrix - np.diag(diagonal)) > PROPORTIONAL * size
        return self.matrix if np.any(off) else diagonal.copy()


class DampingLaw(ABC):
    """A law of damping for a whole structure: a damping ratio for each of its modes."""

    @abstractmethod
    def ratio(self, frequency: npt.ArrayLike) -> Array:
        """Damping ratio ξ(f) at each frequency, of any shape [Hz]."""

    def modal(self, eigenvalue: Array) -> Array:
        """Modal damping d = 2 ξ ω of all modes with φᵀ M φ = 1 and φᵀ K φ = λ, shape (r,) [1/s]."""
        omega = np.sqrt(np.maximum(eigenvalue, 0.0))
        return np.asarray(2.0 * self.ratio(omega / (2.0 * np.pi)) * omega, dtype=np.float64)

    @property
    def rayleigh(self) -> Rayleigh:
        """Itself, where only Rayleigh's will do; ImpactfemError where it is another law."""
        raise ImpactfemError(f"{self}: expected Rayleigh damping")

    @property
    def coefficients(self) -> tuple[float, float]:
        """α [1/s] and β [s] of Rayleigh's law; not a number for others."""
        return math.nan, math.nan

    def stiffness_part(self, eigenvalue: Array) -> float:
        """β of what moves without mass, and so has no frequency: its damping is β K [s].

        β = Δd/Δλ, the slope from the highest frequency of the modes with mass to its double; where
        the ratio falls there, that of a constant ratio, as a slope may be negative then.
        """
        top = float(np.max(eigenvalue))
        low, high = (float(self.modal(np.array([λ]))[0]) for λ in (top, 4.0 * top))
        return (high - min(low, 0.5 * high)) / (3.0 * top)

    def matrix(self, K: Any, M: Any) -> Any:
        """C of dense matrices, of which K is positive definite and M may have rows of zeros.

        Rows m without mass follow the others, c, statically: by block elimination
        K = [1 0]ᵀ K_c [1 0] + Wᵀ K_mm W with W = [K_mm⁻¹ K_mc, 1]. C = Σ d_i M φ_i φ_iᵀ M of the
        modes of K_c, and β Wᵀ K_mm W.
        """
        massive = np.any(M != 0.0, axis=0)
        c, m = np.flatnonzero(massive), np.flatnonzero(~massive)
        K_mm, K_mc = K[np.ix_(m, m)], K[np.ix_(m, c)]
        follows = np.linalg.solve(K_mm, K_mc)
        eigenvalue, φ = scipy.linalg.eigh(K[np.ix_(c, c)] - K_mc.T @ follows, M[np.ix_(c, c)])
        image = M[np.ix_(c, c)] @ φ
        C = np.zeros(np.shape(K))
        C[np.ix_(c, c)] = image * self.modal(eigenvalue) @ image.T
        if len(m):
            W = np.zeros((len(m), len(K)))
            W[:, c], W[:, m] = follows, np.eye(len(m))
            C += self.stiffness_part(eigenvalue) * W.T @ K_mm @ W
        return 0.5 * (C + C.T)


@dataclass(frozen=True, order=True)
class Rayleigh(DampingLaw):
    """Coefficients of C = α M + β K; ImpactfemError where one is negative or not finite."""

    alpha: float = 0.0  #: Mass coefficient α, not negative [1/s].
    beta: float = 0.0  #: Stiffness coefficient β, not negative [s].

    def __post_init__(self) -> None:
        if not all(math.isfinite(c) and c >= 0.0 for c in (self.alpha, self.beta)):
            raise ImpactfemError(
                f"Rayleigh damping with α = {self.alpha!r} 1/s and β = {self.beta!r} s: both must"
                " be finite and not negative"
            )

    @classmethod
    def through(cls, ratio: float, low: float, high: float) -> Rayleigh:
        """The damping with one ratio ξ, 0 <= ξ < 1, at two frequencies, the lower first [Hz].

        α = 2 ξ ω₁ ω₂ / (ω₁ + ω₂), β = 2 ξ / (ω₁ + ω₂), the solution of ξ(ω) = (α / ω + β ω) / 2 at
        both. ImpactfemError where the ratio is none, or the frequencies do not ascend.
        """
        checked_ratio(ratio)
        if not 0.0 < low < high < math.inf:
            raise ImpactfemError(
                f"damping at {low!r} Hz and {high!r} Hz: expected two frequencies, the lower first"
            )
        omega = 2.0 * math.pi * low, 2.0 * math.pi * high
        beta = 2.0 * ratio / sum(omega)
        return cls(beta * omega[0] * omega[1], beta)

    def modal(self, eigenvalue: Array) -> Array:
        """Modal damping φᵀ C φ = α + β λ of modes with φᵀ M φ = 1 and φᵀ K φ = λ [1/s]."""
        return np.asarray(self.alpha + self.beta * eigenvalue, dtype=np.float64)

    @property
    def rayleigh(self) -> Rayleigh:
        """Itself."""
        return self

    @property
    def coefficients(self) -> tuple[float, float]:
        """α [1/s] and β [s]."""
        return self.alpha, self.beta

    def stiffness_part(self, eigenvalue: Array) -> float:
        """β itself [s]."""
        return self.beta

    def matrix(self, K: Any, M: Any) -> Any:
        """C = α M + β K of matrices of NumPy or SciPy."""
        return self.alpha * M + self.beta * K

    def ratio(self, frequency: npt.ArrayLike) -> Array:
        """Damping ratio ξ(f) = (α / ω + β ω) / 2 at each frequency, of any shape [Hz]."""
        omega = 2.0 * np.pi * np.asarray(frequency, dtype=np.float64)
        return np.asarray(0.5 * (self.alpha / omega + self.beta * omega), dtype=np.float64)


UNDAMPED = Rayleigh()


@dataclass(frozen=True)
class RatioTable(DampingLaw):
    """A ratio by frequency: linear in log f between its points, and constant outside of them.

    One point is a constant ratio. From 100 % on, as Rayleigh damping has it at high frequencies,
    modes creep back. ImpactfemError where there is no point, the frequencies do not ascend above
    zero, or a ratio is negative.
    """

    frequency: tuple[float, ...]  #: frequencies of the points, ascending [Hz]
    ratios: tuple[float, ...]  #: ξ of each [-]

    def __post_init__(self) -> None:
        _check_points(self.frequency, self.ratios)

    @classmethod
    def constant(cls, ratio: float) -> RatioTable:
        """One ratio at all frequencies; ImpactfemError where it is none."""
        return cls((1.0,), (checked_ratio(ratio),))

    def ratio(self, frequency: npt.ArrayLike) -> Array:
        """See `DampingLaw.ratio`."""
        with np.errstate(divide="ignore"):
            at = np.log(np.asarray(frequency, dtype=np.float64))
        return np.asarray(np.interp(at, np.log(self.frequency), self.ratios), dtype=np.float64)


@dataclass(frozen=True)
class Caughey(DampingLaw):
    """Caughey's series C = M Σ_j a_j (M⁻¹ K)ʲ, j = 0 to n - 1, through n ratios at n frequencies.

    2 ξ_i ω_i = Σ_j a_j ω_i²ʲ; with two terms it is Rayleigh's. Raising the number of terms, the
    curve may leave its points far, and above the last one it grows with ω²ⁿ⁻³. ImpactfemError as of
    `RatioTable`, and where the ratio is negative at some frequency.
    """

    frequency: tuple[float, ...]  #: frequencies of the points, ascending [Hz]
    ratios: tuple[float, ...]  #: ξ of each [-]

    def __post_init__(self) -> None:
        _check_points(self.frequency, self.ratios)
        where = self.negative_at
        if where is not None:
            raise ImpactfemError(
                f"Caughey damping through {len(self.frequency)} points is negative at "
                f"{where:.4g} Hz: expected points whose curve has ratios above zero only"
            )

    @property
    def _terms(self) -> tuple[Array, float]:
        """Coefficients of d over (ω/ω_n)², the constant one first [1/s], and ω_n² [1/s2]."""
        omega = 2.0 * np.pi * np.array(self.frequency)
        powers = np.vander((omega / omega[-1]) ** 2, increasing=True)
        d = 2.0 * np.array(self.ratios) * omega
        terms = np.linalg.solve(powers, d)
        # Points on the curve of fewer terms: rounding would give the others, of any sign.
        for n in range(1, len(d)):
            fewer = np.linalg.lstsq(powers[:, :n], d, rcond=None)[0]
            if np.allclose(powers[:, :n] @ fewer, d, rtol=1e-12, atol=0.0):
                return fewer, float(omega[-1] ** 2)
        return terms, float(omega[-1] ** 2)

    @property
    def negative_at(self) -> float | None:
        """A frequency at which the ratio is negative; None where there is none [Hz]."""
        terms, unit = self._terms
        roots = np.roots(terms[::-1])
        # Between two roots, and above the last one, the sign does not change.
        ends = np.sort(roots.real[(abs(roots.imag) < 1e-9 * abs(roots)) & (roots.real > 0.0)])
        inner = 0.5 * (ends[1:] + ends[:-1])
        tried = np.array([0.5 * ends[0], *inner, 2.0 * ends[-1]]) if ends.size else np.ones(1)
        negative = tried[np.polyval(terms[::-1], tried) < 0.0]
        return float(np.sqrt(negative[0] * unit) / (2.0 * np.pi)) if negative.size else None

    def modal(self, eigenvalue: Array) -> Array:
        """See `DampingLaw.modal`."""
        terms, unit = self._terms
        return np.asarray(np.polyval(terms[::-1], eigenvalue / unit), dtype=np.float64)

    def ratio(self, frequency: npt.ArrayLike) -> Array:
        """See `DampingLaw.ratio`; infinite at zero where a_0 is not zero."""
        omega = 2.0 * np.pi * np.asarray(frequency, dtype=np.float64)
        with np.errstate(divide="ignore"):
            return np.asarray(0.5 * self.modal(omega**2) / omega, dtype=np.float64)


@dataclass(frozen=True)
class ModeRatios(DampingLaw):
    """A ratio for each of the first modes, by ascending frequency; another law for all others.

    ImpactfemError where a ratio is negative, or 100 % and more.
    """

    ratios: tuple[float, ...]  #: ξ of the first modes [-]
    others: DampingLaw  #: the law of all others

    def __post_init__(self) -> None:
        for ratio in self.ratios:
            checked_ratio(ratio)

    def ratio(self, frequency: npt.ArrayLike) -> Array:
        """ξ(f) of the modes that have no ratio of their own."""
        return self.others.ratio(frequency)

    def modal(self, eigenvalue: Array) -> Array:
        """See `DampingLaw.modal`; the eigenvalues are those of all modes, in any order."""
        found = self.others.modal(eigenvalue)
        first = np.argsort(eigenvalue, kind="stable")[: len(self.ratios)]
        omega = np.sqrt(np.maximum(eigenvalue[first], 0.0))
        found[first] = 2.0 * np.array(self.ratios[: len(first)]) * omega
        return found

    def stiffness_part(self, eigenvalue: Array) -> float:
        """That of the other modes."""
        return self.others.stiffness_part(eigenvalue)


def as_law(damping: DampingLaw | float) -> DampingLaw:
    """A law as it is, or that of one ratio for all modes; ImpactfemError where it is none."""
    return damping if isinstance(damping, DampingLaw) else RatioTable.constant(damping)


def _check_points(frequency: Sequence[float], ratios: Sequence[float]) -> None:
    ascending = all(a < b for a, b in pairwise((0.0, *frequency, math.inf)))
    if not frequency or len(frequency) != len(ratios) or not ascending:
        raise ImpactfemError(
            f"damping at {list(frequency)} Hz: expected ascending frequencies above zero, and a "
            "ratio for each"
        )
    for ratio in ratios:
        if not 0.0 <= ratio < math.inf:
            raise ImpactfemError(f"a damping ratio of {ratio!r}: expected 0 or more (2 % is 0.02)")


def checked_ratio(ratio: float) -> float:
    """Give a damping ratio back; ImpactfemError where it is not 0 <= ξ < 1."""
    if not 0.0 <= ratio < 1.0:
        raise ImpactfemError(
            f"a damping ratio of {ratio!r}: expected 0 <= ratio < 1 (2 % is 0.02); from 100 % on"
            " nothing oscillates, and there is no response spectrum"
        )
    return ratio
