"""Full response histories of oscillators on a moving base: for verification and for plots."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numba import njit

from impactfem.spectra.recurrence import (
    ComplexArray,
    FloatArray,
    StepCoefficients,
    step_coefficients,
)
from impactfem.system.errors import ImpactfemError


@dataclass(frozen=True)
class OscillatorResponse:
    """Histories of oscillators at the samples of the record, at rest before its first sample.

    Args:
        time: Shape (n,) [s], from 0.
        frequency: Shape (n_f,) [Hz].
        damping: Shape (n_d,) [-].
        relative_displacement: x, shape (n_d, n_f, n) [m].
        relative_velocity: x', shape (n_d, n_f, n) [m/s].
        absolute_acceleration: x'' + a, shape (n_d, n_f, n) [m/s2].
    """

    time: FloatArray
    frequency: FloatArray
    damping: FloatArray
    relative_displacement: FloatArray
    relative_velocity: FloatArray
    absolute_acceleration: FloatArray


def oscillator_response(
    acceleration: npt.ArrayLike,
    time_step: float,
    frequencies: npt.ArrayLike,
    dampings: npt.ArrayLike,
) -> OscillatorResponse:
    """Compute the histories of oscillators under one base acceleration, linear between samples.

    Exact for that input at the samples, whatever the ratio of step and period (equations (2) and
    (4) of :mod:`impactfem.spectra.recurrence`); nothing is resampled here.

    Args:
        acceleration: Base acceleration, shape (n,) [m/s2].
        time_step: Step of the record [s].
        frequencies: Natural frequencies, shape (n_f,) [Hz].
        dampings: Damping ratios, shape (n_d,) [-], 0 <= ratio < 1.

    Returns:
        The histories.

    Raises:
        ImpactfemError: The record is empty or not finite, or a parameter is out of range.
    """
    a = np.asarray(acceleration, dtype=np.float64)
    if a.ndim != 1 or a.size == 0 or not np.all(np.isfinite(a)):
        raise ImpactfemError("the base acceleration must be one record of finite numbers")
    c = step_coefficients(time_step, frequencies, dampings)
    f = np.atleast_1d(np.asarray(frequencies, dtype=np.float64))
    d = np.atleast_1d(np.asarray(dampings, dtype=np.float64))
    z = states(np.ascontiguousarray(a), c)
    x = z.imag / c.omega_d[:, None]
    v = z.real - (c.xi * c.omega)[:, None] * x
    gain = c.acceleration_gain[:, None]
    absolute = gain.real * z.real - gain.imag * z.imag
    shape = (d.size, f.size, a.size)
    return OscillatorResponse(
        time=np.asarray(np.arange(a.size) * float(time_step), dtype=np.float64),
        frequency=f,
        damping=d,
        relative_displacement=x.reshape(shape),
        relative_velocity=v.reshape(shape),
        absolute_acceleration=absolute.reshape(shape),
    )


def states(acceleration: FloatArray, coefficients: StepCoefficients) -> ComplexArray:
    """Compute the complex states z of equation (2) at every sample.

    Args:
        acceleration: Base acceleration, shape (n,) [m/s2].
        coefficients: Of n_o oscillators.

    Returns:
        Shape (n_o, n) [m/s].
    """
    c = coefficients
    history: ComplexArray = _states(acceleration, c.propagator, c.input_gain, c.feedthrough)
    return history


@njit(nogil=True, cache=True)
def _states(
    a: FloatArray, propagator: ComplexArray, gain: ComplexArray, feedthrough: ComplexArray
) -> ComplexArray:
    z = np.empty((propagator.size, a.size), dtype=np.complex128)
    for o in range(propagator.size):
        w = -feedthrough[o] * a[0]
        z[o, 0] = 0.0
        for n in range(1, a.size):
            w = propagator[o] * w + gain[o] * a[n - 1]
            z[o, n] = w + feedthrough[o] * a[n]
    return z
