"""Oscillators on a moving base, and spectra: frequencies, interpolation, broadening."""

import numpy as np

from impactfem.spectra import (
    broaden,
    clip_peaks,
    corner_frequencies,
    interpolate_damping,
    interpolate_frequency,
    oscillator_response,
    response_spectra,
    rg_1_122_frequencies,
)
from impactfem.system.arrays import Array
from impactfem.verify.row import Rows, benchmark

SDLD25_FREQUENCY = (1.0, 3.0, 13.0, 33.0)  # Hz
SDLD25_SPECTRA = {0.005: (1.0, 25.0, 25.0, 1.0), 0.05: (1.0, 10.0, 10.0, 1.0)}  # m/s2 by damping
SDLD25_SOURCE = "code_aster validation manual V2.01.025 (SDLD25)"

PULSE = "SDLL06 triangular pulse"


@benchmark(PULSE, "code_aster validation manual V2.01.006 (SDLL06)")
def oscillator_sdll06(rows: Rows) -> None:
    """SDLL06: ω = 30 rad/s, undamped; base acceleration 0, 9.81 m/s² at 25 ms, 0 at 50 ms.

    The steps are exact: allowed is a unit of the last digit that is printed, of seven or eight.
    """
    dt = 0.0025
    response = oscillator_response(_pulse(dt), dt, [30.0 / (2.0 * np.pi)], [0.0])
    x = response.relative_displacement[0, 0]
    t = np.array([0.01, 0.02, 0.03, 0.04, 0.06])
    published = [-6.510633e-5, -5.138627e-4, -1.6793173e-3, -3.4573635e-3, -6.7649559e-3]
    quantities = [f"relative displacement at {at} s" for at in t]
    digit = [2e-7, 2e-7, 6e-8, 6e-8, 6e-8]
    rows.add(quantities, published, x[np.rint(t / dt).astype(int)], "m", digit)


def _pulse(dt: float) -> Array:
    """Base acceleration of SDLL06 up to 0.1 s [m/s2]."""
    time = dt * np.arange(round(0.1 / dt) + 1)
    return np.asarray(np.interp(time, [0.0, 0.025, 0.05], [0.0, 9.81, 0.0]))


@benchmark(
    "oscillator on piecewise-linear input",
    "closed form of the ramp response (Nigam and Jennings 1969)",
)
def oscillator_exact(rows: Rows) -> None:
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
    for frequency in (0.2, 5.0, 90.0, 450.0):
        for xi in (0.0, 0.05, 0.3):
            omega = np.longdouble(2.0) * np.pi * frequency
            omega_d = omega * np.sqrt(np.longdouble(1.0) - np.longdouble(xi) ** 2)
            t = np.maximum(time[:, None] - starts, 0.0)
            swing = 2.0 * xi / omega * np.cos(omega_d * t)
            swing += (2.0 * xi**2 - 1.0) / omega_d * np.sin(omega_d * t)
            ramp = (t - 2.0 * xi / omega + np.exp(-xi * omega * t) * swing) / omega**2
            exact = -(ramp @ changes)
            x = oscillator_response(a, dt, [frequency], [xi]).relative_displacement[0, 0]
            error = np.max(np.abs(x - exact)) / np.max(np.abs(exact))
            rows.add(f"largest error at {frequency:g} Hz, ξ = {xi:g}", 0.0, error, "-", 1e-10)
    f = [30.0 / (2.0 * np.pi)]
    found = response_spectra(_pulse(0.0025), 0.0025, f, [0.0], method="in-step").sd[0, 0, 0]
    amplitude = 9.81 / (30.0**3 * 0.025) * 2.0 * (1.0 - np.cos(30.0 * 0.025))
    rows.name, rows.source = PULSE, "free vibration after a symmetric triangle, closed form"
    quantity = "largest relative displacement, after the end of the record"
    rows.add(quantity, amplitude, found, "m", 1e-10)


@benchmark("frequencies of RG 1.122", "US NRC Regulatory Guide 1.122, revision 1 (1978), table 1")
def rg_1_122(rows: Rows) -> None:
    """The list of Regulatory Guide 1.122: its length, its ends, and where its increments change."""
    listed, continued = rg_1_122_frequencies(), rg_1_122_frequencies(500.0, 100)
    missing = np.sum(~np.isin((3.0, 3.6, 5.0, 8.0, 15.0, 18.0, 22.0), listed))
    rows.add("number", 75.0, listed.size, "-", 0.0)
    rows.add("first", 0.2, listed[0], "Hz", 1e-12)
    rows.add("last", 34.0, listed[-1], "Hz", 0.0)
    # The sum of arithmetic series: n (first + last) / 2 of each range, by hand.
    rows.add("sum of all", 545.7, listed.sum(), "Hz", 1e-12)
    rows.add("ends of ranges missing", 0.0, missing, "-", 0.0)
    rows.add("last, continued for impacts", 500.0, continued[-1], "Hz", 0.0)


