"""Spectra as tables give them and as designers need them: lists, interpolation, broadening."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from impactfem.spectra import (
    broaden,
    clip_peaks,
    corner_frequencies,
    interpolate_damping,
    interpolate_frequency,
    response_spectra,
    rg_1_122_frequencies,
)
from impactfem.verify.row import Row

FloatArray = npt.NDArray[np.float64]

SDLD25_FREQUENCY = (1.0, 3.0, 13.0, 33.0)  # Hz
SDLD25_SPECTRA = {0.005: (1.0, 25.0, 25.0, 1.0), 0.05: (1.0, 10.0, 10.0, 1.0)}  # m/s2 by damping
SDLD25_SOURCE = "code_aster validation manual V2.01.025 (SDLD25)"

Broadened = tuple[str, FloatArray, FloatArray, float | tuple[float, float], float, float]
"""What is asked; frequencies [Hz] and ordinates [m/s2] of a spectrum; the ratio of broadening; a
frequency [Hz] and the ordinate there by hand [m/s2]."""
ONE_PEAK = np.array([[1.0, 5.0, 10.0, 20.0, 100.0], [1.0, 1.0, 9.0, 1.0, 1.0]])
"""9 m/s2 at 10 Hz on 1 m/s2: from 5 Hz up by f^(ln 9/ln 2), to 20 Hz down alike."""


def frequency_list() -> list[Row]:
    """The list of Regulatory Guide 1.122: its length, its ends, and where its increments change."""
    listed = rg_1_122_frequencies()
    source = "US NRC Regulatory Guide 1.122, revision 1 (1978), table 1"
    name = "frequencies of RG 1.122"
    changes = (3.0, 3.6, 5.0, 8.0, 15.0, 18.0, 22.0)
    missing = float(np.sum(~np.isin(changes, listed)))
    continued = rg_1_122_frequencies(500.0, 100)
    return [
        Row(name, "number", 75.0, float(listed.size), "-", 0.0, source),
        Row(name, "first", 0.2, float(listed[0]), "Hz", 1e-12, source),
        Row(name, "last", 34.0, float(listed[-1]), "Hz", 0.0, source),
        # The sum of arithmetic series: n (first + last) / 2 of each range, by hand.
        Row(name, "sum of all", 545.7, float(listed.sum()), "Hz", 1e-12, source),
        Row(name, "ends of ranges missing", 0.0, missing, "-", 0.0, source, absolute=True),
        Row(name, "last, continued for impacts", 500.0, float(continued[-1]), "Hz", 0.0, source),
    ]


def pulse_spectrum() -> list[Row]:
    """SDLL06's triangular pulse: largest displacements of undamped oscillators in closed form.

    A pulse that rises to A in t1 and falls to zero in another t1 leaves an oscillator with the
    amplitude 2 A (1 - cos ωt1) / (ω³ t1). In the falling half, with θ = ωt,

        x = -A/(ω² t1) (t - sin θ/ω - 2 (t - t1) + 2 sin(θ - ωt1)/ω)

    is stationary where (2 cos ωt1 - 1) cos θ + 2 sin ωt1 sin θ = 1; in the rising half it is
    monotonic.
    """
    amplitude, t1, dt = 9.81, 0.025, 0.0025
    pulse = np.interp(dt * np.arange(41), [0.0, t1, 2.0 * t1], [0.0, amplitude, 0.0])
    frequencies = (30.0 / (2.0 * np.pi), 12.0, 25.0, 35.0, 60.0, 150.0)
    spectra = response_spectra(pulse, dt, frequencies, [0.0], method="in-step")
    rows = []
    for k, frequency in enumerate(frequencies):
        omega = 2.0 * np.pi * frequency
        after = 2.0 * amplitude * (1.0 - np.cos(omega * t1)) / (omega**3 * t1)
        a, b = 2.0 * np.cos(omega * t1) - 1.0, 2.0 * np.sin(omega * t1)
        turns = 2.0 * np.pi * np.arange(np.ceil(2.0 * omega * t1 / (2.0 * np.pi)) + 1.0)
        half = np.arccos(np.clip(1.0 / np.hypot(a, b), -1.0, 1.0))
        theta = np.add.outer(np.arctan2(b, a) + np.array([-half, half]), turns).ravel()
        theta = theta[(theta > omega * t1) & (theta < 2.0 * omega * t1)]
        t = np.append(theta / omega, [t1, 2.0 * t1])
        x = (
            amplitude
            / (omega**2 * t1)
            * (
                t
                - np.sin(omega * t) / omega
                - 2.0 * (t - t1)
                + 2.0 * np.sin(omega * (t - t1)) / omega
            )
        )
        rows.append(
            Row(
                "SDLL06 response spectrum",
                f"largest relative displacement at {frequency:.4g} Hz, undamped",
                float(max(after, np.max(np.abs(x)))),
                float(spectra.sd[0, 0, k]),
                "m",
                1e-10,
                "closed form for the pulse of code_aster's V2.01.006 (SDLL06)",
            )
        )
    return rows


def broadening() -> list[Row]:
    """Hand-made spectra broadened by ±15 %: one peak, two peaks, a plateau, and one-sided.

    Sides of straight lines on doubly logarithmic axes keep their slope and move by the factors
    0.85 and 1.15, which gives every ordinate by hand.
    """
    source = "by hand; construction of US NRC Regulatory Guide 1.122, revision 1 (1978), figure 1"
    rows = [
        Row(
            "peak broadening",
            f"{label}, at {at:g} Hz",
            reference,
            float(broaden(frequency, ordinates, ratio, [at])[0]),
            "m/s2",
            1e-12,
            source,
        )
        for label, frequency, ordinates, ratio, at, reference in _broadened_by_hand()
    ]
    f, peak = ONE_PEAK
    listed = corner_frequencies(f, [(f, peak)])
    fine = np.geomspace(1.0, 100.0, 2001)
    straight = interpolate_frequency(listed, broaden(f, peak, 0.15, listed), fine)
    loss = float(np.max(1.0 - straight / broaden(f, peak, 0.15, fine)))
    rows.append(
        Row(
            "peak broadening",
            "largest loss of straight lines between the design frequencies",
            0.0,
            max(loss, 0.0),
            "-",
            1e-12,
            "definition of the design frequencies",
            absolute=True,
        )
    )
    return rows


def _broadened_by_hand() -> list[Broadened]:
    """Ordinates of one peak, of two peaks and of a plateau."""
    f, peak = ONE_PEAK
    slope = np.log(9.0) / np.log(2.0)
    cases: list[Broadened] = [
        ("peak, left end of plateau", f, peak, 0.15, 8.5, 9.0),
        ("peak, right end of plateau", f, peak, 0.15, 11.5, 9.0),
        ("peak, left side", f, peak, 0.15, 6.8, (6.8 / 0.85 / 5.0) ** slope),
        ("peak, right side", f, peak, 0.15, 13.8, 9.0 * (10.0 * 1.15 / 13.8) ** slope),
        ("peak, foot of left side", f, peak, 0.15, 4.25, 1.0),
        ("peak, foot of right side", f, peak, 0.15, 23.0, 1.0),
        ("peak, far end", f, peak, 0.15, 100.0, 1.0),
        ("peak, 10 % down only", f, peak, (0.10, 0.0), 9.0, 9.0),
        ("peak, 10 % down only, right side", f, peak, (0.10, 0.0), 12.0, 9.0 * (10 / 12) ** slope),
    ]
    two = np.array([1.0, 4.0, 5.0, 6.0, 7.0, 8.0, 30.0])
    values = np.array([1.0, 1.0, 6.0, 2.0, 4.0, 1.0, 1.0])
    cases += [
        ("two peaks, plateau of the first", two, values, 0.15, 5.75, 6.0),
        ("two peaks, plateau of the second", two, values, 0.15, 8.05, 4.0),
        # Right side of the first peak, shifted up: from (5.75, 6) to (6.9, 2).
        (
            "two peaks, between them",
            two,
            values,
            0.15,
            5.9,
            6.0 * (5.9 / 5.75) ** (np.log(1 / 3) / np.log(6 / 5)),
        ),
    ]
    flat = np.array([1.0, 4.0, 5.0, 8.0, 10.0, 40.0])
    level = np.array([1.0, 1.0, 3.0, 3.0, 1.0, 1.0])
    cases += [
        ("plateau, widened left end", flat, level, 0.15, 4.25, 3.0),
        ("plateau, widened right end", flat, level, 0.15, 9.2, 3.0),
        ("plateau, inside", flat, level, 0.15, 6.5, 3.0),
    ]
    return cases


def clipping() -> list[Row]:
    """Reduction of narrow peaks: a narrow one and a wide one on doubly logarithmic sides.

    A peak that rises as f^s to P at 10 Hz and falls alike exceeds 0.8 P from 10 r to 10 / r with
    r = 0.8^(1/s), so that B = 2 (1 - r²) / (1 + r²).
    """
    source = "by hand; rule of ASCE 4-98, section 3.4.2.3"
    rows = []
    for label, foot, height in (("narrow", 5.0, 9.0), ("wide", 2.0, 2.0)):
        f = np.array([1.0, foot, 10.0, 100.0 / foot, 100.0])
        peak = np.array([1.0, 1.0, height, 1.0, 1.0])
        r = 0.8 ** (np.log(10.0 / foot) / np.log(height))
        bandwidth = 2.0 * (1.0 - r**2) / (1.0 + r**2)
        reduced = (0.85 if bandwidth < 0.30 else 1.0) * height
        places, ordinates, peaks = clip_peaks(f, peak)
        rows.append(
            Row(
                "peak reduction",
                f"{label} peak of {height:g} m/s2, B = {bandwidth:.3f}, reduced and broadened",
                reduced,
                float(broaden(places, ordinates, 0.15, [10.0])[0]),
                "m/s2",
                1e-12,
                source,
            )
        )
        rows += [
            Row(
                "peak reduction",
                f"{label} peak, bandwidth over central frequency",
                bandwidth,
                one.bandwidth,
                "-",
                1e-12,
                source,
            )
            for one in peaks
        ]
    return rows


def chain_spectra() -> list[Row]:
    """SDLD25: spectrum between tabulated frequencies and dampings, and SRSS of a chain with it.

    Eight masses of 10 kg between nine springs of 1e5 N/m and nine dashpots of 50 N s/m, both ends
    held; log S is linear in log f and, between the dampings, linear in ξ.
    """
    m, k, c, n = 10.0, 1e5, 50.0, 8
    stiffness = k * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    square, shapes = np.linalg.eigh(stiffness / m)
    omega = np.sqrt(square)
    frequency, xi = omega / (2.0 * np.pi), 0.5 * c / k * omega
    dampings = list(SDLD25_SPECTRA)
    tabulated = np.array(list(SDLD25_SPECTRA.values()))
    family = interpolate_frequency(SDLD25_FREQUENCY, tabulated, frequency)
    ordinates = interpolate_damping(dampings, family, xi)
    rows = []
    for number in range(n):
        circular = 2.0 * np.sqrt(k / m) * np.sin((number + 1) * np.pi / 18.0)
        f, ratio = circular / (2.0 * np.pi), 0.5 * c / k * circular
        top = 25.0 ** ((0.05 - ratio) / 0.045) * 10.0 ** ((ratio - 0.005) / 0.045)
        side = 1.0 if f <= 13.0 else np.log(33.0 / f) / np.log(33.0 / 13.0)
        rows.append(
            Row(
                "SDLD25 spectrum",
                f"ordinate at {f:.4f} Hz, ξ = {ratio:.5f}",
                float(top**side),
                float(ordinates[number]),
                "m/s2",
                1e-11,
                f"{SDLD25_SOURCE}: its table; its rule of interpolation written out",
            )
        )
    # Unit masses cancel: the participation of a mode of a uniform chain is the sum of its shape.
    absolute = np.sqrt(np.sum((shapes * shapes.sum(axis=0) * ordinates) ** 2, axis=1))
    published = (10.4498435, 19.0299477, 25.3176949, 28.9453548)
    rows += [
        Row(
            "SDLD25 chain",
            f"absolute acceleration of P{number + 1}, SRSS",
            reference,
            float(absolute[number]),
            "m/s2",
            5e-8,  # five units of the ninth digit, the last that is printed
            SDLD25_SOURCE,
        )
        for number, reference in enumerate(published)
    ]
    return rows
