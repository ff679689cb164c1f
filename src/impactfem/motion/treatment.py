"""What is done to a record before it is used: each step explicit, in a fixed order, and logged."""

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Literal

import numpy as np
from scipy import fft, signal

from impactfem.records.accelerogram import Accelerogram
from impactfem.spectra.response_spectrum import upsampling_factor
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError
from impactfem.system.log import LOGGER

Baseline = Literal["none", "mean", "linear", "rest"]

FILTER_ORDER = 4
_LARGEST_RATIO = 100_000  # of the whole numbers that make the ratio of the steps
_MOST_SAMPLES = 10_000_000
_EDGE = 0.8  # of the new Nyquist frequency: where the low-pass of a coarser step begins
HIGHEST = 100.0
"""Frequency up to which straight lines between the samples keep the motion [Hz]."""
LOST = 0.01
"""Part of an amplitude that straight lines may lose at this frequency."""
_POINTS = 40.0  # in a cycle of a refined record: straight lines lose 0.2 %


class TreatmentError(ImpactfemError):
    """A step that cannot be done on a record; `key` of [[motions]] says which."""

    def __init__(self, message: str, key: str = "resample") -> None:
        super().__init__(message)
        self.key = key


@dataclass(frozen=True)
class Treatment:
    """The steps done to a record, in this order; each is left out by its default.

    1. `baseline` "mean" or "linear": the mean, or the straight line of least squares, of the whole
       record is taken out. First, so that nothing steps at the ends of what follows.
    2. `taper`: half a cosine takes the record to zero over this time at both ends.
    3. `band`: Butterworth band-pass of order 4, once forward and once backward over the record
       continued by zeros for 1.5 x 4 / f_low at both ends (the length that Boore and Bommer 2005,
       Soil Dyn. Earthq. Eng. 25, 93-115, advise): no phase is shifted, the corners are damped by
       a half, and the fall beyond them is that of order 8. The continuation is cut off again, and
       with it what the filter left there: `baseline` "rest" mends the end.
    4. `resample`: another step (:func:`resampled`).
    5. `baseline` "rest": end velocity and displacement are brought to zero by two smooth bells
       (:class:`BaselineCorrection`). Last, as all others would spoil it.

    Raises:
        ImpactfemError: A value is out of range.
    """

    baseline: Baseline = "none"
    taper: float | None = None  #: length of either taper [s]
    band: tuple[float, float] | None = None  #: low and high corner frequency [Hz]
    resample: float | None = None  #: new time step [s]

    def __post_init__(self) -> None:
        if self.taper is not None and not 0.0 < self.taper < math.inf:
            raise ImpactfemError(f"the taper must be positive, got {self.taper!r} s")
        if self.band is not None and not 0.0 < self.band[0] < self.band[1] < math.inf:
            raise ImpactfemError(
                f"the corner frequencies must be 0 < low < high, got {self.band!r} Hz"
            )

    def __call__(self, accelerogram: Accelerogram) -> Accelerogram:
        """The record with each step done in its origin, which is logged as well.

        Raises:
            TreatmentError: A step cannot be done on this record.
        """
        result = accelerogram
        if self.baseline == "mean":
            mean = float(result.acceleration.mean())
            samples = result.acceleration - mean
            result = _noted(result, samples, f"mean of {mean:.6g} m/s2 taken out")
        elif self.baseline == "linear":
            t, a = result.time, result.acceleration
            middle = t - t.mean()
            slope = float(a @ middle / (middle @ middle))
            level = float(a.mean()) - slope * float(t.mean())
            note = f"line {level:.6g} m/s2 + {slope:.6g} m/s3 t taken out"
            result = _noted(result, a - (level + slope * t), note)
        h, t, duration = result.time_step, result.time, result.duration
        if self.taper is not None:
            if self.taper > 0.5 * duration:
                raise TreatmentError(
                    f"the taper of {self.taper:.6g} s is longer than half the record, "
                    f"{0.5 * duration:.6g} s",
                    "taper",
                )
            share = np.clip(np.minimum(t, duration - t) / self.taper, 0.0, 1.0)
            window = 0.5 * (1.0 - np.cos(np.pi * share))
            note = f"tapered over {self.taper:.6g} s at both ends"
            result = _noted(result, result.acceleration * window, note)
        if self.band is not None:
            low, high = self.band
            if high >= 0.5 / h:
                raise TreatmentError(
                    f"the high corner of {high:.6g} Hz must be below the Nyquist frequency of the"
                    f" record, {0.5 / h:.6g} Hz",
                    "filter",
                )
            if low < 0.1 / duration:
                raise TreatmentError(
                    f"the low corner of {low:.6g} Hz must be at least a tenth of a cycle in the"
                    f" duration, {0.1 / duration:.6g} Hz",
                    "filter",
                )
            # Zeros at both ends, so that the filter rings out before the record is turned round.
            pad = math.ceil(1.5 * FILTER_ORDER / low / h)
            sos = signal.butter(FILTER_ORDER, self.band, btype="bandpass", fs=1.0 / h, output="sos")
            forward = signal.sosfilt(sos, np.pad(result.acceleration, pad))
            both = signal.sosfilt(sos, forward[::-1])[::-1]
            corners = f"{low:.6g} Hz to {high:.6g} Hz"
            note = f"Butterworth band-pass {corners} of order {FILTER_ORDER}, forward and backward"
            result = _noted(result, both[pad : pad + t.size], note)
        if self.resample is not None:
            result = resampled(result, self.resample)
        if self.baseline == "rest":
            a = result.acceleration
            correction = BaselineCorrection(a.size, result.time_step)(a) - a
            most = float(np.abs(correction).max())
            note = f"brought to rest at its end by a correction of at most {most:.4g} m/s2"
            result = _noted(result, a + correction, note)
        done = result.origin.removeprefix(accelerogram.origin).removeprefix("; ")
        if done:
            LOGGER.debug("%s: %s", accelerogram.name or "record", done)
        return result