@benchmark(
    "SDLL06 response spectrum", "closed form for the pulse of code_aster's V2.01.006 (SDLL06)"
)
def spectrum_sdll06(rows: Rows) -> None:
    """SDLL06's triangular pulse: largest displacements of undamped oscillators in closed form.

    A pulse that rises to A in t1 and falls to zero in another t1 leaves an oscillator with the
    amplitude 2 A (1 - cos ωt1) / (ω³ t1). In the falling half, with θ = ωt,

        x = -A/(ω² t1) (t - sin θ/ω - 2 (t - t1) + 2 sin(θ - ωt1)/ω)

    is stationary where (2 cos ωt1 - 1) cos θ + 2 sin ωt1 sin θ = 1; in the rising half it is
    monotonic.
    """
    amplitude, t1, dt = 9.81, 0.025, 0.0025
    frequencies = (30.0 / (2.0 * np.pi), 12.0, 25.0, 35.0, 60.0, 150.0)
    spectra = response_spectra(_pulse(dt), dt, frequencies, [0.0], method="in-step")
    for frequency, found in zip(frequencies, spectra.sd[0, 0], strict=True):
        omega = 2.0 * np.pi * frequency
        after = 2.0 * amplitude * (1.0 - np.cos(omega * t1)) / (omega**3 * t1)
        a, b = 2.0 * np.cos(omega * t1) - 1.0, 2.0 * np.sin(omega * t1)
        turns = 2.0 * np.pi * np.arange(np.ceil(2.0 * omega * t1 / (2.0 * np.pi)) + 1.0)
        half = np.arccos(np.clip(1.0 / np.hypot(a, b), -1.0, 1.0))
        theta = np.add.outer(np.arctan2(b, a) + np.array([-half, half]), turns).ravel()
        theta = theta[(theta > omega * t1) & (theta < 2.0 * omega * t1)]
        t = np.append(theta / omega, [t1, 2.0 * t1])
        falling = t - np.sin(omega * t) / omega - 2.0 * (t - t1)
        falling += 2.0 * np.sin(omega * (t - t1)) / omega
        largest = max(after, np.max(np.abs(amplitude / (omega**2 * t1) * falling)))
        quantity = f"largest relative displacement at {frequency:.4g} Hz, undamped"
        rows.add(quantity, largest, found, "m", 1e-10)


@benchmark(
    "peak broadening",
    "closed form; construction of US NRC Regulatory Guide 1.122, revision 1 (1978), figure 1",
)
def broadening(rows: Rows) -> None:
    """Hand-made spectra broadened by ±15 %: one peak, two peaks, a plateau, and one-sided.

    Sides of straight lines on doubly logarithmic axes keep their slope and move by the factors
    0.85 and 1.15, which gives every ordinate in closed form.
    """
    # 9 m/s2 at 10 Hz on 1 m/s2: from 5 Hz up by f^(ln 9/ln 2), to 20 Hz down alike.
    f, peak = np.array([[1.0, 5.0, 10.0, 20.0, 100.0], [1.0, 1.0, 9.0, 1.0, 1.0]])
    slope = np.log(9.0) / np.log(2.0)
    down = (0.10, 0.0)
    two = np.array([1.0, 4.0, 5.0, 6.0, 7.0, 8.0, 30.0])
    values = np.array([1.0, 1.0, 6.0, 2.0, 4.0, 1.0, 1.0])
    # Right side of the first of two peaks, shifted up: from (5.75, 6) to (6.9, 2).
    between = 6.0 * (5.9 / 5.75) ** (np.log(1 / 3) / np.log(6 / 5))
    flat = np.array([1.0, 4.0, 5.0, 8.0, 10.0, 40.0])
    level = np.array([1.0, 1.0, 3.0, 3.0, 1.0, 1.0])
    # What, spectrum, ratio of broadening; a frequency [Hz] and the ordinate there by hand [m/s2].
    for label, places, ordinates, ratio, at, reference in (
        ("peak, left end of plateau", f, peak, 0.15, 8.5, 9.0),
        ("peak, right end of plateau", f, peak, 0.15, 11.5, 9.0),
        ("peak, left side", f, peak, 0.15, 6.8, (6.8 / 0.85 / 5.0) ** slope),
        ("peak, right side", f, peak, 0.15, 13.8, 9.0 * (10.0 * 1.15 / 13.8) ** slope),
        ("peak, foot of left side", f, peak, 0.15, 4.25, 1.0),
        ("peak, foot of right side", f, peak, 0.15, 23.0, 1.0),
        ("peak, far end", f, peak, 0.15, 100.0, 1.0),
        ("peak, 10 % down only", f, peak, down, 9.0, 9.0),
        ("peak, 10 % down only, right side", f, peak, down, 12.0, 9.0 * (10 / 12) ** slope),
        ("two peaks, plateau of the first", two, values, 0.15, 5.75, 6.0),
        ("two peaks, plateau of the second", two, values, 0.15, 8.05, 4.0),
        ("two peaks, between them", two, values, 0.15, 5.9, between),
        ("plateau, widened left end", flat, level, 0.15, 4.25, 3.0),
        ("plateau, widened right end", flat, level, 0.15, 9.2, 3.0),
        ("plateau, inside", flat, level, 0.15, 6.5, 3.0),
    ):
        found = broaden(places, ordinates, ratio, [at])[0]
        rows.add(f"{label}, at {at:g} Hz", reference, found, "m/s2", 1e-12)
    listed = corner_frequencies(f, [(f, peak)])
    fine = np.geomspace(1.0, 100.0, 2001)
    straight = interpolate_frequency(listed, broaden(f, peak, 0.15, listed), fine)
    loss = np.max(1.0 - straight / broaden(f, peak, 0.15, fine))
    quantity = "largest loss of straight lines between the design frequencies"
    rows.add(quantity, 0.0, max(loss, 0.0), "-", 1e-12, "definition of the design frequencies")


