"""What samples of the base's motion lose, and a motion with more samples between them."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from scipy import fft

from impactfem.spectra.oscillator import FloatArray
from impactfem.system.errors import ImpactfemError


def upsampling_factor(time_step: float, frequency: float, points_per_cycle: float) -> int:
    """Give the smallest whole factor that brings a record to the requested points per cycle.

    Args:
        time_step: Step h of the record [s].
        frequency: Highest frequency f [Hz].
        points_per_cycle: Samples in one cycle of f [-].

    Returns:
        max(1, ⌈points_per_cycle f h⌉).
    """
    # The allowance keeps 20 points x 500 Hz x 1 ms at 10, whatever the rounding of the product.
    return max(1, math.ceil(points_per_cycle * frequency * time_step * (1.0 - 1e-12)))


def upsample(acceleration: FloatArray, factor: int) -> FloatArray:
    """Insert factor - 1 band-limited samples between the samples of each record.

    The discrete spectrum is continued by zeros, which interpolates by the periodic sinc function.
    Each record is first continued by zeros to at least twice its length: the interpolant of the
    last samples then fades out in the silence behind the record and does not come back at its
    beginning. The bin at the Nyquist frequency is halved, because its energy belongs to the
    positive and to the negative frequency alike; only so are the given samples kept.

    Args:
        acceleration: Records in rows, shape (n_r, n) [m/s2]. A record that begins or ends with a
            step rings there, as any band-limited signal with a step does.
        factor: Whole number of new steps in an old one [-].

    Returns:
        Shape (n_r, (n - 1) factor + 1) [m/s2]; every factor-th sample is the given one to
        round-off. What the interpolant does after the last given sample is left out.

    Raises:
        ImpactfemError: The factor is below 1.
    """
    if factor < 1:
        raise ImpactfemError(f"the upsampling factor must be a whole number >= 1, got {factor}")
    if factor == 1:
        return acceleration
    n_records, n = acceleration.shape
    padded = 2 * fft.next_fast_len(n, real=True)
    fine = np.empty((n_records, (n - 1) * factor + 1))
    # Record by record: the padded spectra of a large ensemble at once would not fit in memory.
    for record, out in zip(acceleration, fine, strict=True):
        spectrum = fft.rfft(record, padded)
        spectrum[-1] *= 0.5
        out[:] = fft.irfft(spectrum, padded * factor)[: out.size]
    fine *= factor
    return fine


def sampling_loss(points_per_cycle: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Bound of the relative loss of a peak that is read at samples.

    Let the base's motion hold nothing above a frequency f, of which n = 1 / (f Δt) samples make a
    cycle. Neither does the relative displacement x of any oscillator on it, and about its peak
    x_max at the time t it stays above a cosine (Duffin and Schaeffer 1938),

        x(t + τ) ≥ x_max cos(2πfτ),   |τ| ≤ 1 / 2f.

    The straight lines between the samples average x over ±Δt with the weights of a hat, which
    leaves sinc²(1/n) of that cosine at least; the sample that is nearest to the peak is within
    Δt/2 of it, which leaves cos(π/n):

        loss ≤ 1 − sinc²(1/n) cos(π/n),   sinc(x) = sin(πx) / (πx),   n ≥ 3.

    An oscillator in resonance with a sine at f reaches it. Below three samples nothing is proved;
    at the Nyquist frequency, n = 2, nothing is left: the bound is 1.

    Args:
        points_per_cycle: n, any shape [-]; at 2 or less the bound is 1.

    Returns:
        The bound, of the same shape [-].
    """
    n = np.maximum(np.asarray(points_per_cycle, dtype=np.float64), 2.0)
    return np.asarray(1.0 - np.sinc(1.0 / n) ** 2 * np.cos(np.pi / n), dtype=np.float64)
