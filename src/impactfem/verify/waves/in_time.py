"""Order and energy in time: a plate under a step of pressure, a strip of a slab under pulses."""

import math

import numpy as np

from impactfem.building.shell_model import RX, RY, RZ, UX, UY, UZ, Shells, shell_model
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.arrays import Array
from impactfem.verify.row import Rows, benchmark, fitted_order
from impactfem.verify.shells import CONCRETE, STEEL, rectangle
from impactfem.verify.waves import BALANCE, KRYLOV, MovingModel, apart, peak, pressures

LENGTH, THICKNESS, PRESSURE = 10.0, 0.05, 100.0  # of the plate [m, m, Pa]
RAYLEIGH = Rayleigh(alpha=0.299, beta=1.339e-3)
CELLS = 20  # cells a side of a quarter of the plate
STEP, END = 1e-3, 0.4
STRIP = (6.0, 1.2, 0.3, 0.6)  # length, width, thickness and size of the elements of the strip [m]
STRIP_RAYLEIGH = Rayleigh(alpha=1.5, beta=1e-3)
"""3.9 % at the first mode, 5 Hz, and 10 % at the second one, 31 Hz."""
COARSE, STRIP_END = 1e-3, 0.2
FINER = (1, 2, 4, 8)  # parts of the coarse step that make the steps


@benchmark("NAFEMS 13T, plate under a step of pressure")
def nafems_13t(rows: Rows) -> None:
    """Deflection of the centre, in full order and by the reduced model, on the same mesh.

    The series of Kirchhoff's plate has, for odd m and n and ω = π² (m² + n²)/a² √(D/(ρ t)),

        w = Σ ± 16 q/(π² m n ρ t) g(t)/ω²,   g = 1 − exp(−ξωt) (cos ω_d t + ξω/ω_d sin ω_d t),

    with ξ = α/(2ω) + βω/2. Its first term alone gives the published 3.523 mm, 0.210 s and
    1.817 mm, all of the series 3.460 mm and 1.774 mm. So both pressures act here: the uniform one,
    and the part of it in the shape of the first mode, 16 q/π² sin(πx/a) sin(πy/a).
    """
    # A quarter of the plate, its corner at a support and the centre at x = y = a/2.
    half = 0.5 * LENGTH
    nodes, triangles = rectangle(half, half, CELLS, CELLS, 0.15)
    model = shell_model(nodes, Shells(triangles, THICKNESS, STEEL))
    x, y = nodes[:, 0], nodes[:, 1]
    model = model.hold(x >= 0.0, UX, UY, RZ).hold(x == 0.0, UZ, RX).hold(y == 0.0, UZ, RY)
    model = model.hold(x == half, RY).hold(y == half, RX)
    shape = np.sin(np.pi * x / LENGTH) * np.sin(np.pi * y / LENGTH)
    pressure = PRESSURE * np.column_stack([16.0 / np.pi**2 * shape, np.ones(len(nodes))])
    pressed = pressures(model, pressure, STEEL.rho * THICKNESS)
    centre = model.rows((x == half) & (y == half), UZ)
    moving = MovingModel(model, pressed, centre)
    time = STEP * np.arange(round(END / STEP) + 1, dtype=np.float64)
    loads = {
        modes: np.tile(parts, (len(time), 1))
        for modes, parts in (("one", [1.0, 0.0]), ("all", [0.0, 1.0]))
    }
    full = {modes: moving.full(load, STEP, RAYLEIGH) for modes, load in loads.items()}
    found = {"full": {m: one.motion["displacement"][:, 0] for m, one in full.items()}}
    basis = moving.reduced(shift=10.0, vectors=40)
    for scheme in ("newmark", "exact"):
        found[f"reduced, {scheme}"] = {
            modes: basis.motion(load, STEP, RAYLEIGH, scheme)["displacement"][:, 0]
            for modes, load in loads.items()
        }
    nafems = "NAFEMS R0016, Selected Benchmarks for Forced Vibration, test 13T"
    one_mode = f"{nafems}: its static value is that of the first mode alone"
    beside = f"{nafems}: with one mode 1.8 % above the series"
    rows.source = "Kirchhoff's plate, double sine series in closed form"
    exact = series(time)
    at, highest = peak(time, exact)
    for label, values in found.items():
        rows.where = label
        at_one, peak_of_one = peak(time, values["one"])
        rows.add("peak, part in the first mode", 3.523e-3, peak_of_one, "m", 2e-3, one_mode)
        rows.add("time of that peak", 0.210, at_one, "s", 3e-3, one_mode)
        at_all, peak_of_all = peak(time, values["all"])
        rows.add("peak", highest, peak_of_all, "m", 2e-3)
        rows.add("time of the peak", at, at_all, "s", 2e-3)
        quantity = "peak of all modes compared with the published one"
        rows.add(quantity, 3.523e-3, peak_of_all, "m", 0.025, beside)
        quantity = f"largest difference up to {END:g} s over the peak"
        rows.add(quantity, 0.0, apart(values["all"], exact), "-", 3e-3)
    rows.where = ""
    one, uniform = moving.static()[0]
    rows.add("static, part in the first mode", 1.817e-3, one, "m", 2e-3, one_mode)
    rows.add("static", series(np.inf), uniform, "m", 2e-3)
    away = apart(found["reduced, newmark"]["all"], found["full"]["all"])
    quantity = "reduced model from the full one, both by Newmark, over the peak"
    rows.add(quantity, 0.0, away, "-", 1e-8, KRYLOV)
    quantity = "residual of the energy identity over the largest energy, full"
    rows.add(quantity, 0.0, full["all"].energy.residual, "-", 1e-9, BALANCE)


