"""How well a motion meets a design spectrum, and whether a reviewer would accept it."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.motion.design_spectrum import Target
from impactfem.motion.power_spectrum import (
    WINDOW,
    StrongPhase,
    compatible_power_spectrum,
    power_spectrum,
    strong_phase,
)
from impactfem.records.accelerogram import Accelerogram
from impactfem.spectra import logarithmic_frequencies, response_spectra
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError

CORRELATION_LIMIT = 0.16
_LOW_PSD, _HIGH_PSD = 0.3, 24.0  # Hz
_BINS = 4.0  # of width 1/T_D that the mean of the density must hold to say anything


@dataclass(frozen=True, eq=False)
class Misfit:
    """Pseudo-acceleration of a motion and its target, shape (n,), and their ratio r."""

    frequency: Array  #: equidistant on a logarithmic axis [Hz]
    computed: Array  #: of the motion at the target's damping [m/s2]
    target: Array  #: the design spectrum [m/s2]

    @property
    def ratio(self) -> Array:
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
) -> Misfit:
    """Compare a motion with a design spectrum at its damping, between two frequencies [Hz].

    The frequencies are so many in a factor of ten, 100 as nuclear practice requires; the motion is
    interpolated for 20 points in a cycle of the highest one.
    """
    frequency = logarithmic_frequencies(minimum, maximum, per_decade)
    spectra = response_spectra(
        accelerogram.acceleration,
        accelerogram.time_step,
        frequency,
        [target.damping],
        points_per_cycle=20.0,
    )
    return Misfit(frequency, spectra.psa[0, 0], target.pseudo_acceleration(frequency))


@dataclass(frozen=True)
class Criteria:
    """What a motion must meet.

    The defaults are those of US NRC SRP 3.7.1, option 1, approach 2 (revision 4; taken from the
    checker of the NRC staff's public ground motion tools): spectrum at 100 points a decade from
    0.1 Hz to 50 Hz, none more than 10 % below or 30 % above the target, no more than 9 points in a
    row below it (a window of ±10 %), 20 s, a Nyquist frequency of 50 Hz. Strong phase of 6 s and
    80 % of a target density from 0.3 Hz to 24 Hz: the same text, but from memory.
    `derived_psd_share` is a choice of this program: see :func:`acceptance`.
    """

    per_decade: int = 100  #: points in a decade, at least
    lower: float = 0.9  #: smallest ratio of spectrum to target
    upper: float = 1.3  #: largest ratio
    longest_below: int = 9  #: most points in a row below the target
    duration: float = 20.0  #: at least [s]
    strong_phase: float = 6.0  #: least time from 5 % to 75 % of the Arias intensity [s]
    nyquist: float = 50.0  #: least Nyquist frequency [Hz]
    psd_share: float = 0.8  #: smallest ratio of the power spectral density to a target given
    derived_psd_share: float = 0.4  #: the same, to the density derived from the design spectrum


@dataclass(frozen=True)
class Verdict:
    """One criterion, the value of the motion and its limit, a lower or an upper one."""

    name: str
    value: float
    limit: float
    at_least: bool
    unit: str
    at: float = math.nan  #: frequency of the value, or where its row begins [Hz]; nan where none

    @property
    def passed(self) -> bool:
        """Whether the motion meets it."""
        return self.value >= self.limit if self.at_least else self.value <= self.limit


@dataclass(frozen=True, eq=False)
class Acceptance:
    """A motion and the criteria."""

    misfit: Misfit
    strong_phase: StrongPhase
    psd_frequency: Array  #: (n_p,) [Hz]; empty for a strong phase too short to say anything
    psd: Array  #: one-sided density of the strong phase, smoothed, (n_p,) [m²/s³]
    psd_target: Array  #: what it is compared with, (n_p,) [m²/s³]
    verdicts: tuple[Verdict, ...]

    @property
    def accepted(self) -> bool:
        """Whether all criteria are met."""
        return all(verdict.passed for verdict in self.verdicts)

    def verdict(self, name: str) -> Verdict:
        """The verdict on a criterion; KeyError when there is no such criterion."""
        return {verdict.name: verdict for verdict in self.verdicts}[name]


def acceptance(
    accelerogram: Accelerogram,
    target: Target,
    *,
    minimum: float = 0.1,
    maximum: float = 50.0,
    criteria: Criteria | None = None,
    psd: Callable[[npt.ArrayLike], Array] | None = None,
) -> Acceptance:
    """Check a motion against its design spectrum.

    A motion may meet its spectrum and still have holes in its power spectral density, because
    oscillators respond to what lies beside their frequency. The density of the strong phase
    (:func:`impactfem.motion.power_spectrum.power_spectrum`) is therefore compared as well: with
    `psd` where a text gives one, such as
    :func:`impactfem.motion.power_spectrum.rg160_power_spectrum`, from 0.3 Hz to 24 Hz; else with
    the density that the design spectrum itself describes
    (:func:`impactfem.motion.power_spectrum.compatible_power_spectrum`), in the same range, from the
    frequency on where the ±20 % hold 4 bins of the strong phase (f >= 10 / T_D). That density is
    one of a mean motion: the smoothed density of 72 synthetic motions (3 targets, 12 seeds, 1 and
    30 iterations) stayed above 0.44 of it; hence 0.4 for `derived_psd_share`.

    Frequencies are compared from `minimum` to `maximum` [Hz], at most the Nyquist frequency; the
    criteria are those of SRP 3.7.1 when None; `psd` gives one-sided densities [m²/s³] at
    frequencies [Hz].

    Raises:
        ImpactfemError: The motion is zero throughout, or the frequencies are out of range.
    """
    required = criteria or Criteria()
    nyquist = 0.5 / accelerogram.time_step
    if not 0.0 < minimum < maximum <= nyquist:
        raise ImpactfemError(
            "the frequencies compared must be 0 < minimum < maximum <= Nyquist frequency,"
            f" {nyquist:.6g} Hz, got {minimum!r} Hz and {maximum!r} Hz"
        )
    phase = strong_phase(accelerogram)
    misfit = spectral_misfit(accelerogram, target, minimum, maximum, per_decade=required.per_decade)
    ratio = misfit.ratio
    decades = np.log10(misfit.frequency[-1] / misfit.frequency[0])
    low = max(_LOW_PSD, minimum, 0.0 if psd else _BINS / (2.0 * WINDOW * phase.duration))
    checked = misfit.frequency[(misfit.frequency >= low) & (misfit.frequency <= _HIGH_PSD)]
    has = power_spectrum(accelerogram, checked)
    wants = psd(checked) if psd else compatible_power_spectrum(target, checked, phase.duration)
    least_points = required.per_decade * (1 - 1e-9)
    share = required.psd_share if psd else required.derived_psd_share
    smallest = float(np.min(has[wants > 0.0] / wants[wants > 0.0], initial=np.inf))
    if checked.size == 0:
        smallest = 0.0  # too short to say: not accepted
    # The rows of points below the target: where they begin, and their lengths.
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (ratio < 1.0).astype(np.int8), [0]])))
    first, lengths = edges[::2], edges[1::2] - edges[::2]
    longest = int(np.max(lengths, initial=0))
    f = misfit.frequency
    low_at, high_at = (float(f[k]) for k in (ratio.argmin(), ratio.argmax()))
    row_at = float(f[first[lengths.argmax()]]) if longest else math.nan
    verdicts = (
        Verdict("points_per_decade", (ratio.size - 1) / decades, least_points, True, "-"),
        Verdict("smallest_ratio", misfit.smallest_ratio, required.lower, True, "-", low_at),
        Verdict("largest_ratio", misfit.largest_ratio, required.upper, False, "-", high_at),
        Verdict("longest_below", longest, required.longest_below, False, "-", row_at),
        Verdict("duration", accelerogram.duration, required.duration * (1 - 1e-9), True, "s"),
        Verdict("strong_phase", phase.duration, required.strong_phase, True, "s"),
        Verdict("nyquist", nyquist, required.nyquist * (1 - 1e-9), True, "Hz"),
        Verdict("psd_ratio", smallest, share, True, "-"),
    )
    return Acceptance(misfit, phase, checked, has, wants, verdicts)


def pair_correlation(first: Accelerogram, second: Accelerogram) -> float:
    """Correlate two components over their whole duration.

        ρ = Σ (a - ā)(b - b̄) / √(Σ (a - ā)² Σ (b - b̄)²)

    The shorter one is at rest after its end. Components are independent with |ρ| up to
    `CORRELATION_LIMIT`, as US NRC SRP 3.7.1 and ASCE 4-16 require; ASCE 4-98 and 43-05 have 0.3.

    Raises:
        ImpactfemError: The time steps differ, or a component does not change.
    """
    if abs(first.time_step / second.time_step - 1.0) > 1e-9:
        raise ImpactfemError(
            f"components at steps of {first.time_step:.9g} s and {second.time_step:.9g} s cannot be"
            " correlated; resample one of them"
        )
    n = max(first.acceleration.size, second.acceleration.size)
    a, b = (np.pad(x.acceleration, (0, n - x.acceleration.size)) for x in (first, second))
    a, b = a - a.mean(), b - b.mean()
    norm = float(np.sqrt((a @ a) * (b @ b)))
    if norm == 0.0:
        raise ImpactfemError("a component that does not change has no correlation")
    return float(a @ b) / norm
