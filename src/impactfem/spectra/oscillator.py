"""Oscillators under a base acceleration that is linear in each step: one exact step, histories.

The relative displacement x of an oscillator (circular frequency ω, damping ratio ξ) obeys

    x'' + 2 ξ ω x' + ω² x = -a(t)                                                       (1)

With λ = -ξω + iω_d, ω_d = ω √(1-ξ²), the complex state z = x' - λ* x turns (1) into a single
first-order equation, and gives back both unknowns without a division of small numbers:

    z' = λ z - a(t),    x = Im z / ω_d,    x' = Re z - (ξω / ω_d) Im z                    (2)

For a(t) linear between a_n and a_n+1 = a(t_n + h), with φ1(y) = (e^y - 1) / y and
φ2(y) = (e^y - 1 - y) / y² at y = λh,

    z_n+1 = e^y z_n - h (φ1 - φ2) a_n - h φ2 a_n+1                                        (3)

The shifted state w_n = z_n + h φ2 a_n needs one sample a step only, because
φ1 - φ2 + e^y φ2 = φ1² (a ramp-invariant filter is a box filter applied twice):

    w_n+1 = e^y w_n - h φ1² a_n                                                           (4)

This is the recurrence of Nigam and Jennings (1969), Bull. Seism. Soc. Am. 59(2), 909-922, in a
coupled complex form. The form matters: the two-term recurrence in x alone loses a factor
1/(ωh)² of accuracy, this one loses nothing as ωh → 0.
"""

import cmath
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numba import njit

from impactfem.system.arrays import Array, Complex
from impactfem.system.errors import ImpactfemError

# Allow fused multiply-add and nothing else of "fast math": NaN and infinity keep their meaning.
FUSED = {"contract"}
_SERIES_RADIUS = 1.0
_SERIES_TERMS = 20  # 1 / 21! is below the round-off of the sum for |y| <= 1


@dataclass(frozen=True)
class StepCoefficients:
    """The coefficients of equations (2) to (4), one entry an oscillator."""

    omega: Array  #: circular frequency ω, shape (n,) [rad/s]
    xi: Array  #: damping ratio ξ, shape (n,) [-]
    omega_d: Array  #: damped circular frequency ω_d, shape (n,) [rad/s]
    time_step: float  #: step h [s]
    rate: Complex  #: λ, shape (n,) [1/s]
    propagator: Complex  #: e^(λh), shape (n,) [-]
    input_gain: Complex  #: -h φ1², what a sample adds to the shifted state, shape (n,) [s]
    feedthrough: Complex  #: -h φ2, so that z_n = w_n + feedthrough a_n, shape (n,) [s]

    @property
    def acceleration_gain(self) -> Complex:
        """G with absolute acceleration x'' + a = Re(G z), shape (n,) [1/s]."""
        # From (1), x'' + a = -2ξω x' - ω² x; by (2) it is -2ξω Re z - ω² (1 - 2ξ²) / ω_d Im z.
        real = -2.0 * self.xi * self.omega
        imag = self.omega**2 * (1.0 - 2.0 * self.xi**2) / self.omega_d
        return np.asarray(real + 1j * imag, dtype=np.complex128)


def step_coefficients(
    time_step: float, frequencies: npt.ArrayLike, dampings: npt.ArrayLike
) -> StepCoefficients:
    """Compute the exact step of one oscillator for each pair of frequency and damping.

    Args:
        time_step: Step h [s], positive.
        frequencies: Undamped natural frequencies, shape (n_f,) [Hz], positive. There is no upper
            limit: (3) is exact above the Nyquist frequency of the input, too.
        dampings: Damping ratios, shape (n_d,) [-], 0 <= ξ < 1.

    Gives coefficients with the dampings outside and the frequencies inside, n = n_d n_f.
    ImpactfemError where one is out of its range or not finite; critical and overcritical damping
    are refused: (2) needs ω_d > 0.
    """
    h = float(time_step)
    f = np.atleast_1d(np.asarray(frequencies, dtype=np.float64))
    d = np.atleast_1d(np.asarray(dampings, dtype=np.float64))
    if not (np.isfinite(h) and h > 0.0):
        raise ImpactfemError(f"the time step must be positive and finite, got {h!r} s")
    if f.ndim != 1 or f.size == 0 or not np.all(np.isfinite(f) & (f > 0.0)):
        raise ImpactfemError("frequencies must be a list of positive finite numbers in Hz")
    if d.ndim != 1 or d.size == 0 or not np.all((d >= 0.0) & (d < 1.0)):
        raise ImpactfemError(
            "damping ratios must be a list of numbers with 0 <= ratio < 1 (5 % is 0.05);"
            " critically and over-damped oscillators have no response spectrum here"
        )
    omega = np.tile(2.0 * np.pi * f, d.size)
    xi = np.repeat(d, f.size)
    omega_d = omega * np.sqrt((1.0 - xi) * (1.0 + xi))
    rate = -xi * omega + 1j * omega_d
    y = rate * h
    phi1 = np.array([phi(one, 1) for one in y], dtype=np.complex128)
    phi2 = np.array([phi(one, 2) for one in y], dtype=np.complex128)
    return StepCoefficients(
        omega=omega,
        xi=xi,
        omega_d=omega_d,
        time_step=h,
        rate=rate,
        propagator=np.exp(y),
        input_gain=np.asarray(-h * phi1**2, dtype=np.complex128),
        feedthrough=np.asarray(-h * phi2, dtype=np.complex128),
    )


