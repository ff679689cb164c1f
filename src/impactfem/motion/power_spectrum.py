"""Power spectral density of the strong phase of a motion, and what a design spectrum asks of it."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import fft

from impactfem.motion.design_spectrum import Target
from impactfem.records.accelerogram import STANDARD_GRAVITY, Accelerogram
from impactfem.spectra import logarithmic_frequencies
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError

STRONG_PHASE = (0.05, 0.75)  # of the Arias intensity
WINDOW = 0.2  # half the width over which the density is averaged, relative to the frequency
_PER_DECADE = 400  # of the integral of the target density
_LOWEST = 0.1  # Hz, where that integral begins


@dataclass(frozen=True)
class StrongPhase:
    """The part of a motion that carries its power: 5 % to 75 % of the Arias intensity [s]."""

    begin: float
    end: float

    @property
    def duration(self) -> float:
        """Its duration T_D [s]."""
        return self.end - self.begin


def strong_phase(accelerogram: Accelerogram) -> StrongPhase:
    """The strong phase of a motion; a motion that is zero throughout is refused."""
    a = accelerogram.acceleration
    intensity = np.concatenate([[0.0], np.cumsum(a[:-1] ** 2 + a[:-1] * a[1:] + a[1:] ** 2)])
    if intensity[-1] <= 0.0:
        raise ImpactfemError("a motion that is zero throughout has no strong phase")
    shares = np.array(STRONG_PHASE) * intensity[-1]
    begin, end = np.interp(shares, intensity, accelerogram.time)
    return StrongPhase(float(begin), float(end))


def power_spectrum(accelerogram: Accelerogram, frequency: npt.ArrayLike) -> Array:
    """Estimate the one-sided power spectral density of the strong phase, smoothed.

    With F(ω) = ∫ a(t) exp(-iωt) dt over the strong phase of duration T_D,

        S(ω) = 2 |F(ω)|² / (2π T_D)                                                        (1)

    in (m/s²)² per rad/s, so that ∫ S dω from 0 is the mean square acceleration of that phase. At
    each frequency f the mean of (1) over f (1 ± 0.2) is given; where that holds less than one
    bin of width 1/T_D, over one bin. Form (1), the ±20 % and the strong phase are those of the
    check in US NRC SRP 3.7.1, Appendix A. Frequencies and densities have shape (n_f,) [Hz, m²/s³].

    Raises:
        ImpactfemError: The motion is zero, its strong phase has fewer than 16 samples, or a
            frequency is not positive or above the Nyquist frequency.
    """
    f = np.asarray(frequency, dtype=np.float64)
    h = accelerogram.time_step
    if not (np.all(f > 0.0) and np.all(f <= 0.5 / h)):
        raise ImpactfemError(
            "the frequencies of a power spectral density must be positive and not above the"
            f" Nyquist frequency, {0.5 / h:.6g} Hz"
        )
    phase = strong_phase(accelerogram)
    first, last = round(phase.begin / h), round(phase.end / h) + 1
    a = accelerogram.acceleration[first:last]
    if a.size < 16:
        raise ImpactfemError(f"the strong phase has only {a.size} samples; expected at least 16")
    duration = a.size * h
    padded = fft.next_fast_len(8 * a.size, real=True)  # bins fine enough for the mean's borders
    transform = h * fft.rfft(a, padded)
    density = 2.0 * np.abs(transform) ** 2 / (2.0 * np.pi * duration)
    # Means over windows of bins as differences of running sums.
    sums = np.concatenate([[0.0], np.cumsum(density)])
    step = 1.0 / (padded * h)
    half = np.maximum(WINDOW * f, 0.5 / duration)
    lower = np.clip(np.rint((f - half) / step), 0, density.size - 1).astype(np.int64)
    upper = np.clip(np.rint((f + half) / step) + 1, lower + 1, density.size).astype(np.int64)
    return np.asarray((sums[upper] - sums[lower]) / (upper - lower))


def compatible_power_spectrum(target: Target, frequency: npt.ArrayLike, duration: float) -> Array:
    """Give the power spectral density of a stationary motion that a design spectrum describes.

    The mean square response of an oscillator of damping ξ to a density G(ω) that changes slowly
    around its frequency, and quasi-static to what lies below, is (Gasparini and Vanmarcke 1976,
    SIMQKE, MIT R76-4)

        (S_a / η)² = G(ω) ω (π / 4ξ_t - 1) + ∫_0^ω G dω                                    (2)

    with the peak factor η of a Gaussian process: half of all peaks in the duration T stay below,
    η² = 2 ln(ωT / (π ln 2)); the damping is that of a response which starts from rest,
    ξ_t = ξ / (1 - exp(-2ξωT)). (2) is solved for G from low to high frequencies.

    T is the duration of the strong phase [s]; G is zero where (2) has nothing left for it. Both
    frequencies and densities have shape (n_f,) [Hz, m²/s³].

    Raises:
        ImpactfemError: The duration or a frequency is not positive.
    """
    requested = np.asarray(frequency, dtype=np.float64)
    if not (np.isfinite(duration) and duration > 0.0 and np.all(requested > 0.0)):
        raise ImpactfemError("duration and frequencies of a density must be positive")
    lowest = min(_LOWEST, 0.9 * float(requested.min()))
    f = logarithmic_frequencies(lowest, 1.01 * float(requested.max()), _PER_DECADE)
    omega = 2.0 * np.pi * f
    xi = max(target.damping, 1e-4)
    transient = xi / (1.0 - np.exp(-2.0 * xi * omega * duration))
    cycles = np.maximum(omega * duration / (np.pi * np.log(2.0)), np.e)
    mean_square = target.pseudo_acceleration(f) ** 2 / (2.0 * np.log(cycles))
    white = omega * np.maximum(np.pi / (4.0 * transient) - 1.0, 0.1)
    # From low to high: the integral in (2) holds only what is known already.
    density, below = np.zeros(f.size), 0.0
    for k, step in enumerate(np.diff(omega, append=omega[-1])):
        density[k] = max(mean_square[k] - below, 0.0) / white[k]
        below += density[k] * step
    return np.asarray(np.interp(requested, f, density))


def rg160_power_spectrum(frequency: npt.ArrayLike, pga: float) -> Array:
    """Give the target density of US NRC SRP 3.7.1, Appendix A, for RG 1.60 horizontal spectra.

    For a peak of 1 g, in m²/s³:

        0.419 (f / 2.5)^0.2       f < 2.5 Hz
        0.419 (2.5 / f)^1.8       2.5 Hz to 9 Hz
        0.0418 (9 / f)³           9 Hz to 16 Hz
        0.00742 (16 / f)⁸         above

    times the square of the peak in g; at frequencies of any shape [Hz] and a peak [m/s2].
    """
    f = np.asarray(frequency, dtype=np.float64)
    conditions = [f < 2.5, f < 9.0, f < 16.0]
    with np.errstate(divide="ignore"):
        values = [0.419 * (f / 2.5) ** 0.2, 0.419 * (2.5 / f) ** 1.8, 0.0418 * (9.0 / f) ** 3]
        above = 0.00742 * (16.0 / f) ** 8
    return np.asarray(np.select(conditions, values, above) * (pga / STANDARD_GRAVITY) ** 2)