def _noted(
    accelerogram: Accelerogram, acceleration: Array, note: str, **others: Any
) -> Accelerogram:
    origin = f"{accelerogram.origin}; {note}".removeprefix("; ")
    return replace(accelerogram, acceleration=acceleration, origin=origin, **others)


def straight_line_loss(time_step: float, frequency: float) -> float:
    """Compute what straight lines between samples take from the amplitude of a sine.

    1 − sinc²(f h), h the step of the samples [s], f the frequency [Hz], sinc(x) = sin(πx) / (πx).
    """
    return float(1.0 - np.sinc(frequency * time_step) ** 2)


def refined_step(time_step: float) -> float | None:
    """Compute the step to which a record is refined before a structure takes straight lines [s].

    A record holds nothing above its Nyquist frequency. Up to this, or to 100 Hz, the refined record
    has 40 samples in a cycle, so that straight lines between them lose 0.2 %. None where those
    between the given samples lose at most 1 %, as at steps up to 0.55 ms.
    """
    highest = min(HIGHEST, 0.5 / time_step)
    if straight_line_loss(time_step, highest) <= LOST:
        return None
    return time_step / upsampling_factor(time_step, highest, _POINTS)


def resampled(accelerogram: Accelerogram, time_step: float) -> Accelerogram:
    """Give a motion another time step, up to the last multiple of it inside its duration.

    The straight line from the first to the last sample is taken out first, and added again: a
    record that begins or ends with an offset does not ring there. With h / h' = p / q in whole
    numbers, the rest is continued by zeros to at least twice its length and to a multiple of q, so
    that its end does not come back at its beginning; its discrete spectrum is cut, or continued by
    zeros, to that of p / q times as many samples. A finer step keeps the given samples where the
    steps meet. For a coarser one all above its Nyquist frequency is lost: from 0.8 of it on, half a
    cosine takes the spectrum to zero there, so that nothing is folded back.

    Args:
        accelerogram: The motion.
        time_step: New step h' [s]; its ratio to the old one must be one of whole numbers up to
            100 000.

    Raises:
        TreatmentError: The step is out of range, or the ratio is not one of whole numbers.
    """
    h, n, duration = accelerogram.time_step, accelerogram.acceleration.size, accelerogram.duration
    if not (np.isfinite(time_step) and 0.0 < time_step <= 0.5 * duration):
        raise TreatmentError(
            "the step to resample to must be positive and at most half the duration of"
            f" {duration:.6g} s, got {time_step!r} s"
        )
    if duration / time_step > _MOST_SAMPLES:
        raise TreatmentError(
            f"a step of {time_step:.6g} s would make more than {_MOST_SAMPLES:.0e} samples of"
            f" {duration:.6g} s; cut the record, or give a longer step"
        )
    ratio = Fraction(h / time_step).limit_denominator(_LARGEST_RATIO)
    p, q = ratio.numerator, ratio.denominator
    if p == q:
        return accelerogram
    if p > _LARGEST_RATIO or p == 0 or abs(float(ratio) * time_step / h - 1.0) > 1e-9:
        raise TreatmentError(
            f"the steps {h:.9g} s and {time_step:.9g} s must have the ratio of whole numbers up"
            f" to {_LARGEST_RATIO}"
        )
    block = fft.next_fast_len(-(-2 * n // q), real=True)
    first, last = accelerogram.acceleration[[0, -1]]
    spectrum = fft.rfft(accelerogram.acceleration - np.linspace(first, last, n), block * q)
    n_new = block * p
    if p < q:
        nyquist = 0.5 * n_new
        edge = np.clip((np.arange(spectrum.size) / nyquist - _EDGE) / (1.0 - _EDGE), 0.0, 1.0)
        spectrum *= 0.5 * (1.0 + np.cos(np.pi * edge))
        spectrum = spectrum[: n_new // 2 + 1]
    elif block * q % 2 == 0:
        spectrum[-1] *= 0.5  # its energy belongs to the positive and the negative frequency alike
    size = int(duration / time_step * (1.0 + 1e-12)) + 1
    line = first + (last - first) / duration * time_step * np.arange(size)
    samples = fft.irfft(spectrum, n_new)[:size] * (p / q) + line
    how = f"low-pass at {0.5 / time_step:.6g} Hz" if p < q else "band-limited"
    note = f"resampled from {h:.9g} s to {time_step:.9g} s, {how}"
    return _noted(accelerogram, samples, note, time_step=time_step)


class BaselineCorrection:
    """Takes c_1 φ_1 + c_2 φ_2 from an acceleration so that it ends at rest and without offset.

    With τ = t/T from 0 to 1,

        φ_1 = sin²(πτ),    φ_2 = sin²(πτ) cos(πτ)

    begin and end smoothly at zero and hold nothing much above 1.5/T Hz (0.09 Hz for the 16.79 s
    of the paper): an oscillator well above that follows them statically, so that a spectrum
    ordinate changes by no more than the correction itself, about 2 v(T)/T. φ_1 changes the end
    velocity, φ_2 only the end displacement; c_1, c_2 follow from the end values

        v(T) = ∫ a dt,    d(T) = ∫ (T - t) a dt

    which are linear in the samples and exact for acceleration that is linear between them. A motion
    of fewer than 4 samples is refused.
    """

    def __init__(self, n: int, time_step: float) -> None:
        if n < 4:
            expected = f"a baseline correction needs at least 4 samples, got {n}"
            raise TreatmentError(expected, "baseline")
        h = time_step
        tau = np.linspace(0.0, 1.0, n)
        bell = np.sin(np.pi * tau) ** 2
        self._shapes = np.array([bell, bell * np.cos(np.pi * tau)])
        velocity = np.full(n, h)
        velocity[[0, -1]] = 0.5 * h
        displacement = h**2 * np.arange(n - 1, -1, -1, dtype=np.float64)
        displacement[0] = h**2 * ((n - 1) / 2.0 - 1.0 / 6.0)
        displacement[-1] = h**2 / 6.0
        self._ends = np.array([velocity, displacement])
        self._inverse = np.linalg.inv(self._ends @ self._shapes.T)

    def __call__(self, acceleration: Array) -> Array:
        """An acceleration, shape (n,) [m/s2], at rest and without offset at its end."""
        # c_1, c_2 from v(T) and d(T).
        coefficients = self._inverse @ (self._ends @ acceleration)
        return np.asarray(acceleration - coefficients @ self._shapes)
