"""How well the response spectrum of a motion meets a design spectrum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.motion.accelerogram import Accelerogram
from impactfem.motion.target import Target
from impactfem.spectra import logarithmic_frequencies, response_spectra

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Misfit:
    """Pseudo-acceleration of a motion beside its target, and the ratio r = computed / target.

    Args:
        frequency: Where they are compared, equidistant on a logarithmic axis, shape (n,) [Hz].
        computed: Pseudo-acceleration of the motion at the target's damping, shape (n,) [m/s2].
        target: The design spectrum, shape (n,) [m/s2].
    """

    frequency: FloatArray
    computed: FloatArray
    target: FloatArray

    @property
    def ratio(self) -> FloatArray:
        """The ratio r, shape (n,) [-]."""
        return self.computed / self.target

    @property
    def mean(self) -> float:
        """Mean of r - 1: the bias [-]."""
        return float(np.mean(self.ratio - 1.0))

    @property
    def rms(self) -> float:
        """Root mean square of r - 1 [-]."""
        return float(np.sqrt(np.mean((self.ratio - 1.0) ** 2)))

    @property
    def largest_ratio(self) -> float:
        """Largest r: how far the motion goes above the target [-]."""
        return float(self.ratio.max())

    @property
    def smallest_ratio(self) -> float:
        """Smallest r: how far the motion falls below the target [-]."""
        return float(self.ratio.min())


def spectral_misfit(
    accelerogram: Accelerogram,
    target: Target,
    minimum: float,
    maximum: float,
    *,
    per_decade: int = 100,
    points_per_cycle: float = 20.0,
) -> Misfit:
    """Compare a motion with a design spectrum.

    Args:
        accelerogram: The motion.
        target: The spectrum, at its own damping.
        minimum: Lowest frequency compared [Hz].
        maximum: Highest frequency compared [Hz].
        per_decade: Frequencies in a factor of ten; 100 is what nuclear practice asks [-].
        points_per_cycle: Of the oscillators at the highest frequency [-].

    Returns:
        The two spectra and their misfit.
    """
    frequency = logarithmic_frequencies(minimum, maximum, per_decade)
    spectra = response_spectra(
        accelerogram.acceleration,
        accelerogram.time_step,
        frequency,
        [target.damping],
        points_per_cycle=points_per_cycle,
    )
    return Misfit(frequency, spectra.psa[0, 0], target.pseudo_acceleration(frequency))
