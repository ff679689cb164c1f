"""Speed of the sticks, and of the response spectra against a plain compiled loop and a library.

The oscillator kernel, the loop and the filter find the same peaks at the samples; they differ in
how the work is laid out.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from scipy.signal import lfilter

from bench.suite import Figure, best_time, timed
from impactfem.case import load_case
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.coupling.ground import interpolate_ground
from impactfem.coupling.pounding import simulate
from impactfem.motion.from_case import ground_motions
from impactfem.spectra.frequency_list import logarithmic_frequencies
from impactfem.spectra.oscillator import StepCoefficients, step_coefficients
from impactfem.spectra.peaks import peak_responses
from impactfem.spectra.response_spectrum import upsample
from impactfem.system.arrays import Array
from impactfem.system.files import in_source_tree

STEPS = 50_000
FINER = 10
"""Samples that a record of the kernels is refined to in a step of its own."""


def stick_figures() -> list[Figure]:
    """The two 8-floor buildings of the paper, all 96 degrees of freedom, 50,000 steps."""
    case = load_case(in_source_tree("geometry/npp_pair.toml"))
    calibration, calibrated = timed(lambda: calibration_of(case))
    system, dt = system_of(case, calibration), case.pounding.time_step
    motions = [motion.history for motion in ground_motions(case.motions)]
    ground = interpolate_ground(motions, dt, STEPS + 1)
    whole = best_time(lambda: simulate(system, ground, dt), 5)
    return [
        Figure("pounding, 50,000 steps of two 8-floor buildings", whole, "s", 0.3),
        Figure("pounding, degrees of freedom", float(system.M.shape[0]), "-"),
        Figure("pounding, time a step", 1e6 * whole / STEPS, "µs"),
        Figure("calibration of the sticks", calibrated, "s"),
    ]


def spectrum_figures(
    records: int = 4, samples: int = 20_000, frequencies: int = 300, repeats: int = 5
) -> list[Figure]:
    """Rates of one core in double precision on random records; compilation is left out.

    These are refined as spectra are, which have 20 samples in a cycle of the highest frequency.
    The two slow ones run on a tenth of the oscillators, which are 0.5 Hz to 500 Hz at 5 %.
    """
    coarse = np.random.default_rng(0).standard_normal((records, 2 + (samples - 1) // FINER))
    a = np.ascontiguousarray(upsample(coarse, FINER)[:, :samples])
    listed = logarithmic_frequencies(0.5, 500.0, max(1, (frequencies - 1) // 3))
    every = step_coefficients(1e-4, listed, [0.05])
    few = step_coefficients(1e-4, listed[::10], [0.05])
    kernel = (
        a.size
        * every.omega.size
        / best_time(lambda: peak_responses(a, every, absolute=False), repeats)
    )
    plain = a.size * few.omega.size / best_time(lambda: plain_peaks(a, few), 3)
    library = a.size * few.omega.size / best_time(lambda: filtered(a, few), 3)
    unit = "record·frequency·sample/s"
    return [
        Figure("oscillator kernel, one core", kernel, unit, 1.5e9, at_most=False),
        Figure("plain compiled scalar loop, one core", plain, unit),
        Figure("scipy lfilter, one core", library, unit),
        Figure("kernel over plain loop", kernel / plain, "-"),
        Figure("kernel over lfilter", kernel / library, "-"),
    ]


def plain_peaks(acceleration: Array, coefficients: StepCoefficients) -> Array:
    """Peaks of |x| by the recurrence of textbooks, one oscillator at a time, (n_r, n_o) [m].

    Displacement and velocity at the new sample from those at the old one and two input samples.
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
    peaks: Array = _plain_loop(acceleration, np.ascontiguousarray(matrix))
    return peaks


def filtered(acceleration: Array, coefficients: StepCoefficients) -> list[Array]:
    """Histories of x by ``scipy.signal.lfilter``, an array (n_r, n) an oscillator [m].

    The transfer function of the complex step, d + g/(ζ - E) with ζ the shift of one sample, is
    brought to real polynomials; its imaginary part over ω_d gives x. The first sample is zero.
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
def _plain_loop(acceleration: Array, matrix: Array) -> Array:
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
