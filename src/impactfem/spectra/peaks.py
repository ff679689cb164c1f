"""Peaks of oscillators at the samples of many records: the fast kernel.

The loop over samples is outside and the loop over oscillators inside, over contiguous memory, so
that the compiler puts four or eight oscillators into one vector register. Four samples are taken
in one pass to spare loads and stores of the state, and the shifted state of equation (4) of
:mod:`impactfem.spectra.recurrence` needs one input a sample. What that gains over a plain scalar
loop is printed by ``impactfem bench``.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
from numba import njit

from impactfem.spectra.recurrence import ComplexArray, FloatArray, StepCoefficients
from impactfem.system.errors import ImpactfemError

# Oscillators in one block: 13 rows of so many doubles stay in a first-level cache of 32 KiB.
_BLOCK = 256

# Allow fused multiply-add and nothing else of "fast math": NaN and infinity keep their meaning.
_FUSED = {"contract"}


def peak_responses(
    acceleration: FloatArray, coefficients: StepCoefficients, *, threads: int = 1
) -> tuple[FloatArray, FloatArray]:
    """Find the largest relative displacement and absolute acceleration of every oscillator.

    The peaks are those at the samples, and those of the free vibration after the last sample
    (the base stands still there), which are exact.

    Args:
        acceleration: Base accelerations, C-contiguous, finite, shape (n_r, n) [m/s2].
        coefficients: Of n_o oscillators at the records' time step.
        threads: Records are shared out to so many threads; the result does not depend on it.

    Returns:
        max |x|, shape (n_r, n_o) [m], and max |x'' + a|, shape (n_r, n_o) [m/s2].

    Raises:
        ImpactfemError: The number of threads is below 1.
    """
    c = coefficients
    peaks, z = _run(both_kernel, 2, acceleration, c, threads)
    sd = np.maximum(
        peaks[0] / c.omega_d, free_vibration_peak(z, c.rate, (-1j / c.omega_d).astype(complex))
    )
    return sd, np.maximum(peaks[1], free_vibration_peak(z, c.rate, c.acceleration_gain))


def displacement_peaks(
    acceleration: FloatArray, coefficients: StepCoefficients, *, threads: int = 1
) -> FloatArray:
    """Find the largest relative displacement only, in about two thirds of the time.

    Args:
        acceleration: As in :func:`peak_responses`, shape (n_r, n) [m/s2].
        coefficients: Of n_o oscillators at the records' time step.
        threads: Records are shared out to so many threads.

    Returns:
        max |x|, shape (n_r, n_o) [m].

    Raises:
        ImpactfemError: The number of threads is below 1.
    """
    c = coefficients
    peaks, z = _run(displacement_kernel, 1, acceleration, c, threads)
    free = free_vibration_peak(z, c.rate, (-1j / c.omega_d).astype(complex))
    return np.asarray(np.maximum(peaks[0] / c.omega_d, free))


def _run(
    kernel: Callable[[FloatArray, FloatArray, FloatArray, FloatArray], None],
    outputs: int,
    acceleration: FloatArray,
    coefficients: StepCoefficients,
    threads: int,
) -> tuple[FloatArray, ComplexArray]:
    """Run a kernel on all records; return its peaks and the states at the last sample."""
    if threads < 1:
        raise ImpactfemError(f"the number of threads must be at least 1, got {threads}")
    c = coefficients
    n_records = acceleration.shape[0]
    state = np.empty((2, n_records, c.omega.size))
    state[0] = -c.feedthrough.real * acceleration[:, :1]
    state[1] = -c.feedthrough.imag * acceleration[:, :1]
    peaks = np.zeros((outputs, n_records, c.omega.size))
    rows = coefficient_rows(c)

    def run(part: slice) -> None:
        # The kernels are fast on contiguous arrays only: a slice of the second axis is none.
        mine, found = np.ascontiguousarray(state[:, part]), np.zeros_like(peaks[:, part], order="C")
        kernel(acceleration[part], rows, mine, found)
        state[:, part], peaks[:, part] = mine, found

    n_parts = min(threads, n_records)
    bounds = [n_records * k // n_parts for k in range(n_parts + 1)]
    parts = [slice(i, j) for i, j in pairwise(bounds)]
    if n_parts == 1:
        run(parts[0])
    else:
        with ThreadPoolExecutor(n_parts) as pool:
            list(pool.map(run, parts))
    return peaks, state[0] + 1j * state[1]


def coefficient_rows(coefficients: StepCoefficients) -> FloatArray:
    """Lay the coefficients out as the kernels want them.

    Args:
        coefficients: Of n_o oscillators.

    Returns:
        Rows Re and Im of the propagator, of the input gain and of the feedthrough, then Re and
        -Im of the acceleration gain G, then Re(G feedthrough), shape (9, n_o).
    """
    c = coefficients
    gain = c.acceleration_gain
    return np.array(
        [
            c.propagator.real,
            c.propagator.imag,
            c.input_gain.real,
            c.input_gain.imag,
            c.feedthrough.real,
            c.feedthrough.imag,
            gain.real,
            -gain.imag,
            (gain * c.feedthrough).real,
        ]
    )


def free_vibration_peak(z: ComplexArray, rate: ComplexArray, gain: ComplexArray) -> FloatArray:
    """Find the exact maximum of |Re(G z e^(λt))| at a stationary point t >= 0.

    The derivative Re(Gλ z e^(λt)) first vanishes when its phase reaches π/2 modulo π; later
    maxima are smaller or, without damping, equal.

    Args:
        z: States at t = 0, shape (..., n_o) [m/s].
        rate: λ, shape (n_o,) [1/s].
        gain: G, shape (n_o,).

    Returns:
        Shape (..., n_o), in the unit of G z.
    """
    phase = np.angle(gain * rate * z)
    t = np.mod(0.5 * np.pi - phase, np.pi) / rate.imag
    return np.asarray(np.abs((gain * z * np.exp(rate * t)).real))


@njit(nogil=True, cache=True, fastmath=_FUSED)
def displacement_kernel(
    acceleration: FloatArray, rows: FloatArray, state: FloatArray, peaks: FloatArray
) -> None:
    """Find max |Im z| at the samples of each record.

    Args:
        acceleration: Shape (n_r, n) [m/s2].
        rows: Of :func:`coefficient_rows`, shape (9, n_o).
        state: Re and Im of the shifted state w at the first sample on entry, of the state z at
            the last sample on return, shape (2, n_r, n_o) [m/s].
        peaks: Raised to max |Im z|, shape (1, n_r, n_o) [m/s].
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
                    p = _larger(s + di[j] * a0, p)
                    r, s = _step(r, s, er[j], ei[j], br[j], bi[j], a0)
                    p = _larger(s + di[j] * a1, p)
                    r, s = _step(r, s, er[j], ei[j], br[j], bi[j], a1)
                    p = _larger(s + di[j] * a2, p)
                    r, s = _step(r, s, er[j], ei[j], br[j], bi[j], a2)
                    p = _larger(s + di[j] * a3, p)
                    r, s = _step(r, s, er[j], ei[j], br[j], bi[j], a3)
                    wr[j], wi[j], peak[j] = r, s, p
            for i in range(fours, n - 1):
                for j in range(er.size):
                    peak[j] = _larger(wi[j] + di[j] * a[i], peak[j])
                    wr[j], wi[j] = _step(wr[j], wi[j], er[j], ei[j], br[j], bi[j], a[i])
            for j in range(er.size):
                wr[j] += dr[j] * a[n - 1]
                wi[j] += di[j] * a[n - 1]
                peak[j] = _larger(wi[j], peak[j])