@benchmark("peak reduction", "closed form; rule of ASCE 4-98, section 3.4.2.3")
def peak_reduction(rows: Rows) -> None:
    """Reduction of narrow peaks: a narrow one and a wide one on doubly logarithmic sides.

    A peak that rises as f^s to P at 10 Hz and falls alike exceeds 0.8 P from 10 r to 10 / r with
    r = 0.8^(1/s), so that B = 2 (1 - r²) / (1 + r²).
    """
    for label, foot, height in (("narrow", 5.0, 9.0), ("wide", 2.0, 2.0)):
        f = np.array([1.0, foot, 10.0, 100.0 / foot, 100.0])
        peak = np.array([1.0, 1.0, height, 1.0, 1.0])
        r = 0.8 ** (np.log(10.0 / foot) / np.log(height))
        bandwidth = 2.0 * (1.0 - r**2) / (1.0 + r**2)
        reduced = (0.85 if bandwidth < 0.30 else 1.0) * height
        places, ordinates, peaks = clip_peaks(f, peak)
        found = broaden(places, ordinates, 0.15, [10.0])[0]
        quantity = f"{label} peak of {height:g} m/s2, B = {bandwidth:.3f}, reduced and broadened"
        rows.add(quantity, reduced, found, "m/s2", 1e-12)
        quantities = [f"{label} peak, bandwidth over central frequency" for _ in peaks]
        rows.add(quantities, bandwidth, [one.bandwidth for one in peaks], "-", 1e-12)


@benchmark("SDLD25 spectrum", f"{SDLD25_SOURCE}: its table; its rule of interpolation written out")
def sdld25(rows: Rows) -> None:
    """SDLD25: spectrum between tabulated frequencies and dampings, and SRSS of a chain with it.

    Eight masses of 10 kg between nine springs of 1e5 N/m and nine dashpots of 50 N s/m, both ends
    held; log S is linear in log f and, between the dampings, linear in ξ.
    """
    m, k, c, n = 10.0, 1e5, 50.0, 8
    stiffness = k * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    square, shapes = np.linalg.eigh(stiffness / m)
    omega = np.sqrt(square)
    frequency, xi = omega / (2.0 * np.pi), 0.5 * c / k * omega
    family = interpolate_frequency(SDLD25_FREQUENCY, list(SDLD25_SPECTRA.values()), frequency)
    ordinates = interpolate_damping(list(SDLD25_SPECTRA), family, xi)
    circular = 2.0 * np.sqrt(k / m) * np.sin(np.arange(1, n + 1) * np.pi / 18.0)
    f, ratio = circular / (2.0 * np.pi), 0.5 * c / k * circular
    top = 25.0 ** ((0.05 - ratio) / 0.045) * 10.0 ** ((ratio - 0.005) / 0.045)
    side = np.where(f <= 13.0, 1.0, np.log(33.0 / f) / np.log(33.0 / 13.0))
    quantities = [f"ordinate at {f:.4f} Hz, ξ = {x:.5f}" for f, x in zip(f, ratio, strict=True)]
    rows.add(quantities, top**side, ordinates, "m/s2", 1e-11)
    # Unit masses cancel: the participation of a mode of a uniform chain is the sum of its shape.
    absolute = np.sqrt(np.sum((shapes * shapes.sum(axis=0) * ordinates) ** 2, axis=1))
    rows.name, rows.source = "SDLD25 chain", SDLD25_SOURCE
    # Allowed are five units of the ninth digit, the last that is printed.
    published = [10.4498435, 19.0299477, 25.3176949, 28.9453548]
    quantities = [f"absolute acceleration of P{number}, SRSS" for number in range(1, 5)]
    rows.add(quantities, published, absolute[:4], "m/s2", 5e-8)
