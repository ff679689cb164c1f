"""Forces in closed form: a pulse on one mode, and a force that travels along a beam."""

import math

import numpy as np

from impactfem.building.section import BeamSection
from impactfem.building.shell_model import RX, RZ, UX, UY, UZ, Shells, shell_model
from impactfem.dynamics.damping import UNDAMPED, Rayleigh
from impactfem.system.arrays import Array
from impactfem.verify.row import Rows, benchmark
from impactfem.verify.shells import CONCRETE, SHEAR, mindlin, rectangle, straight_beam
from impactfem.verify.waves import MovingModel, apart, pressures

DAMPED = {"undamped": 0.0, "5 % damped": 0.05, "critically damped": 1.0, "overdamped": 3.0}
"""Part of critical damping, by its name."""
HALF_WAVES, RATIO = 5, 0.8  # half waves of the pulse, and its frequency over that of the mode
PERIODS, SAMPLES = 6.0, 400
"""Time that is computed, in periods of the mode, and samples of a wave of the pulse."""
SINGLE = "single degree of freedom under a sine that stops, closed form"
STRIP, WIDTH, THICKNESS, CELLS = 6.0, 0.25, 0.3, 24
"""Length, width and thickness of the strip [m], and cells along it."""

LENGTH, DEPTH, ELEMENTS = 20.0, 0.1, 40
"""A slender beam: its shear and the inertia of its rotation change a frequency by 0.01 % or so."""
FORCE = 10.0
SPEEDS = (0.25, 0.5, 1.0)
"""Speeds of the force over that of resonance, at which it crosses in half of the first period."""
STEPS = 2000  # time steps of a crossing
WAVE_NUMBERS = np.pi / LENGTH * np.arange(1.0, 17.0)
"""Of the load patterns of the reduced model [rad/m]."""


@benchmark("modal equation under a pulse")
def modal_equation(rows: Rows) -> None:
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
    for label, ratio in DAMPED.items():
        rows.where = label
        time, load = _pulse(omega)
        triangle = np.interp(time / time[-1], [0.0, 0.125, 0.25], [0.0, 1.0, 0.0], right=0.0)
        closed = "single degree of freedom, closed form"
        # To a load t from rest: the steady state t/ω² − 2 ξ/ω³, and what starts it.
        ramps, rise, offset = np.zeros_like(time), time[-1] / 8.0, 2.0 * ratio / omega**3
        for start, slope in ((0.0, 1.0), (rise, -2.0), (2.0 * rise, 1.0)):
            t = np.clip(time - start, 0.0, None)
            ramp = t / omega**2 - offset + _free(t, omega, ratio, offset, -1.0 / omega**2)
            ramps += slope / rise * ramp
        for what, allowed, source, amplitude, exact in (
            ("an oscillating pulse", 5e-5, SINGLE, load, response(time, omega, ratio)),
            ("a triangular pulse", 1e-10, closed, triangle, ramps),
        ):
            z = modal_response(model, amplitude[:, None], time[1], Rayleigh(2.0 * ratio * omega))
            away = apart(z.displacement[0], exact)
            rows.add(f"largest difference over the peak, {what}", 0.0, away, "-", allowed, source)


