"""Whether a motion may stand for a design spectrum, as a reviewer checks it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from impactfem.motion.accelerogram import Accelerogram
from impactfem.motion.misfit import Misfit, spectral_misfit
from impactfem.motion.power_spectrum import (
    WINDOW,
    StrongPhase,
    compatible_power_spectrum,
    power_spectrum,
    strong_phase,
)
from impactfem.motion.target import Target
from impactfem.system.errors import ImpactfemError

FloatArray = npt.NDArray[np.float64]

_LOW_PSD, _HIGH_PSD = 0.3, 24.0  # Hz
_BINS = 4.0  # of width 1/T_D that the mean of the density must hold to say anything


@dataclass(frozen=True)
class Criteria:
    """What a motion must meet.

    The defaults are those of US NRC SRP 3.7.1, option 1, approach 2 (revision 4; taken from the
    checker of the NRC staff's public ground motion tools): spectrum at 100 points a decade from
    0.1 Hz to 50 Hz, none more than 10 % below or 30 % above the target, no more than 9 points in a
    row below it (a window of ±10 %), 20 s, a Nyquist frequency of 50 Hz. Strong phase of 6 s and
    80 % of a target density from 0.3 Hz to 24 Hz: the same text, but from memory. `own_psd_share`
    is a choice of this program: see :func:`acceptance`.

    Args:
        per_decade: Points in a decade, at least [-].
        lower: Smallest ratio of spectrum to target [-].
        upper: Largest ratio [-].
        longest_below: Most points in a row below the target [-].
        duration: Least duration [s].
        strong_phase: Least time from 5 % to 75 % of the Arias intensity [s].
        nyquist: Least Nyquist frequency [Hz].
        psd_share: Smallest ratio of the power spectral density to a target given [-].
        own_psd_share: The same, to the density derived from the design spectrum [-].
    """

    per_decade: int = 100
    lower: float = 0.9
    upper: float = 1.3
    longest_below: int = 9
    duration: float = 20.0
    strong_phase: float = 6.0
    nyquist: float = 50.0
    psd_share: float = 0.8
    own_psd_share: float = 0.4


@dataclass(frozen=True)
class Verdict:
    """One criterion and what the motion has.

    Args:
        name: The criterion, as a key.
        value: What the motion has.
        limit: What it must have.
        at_least: Whether the limit is a lower one.
        unit: Of both; "-" when they have none.
    """

    name: str
    value: float
    limit: float
    at_least: bool
    unit: str

    @property
    def passed(self) -> bool:
        """Whether the motion meets it."""
        return self.value >= self.limit if self.at_least else self.value <= self.limit


@dataclass(frozen=True, eq=False)
class Acceptance:
    """A motion beside the criteria.

    Args:
        misfit: Spectrum and target at the frequencies compared.
        strong_phase: From 5 % to 75 % of the Arias intensity.
        zero_crossings: Of the acceleration in the strong phase, in a second [1/s].
        psd_frequency: Where the density is compared, shape (n_p,) [Hz]; may be empty for a strong
            phase too short to say anything.
        psd: One-sided power spectral density of the strong phase, smoothed, shape (n_p,) [m²/s³].
        psd_target: What it is compared with, shape (n_p,) [m²/s³].
        verdicts: The criteria.
    """

    misfit: Misfit
    strong_phase: StrongPhase
    zero_crossings: float
    psd_frequency: FloatArray
    psd: FloatArray
    psd_target: FloatArray
    verdicts: tuple[Verdict, ...]

    @property
    def accepted(self) -> bool:
        """Whether all criteria are met."""
        return all(verdict.passed for verdict in self.verdicts)

    @property
    def points_below(self) -> int:
        """Number of points below the target."""
        return int(np.count_nonzero(self.misfit.ratio < 1.0))

    @property
    def points_above(self) -> int:
        """Number of points above the target."""
        return int(np.count_nonzero(self.misfit.ratio > 1.0))

    @property
    def frequency_of_smallest_ratio(self) -> float:
        """Where the motion falls below the target most [Hz]."""
        return float(self.misfit.frequency[np.argmin(self.misfit.ratio)])

    @property
    def frequency_of_largest_ratio(self) -> float:
        """Where the motion goes above the target most [Hz]."""
        return float(self.misfit.frequency[np.argmax(self.misfit.ratio)])

    def verdict(self, name: str) -> Verdict:
        """The verdict on a criterion.

        Raises:
            KeyError: There is no such criterion.
        """
        for verdict in self.verdicts:
            if verdict.name == name:
                return verdict
        raise KeyError(name)


def acceptance(
    accelerogram: Accelerogram,
    target: Target,
    *,
    minimum: float = 0.1,
    maximum: float = 50.0,
    criteria: Criteria | None = None,
    psd: Callable[[npt.ArrayLike], FloatArray] | None = None,
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
    30 iterations) stayed above 0.44 of it; hence 0.4 for `own_psd_share`.

    Args:
        accelerogram: The motion.
        target: The design spectrum, at its damping.
        minimum: Lowest frequency compared [Hz].
        maximum: Highest frequency compared [Hz], not above the Nyquist frequency.
        criteria: What is asked; those of SRP 3.7.1 when None.
        psd: Target of the one-sided density [m²/s³] by frequency [Hz].

    Returns:
        The comparison and the verdicts: "points_per_decade", "smallest_ratio", "largest_ratio",
        "longest_below", "duration", "strong_phase", "nyquist", "psd_ratio".

    Raises:
        ImpactfemError: The motion is zero throughout, or the frequencies are out of range.
    """
    asked = criteria or Criteria()
    nyquist = 0.5 / accelerogram.time_step
    if not 0.0 < minimum < maximum <= nyquist:
        raise ImpactfemError(
            "the frequencies compared must be 0 < minimum < maximum <= Nyquist frequency,"
            f" {nyquist:.6g} Hz, got {minimum!r} Hz and {maximum!r} Hz"
        )
    phase = strong_phase(accelerogram)
    misfit = spectral_misfit(accelerogram, target, minimum, maximum, per_decade=asked.per_decade)
    ratio = misfit.ratio
    decades = np.log10(misfit.frequency[-1] / misfit.frequency[0])
    low = max(_LOW_PSD, minimum, 0.0 if psd else _BINS / (2.0 * WINDOW * phase.duration))
    checked = misfit.frequency[(misfit.frequency >= low) & (misfit.frequency <= _HIGH_PSD)]
    has = power_spectrum(accelerogram, checked)
    wants = psd(checked) if psd else compatible_power_spectrum(target, checked, phase.duration)
    share = asked.psd_share if psd else asked.own_psd_share
    smallest = float(np.min(has[wants > 0.0] / wants[wants > 0.0], initial=np.inf))
    if checked.size == 0:
        smallest = 0.0  # too short to say: not accepted
    verdicts = (
        Verdict(
            "points_per_decade",
            (ratio.size - 1) / decades,
            asked.per_decade * (1 - 1e-9),
            True,
            "-",
        ),
        Verdict("smallest_ratio", misfit.smallest_ratio, asked.lower, True, "-"),
        Verdict("largest_ratio", misfit.largest_ratio, asked.upper, False, "-"),
        Verdict("longest_below", _longest_run(ratio < 1.0), asked.longest_below, False, "-"),
        Verdict("duration", accelerogram.duration, asked.duration * (1 - 1e-9), True, "s"),
        Verdict("strong_phase", phase.duration, asked.strong_phase, True, "s"),
        Verdict("nyquist", nyquist, asked.nyquist * (1 - 1e-9), True, "Hz"),
        Verdict("psd_ratio", smallest, share, True, "-"),
    )
    return Acceptance(
        misfit, phase, _zero_crossings(accelerogram, phase), checked, has, wants, verdicts
    )


def _longest_run(holds: npt.NDArray[np.bool_]) -> int:
    """Length of the longest row of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], holds.astype(np.int8), [0]])))
    return int(np.max(edges[1::2] - edges[::2], initial=0))


def _zero_crossings(accelerogram: Accelerogram, phase: StrongPhase) -> float:
    """Changes of sign in the strong phase, in a second."""
    t = accelerogram.time
    part = accelerogram.acceleration[(t >= phase.begin) & (t <= phase.end)]
    signs = np.sign(part[part != 0.0])
    return float(np.count_nonzero(np.diff(signs)) / phase.duration) if phase.duration else 0.0