@njit(nogil=True, cache=True)
def phi(y: complex, order: int) -> complex:
    """φ1(y) = (e^y - 1)/y or φ2(y) = (e^y - 1 - y)/y², Re y <= 0, without cancellation.

    The Taylor series Σ y^k/(k+1)! or Σ y^k/(k+2)! inside the unit circle (real and imaginary part
    are then accurate each on its own, which the division by ω_d in (2) needs), the closed form
    outside.
    """
    if abs(y) <= _SERIES_RADIUS:
        value = 0.0j
        for k in range(_SERIES_TERMS - 1, -1, -1):
            value = 1.0 + y * value / (k + order + 1)
        return value / order  # leading terms 1/1! and 1/2!
    phi1 = (cmath.exp(y) - 1.0) / y
    return phi1 if order == 1 else (phi1 - 1.0) / y


@njit(nogil=True, cache=True, fastmath=FUSED, inline="always")
def next_state(
    r: float, s: float, er: float, ei: float, br: float, bi: float, a: float
) -> tuple[float, float]:
    """Re and Im of the shifted state by (4), from r and s, propagator, input gain and sample."""
    return er * r - (ei * s - br * a), ei * r + (er * s + bi * a)


@njit(nogil=True, cache=True, fastmath=FUSED, inline="always")
def larger(value: float, peak: float) -> float:
    """A peak raised to |value|."""
    size = abs(value)
    return size if size > peak else peak


@dataclass(frozen=True)
class OscillatorResponse:
    """Histories of oscillators at the samples of the record, at rest before its first sample."""

    time: Array  #: shape (n,) [s], from 0
    frequency: Array  #: shape (n_f,) [Hz]
    damping: Array  #: shape (n_d,) [-]
    relative_displacement: Array  #: x, shape (n_d, n_f, n) [m]
    relative_velocity: Array  #: x', shape (n_d, n_f, n) [m/s]
    absolute_acceleration: Array  #: x'' + a, shape (n_d, n_f, n) [m/s2]


def oscillator_response(
    acceleration: npt.ArrayLike,
    time_step: float,
    frequencies: npt.ArrayLike,
    dampings: npt.ArrayLike,
) -> OscillatorResponse:
    """Compute the histories of oscillators under one base acceleration, linear between samples.

    Exact for that input at the samples, whatever the ratio of step and period (equations (2) and
    (4) of :mod:`impactfem.spectra.oscillator`); nothing is resampled here.

    Args:
        acceleration: Base acceleration, finite, shape (n,) [m/s2].
        time_step: Step of the record [s].
        frequencies: Natural frequencies, shape (n_f,) [Hz].
        dampings: Damping ratios, shape (n_d,) [-], 0 <= ratio < 1.
    """
    a = np.asarray(acceleration, dtype=np.float64)
    if a.ndim != 1 or a.size == 0 or not np.all(np.isfinite(a)):
        raise ImpactfemError("the base acceleration must be one record of finite numbers")
    c = step_coefficients(time_step, frequencies, dampings)
    f = np.atleast_1d(np.asarray(frequencies, dtype=np.float64))
    d = np.atleast_1d(np.asarray(dampings, dtype=np.float64))
    z = _states(np.ascontiguousarray(a), c.propagator, c.input_gain, c.feedthrough)
    # (2) solved for x and x', and the absolute acceleration as Re(G z).
    x = z.imag / c.omega_d[:, None]
    v = z.real - (c.xi * c.omega)[:, None] * x
    gain = c.acceleration_gain[:, None]
    absolute = gain.real * z.real - gain.imag * z.imag
    shape = (d.size, f.size, a.size)
    time = np.arange(a.size) * float(time_step)
    return OscillatorResponse(time, f, d, *(one.reshape(shape) for one in (x, v, absolute)))


@njit(nogil=True, cache=True)
def _states(a: Array, propagator: Complex, gain: Complex, feedthrough: Complex) -> Complex:
    z = np.empty((propagator.size, a.size), dtype=np.complex128)
    for o in range(propagator.size):
        w = -feedthrough[o] * a[0]
        z[o, 0] = 0.0
        for n in range(1, a.size):
            w = propagator[o] * w + gain[o] * a[n - 1]
            z[o, n] = w + feedthrough[o] * a[n]
    return z
