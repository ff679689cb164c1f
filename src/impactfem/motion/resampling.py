"""Another time step for a motion, band-limited."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
from scipy import fft

from impactfem.motion.accelerogram import Accelerogram
from impactfem.system.errors import ImpactfemError

_LARGEST_RATIO = 100_000  # of the whole numbers that make the ratio of the steps
_MOST_SAMPLES = 10_000_000
_EDGE = 0.8  # of the new Nyquist frequency: where the low-pass of a coarser step begins


def resampled(accelerogram: Accelerogram, time_step: float) -> Accelerogram:
    """Give a motion another time step.

    With h / h' = p / q in whole numbers, the record is continued by zeros to at least twice its
    length and to a multiple of q; its discrete spectrum is cut, or continued by zeros, to that of
    p / q times as many samples. A finer step keeps the given samples where the steps meet. For a
    coarser one all above its Nyquist frequency is lost: from 0.8 of it on, half a cosine takes
    the spectrum to zero there, so that nothing is folded back.

    Args:
        accelerogram: The motion.
        time_step: New step h' [s]; its ratio to the old one must be one of whole numbers up to
            100 000.

    Returns:
        The motion from 0 to the last multiple of h' inside its duration.

    Raises:
        ImpactfemError: The step is out of range, or the ratio is not one of whole numbers.
    """
    h, n = accelerogram.time_step, accelerogram.acceleration.size
    if not (np.isfinite(time_step) and 0.0 < time_step <= 0.5 * accelerogram.duration):
        raise ImpactfemError(
            "the step to resample to must be positive and at most half the duration of"
            f" {accelerogram.duration:.6g} s, got {time_step!r} s"
        )
    if accelerogram.duration / time_step > _MOST_SAMPLES:
        raise ImpactfemError(
            f"a step of {time_step!r} s would make more than {_MOST_SAMPLES:.0e} samples of"
            f" {accelerogram.duration:.6g} s"
        )
    ratio = Fraction(h / time_step).limit_denominator(_LARGEST_RATIO)
    p, q = ratio.numerator, ratio.denominator
    if p == q:
        return accelerogram
    if p > _LARGEST_RATIO or p == 0 or abs(float(ratio) * time_step / h - 1.0) > 1e-9:
        raise ImpactfemError(
            f"the steps {h:.9g} s and {time_step:.9g} s must have the ratio of whole numbers up"
            f" to {_LARGEST_RATIO}"
        )
    block = fft.next_fast_len(-(-2 * n // q), real=True)
    spectrum = fft.rfft(accelerogram.acceleration, block * q)
    n_new = block * p
    if p < q:
        nyquist = 0.5 * n_new
        edge = np.clip((np.arange(spectrum.size) / nyquist - _EDGE) / (1.0 - _EDGE), 0.0, 1.0)
        spectrum *= 0.5 * (1.0 + np.cos(np.pi * edge))
        spectrum = spectrum[: n_new // 2 + 1]
    elif block * q % 2 == 0:
        spectrum[-1] *= 0.5  # its energy belongs to the positive and the negative frequency alike
    size = int(accelerogram.duration / time_step * (1.0 + 1e-12)) + 1
    samples = fft.irfft(spectrum, n_new)[:size] * (p / q)
    how = f"low-pass at {0.5 / time_step:.6g} Hz" if p < q else "band-limited"
    note = f"{accelerogram.origin}; resampled from {h:.9g} s to {time_step:.9g} s, {how}"
    return replace(
        accelerogram,
        time_step=time_step,
        acceleration=samples,
        origin=note.removeprefix("; "),
    )
