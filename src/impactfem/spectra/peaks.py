"""Peaks of oscillators: at the samples of many records, or exact inside their steps.

The loop over samples is outside and the loop over oscillators inside, over contiguous memory, so
that the compiler puts four or eight oscillators into one vector register. Four samples are taken
in one pass to spare loads and stores of the state, and the shifted state of equation (4) of
:mod:`impactfem.spectra.oscillator` needs one input a sample. What that gains over a plain scalar
loop is printed by ``impactfem bench``. Where displacements alone count, slow oscillators go in
strides of many samples (:mod:`impactfem.spectra.strides`).

Inside a step, a(t_n + t) = a_n + s t, and an output f = Re(G z) of the state z (equation (2) of
:mod:`impactfem.spectra.oscillator`) is a damped sinusoid plus a straight line. With

    Q = Gλ² z_n - Gλ a_n - G s                                                            (1)

its value and derivatives are, again without a division of small numbers,

    f(t)   = f_n + f'_n t + Re(Q φ2(λt)) t²                                               (2)
    f'(t)  = f'_n + Re(Q φ1(λt)) t,    f'_n = Re(Gλ z_n) - Re(G) a_n                      (3)
    f''(t) = Re(Q e^(λt))                                                                 (4)

The zeros of (4) are known in closed form; between two of them f' is monotonic and has at most one
zero, which is bracketed and found by bisection and Newton's method.
"""

import cmath
import math
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numba import njit

from impactfem.spectra.oscillator import FUSED, StepCoefficients, larger, next_state, phi
from impactfem.spectra.strides import strides_of
from impactfem.system.arrays import Array, Complex
from impactfem.system.errors import ImpactfemError

# Oscillators in one block: 13 rows of so many doubles stay in a first-level cache of 32 KiB.
_BLOCK = 256


