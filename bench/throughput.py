"""How fast the kernel is on this machine, beside a plain compiled loop and a library filter.

All three find the same peaks at the samples; they differ in how the work is laid out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.signal import lfilter

from bench.timing import best_time
from impactfem.spectra.frequency_list import logarithmic_frequencies
from impactfem.spectra.oscillator import FloatArray, StepCoefficients, step_coefficients
from impactfem.spectra.peaks import displacement_peaks


@dataclass(frozen=True)
class Throughput:
    """Rates of one core in double precision, records x frequencies x samples a second [1/s].

    Args:
        kernel: Of :func:`impactfem.spectra.peaks.displacement_peaks`.
        plain_loop: Of the textbook recurrence, one oscillator after the other, compiled.
        lfilter: Of ``scipy.signal.lfilter``, the filter alone, its peaks not yet looked for.
    """

    kernel: float
    plain_loop: float
    lfilter: float


def measure_throughput(
    records: int = 4, samples: int = 20_000, frequencies: int = 300, repeats: int = 5
) -> Throughput:
    """Time the three on random records; compilation is left out, the best repeat counts.

    Args:
        records: Number of records.
        samples: Samples of each.
        frequencies: Number of oscillators, 0.5 Hz to 500 Hz at 5 %.
        repeats: How often the kernel is timed; the two slow ones run on a part of the work.

    Returns:
        The rates.
    """
    a = np.random.default_rng(0).standard_normal((records, samples))
    listed = logarithmic_frequencies(0.5, 500.0, max(1, (frequencies - 1) // 3))
    every = step_coefficients(1e-4, listed, [0.05])
    few = step_coefficients(1e-4, listed[::10], [0.05])
    return Throughput(
        kernel=a.size * every.omega.size / best_time(lambda: displacement_peaks(a, every), repeats),
        plain_loop=a.size * few.omega.size / best_time(lambda: plain_peaks(a, few), 3),
        lfilter=a.size * few.omega.size / best_time(lambda: filtered(a, few), 3),
    )


def plain_peaks(acceleration: FloatArray, coefficients: StepCoefficients) -> FloatArray:
    """Find max |x| at the samples with the recurrence as it is printed in textbooks.

    Displacement and velocity at the new sample from those at the old one and two input samples:
    eight multiplications, one oscillator at a time.

    Args:
        acceleration: Shape (n_r, n) [m/s2].
        coefficients: Of n_o oscillators.

    Returns:
        Shape (n_r, n_o) [m].
    """
    c = coefficients
    slope = c.xi * c.omega / c.omega_d
    # Unit states (x, x') = (1, 0) and (0, 1), and unit inputs, taken through the complex step.
    images = [
        c.propagator * (c.xi * c.omega + 1j * c.omega_d),
        c.propagator,
        c.input_gain - c.propagator * c.feedthrough,
        c.feedthrough,
    ]
    matrix = np.array(
        [[z.imag / c.omega_d for z in images], [z.real - slope * z.imag for z in images]]
    )
    peaks: FloatArray = _plain_loop(acceleration, np.ascontiguousarray(matrix))
    return peaks


def filtered(acceleration: FloatArray, coefficients: StepCoefficients) -> list[FloatArray]:
    """Compute x at the samples with ``scipy.signal.lfilter``, one oscillator after the other.

    The transfer function of the complex step, d + g/(ζ - E) with ζ the shift of one sample, is
    brought to real polynomials; its imaginary part over ω_d gives x.

    Args:
        acceleration: Shape (n_r, n) [m/s2]; the first sample zero, or the filter starts with it.
        coefficients: Of n_o oscillators.

    Returns:
        One array of histories an oscillator, shape (n_r, n) [m].
    """
    c = coefficients
    E, g, d = c.propagator, c.input_gain, c.feedthrough
    numerator = np.array(
        [d.imag, (g - 2.0 * E.real * d).imag, (abs(E) ** 2 * d - g * E.conj()).imag]
    )
    denominator = np.array([np.ones_like(c.omega), -2.0 * E.real, abs(E) ** 2])
    return [
        lfilter(b / omega_d, q, acceleration, axis=1)
        for b, q, omega_d in zip(numerator.T, denominator.T, c.omega_d, strict=True)
    ]


@njit(nogil=True, cache=True)
def _plain_loop(acceleration: FloatArray, matrix: FloatArray) -> FloatArray:
    n_records, n = acceleration.shape
    peaks = np.zeros((n_records, matrix.shape[2]))
    for record in range(n_records):
        for o in range(matrix.shape[2]):
            x, v, peak = 0.0, 0.0, 0.0
            m = matrix[:, :, o]
            for i in range(1, n):
                old, new = acceleration[record, i - 1], acceleration[record, i]
                x_next = m[0, 0] * x + m[0, 1] * v + m[0, 2] * old + m[0, 3] * new
                v = m[1, 0] * x + m[1, 1] * v + m[1, 2] * old + m[1, 3] * new
                x = x_next
                peak = max(peak, abs(x))
            peaks[record, o] = peak
    return peaks
