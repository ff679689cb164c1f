"""Oscillators on a moving base: SDLL06, and exactness on piecewise-linear input."""

from __future__ import annotations

import numpy as np

from impactfem.spectra import oscillator_response, response_spectra
from impactfem.verify.row import Row


def triangular_pulse() -> list[Row]:
    """SDLL06: ω = 30 rad/s, undamped; base acceleration 0, 9.81 m/s² at 25 ms, 0 at 50 ms.

    The steps are exact: allowed is a unit of the last digit that is printed, of seven or eight.
    """
    dt = 0.0025
    time = dt * np.arange(41)
    pulse = np.interp(time, [0.0, 0.025, 0.05, 0.1], [0.0, 9.81, 0.0, 0.0])
    response = oscillator_response(pulse, dt, [30.0 / (2.0 * np.pi)], [0.0])
    x = response.relative_displacement[0, 0]
    published = (
        (0.01, -6.510633e-5, 2e-7),
        (0.02, -5.138627e-4, 2e-7),
        (0.03, -1.6793173e-3, 6e-8),
        (0.04, -3.4573635e-3, 6e-8),
        (0.06, -6.7649559e-3, 6e-8),
    )
    return [
        Row(
            "SDLL06 triangular pulse",
            f"relative displacement at {t} s",
            reference,
            float(x[round(t / dt)]),
            "m",
            digit,
            "code_aster validation manual V2.01.006 (SDLL06)",
        )
        for t, reference, digit in published
    ]


def piecewise_linear() -> list[Row]:
    """Histories on random piecewise-linear input against a sum of closed-form ramps.

    A unit ramp of base acceleration from rest moves the oscillator by
    -R(t) = -(t - 2ξ/ω + exp(-ξωt) (2ξ/ω cos ω_D t + (2ξ² - 1)/ω_D sin ω_D t)) / ω²; a piecewise
    linear input is a sum of ramps. The sum is taken in extended precision.
    """
    rng = np.random.default_rng(3)
    dt, n = 0.005, 400
    a = rng.standard_normal(n)
    a[0] = 0.0
    slopes = np.diff(a, prepend=0.0)[1:] / dt
    changes = np.diff(slopes, prepend=0.0).astype(np.longdouble)
    starts = dt * np.arange(n - 1, dtype=np.longdouble)
    time = dt * np.arange(n, dtype=np.longdouble)
    rows = []
    for frequency in (0.2, 5.0, 90.0, 450.0):
        for xi in (0.0, 0.05, 0.3):
            omega = np.longdouble(2.0) * np.pi * frequency
            omega_d = omega * np.sqrt(np.longdouble(1.0) - np.longdouble(xi) ** 2)
            t = np.maximum(time[:, None] - starts, 0.0)
            ramp = (
                t
                - 2.0 * xi / omega
                + np.exp(-xi * omega * t)
                * (
                    2.0 * xi / omega * np.cos(omega_d * t)
                    + (2.0 * xi**2 - 1.0) / omega_d * np.sin(omega_d * t)
                )
            ) / omega**2
            exact = -(ramp @ changes)
            x = oscillator_response(a, dt, [frequency], [xi]).relative_displacement[0, 0]
            error = float(np.max(np.abs(x - exact)) / np.max(np.abs(exact)))
            rows.append(
                Row(
                    "oscillator on piecewise-linear input",
                    f"largest error at {frequency:g} Hz, ξ = {xi:g}",
                    0.0,
                    error,
                    "-",
                    1e-10,
                    "closed form of the ramp response (Nigam and Jennings 1969)",
                    absolute=True,
                )
            )
    pulse = np.interp(0.0025 * np.arange(41), [0.0, 0.025, 0.05, 0.1], [0.0, 9.81, 0.0, 0.0])
    spectra = response_spectra(pulse, 0.0025, [30.0 / (2.0 * np.pi)], [0.0], method="in-step")
    amplitude = 9.81 / (30.0**3 * 0.025) * 2.0 * (1.0 - np.cos(30.0 * 0.025))
    rows.append(
        Row(
            "SDLL06 triangular pulse",
            "largest relative displacement, after the end of the record",
            float(amplitude),
            float(spectra.sd[0, 0, 0]),
            "m",
            1e-10,
            "free vibration after a symmetric triangle, closed form",
        )
    )
    return rows