def peak_responses(
    acceleration: Array, coefficients: StepCoefficients, *, threads: int = 1, absolute: bool = True
) -> tuple[Array, Array]:
    """Find the largest relative displacement and absolute acceleration of every oscillator.

    The peaks are those at the samples, and those of the free vibration after the last sample
    (the base stands still there), which are exact.

    Args:
        acceleration: Base accelerations, C-contiguous, finite, shape (n_r, n) [m/s2].
        coefficients: Of n_o oscillators at the records' time step.
        threads: Records are shared out to so many threads; the result does not depend on it.
        absolute: Whether the second peaks are found; nan without, in about a third of the time.

    Gives max |x|, shape (n_r, n_o) [m], and max |x'' + a|, shape (n_r, n_o) [m/s2].
    """
    if threads < 1:
        raise ImpactfemError(f"the number of threads must be at least 1, got {threads}")
    c = coefficients
    n_records = acceleration.shape[0]
    # The shifted state of a system at rest at the first sample, w = -feedthrough a.
    state = np.empty((2, n_records, c.omega.size))
    state[0] = -c.feedthrough.real * acceleration[:, :1]
    state[1] = -c.feedthrough.imag * acceleration[:, :1]
    peaks = np.zeros((2 if absolute else 1, n_records, c.omega.size))
    gain = c.acceleration_gain
    # Re and Im of the propagator, of the input gain and of the feedthrough; Re and -Im of the
    # acceleration gain G; Re(G feedthrough).
    parts = [of for z in (c.propagator, c.input_gain, c.feedthrough) for of in (z.real, z.imag)]
    rows = np.array([*parts, gain.real, -gain.imag, (gain * c.feedthrough).real])

    strides, others = ([], np.arange(c.omega.size)) if absolute else strides_of(c, rows[:6])
    kernel, own = both_kernel if absolute else displacement_kernel, np.take(rows, others, axis=1)

    def run(part: slice) -> None:
        # The kernels are fast on contiguous arrays only: a slice of the second axis is none.
        z, largest = (np.take(of[:, part], others, axis=2) for of in (state, peaks))
        kernel(acceleration[part], own, z, largest)
        state[:, part, others], peaks[:, part, others] = z, largest
        for one in strides:
            z, largest = (np.take(of[:, part], one.index, axis=2) for of in (state, peaks))
            for k, a in enumerate(acceleration[part]):
                z[:, k] = one.follow(a, z[:, k], largest[0, k])
            rest = np.ascontiguousarray(acceleration[part, one.end(acceleration.shape[1]) :])
            displacement_kernel(rest, one.rows, z, largest)
            state[:, part, one.index], peaks[:, part, one.index] = z, largest

    n_parts = min(threads, n_records)
    bounds = [n_records * k // n_parts for k in range(n_parts + 1)]
    records = [slice(i, j) for i, j in pairwise(bounds)]
    if n_parts == 1:
        run(records[0])
    else:
        with ThreadPoolExecutor(n_parts) as pool:
            list(pool.map(run, records))
    z = state[0] + 1j * state[1]
    free = free_vibration_peak(z, c.rate, (-1j / c.omega_d).astype(complex))
    sd = np.maximum(peaks[0] / c.omega_d, free)
    if not absolute:
        return sd, np.full_like(sd, np.nan)
    return sd, np.maximum(peaks[1], free_vibration_peak(z, c.rate, c.acceleration_gain))


def free_vibration_peak(z: Complex, rate: Complex, gain: Complex) -> Array:
    """Exact maximum of |Re(G z e^(λt))| at a stationary point t >= 0, in the unit of G z.

    The derivative Re(Gλ z e^(λt)) first vanishes when its phase reaches π/2 modulo π; later maxima
    are smaller or, without damping, equal. z are the states at t = 0, shape (..., n_o) [m/s], λ
    [1/s] and G have shape (n_o,), the result that of z.
    """
    phase = np.angle(gain * rate * z)
    t = np.mod(0.5 * np.pi - phase, np.pi) / rate.imag
    return np.asarray(np.abs((gain * z * np.exp(rate * t)).real))


@njit(nogil=True, cache=True, fastmath=FUSED)
def displacement_kernel(acceleration: Array, rows: Array, state: Array, peaks: Array) -> None:
    """Raise the peaks, shape (1, n_r, n_o), to max |Im z| at the samples of each record [m/s].

    `acceleration` has the shape (n_r, n) [m/s2], `rows`, as `peak_responses` lays them out, (6 or
    more, n_o). `state`, shape (2, n_r, n_o) [m/s], has Re and Im of the shifted state w at the
    first sample on entry, of the state z at the last one on return.
    """
    n_records, n = acceleration.shape
    for record in range(n_records):
        a = acceleration[record]
        for first in range(0, rows.shape[1], _BLOCK):
            block = slice(first, min(first + _BLOCK, rows.shape[1]))
            er, ei, br, bi = rows[0, block], rows[1, block], rows[2, block], rows[3, block]
            dr, di = rows[4, block], rows[5, block]
            wr, wi = state[0, record, block], state[1, record, block]
            peak = peaks[0, record, block]
            fours = (n - 1) // 4 * 4
            for i in range(0, fours, 4):
                a0, a1, a2, a3 = a[i], a[i + 1], a[i + 2], a[i + 3]
                for j in range(er.size):
                    r, s, p = wr[j], wi[j], peak[j]
                    p = larger(s + di[j] * a0, p)
                    r, s = next_state(r, s, er[j], ei[j], br[j], bi[j], a0)
                    p = larger(s + di[j] * a1, p)
                    r, s = next_state(r, s, er[j], ei[j], br[j], bi[j], a1)
                    p = larger(s + di[j] * a2, p)
                    r, s = next_state(r, s, er[j], ei[j], br[j], bi[j], a2)
                    p = larger(s + di[j] * a3, p)
                    r, s = next_state(r, s, er[j], ei[j], br[j], bi[j], a3)
                    wr[j], wi[j], peak[j] = r, s, p
            for i in range(fours, n - 1):
                for j in range(er.size):
                    peak[j] = larger(wi[j] + di[j] * a[i], peak[j])
                    wr[j], wi[j] = next_state(wr[j], wi[j], er[j], ei[j], br[j], bi[j], a[i])
            for j in range(er.size):
                wr[j] += dr[j] * a[n - 1]
                wi[j] += di[j] * a[n - 1]
                peak[j] = larger(wi[j], peak[j])


@njit(nogil=True, cache=True, fastmath=FUSED)
def both_kernel(acceleration: Array, rows: Array, state: Array, peaks: Array) -> None:
    """Raise the peaks, shape (2, n_r, n_o), to max |Im z| [m/s] and max |Re(G z)| [m/s2].

    As :func:`displacement_kernel`, with rows of the shape (9, n_o).
    """
    n_records, n = acceleration.shape
    for record in range(n_records):
        a = acceleration[record]
        for first in range(0, rows.shape[1], _BLOCK):
            block = slice(first, min(first + _BLOCK, rows.shape[1]))
            er, ei, br, bi = rows[0, block], rows[1, block], rows[2, block], rows[3, block]
            dr, di = rows[4, block], rows[5, block]
            gr, gi, ga = rows[6, block], rows[7, block], rows[8, block]
            wr, wi = state[0, record, block], state[1, record, block]
            peak_x, peak_a = peaks[0, record, block], peaks[1, record, block]
            twos = (n - 1) // 2 * 2
            for i in range(0, twos, 2):
                a0, a1 = a[i], a[i + 1]
                for j in range(er.size):
                    r, s, p, q = wr[j], wi[j], peak_x[j], peak_a[j]
                    p = larger(s + di[j] * a0, p)
                    q = larger(gr[j] * r + (gi[j] * s + ga[j] * a0), q)
                    r, s = next_state(r, s, er[j], ei[j], br[j], bi[j], a0)
                    p = larger(s + di[j] * a1, p)
                    q = larger(gr[j] * r + (gi[j] * s + ga[j] * a1), q)
                    r, s = next_state(r, s, er[j], ei[j], br[j], bi[j], a1)
                    wr[j], wi[j], peak_x[j], peak_a[j] = r, s, p, q
            for i in range(twos, n - 1):
                for j in range(er.size):
                    peak_x[j] = larger(wi[j] + di[j] * a[i], peak_x[j])
                    peak_a[j] = larger(gr[j] * wr[j] + (gi[j] * wi[j] + ga[j] * a[i]), peak_a[j])
                    wr[j], wi[j] = next_state(wr[j], wi[j], er[j], ei[j], br[j], bi[j], a[i])
            for j in range(er.size):
                wr[j] += dr[j] * a[n - 1]
                wi[j] += di[j] * a[n - 1]
                peak_x[j] = larger(wi[j], peak_x[j])
                peak_a[j] = larger(gr[j] * wr[j] + gi[j] * wi[j], peak_a[j])


def in_step_peak_responses(
    acceleration: Array, coefficients: StepCoefficients
) -> tuple[Array, Array]:
    """Peaks of relative displacement and absolute acceleration, between the samples as well.

    Exact for an input that is linear between its samples, over the steps and in the free vibration
    after the last sample. Arguments and result as of :func:`peak_responses`.
    """
    c = coefficients
    gains = np.array([-1j / c.omega_d, c.acceleration_gain])
    peaks = np.zeros((2, len(acceleration), c.omega.size))
    end = np.empty(peaks.shape[1:], dtype=np.complex128)
    step = Step(c.time_step, c.rate, c.propagator, c.input_gain, c.feedthrough)
    _in_step_kernel(acceleration, step, gains, peaks, end)
    sd, sa = np.maximum(peaks, [free_vibration_peak(end, c.rate, gain) for gain in gains])
    return sd, sa


class Step(NamedTuple):
    """Coefficients of one step of the oscillators."""

    time_step: float
    rate: Complex
    propagator: Complex
    input_gain: Complex
    feedthrough: Complex


@njit(nogil=True, cache=True)
def _in_step_kernel(
    acceleration: Array, step: Step, gains: Complex, peaks: Array, end: Complex
) -> None:
    h, rate, propagator, input_gain, feedthrough = step
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
    q = gain * (rate * (rate * z - a) - (a_next - a) / h)  # (1)
    # A function leaves its chord by h²/8 max |f''| at most: most steps cannot hold the peak.
    if ends + 0.125 * h * h * abs(q) <= peak:
        return peak
    peak = max(peak, ends)
    slope = (gain * rate * z).real - gain.real * a
    left, slope_left = 0.0, slope
    # From zero to zero of (4): between two of them (3) is monotonic.
    turn = ((0.5 * math.pi - cmath.phase(q)) % math.pi) / rate.imag
    while left < h:
        right = turn if left < turn < h else h
        slope_right = slope + (q * phi(rate * right, 1)).real * right
        if (slope_left < 0.0) != (slope_right < 0.0):
            # The zero of (3) in this bracket: Newton's method, bisection where it leaves it.
            begin, end = left, right
            t = 0.5 * (begin + end)
            for _ in range(60):
                value = slope + (q * phi(rate * t, 1)).real * t
                if (value < 0.0) == (slope_left < 0.0):
                    begin = t
                else:
                    end = t
                curvature = (q * cmath.exp(rate * t)).real
                t_next = t - value / curvature if curvature != 0.0 else begin
                if not begin < t_next < end:
                    t_next = 0.5 * (begin + end)
                # At a stationary point an error in time enters the value squared.
                close = abs(t_next - t) <= 1e-9 * end
                t = t_next
                if close:
                    break
            peak = max(peak, abs(f + slope * t + (q * phi(rate * t, 2)).real * t * t))
        left, slope_left = right, slope_right
        turn += math.pi / rate.imag
    return peak
