"""Damping of a linear structure: a law that gives the modal damping d, or the d themselves."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]


PROPORTIONAL = 1e-11
"""Damping couples modes i and j where φᵢᵀ C φⱼ is above this part of √(φᵢᵀ C φᵢ φⱼᵀ C φⱼ)."""


class Damping(Protocol):
    """What a body needs of its damping."""

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


@dataclass(frozen=True, order=True)
class Rayleigh:
    """Coefficients of C = α M + β K.

    Raises:
        ImpactfemError: A coefficient is negative or not finite.
    """

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
        both.

        Raises:
            ImpactfemError: The ratio is negative or 100 % and more, or the frequencies do not
                ascend.
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

    def matrix(self, K: Any, M: Any) -> Any:
        """C = α M + β K of matrices of NumPy or SciPy."""
        return self.alpha * M + self.beta * K

    def ratio(self, frequency: npt.ArrayLike) -> Array:
        """Damping ratio ξ(f) = (α / ω + β ω) / 2 at each frequency, of any shape [Hz]."""
        omega = 2.0 * np.pi * np.asarray(frequency, dtype=np.float64)
        return np.asarray(0.5 * (self.alpha / omega + self.beta * omega), dtype=np.float64)


UNDAMPED = Rayleigh()


def checked_ratio(ratio: float) -> float:
    """Give a damping ratio back; refuse one that is none.

    Raises:
        ImpactfemError: It is not 0 <= ξ < 1.
    """
    if not 0.0 <= ratio < 1.0:
        raise ImpactfemError(
            f"a damping ratio of {ratio!r}: expected 0 <= ratio < 1 (2 % is 0.02); from 100 % on"
            " nothing oscillates, and there is no response spectrum"
        )
    return ratio