def series(time: Array | float, count: int = 60) -> Array:
    """Deflection of the centre by Kirchhoff's plate at times [m]; at infinity the static one."""
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


@benchmark("shell strip in time")
def newmark_order_3d(rows: Rows) -> None:
    """Newmark in full order against the exact integration of the modal equations.

    The loads, a pulse at the free end and one on half of the way, are straight between the times
    of the coarse step, so that all steps have the same loads. The space of 120 vectors holds all
    that these loads move at such steps, to 1e-9: what is left is the error of the time integration.
    """
    moving = _strip()
    basis = moving.reduced(60.0, 120)
    exact = basis.motion(_loads(1), COARSE, STRIP_RAYLEIGH)
    full = {n: moving.full(_loads(n), COARSE / n, STRIP_RAYLEIGH) for n in FINER}
    for name in ("displacement", "velocity", "acceleration"):
        errors = [apart(full[n].motion[name][::n], exact[name]) for n in FINER]
        order = fitted_order(COARSE / np.array(FINER), errors)
        quantity = f"fitted order of the full model's {name} in the step"
        source = "Newmark 1959: second order; exact integration of the same reduced model"
        rows.add(quantity, 2.0, order, "-", 0.03, source, absolute=True)
        newmark = basis.motion(_loads(1), COARSE, STRIP_RAYLEIGH, "newmark")[name]
        quantity = f"{name}, reduced model from the full one, both by Newmark"
        rows.add(quantity, 0.0, apart(newmark, full[1].motion[name]), "-", 1e-9, KRYLOV)
        finest = basis.motion(_loads(8), COARSE / 8, STRIP_RAYLEIGH)[name][::8]
        quantity = f"{name}, exact integration from itself at an eighth of the step"
        source = "exact for loads that are straight between their samples"
        rows.add(quantity, 0.0, apart(exact[name], finest), "-", 1e-9, source)


@benchmark("shell strip in time")
def energy_identity_3d(rows: Rows) -> None:
    """Kinetic, elastic and damped energy against the work of the loads, step by step."""
    moving = _strip()
    energy = moving.full(_loads(1), COARSE, STRIP_RAYLEIGH).energy
    quantity = "residual of the energy identity over the largest energy"
    rows.add(quantity, 0.0, energy.residual, "-", 1e-9, BALANCE)
    whole = (energy.kinetic + energy.elastic + energy.damped)[-1] / energy.input[-1]
    quantity = "energy that is damped away or still there, over the work of the loads"
    rows.add(quantity, 1.0, whole, "-", 1e-9, "balance of energy at the last time")
    much = energy.damped[-1] > 0.1 * energy.input[-1]
    quantity = "damped part of the energy at the end, at least a tenth"
    rows.add(quantity, 1.0, much, "-", 0.0, "the rows above would say nothing of damping without")


def _strip() -> MovingModel:
    length, width, thickness, size = STRIP
    nodes, triangles = rectangle(length, width, round(length / size), round(width / size), 0.2)
    model = shell_model(nodes, Shells(triangles, thickness, CONCRETE))
    x, y = nodes[:, 0], nodes[:, 1]
    edges = (x == length, y == width)
    loads = np.column_stack([model.edge_load(edge, (0.0, 0.0, 1e5)).ravel() for edge in edges])
    tip = model.rows((x == length) & (y == 0.0), UZ)
    return MovingModel(model.hold(x == 0.0), loads, tip)


def _loads(parts: int) -> Array:
    """Two pulses of 50 and 30 ms, straight between the times of the coarse step."""
    coarse = COARSE * np.arange(round(STRIP_END / COARSE) + 1)
    time = COARSE / parts * np.arange(round(STRIP_END / COARSE) * parts + 1)
    phases = [np.clip((coarse - t) / end, 0.0, 1.0) for t, end in ((0.0, 0.05), (0.04, 0.03))]
    pulses = [np.interp(time, coarse, 0.5 - 0.5 * np.cos(2.0 * np.pi * p)) for p in phases]
    return np.column_stack(pulses)
