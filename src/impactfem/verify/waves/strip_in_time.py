"""The time integration of the 3D model on a cantilever strip of a slab: order and energy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.building.section import Material
from impactfem.building.shell_model import UZ, Shells, shell_model
from impactfem.dynamics.damping import Rayleigh
from impactfem.verify.row import Row, fitted_order
from impactfem.verify.shells import flat, panel
from impactfem.verify.waves.shell_motion import MovingModel, apart

Array = NDArray[np.float64]

NAME = "shell strip in time"
CONCRETE = Material(E=33e9, nu=0.2, rho=2500.0)
LENGTH, WIDTH, THICKNESS, SIZE = 6.0, 1.2, 0.3, 0.6
RAYLEIGH = Rayleigh(alpha=1.5, beta=1e-3)
"""3.9 % at the first mode, 5 Hz, and 10 % at the second one, 31 Hz."""
COARSE, END = 1e-3, 0.2
FINER = (1, 2, 4, 8)
"""Parts of the coarse step that make the steps."""
SHIFT, VECTORS = 60.0, 120
SOURCE = "Newmark 1959: second order; exact integration of the same reduced model"


def order() -> list[Row]:
    """Newmark in full order against the exact integration of the modal equations.

    The loads, a pulse at the free end and one on half of the way, are straight between the times
    of the coarse step, so that all steps have the same loads. The space of 120 vectors holds all
    that these loads move at such steps, to 1e-9: what is left is the error of the time integration.
    """
    moving = _strip()
    basis = moving.reduced(SHIFT, VECTORS)
    exact = basis.motion(_loads(1), COARSE, RAYLEIGH)
    full = {n: moving.full(_loads(n), COARSE / n, RAYLEIGH) for n in FINER}
    rows = []
    for name in ("displacement", "velocity", "acceleration"):
        errors = [apart(full[n].motion[name][::n], exact[name]) for n in FINER]
        steps = COARSE / np.array(FINER)
        what = f"fitted order of the full model's {name} in the step"
        rows.append(
            Row(NAME, what, 2.0, fitted_order(steps, np.array(errors)), "-", 0.03, SOURCE, True)
        )
        newmark = basis.motion(_loads(1), COARSE, RAYLEIGH, "newmark")[name]
        what = f"{name}, reduced model from the full one, both by Newmark"
        difference = apart(newmark, full[1].motion[name])
        source = "the same equations in a Krylov space"
        rows.append(Row(NAME, what, 0.0, difference, "-", 1e-9, source, True))
        finest = basis.motion(_loads(8), COARSE / 8, RAYLEIGH)[name][::8]
        what = f"{name}, exact integration from itself at an eighth of the step"
        source = "exact for loads that are straight between their samples"
        rows.append(Row(NAME, what, 0.0, apart(exact[name], finest), "-", 1e-9, source, True))
    return rows


def energy_identity() -> list[Row]:
    """Kinetic, elastic and damped energy against the work of the loads, step by step."""
    moving = _strip()
    energy = moving.full(_loads(1), COARSE, RAYLEIGH).energy
    return [
        Row(
            NAME,
            "residual of the energy identity over the largest energy",
            0.0,
            energy.residual,
            "-",
            1e-9,
            "average acceleration conserves the discrete balance (Hughes 1983)",
            absolute=True,
        ),
        Row(
            NAME,
            "energy that is damped away or still there, over the work of the loads",
            1.0,
            float((energy.kinetic + energy.elastic + energy.damped)[-1] / energy.input[-1]),
            "-",
            1e-9,
            "balance of energy at the last time",
        ),
        Row(
            NAME,
            "damped part of the energy at the end, at least a tenth",
            1.0,
            float(energy.damped[-1] > 0.1 * energy.input[-1]),
            "-",
            0.0,
            "the rows above would say nothing of damping without",
        ),
    ]


def _strip() -> MovingModel:
    place = flat((LENGTH, 0.0, 0.0), (0.0, WIDTH, 0.0))
    nodes, triangles = panel(round(LENGTH / SIZE), round(WIDTH / SIZE), place, 0.2)
    model = shell_model(nodes, Shells(triangles, THICKNESS, CONCRETE))
    x, y = nodes[:, 0], nodes[:, 1]
    loads = np.zeros((6 * len(nodes), 2))
    loads[:, 0] = model.edge_load(x == LENGTH, (0.0, 0.0, 1e5)).ravel()
    loads[:, 1] = model.edge_load(y == WIDTH, (0.0, 0.0, 1e5)).ravel()
    tip = model.rows((x == LENGTH) & (y == 0.0), UZ)
    return MovingModel(model.hold(x == 0.0), loads, tip)


def _loads(parts: int) -> Array:
    """Two pulses of 50 and 30 ms, straight between the times of the coarse step."""
    coarse = COARSE * np.arange(round(END / COARSE) + 1)
    time = COARSE / parts * np.arange(round(END / COARSE) * parts + 1)
    pulses = []
    for start, length in ((0.0, 0.05), (0.04, 0.03)):
        phase = np.clip((coarse - start) / length, 0.0, 1.0)
        pulses.append(np.interp(time, coarse, 0.5 - 0.5 * np.cos(2.0 * np.pi * phase)))
    return np.column_stack(pulses)
