"""The pinched cylinder between diaphragms, by two forces and by a smooth pressure."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.building.section import Material
from impactfem.building.shell_model import RX, RY, RZ, UX, UY, UZ, ShellModel, Shells, shell_model
from impactfem.verify.row import Row, order_at_least
from impactfem.verify.shells.cylinder import Cylinder, wave
from impactfem.verify.shells.shell_meshes import panel

Array = NDArray[np.float64]

NAME = "pinched cylinder"
STEEL = Material(E=3e6, nu=0.3, rho=1.0)
CYLINDER = Cylinder(STEEL, thickness=3.0, radius=300.0, length=600.0, span=0.5 * np.pi)
WAVES = 2
CELLS = (8, 16, 32)


def pinched_cylinder() -> list[Row]:
    """Displacement under two opposite unit forces, on an octant (units of the source).

    The reference is a Fourier series without shear strains. Under a point force the displacement
    of a shear-flexible shell has no limit: each halving of the elements adds about
    ln 2 / (2 π κ G t), 0.2 %; hence 2 %. The pressure sin(π x / L) cos 2φ has none of this. Its
    work's order is 2 at least, that of flat facets, and above it while the elements' own error, of
    fourth order, counts.
    """
    return [_under_force(CELLS[-1]), *_under_pressure()]


def pinched_cylinder_fine() -> list[Row]:
    """The forces on 64 cells a side."""
    return [_under_force(2 * CELLS[-1])]


def _under_force(cells: int) -> Row:
    model = _octant(cells)
    load = np.zeros(model.K.shape[0])
    top = 6 * int(np.argmax(model.nodes[:, 2] + model.nodes[:, 0]))
    load[top + UZ] = -0.25
    return Row(
        NAME,
        f"displacement under the force, {cells} cells a side",
        1.8248e-5,
        -float(_displacement(model, load)[top + UZ]),
        "in",
        0.02,
        "Lindberg, Olson and Cowper 1969; MacNeal and Harder 1985",
    )


def _under_pressure() -> list[Row]:
    even, odd = wave(WAVES)
    *_, work = CYLINDER.term(1, even, odd, lambda phi: (0.0 * phi, even(phi)[0][:, 0]))
    exact = work * 0.25 * CYLINDER.length  # ∫ sin² over half the length
    found = np.array([_work_of_pressure(cells) for cells in CELLS])
    source = "shear-flexible shell, closed form for one wave"
    return [
        Row(
            NAME,
            f"work of a smooth pressure, {CELLS[-1]} cells a side",
            exact,
            float(found[-1]),
            "in lbf",
            1e-3,
            source,
        ),
        order_at_least(
            NAME,
            "the work",
            2.0,
            1.0 / np.array(CELLS),
            np.abs(found - exact),
            "flat facets on a curved surface: 2 at least; quadratic elements: 4",
        ),
    ]


def _work_of_pressure(cells: int) -> float:
    model = _octant(cells)
    x, y, z = model.nodes.T
    phi = np.arctan2(y, z)
    pressure = np.sin(np.pi * x / CYLINDER.length) * np.cos(WAVES * phi)
    field = np.zeros((len(x), 6))
    field[:, UY], field[:, UZ] = pressure * np.sin(phi), pressure * np.cos(phi)
    load = model.M @ field.ravel() / (STEEL.rho * CYLINDER.thickness)
    return float(load @ _displacement(model, load))


def _octant(cells: int) -> ShellModel:
    """From the diaphragm x = 0 to the middle, from the crown φ = 0 to the side."""
    R, half, span = CYLINDER.radius, 0.5 * CYLINDER.length, CYLINDER.span
    nodes, triangles = panel(
        cells, cells, lambda a, b: (half * a, R * np.sin(span * b), R * np.cos(span * b)), 0.15
    )
    return shell_model(nodes, Shells(triangles, CYLINDER.thickness, STEEL))


def _displacement(model: ShellModel, load: Array) -> Array:
    x, y, z = model.nodes.T
    held = model.hold(x == 0.0, UY, UZ, RX).hold(x == 0.5 * CYLINDER.length, UX, RY, RZ)
    held = held.hold(y == 0.0, UY, RX, RZ).hold(z < 1e-9 * CYLINDER.radius, UZ, RX, RY)
    return held.static(load)
