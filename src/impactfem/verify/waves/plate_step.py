"""NAFEMS 13T: a thin simply supported plate under a pressure that comes suddenly and stays."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from impactfem.building.shell_model import RX, RY, RZ, UX, UY, UZ, Shells, shell_model
from impactfem.dynamics.damping import Rayleigh
from impactfem.verify.row import Row
from impactfem.verify.shells import STEEL, flat, panel
from impactfem.verify.shells.plates import LENGTH
from impactfem.verify.waves.shell_motion import MovingModel, apart, peak

if TYPE_CHECKING:
    from impactfem.dynamics.history import History

Array = NDArray[np.float64]

NAME = "NAFEMS 13T, plate under a step of pressure"
THICKNESS = 0.05
PRESSURE = 100.0
RAYLEIGH = Rayleigh(alpha=0.299, beta=1.339e-3)
CELLS = 20
"""Cells a side of a quarter of the plate."""
STEP, END = 1e-3, 0.4
SHIFT, VECTORS = 10.0, 40
"""Of the reduced model: frequency of the shift [Hz], fewest vectors for the two loads."""
NAFEMS = "NAFEMS R0016, Selected Benchmarks for Forced Vibration, test 13T"
ONE_MODE = f"{NAFEMS}: its static value is that of the first mode alone"
SERIES = "Kirchhoff's plate, double sine series in closed form"


def step_pressure() -> list[Row]:
    """Deflection of the centre, in full order and by the reduced model, on the same mesh.

    The series of Kirchhoff's plate has, for odd m and n and ω = π² (m² + n²)/a² √(D/(ρ t)),

        w = Σ ± 16 q/(π² m n ρ t) g(t)/ω²,   g = 1 − exp(−ξωt) (cos ω_d t + ξω/ω_d sin ω_d t),

    with ξ = α/(2ω) + βω/2. Its first term alone gives the published 3.523 mm, 0.210 s and
    1.817 mm, all of the series 3.460 mm and 1.774 mm. So both pressures act here: the uniform one,
    and the part of it in the shape of the first mode, 16 q/π² sin(πx/a) sin(πy/a).
    """
    moving = _plate()
    time = STEP * np.arange(round(END / STEP) + 1, dtype=np.float64)
    one, all_of_it = np.zeros((len(time), 2)), np.zeros((len(time), 2))
    one[:, 0] = all_of_it[:, 1] = 1.0
    first, uniform = (moving.full(f, STEP, RAYLEIGH) for f in (one, all_of_it))
    basis = moving.reduced(SHIFT, VECTORS)
    rows = []
    for solver, in_mode, everywhere in (
        ("full", _centre(first), _centre(uniform)),
        *(
            (
                f"reduced, {scheme}",
                basis.motion(one, STEP, RAYLEIGH, scheme)["displacement"][:, 0],
                basis.motion(all_of_it, STEP, RAYLEIGH, scheme)["displacement"][:, 0],
            )
            for scheme in ("newmark", "exact")
        ),
    ):
        rows += _against_published(solver, time, in_mode)
        rows += _against_series(solver, time, everywhere)
    static = moving.static()[0]
    rows += [
        Row(NAME, "static, part in the first mode", 1.817e-3, static[0], "m", 2e-3, ONE_MODE),
        Row(NAME, "static", float(series(np.inf)), static[1], "m", 2e-3, SERIES),
    ]
    newmark = basis.motion(all_of_it, STEP, RAYLEIGH, "newmark")["displacement"][:, 0]
    return [
        *rows,
        Row(
            NAME,
            "reduced model from the full one, both by Newmark, over the peak",
            0.0,
            apart(newmark, _centre(uniform)),
            "-",
            1e-8,
            "the same equations in a Krylov space",
            absolute=True,
        ),
        Row(
            NAME,
            "residual of the energy identity over the largest energy, full",
            0.0,
            uniform.energy.residual,
            "-",
            1e-9,
            "average acceleration conserves the discrete balance (Hughes 1983)",
            absolute=True,
        ),
    ]


def series(time: Array | float, count: int = 60) -> Array:
    """Deflection of the centre by Kirchhoff's plate [m]; at infinity the static one.

    Args:
        time: Times, any shape [s].
        count: Odd waves m and n that are taken each.
    """
    a, rho_t = LENGTH, STEEL.rho * THICKNESS
    D = STEEL.E * THICKNESS**3 / (12.0 * (1.0 - STEEL.nu**2))
    t = np.asarray(time, dtype=np.float64)
    odd = 2.0 * np.arange(count) + 1.0
    m, n = (w.ravel() for w in np.meshgrid(odd, odd))
    sign = np.where((m + n) % 4.0 == 2.0, 1.0, -1.0)  # sin(mπ/2) sin(nπ/2)
    omega = (np.pi / a) ** 2 * (m**2 + n**2) * math.sqrt(D / rho_t)
    static = sign * 16.0 * PRESSURE / (np.pi**2 * m * n * rho_t * omega**2)
    if np.isposinf(t).all():
        return np.asarray(static.sum())
    # The roots are complex below critical damping, real above it.
    half = 0.5 * (RAYLEIGH.alpha + RAYLEIGH.beta * omega**2)
    spread = np.sqrt((half**2 - omega**2).astype(complex))
    slow = -(omega**2) / (half + spread)
    fast = -half - spread
    g = 1.0 + (
        fast * np.exp(np.multiply.outer(t, slow)) - slow * np.exp(np.multiply.outer(t, fast))
    ) / (slow - fast)
    return np.asarray(g.real @ static)


def _against_published(solver: str, time: Array, values: Array) -> list[Row]:
    at, highest = peak(time, values)
    return [
        Row(
            NAME, f"peak, part in the first mode, {solver}", 3.523e-3, highest, "m", 2e-3, ONE_MODE
        ),
        Row(NAME, f"time of that peak, {solver}", 0.210, at, "s", 3e-3, ONE_MODE),
    ]


def _against_series(solver: str, time: Array, values: Array) -> list[Row]:
    exact = series(time)
    at, highest = peak(time, exact)
    at_found, found = peak(time, values)
    return [
        Row(NAME, f"peak, {solver}", highest, found, "m", 2e-3, SERIES),
        Row(NAME, f"time of the peak, {solver}", at, at_found, "s", 2e-3, SERIES),
        Row(
            NAME,
            f"peak of all modes beside the published one, {solver}",
            3.523e-3,
            found,
            "m",
            0.025,
            f"{NAFEMS}: with one mode 1.8 % above the series",
        ),
        Row(
            NAME,
            f"largest difference up to {END:g} s over the peak, {solver}",
            0.0,
            apart(values, exact),
            "-",
            3e-3,
            SERIES,
            absolute=True,
        ),
    ]


def _plate() -> MovingModel:
    """A quarter of the plate, its corner at a support and the centre at x = y = a/2."""
    half = 0.5 * LENGTH
    nodes, triangles = panel(CELLS, CELLS, flat((half, 0.0, 0.0), (0.0, half, 0.0)), 0.15)
    model = shell_model(nodes, Shells(triangles, THICKNESS, STEEL))
    x, y = nodes[:, 0], nodes[:, 1]
    model = model.hold(x >= 0.0, UX, UY, RZ).hold(x == 0.0, UZ, RX).hold(y == 0.0, UZ, RY)
    model = model.hold(x == half, RY).hold(y == half, RX)
    shape = np.sin(np.pi * x / LENGTH) * np.sin(np.pi * y / LENGTH)
    pressure = PRESSURE * np.column_stack([16.0 / np.pi**2 * shape, np.ones(len(nodes))])
    # The mass of the deflections is ρ t ∫N Nᵀ dA: over ρ t it turns a pressure into its forces.
    loads = np.zeros((6 * len(nodes), 2))
    loads[UZ::6] = model.M[UZ::6, UZ::6] @ pressure / (STEEL.rho * THICKNESS)
    centre = model.rows((x == half) & (y == half), UZ)
    return MovingModel(model, loads, centre)


def _centre(history: History) -> Array:
    return history.motion["displacement"][:, 0]
