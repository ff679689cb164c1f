"""A constant force that travels along a simply supported beam."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.building.section import BeamSection, Material
from impactfem.building.shell_model import RX, RZ, UX, UY, UZ, shell_model
from impactfem.dynamics.damping import UNDAMPED
from impactfem.verify.row import Row
from impactfem.verify.shells import straight_beam
from impactfem.verify.waves.shell_motion import MovingModel, apart

Array = NDArray[np.float64]

NAME = "beam under a travelling force"
CONCRETE = Material(E=33e9, nu=0.2, rho=2500.0)
LENGTH, DEPTH, ELEMENTS = 20.0, 0.1, 40
"""A slender beam: its shear and the inertia of its rotation change a frequency by 0.01 % or so."""
FORCE = 10.0
SPEEDS = (0.25, 0.5, 1.0)
"""Speeds of the force over that of resonance, at which it crosses in half of the first period."""
STEPS = 2000
"""Time steps of a crossing."""
SINES, SHIFT, VECTORS = 16, 5.0, 48
"""Of the reduced model: load patterns, frequency of the shift [Hz], fewest vectors."""
SOURCE = "Fryba, Vibration of Solids and Structures under Moving Loads: series for Euler's beam"


def travelling_force() -> list[Row]:
    """Deflection of the middle and of the quarter while the force is on the beam.

    The full model takes the nodal forces of a point force at x = v t: its shape functions, as many
    patterns as nodes. The reduced one takes the force's series, 2P/L Σ sin(nπvt/L) sin(nπx/L), of
    16 patterns in space. Undamped, with ω_n = (nπ/L)² √(E I/(ρ A)) and Ω_n = nπv/L,

        w = 2P/(ρ A L) Σ sin(nπx/L) (sin Ω_n t − Ω_n/ω_n sin ω_n t)/(ω_n² − Ω_n²),

    whose term at Ω_n = ω_n is (sin ω_n t − ω_n t cos ω_n t)/(2 ω_n²).
    """
    moving, waves, x = _beam()
    basis = waves.reduced(SHIFT, VECTORS)
    rows = []
    for ratio in SPEEDS:
        speed = ratio * float(_omega(1.0)) * LENGTH / np.pi
        dt = LENGTH / speed / STEPS
        time = dt * np.arange(STEPS + 1, dtype=np.float64)
        nodal = FORCE * nodal_forces(x, speed * time)[:, 1:-1]
        sines = 2.0 * FORCE / LENGTH * np.sin(np.outer(speed * time, _wave_numbers()))
        exact = series(0.5 * LENGTH, time, speed), series(0.25 * LENGTH, time, speed)
        for solver, found in (
            ("full", moving.full(nodal, dt, UNDAMPED).motion["displacement"]),
            ("reduced", basis.motion(sines, dt, UNDAMPED)["displacement"]),
        ):
            at = f"{ratio:g} of the speed of resonance, {solver}"
            rows.append(
                Row(
                    NAME,
                    f"largest deflection of the middle at {at}",
                    float(exact[0].max()),
                    float(found[:, 0].max()),
                    "m",
                    5e-4,
                    SOURCE,
                )
            )
            for where, values, reference in zip(("middle", "quarter"), found.T, exact, strict=True):
                what = f"largest difference over the peak, {where}, at {at}"
                difference = apart(values, reference)
                rows.append(Row(NAME, what, 0.0, difference, "-", 1e-3, SOURCE, absolute=True))
    return rows


def series(x: float, time: Array, speed: float, count: int = 200) -> Array:
    """Deflection along the force at a point while the force is on the beam, shape of `time` [m].

    Args:
        x: The point [m].
        time: Times [s].
        speed: Speed of the force [m/s].
        count: Terms of the series.
    """
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
    """Forces on the nodes of quadratic elements of a unit force at a point.

    Args:
        x: Nodes, ends and middles in their order, shape (n,) [m].
        at: Where the force is, at each time, shape (n_t,) [m].

    Returns:
        Shape (n_t, n).
    """
    length = x[2] - x[0]
    element = np.clip((at / length).astype(int), 0, len(x) // 2 - 1)
    s = 2.0 * (at / length - element) - 1.0
    forces = np.zeros((len(at), len(x)))
    shapes = 0.5 * s * (s - 1.0), 1.0 - s**2, 0.5 * s * (s + 1.0)
    for k, shape in enumerate(shapes):
        forces[np.arange(len(at)), 2 * element + k] = shape
    return forces


def _omega(n: Array | float) -> Array:
    """Frequencies of Euler's beam [rad/s]."""
    stiffness = CONCRETE.E * DEPTH**4 / 12.0
    return np.asarray((n * np.pi / LENGTH) ** 2 * np.sqrt(stiffness / (CONCRETE.rho * DEPTH**2)))


def _wave_numbers() -> Array:
    """Those of the patterns of the reduced model [rad/m]."""
    return np.pi / LENGTH * np.arange(1.0, SINES + 1.0)


def _beam() -> tuple[MovingModel, MovingModel, Array]:
    """The beam with 1 N on each inner node, with waves of 1 N/m, and where its nodes are."""
    model = shell_model(*straight_beam(LENGTH, ELEMENTS, BeamSection.beam(DEPTH, DEPTH), CONCRETE))
    x = model.nodes[:, 0]
    loads = np.zeros((6 * len(x), len(x) - 2))
    loads[6 * np.arange(1, len(x) - 1) + UZ, np.arange(len(x) - 2)] = 1.0
    down = np.array([int(np.argmin(np.abs(x - share * LENGTH))) for share in (0.5, 0.25)])
    ends = (x == 0.0) | (x == LENGTH)
    model = model.hold(x >= 0.0, UX, UY, RX, RZ).hold(ends, UZ)
    # The mass of the deflections is ρ A ∫N Nᵀ dx: over ρ A it turns a line load into its forces.
    waves = np.zeros((6 * len(x), SINES))
    wave = np.sin(np.outer(x, _wave_numbers()))
    waves[UZ::6] = model.M[UZ::6, UZ::6] @ wave / (CONCRETE.rho * DEPTH**2)
    probes = 6 * down + UZ
    return MovingModel(model, loads, probes), MovingModel(model, waves, probes), x
