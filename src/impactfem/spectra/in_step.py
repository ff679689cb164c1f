"""Exact peaks of oscillators inside the steps of a piecewise-linear base acceleration.

In a step a(t_n + t) = a_n + s t, and an output f = Re(G z) of the state z (equation (2) of
:mod:`impactfem.spectra.recurrence`) is a damped sinusoid plus a straight line. With

    Q = Gλ² z_n - Gλ a_n - G s                                                            (1)

its value and derivatives are, again without a division of small numbers,

    f(t)   = f_n + f'_n t + Re(Q φ2(λt)) t²                                               (2)
    f'(t)  = f'_n + Re(Q φ1(λt)) t,    f'_n = Re(Gλ z_n) - Re(G) a_n                      (3)
    f''(t) = Re(Q e^(λt))                                                                 (4)

The zeros of (4) are known in closed form; between two of them f' is monotonic and has at most one
zero, which is bracketed and found by bisection and Newton's method.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
from numba import njit

from impactfem.spectra.peaks import free_vibration_peak
from impactfem.spectra.recurrence import ComplexArray, FloatArray, StepCoefficients


def in_step_peak_responses(
    acceleration: FloatArray, coefficients: StepCoefficients
) -> tuple[FloatArray, FloatArray]:
    """Find the exact peaks of relative displacement and absolute acceleration.

    Exact for an input that is linear between its samples, over the steps and in the free
    vibration after the last sample.

    Args:
        acceleration: Base accelerations, finite, shape (n_r, n) [m/s2].
        coefficients: Of n_o oscillators at the records' time step.

    Returns:
        max |x|, shape (n_r, n_o) [m], and max |x'' + a|, shape (n_r, n_o) [m/s2].
    """
    c = coefficients
    gains = np.array([-1j / c.omega_d, c.acceleration_gain])
    peaks = np.zeros((2, acceleration.shape[0], c.omega.size))
    end = np.empty(peaks.shape[1:], dtype=np.complex128)
    _in_step_kernel(
        acceleration,
        c.time_step,
        c.rate,
        c.propagator,
        c.input_gain,
        c.feedthrough,
        gains,
        peaks,
        end,
    )
    sd = np.maximum(peaks[0], free_vibration_peak(end, c.rate, gains[0]))
    sa = np.maximum(peaks[1], free_vibration_peak(end, c.rate, gains[1]))
    return sd, sa


@njit(nogil=True, cache=True)
def _in_step_kernel(
    acceleration: FloatArray,
    h: float,
    rate: ComplexArray,
    propagator: ComplexArray,
    input_gain: ComplexArray,
    feedthrough: ComplexArray,
    gains: ComplexArray,
    peaks: FloatArray,
    end: ComplexArray,
) -> None:
    n_records, n = acceleration.shape
    for record in range(n_records):
        a = acceleration[record]
        for o in range(rate.size):
            z = 0.0j
            w = -feedthrough[o] * a[0]
            for i in range(n - 1):
                w = propagator[o] * w + input_gain[o] * a[i]
                z_next = w + feedthrough[o] * a[i + 1]
                for k in range(2):
                    peaks[k, record, o] = _step_peak(
                        peaks[k, record, o], gains[k, o], rate[o], z, z_next, a[i], a[i + 1], h
                    )
                z = z_next
            end[record, o] = z


@njit(nogil=True, cache=True)
def _step_peak(
    peak: float,
    gain: complex,
    rate: complex,
    z: complex,
    z_next: complex,
    a: float,
    a_next: float,
    h: float,
) -> float:
    """Raise a peak by the maximum of |Re(G z)| in one step."""
    f = (gain * z).real
    ends = max(abs(f), abs((gain * z_next).real))
    q = gain * (rate * (rate * z - a) - (a_next - a) / h)
    # A function leaves its chord by h²/8 max |f''| at most: most steps cannot hold the peak.
    if ends + 0.125 * h * h * abs(q) <= peak:
        return peak
    peak = max(peak, ends)
    slope = (gain * rate * z).real - gain.real * a
    left, slope_left = 0.0, slope
    turn = ((0.5 * math.pi - cmath.phase(q)) % math.pi) / rate.imag
    while left < h:
        right = turn if left < turn < h else h
        slope_right = slope + (q * _phi(rate * right, 1)).real * right
        if (slope_left < 0.0) != (slope_right < 0.0):
            t = _stationary_point(left, right, slope_left, slope, q, rate)
            peak = max(peak, abs(f + slope * t + (q * _phi(rate * t, 2)).real * t * t))
        left, slope_left = right, slope_right
        turn += math.pi / rate.imag
    return peak


@njit(nogil=True, cache=True)
def _stationary_point(
    left: float, right: float, slope_left: float, slope: float, q: complex, rate: complex
) -> float:
    """Find the zero of (3) in a bracket: Newton's method, bisection where it leaves the bracket."""
    t = 0.5 * (left + right)
    for _ in range(60):
        value = slope + (q * _phi(rate * t, 1)).real * t
        if (value < 0.0) == (slope_left < 0.0):
            left = t
        else:
            right = t
        curvature = (q * cmath.exp(rate * t)).real
        t_next = t - value / curvature if curvature != 0.0 else left
        if not left < t_next < right:
            t_next = 0.5 * (left + right)
        # At a stationary point an error in time enters the value squared.
        if abs(t_next - t) <= 1e-9 * right:
            return t_next
        t = t_next
    return t


@njit(nogil=True, cache=True)
def _phi(y: complex, order: int) -> complex:
    """φ1 or φ2 of one argument: the series inside the unit circle, else the closed form."""
    if abs(y) <= 1.0:
        value = 0.0j
        for k in range(19, -1, -1):
            value = 1.0 + y * value / (k + order + 1)
        return value / order  # leading terms 1/1! and 1/2!
    phi1 = (cmath.exp(y) - 1.0) / y
    return phi1 if order == 1 else (phi1 - 1.0) / y
