"""An oscillating pulse on one mode: the modal equation alone, and a strip of a slab in it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from impactfem.building.section import Material
from impactfem.building.shell_model import RX, RZ, UX, UY, UZ, Shells, shell_model
from impactfem.dynamics.damping import Rayleigh
from impactfem.verify.row import Row
from impactfem.verify.shells import flat, panel
from impactfem.verify.waves.shell_motion import MovingModel, apart

Array = NDArray[np.float64]

DAMPED = {"undamped": 0.0, "5 % damped": 0.05, "critically damped": 1.0, "overdamped": 3.0}
"""Part of critical damping, by its name."""
HALF_WAVES, RATIO = 5, 0.8
"""Half waves of the pulse, and its frequency over that of the mode."""
PERIODS = 6.0
"""Time that is computed, in periods of the mode."""
EQUATION = "modal equation under a pulse"
STRIP = "slab strip under an oscillating pulse"
SINGLE = "single degree of freedom under a sine that stops, closed form"
CONCRETE = Material(E=33e9, nu=0.2, rho=2500.0)
LENGTH, WIDTH, THICKNESS, CELLS = 6.0, 0.25, 0.3, 24
SHEAR = 5.0 / 6.0


def modal_equation() -> list[Row]:
    """z̈ + 2 ξ ω ż + ω² z = sin Ωt up to a time, then 0, in exact steps.

    The step takes the load as straight between its samples: with 400 samples a wave that leaves
    (2π/400)²/12, 2e-5. A triangular pulse is straight: the steps are exact for it.
    """
    from impactfem.reduction.modal_response import modal_response
    from impactfem.reduction.reduced import ReducedModel

    omega = 2.0 * math.pi * 7.0
    model = ReducedModel(
        eigenvalue=np.array([omega**2]),
        load=np.ones((1, 1)),
        coordinates=np.eye(1),
        shift=0.0,
        tail=np.zeros((0, 1)),
    )
    rows = []
    for label, ratio in DAMPED.items():
        time, load = _pulse(omega, 400)
        triangle = np.interp(time / time[-1], [0.0, 0.125, 0.25], [0.0, 1.0, 0.0], right=0.0)
        for what, allowed, source, amplitude, exact in (
            ("an oscillating pulse", 5e-5, SINGLE, load, response(time, omega, ratio)),
            (
                "a triangular pulse",
                1e-10,
                "single degree of freedom, closed form",
                triangle,
                ramps(time, omega, ratio, time[-1] / 8.0),
            ),
        ):
            z = modal_response(model, amplitude[:, None], time[1], Rayleigh(2.0 * ratio * omega))
            quantity = f"largest difference over the peak, {what}, {label}"
            difference = apart(z.displacement[0], exact)
            rows.append(Row(EQUATION, quantity, 0.0, difference, "-", allowed, source, True))
    return rows


def strip_pulse() -> list[Row]:
    """A simply supported strip, bent to a cylinder, under a pressure in its first mode's shape.

    The pressure p sin(πx/L) moves this mode alone: one equation with Mindlin's frequency, whose
    modal mass is half of the strip's, of which the rotation of the section has a small part. An
    error of the frequency by mesh or step, 1e-5, grows with 2π and the six periods to 4e-4 where
    little damps it, and does not with critical damping and above.
    """
    omega, moving = _strip()
    basis = moving.reduced(omega / (2.0 * math.pi), 20)
    time, pulse = _pulse(omega, 400)
    rows = []
    for label, ratio in DAMPED.items():
        # Half of it by the mass and half by the stiffness.
        damping = Rayleigh(alpha=ratio * omega, beta=ratio / omega)
        exact: Array = response(time, omega, ratio)
        exact /= _modal_mass(omega)
        at_peak, anywhere = (5e-4, 1e-3) if ratio < 1.0 else (2e-4, 2e-4)
        for solver, found in (
            ("full", moving.full(pulse[:, None], time[1], damping).motion["displacement"]),
            ("reduced", basis.motion(pulse[:, None], time[1], damping)["displacement"]),
        ):
            k = int(np.argmax(np.abs(exact)))
            rows += [
                Row(
                    STRIP,
                    f"largest deflection, {label}, {solver}",
                    float(exact[k]),
                    float(found[k, 0]),
                    "m",
                    at_peak,
                    SINGLE,
                ),
                Row(
                    STRIP,
                    f"largest difference over the peak, {label}, {solver}",
                    0.0,
                    apart(found[:, 0], exact),
                    "-",
                    anywhere,
                    SINGLE,
                    absolute=True,
                ),
            ]
    return rows


def response(time: Array, omega: float, ratio: float) -> Array:
    """Response of z̈ + 2 ξ ω ż + ω² z to the pulse, by the impulse response h.

    The pulse of whole half waves is sin Ωt, and after its end T another sine that takes it away:
    z(t) = s(t) − (−1)^n s(t − T), where s is the response to a sine that begins and stays.
    """
    drive = RATIO * omega
    end = HALF_WAVES * math.pi / drive
    later = np.clip(time - end, 0.0, None)
    sign = 1.0 if HALF_WAVES % 2 else -1.0
    return _sine(time, omega, ratio) + sign * _sine(later, omega, ratio)


def ramps(time: Array, omega: float, ratio: float, rise: float) -> Array:
    """Response to a triangular pulse that rises in some time and falls in the same one."""
    total = np.zeros_like(time)
    for start, slope in ((0.0, 1.0), (rise, -2.0), (2.0 * rise, 1.0)):
        total += slope / rise * _ramp(np.clip(time - start, 0.0, None), omega, ratio)
    return total


def _sine(t: Array, omega: float, ratio: float) -> Array:
    """Response to sin Ωt from rest: the steady state Im X exp(iΩt), and what starts it."""
    drive = RATIO * omega
    X = 1.0 / (omega**2 - drive**2 + 2j * ratio * omega * drive)
    steady = (X * np.exp(1j * drive * t)).imag
    return np.asarray(steady + _free(t, omega, ratio, -X.imag, -(1j * drive * X).imag))


def _ramp(t: Array, omega: float, ratio: float) -> Array:
    """Response to the load t from rest: the steady state t/ω² − 2 ξ/ω³, and what starts it."""
    offset = 2.0 * ratio / omega**3
    return t / omega**2 - offset + _free(t, omega, ratio, offset, -1.0 / omega**2)


def _free(t: Array, omega: float, ratio: float, z0: float, v0: float) -> Array:
    """Free vibration from z₀ and v₀."""
    decay = ratio * omega
    if ratio == 1.0:
        return np.asarray(np.exp(-decay * t) * (z0 + (v0 + decay * z0) * t))
    if ratio < 1.0:
        damped = omega * math.sqrt(1.0 - ratio**2)
        swing = z0 * np.cos(damped * t) + (v0 + decay * z0) / damped * np.sin(damped * t)
        return np.asarray(np.exp(-decay * t) * swing)
    spread = omega * math.sqrt(ratio**2 - 1.0)
    slow, fast = -decay + spread, -decay - spread
    part = (v0 - fast * z0) / (slow - fast)
    return np.asarray(part * np.exp(slow * t) + (z0 - part) * np.exp(fast * t))


def _pulse(omega: float, samples: int) -> tuple[Array, Array]:
    """Times and the pulse, with so many samples a wave; it ends at one of them."""
    drive = RATIO * omega
    step = 2.0 * math.pi / drive / samples
    count = 8 * math.ceil(PERIODS * RATIO * samples / 8)
    time = step * np.arange(count + 1, dtype=np.float64)
    wave = np.sin(2.0 * np.pi * np.arange(count + 1, dtype=np.float64) / samples)
    pulse: Array = np.where(np.arange(count + 1) < HALF_WAVES * samples // 2, wave, 0.0)
    return time, pulse


def _frequency() -> tuple[float, float]:
    """First frequency of Mindlin's strip [rad/s], and the slope of its section over k w.

    With k = π/L, ω² is the smaller root of (S k² − ρ t ω²) (D k² + S − I ω²) = S² k²; the section
    turns by S k/(D k² + S − I ω²) for w = 1.
    """
    E, nu, rho, t = CONCRETE.E, CONCRETE.nu, CONCRETE.rho, THICKNESS
    D, S, rotary = E * t**3 / (12.0 * (1.0 - nu**2)), SHEAR * CONCRETE.G * t, rho * t**3 / 12.0
    k = math.pi / LENGTH
    a, b, c = rho * t * rotary, rho * t * (D * k**2 + S) + rotary * S * k**2, S * D * k**4
    square = 2.0 * c / (b + math.sqrt(b**2 - 4.0 * a * c))
    return math.sqrt(square), S / (D * k**2 + S - rotary * square)


def _modal_mass(omega: float) -> float:
    """Mass per load: M = ½ b L (ρ t + ρ t³/12 (k φ)²) over F = ½ b L p, with p = 1 Pa [kg/N]."""
    k_phi = math.pi / LENGTH * _frequency()[1]
    return CONCRETE.rho * THICKNESS * (1.0 + THICKNESS**2 / 12.0 * k_phi**2)


def _strip() -> tuple[float, MovingModel]:
    place = flat((LENGTH, 0.0, 0.0), (0.0, WIDTH, 0.0))
    nodes, triangles = panel(CELLS, 1, place)
    model = shell_model(nodes, Shells(triangles, THICKNESS, CONCRETE))
    x, y = nodes[:, 0], nodes[:, 1]
    model = model.hold(x >= 0.0, UX, UY, RX, RZ)  # RX would turn across the cylinder
    model = model.hold((x == 0.0) | (x == LENGTH), UZ)
    load = np.zeros((6 * len(nodes), 1))
    pressure = np.sin(np.pi * x / LENGTH)
    # The mass of the deflections is ρ t ∫N Nᵀ dA: over ρ t it turns a pressure into its forces.
    load[UZ::6, 0] = model.M[UZ::6, UZ::6] @ pressure / (CONCRETE.rho * THICKNESS)
    middle = model.rows((x == 0.5 * LENGTH) & (y == 0.0), UZ)
    return _frequency()[0], MovingModel(model, load, middle)