@benchmark("slab strip under an oscillating pulse", SINGLE)
def strip_pulse(rows: Rows) -> None:
    """A simply supported strip, bent to a cylinder, under a pressure in its first mode's shape.

    The pressure p sin(πx/L) moves this mode alone: one equation with Mindlin's frequency, whose
    modal mass is half of the strip's, of which the rotation of the section has a small part. An
    error of the frequency by mesh or step, 1e-5, grows with 2π and the six periods to 4e-4 where
    little damps it, and does not with critical damping and above.
    """
    # Frequency, and modal mass over load: M = ½ b L (ρ t + ρ t³/12 (k φ)²) over F = ½ b L p, with
    # p = 1 Pa; for w = 1 the section turns by k φ = S k/(D k² + S − I ω²).
    k2, rho, t = (math.pi / STRIP) ** 2, CONCRETE.rho, THICKNESS
    omega = float(mindlin(np.array([k2]), t, CONCRETE)[0])
    D = CONCRETE.E * t**3 / (12.0 * (1.0 - CONCRETE.nu**2))
    S, rotary = SHEAR * CONCRETE.G * t, rho * t**3 / 12.0
    k_phi = math.sqrt(k2) * S / (D * k2 + S - rotary * omega**2)
    mass = rho * t * (1.0 + t**2 / 12.0 * k_phi**2)
    nodes, triangles = rectangle(STRIP, WIDTH, CELLS, 1)
    model = shell_model(nodes, Shells(triangles, t, CONCRETE))
    x, y = nodes[:, 0], nodes[:, 1]
    model = model.hold(x >= 0.0, UX, UY, RX, RZ)  # RX would turn across the cylinder
    model = model.hold((x == 0.0) | (x == STRIP), UZ)
    load = pressures(model, np.sin(np.pi * x / STRIP)[:, None], rho * t)
    moving = MovingModel(model, load, model.rows((x == 0.5 * STRIP) & (y == 0.0), UZ))
    basis = moving.reduced(omega / (2.0 * math.pi), 20)
    time, pulse = _pulse(omega)
    for label, ratio in DAMPED.items():
        # Half of it by the mass and half by the stiffness.
        damping = Rayleigh(alpha=ratio * omega, beta=ratio / omega)
        exact = response(time, omega, ratio) / mass
        at_peak, anywhere = (5e-4, 1e-3) if ratio < 1.0 else (2e-4, 2e-4)
        k = int(np.argmax(np.abs(exact)))
        for solver, motion in (
            ("full", moving.full(pulse[:, None], time[1], damping).motion),
            ("reduced", basis.motion(pulse[:, None], time[1], damping)),
        ):
            found, rows.where = motion["displacement"][:, 0], f"{label}, {solver}"
            rows.add("largest deflection", exact[k], found[k], "m", at_peak)
            away = apart(found, exact)
            rows.add("largest difference over the peak", 0.0, away, "-", anywhere)


def response(time: Array, omega: float, ratio: float) -> Array:
    """Response of z̈ + 2 ξ ω ż + ω² z to the pulse, by the impulse response h.

    The pulse of whole half waves is sin Ωt, and after its end T another sine that takes it away:
    z(t) = s(t) − (−1)^n s(t − T), where s is the response to a sine that begins and stays.
    """
    drive = RATIO * omega
    # To sin Ωt from rest: the steady state Im X exp(iΩt), and what starts it.
    X = 1.0 / (omega**2 - drive**2 + 2j * ratio * omega * drive)
    later = np.clip(time - HALF_WAVES * math.pi / drive, 0.0, None)
    began, stopped = (
        (X * np.exp(1j * drive * t)).imag + _free(t, omega, ratio, -X.imag, -(1j * drive * X).imag)
        for t in (time, later)
    )
    return np.asarray(began + (1.0 if HALF_WAVES % 2 else -1.0) * stopped)


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