@njit(nogil=True, cache=True, fastmath=_FUSED)
def both_kernel(
    acceleration: FloatArray, rows: FloatArray, state: FloatArray, peaks: FloatArray
) -> None:
    """Find max |Im z| and max |Re(G z)| at the samples of each record.

    Args:
        acceleration: Shape (n_r, n) [m/s2].
        rows: Of :func:`coefficient_rows`, shape (9, n_o).
        state: As in :func:`displacement_kernel`, shape (2, n_r, n_o) [m/s].
        peaks: Raised to max |Im z| [m/s] and max |Re(G z)| [m/s2], shape (2, n_r, n_o).
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
                    p = _larger(s + di[j] * a0, p)
                    q = _larger(gr[j] * r + (gi[j] * s + ga[j] * a0), q)
                    r, s = _step(r, s, er[j], ei[j], br[j], bi[j], a0)
                    p = _larger(s + di[j] * a1, p)
                    q = _larger(gr[j] * r + (gi[j] * s + ga[j] * a1), q)
                    r, s = _step(r, s, er[j], ei[j], br[j], bi[j], a1)
                    wr[j], wi[j], peak_x[j], peak_a[j] = r, s, p, q
            for i in range(twos, n - 1):
                for j in range(er.size):
                    peak_x[j] = _larger(wi[j] + di[j] * a[i], peak_x[j])
                    peak_a[j] = _larger(gr[j] * wr[j] + (gi[j] * wi[j] + ga[j] * a[i]), peak_a[j])
                    wr[j], wi[j] = _step(wr[j], wi[j], er[j], ei[j], br[j], bi[j], a[i])
            for j in range(er.size):
                wr[j] += dr[j] * a[n - 1]
                wi[j] += di[j] * a[n - 1]
                peak_x[j] = _larger(wi[j], peak_x[j])
                peak_a[j] = _larger(gr[j] * wr[j] + gi[j] * wi[j], peak_a[j])


@njit(nogil=True, cache=True, fastmath=_FUSED, inline="always")
def _step(
    r: float, s: float, er: float, ei: float, br: float, bi: float, a: float
) -> tuple[float, float]:
    return er * r - (ei * s - br * a), ei * r + (er * s + bi * a)


@njit(nogil=True, cache=True, fastmath=_FUSED, inline="always")
def _larger(value: float, peak: float) -> float:
    size = abs(value)
    return size if size > peak else peak
