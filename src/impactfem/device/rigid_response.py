"""The part of a mode's response that follows the anchors rigidly.

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

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.device.spectrum import AnchorSpectrum, NotRigidError
from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Gupta:
    """Equation (1).

    Args:
        f1: f₁ [Hz]; from the spectrum when None.
        f2: f₂ [Hz]; from the spectrum when None.

    Raises:
        ImpactfemError: The frequencies do not ascend.
    """

    f1: float | None = None
    f2: float | None = None

    def __post_init__(self) -> None:
        f1 = 0.0 if self.f1 is None else self.f1
        f2 = math.inf if self.f2 is None else self.f2
        if not f1 < f2 or (self.f1 is not None and not self.f1 > 0.0):
            raise ImpactfemError(
                f"Gupta's frequencies {self.f1!r} Hz and {self.f2!r} Hz: expected 0 < f1 < f2"
            )

    def corners(self, spectrum: AnchorSpectrum, damping: float) -> tuple[float, float]:
        """f₁ and f₂ of a spectrum [Hz].

        Args:
            spectrum: The spectrum.
            damping: At which they are taken [-].

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
        out = np.empty(frequency.size)
        for i, (f, xi) in enumerate(zip(frequency, damping, strict=True)):
            f1, f2 = self.corners(spectrum, float(xi))
            out[i] = np.clip(np.log(f / f1) / np.log(f2 / f1), 0.0, 1.0)
        return out


@dataclass(frozen=True)
class LindleyYow:
    """Equation (2)."""

    def fraction(
        self, spectrum: AnchorSpectrum, frequency: Array, damping: Array, ordinates: Array
    ) -> Array:
        """α of modes.

        Args:
            spectrum: The spectrum that drives them.
            frequency: Shape (m,) [Hz].
            damping: Shape (m,) [-].
            ordinates: Pseudo-accelerations S of the modes, shape (m,).

        Returns:
            Shape (m,) [-].
        """
        peak = np.array([spectrum.frequency[np.argmax(spectrum.curve(float(x)))] for x in damping])
        ratio = np.divide(
            spectrum.zpa, ordinates, out=np.ones_like(ordinates), where=ordinates > 0.0
        )
        return np.where(frequency < peak, 0.0, np.minimum(ratio, 1.0))


RigidResponse = Gupta | LindleyYow