def _pulse(omega: float) -> tuple[Array, Array]:
    """Times and the pulse, which ends at one of them."""
    k = np.arange(8 * math.ceil(PERIODS * RATIO * SAMPLES / 8) + 1, dtype=np.float64)
    pulse = np.where(k < HALF_WAVES * SAMPLES // 2, np.sin(2.0 * np.pi * k / SAMPLES), 0.0)
    return 2.0 * math.pi / (RATIO * omega) / SAMPLES * k, pulse


@benchmark(
    "beam under a travelling force",
    "Fryba, Vibration of Solids and Structures under Moving Loads: series for Euler's beam",
)
def travelling_force(rows: Rows) -> None:
    """Deflection of the middle and of the quarter while the force is on the beam.

    The full model takes the nodal forces of a point force at x = v t: its shape functions, as many
    patterns as nodes. The reduced one takes the force's series, 2P/L Σ sin(nπvt/L) sin(nπx/L), of
    16 patterns in space. Undamped, with ω_n = (nπ/L)² √(E I/(ρ A)) and Ω_n = nπv/L,

        w = 2P/(ρ A L) Σ sin(nπx/L) (sin Ω_n t − Ω_n/ω_n sin ω_n t)/(ω_n² − Ω_n²),

    whose term at Ω_n = ω_n is (sin ω_n t − ω_n t cos ω_n t)/(2 ω_n²).
    """
    # The beam with 1 N on each inner node, and with waves of 1 N/m.
    model = shell_model(*straight_beam(LENGTH, ELEMENTS, BeamSection.beam(DEPTH, DEPTH), CONCRETE))
    x = model.nodes[:, 0]
    loads = np.zeros((6 * len(x), len(x) - 2))
    loads[6 * np.arange(1, len(x) - 1) + UZ, np.arange(len(x) - 2)] = 1.0
    probes = [6 * int(np.argmin(np.abs(x - share * LENGTH))) + UZ for share in (0.5, 0.25)]
    model = model.hold(x >= 0.0, UX, UY, RX, RZ).hold((x == 0.0) | (x == LENGTH), UZ)
    waves = pressures(model, np.sin(np.outer(x, WAVE_NUMBERS)), CONCRETE.rho * DEPTH**2)
    moving = MovingModel(model, loads, np.array(probes))
    basis = MovingModel(model, waves, np.array(probes)).reduced(shift=5.0, vectors=48)
    for ratio in SPEEDS:
        speed = ratio * float(_omega(1.0)) * LENGTH / np.pi
        dt = LENGTH / speed / STEPS
        time = dt * np.arange(STEPS + 1, dtype=np.float64)
        nodal = FORCE * nodal_forces(x, speed * time)[:, 1:-1]
        sines = 2.0 * FORCE / LENGTH * np.sin(np.outer(speed * time, WAVE_NUMBERS))
        exact = {
            s: series(p * LENGTH, time, speed) for s, p in (("middle", 0.5), ("quarter", 0.25))
        }
        for solver, motion in (
            ("full", moving.full(nodal, dt, UNDAMPED).motion),
            ("reduced", basis.motion(sines, dt, UNDAMPED)),
        ):
            found = motion["displacement"].T
            at = f"at {ratio:g} of the speed of resonance, {solver}"
            largest, middle = found[0].max(), exact["middle"].max()
            rows.add(f"largest deflection of the middle {at}", middle, largest, "m", 5e-4)
            quantities = [f"largest difference over the peak, {where}, {at}" for where in exact]
            away = [apart(v, reference) for v, reference in zip(found, exact.values(), strict=True)]
            rows.add(quantities, 0.0, away, "-", 1e-3)


def series(x: float, time: Array, speed: float, count: int = 200) -> Array:
    """Deflection at a point along the force while the force is on the beam, shape of `time` [m]."""
    n = np.arange(1, count + 1, dtype=np.float64)
    omega, drive = _omega(n), n * np.pi * speed / LENGTH
    t = time[:, None]
    resonant = np.abs(drive / omega - 1.0) < 1e-9
    apart_by = np.where(resonant, 1.0, omega**2 - drive**2)
    driven = (np.sin(drive * t) - drive / omega * np.sin(omega * t)) / apart_by
    grown = (np.sin(omega * t) - omega * t * np.cos(omega * t)) / (2.0 * omega**2)
    mass = CONCRETE.rho * DEPTH**2 * LENGTH
    terms = np.sin(n * np.pi * x / LENGTH) * np.where(resonant, grown, driven)
    return np.asarray(2.0 * FORCE / mass * terms.sum(axis=1))


def nodal_forces(x: Array, at: Array) -> Array:
    """Forces on nodes x of quadratic elements of a unit force at places (n_t,): (n_t, n)."""
    length = x[2] - x[0]
    element = np.clip((at / length).astype(int), 0, len(x) // 2 - 1)
    s = 2.0 * (at / length - element) - 1.0
    forces = np.zeros((len(at), len(x)))
    shapes = np.column_stack([0.5 * s * (s - 1.0), 1.0 - s**2, 0.5 * s * (s + 1.0)])
    np.put_along_axis(forces, 2 * element[:, None] + np.arange(3), shapes, axis=1)
    return forces


def _omega(n: Array | float) -> Array:
    """Frequencies of Euler's beam [rad/s]."""
    stiffness = CONCRETE.E * DEPTH**4 / 12.0
    return np.asarray((n * np.pi / LENGTH) ** 2 * np.sqrt(stiffness / (CONCRETE.rho * DEPTH**2)))
