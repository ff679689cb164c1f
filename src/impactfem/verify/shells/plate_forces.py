"""Section forces of plates against closed forms: bent by a pressure, stretched in their plane."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.quality import areas
from impactfem.building.shell_model import RX, RY, RZ, UX, UY, UZ, Shells, shell_model
from impactfem.verify.row import Row, order_at_least
from impactfem.verify.shells.shell_meshes import flat, panel
from impactfem.verify.shells.thin_shells import STEEL, UNIT_PRESSURE

Array = NDArray[np.float64]

RATIOS = (0.1, 0.01, 0.001)
"""Thickness over length."""
CELLS = (8, 16, 32)
NAVIER = "double sine series (Navier); of Mindlin's plate, too, on hard supports"
PLACES = np.array([[0.5, 0.5, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.0]])
"""Centre, middle of an edge, corner of a plate of 1 m by 1 m."""


def supported_plate() -> list[Row]:
    """A unit pressure on a square plate of 1 m on hard simple supports.

    Moments are of the order 2 and the shear of the order 1 at least, over the centres of the
    elements and whatever the thickness.
    """
    rows = []
    for t in RATIOS:
        errors = []
        for cells in CELLS:
            nodes, triangles = panel(cells, cells, flat((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), 0.15)
            model = shell_model(nodes, Shells(triangles, t, STEEL))
            x, y, _ = nodes.T
            held = (
                model.hold(x >= 0.0, UX, UY, RZ)
                .hold((x == 0.0) | (x == 1.0), UZ, RX)
                .hold((y == 0.0) | (y == 1.0), UZ, RY)
            )
            field = model.section_forces(held.static(model.area_load(UNIT_PRESSURE)))
            centres = field.centres()
            exact = series(nodes[triangles[:, :3]].mean(axis=1))
            found = np.hstack([centres.moment, centres.shear])
            weights = areas(nodes, triangles)
            away, size = (weights @ a**2 for a in (found - exact, exact))
            errors.append(
                np.sqrt([away[:3].sum() / size[:3].sum(), away[3:].sum() / size[3:].sum()])
            )
        name = f"simply supported plate, t/L = {t:g}"
        at = field.at(PLACES)
        wanted = series(PLACES)
        rows += [
            Row(name, f"{quantity}, {CELLS[-1]} cells a side", float(reference), float(computed),
                "q L²" if quantity[0] == "M" else "q L", allowed, NAVIER)
            for quantity, reference, computed, allowed in (
                ("M11 at the centre", wanted[0, 0], at.moment[0, 0], 3e-3),
                ("M12 in the corner", wanted[2, 2], at.moment[2, 2], 1e-2),
                ("Q1 in the middle of an edge", wanted[1, 3], at.shear[1, 0], 0.03),
            )
        ]  # fmt: skip
        sizes = 1.0 / np.array(CELLS)
        rows += [
            order_at_least(
                name, f"{quantity} at the elements' centres", least, sizes, error, source, 0.2
            )
            for quantity, least, error, source in zip(
                ("the moments", "the shear"),
                (2.0, 1.0),
                np.transpose(errors),
                ("strains of quadratic elements", "derivatives of moments of the order 2"),
                strict=True,
            )
        ]
    return rows


def bent_in_plane() -> list[Row]:
    """Pure bending in the plane, N11 = y: quadratic displacements, which the element holds."""
    t, E, nu = 0.2, STEEL.E, STEEL.nu
    nodes, triangles = panel(4, 3, flat((3.0, 0.0, 0.0), (0.0, 2.0, 0.0)), 0.3)
    model = shell_model(nodes, Shells(triangles, t, STEEL))
    x, y, _ = nodes.T
    exact = np.zeros((len(nodes), 6))
    exact[:, UX] = x * y / (E * t)
    exact[:, UY] = -0.5 * (x**2 + nu * y**2) / (E * t)
    exact[:, RZ] = -x / (E * t)
    edge = (np.minimum(x, 3.0 - x) < 1e-9) | (np.minimum(y, 2.0 - y) < 1e-9)
    field = model.section_forces(model.prescribed(exact.ravel(), model.rows(edge)))
    wanted = np.zeros((*field.values.shape[:2], 3))
    wanted[..., 0] = y[triangles]
    away = np.abs(field.values[..., :3] - wanted).max()
    return [
        Row(
            "plate bent in its plane",
            "largest error of N at the nodes of the elements, over the largest N",
            0.0,
            float(away / np.abs(wanted).max()),
            "-",
            1e-9,
            "closed form; quadratic elements hold it",
            absolute=True,
        )
    ]


def series(points: Array, count: int = 200) -> Array:
    """M11, M22, M12, Q1, Q2 of Navier's plate of 1 m under a unit pressure, shape (n, 5).

    With w ~ Σ q_mn / (D k⁴) sin(m π x) sin(n π y), q_mn = 16 / (π² m n), k² = π² (m² + n²), odd m
    and n. Positive moments stretch the side of the pressure's direction: those of a pressure along
    the normal are positive where the plate arches towards it.
    """
    nu = STEEL.nu
    odd = 2.0 * np.arange(count) + 1.0
    a, b = np.pi * odd[:, None], np.pi * odd[None]
    load = 16.0 / (np.pi**2 * np.outer(odd, odd))
    k2 = a**2 + b**2
    x, y = (np.outer(p, np.pi * odd) for p in np.asarray(points, dtype=np.float64).T[:2])
    sx, cx, sy, cy = np.sin(x), np.cos(x), np.sin(y), np.cos(y)
    w = load / k2**2

    def total(terms: Any, along_x: Array, along_y: Array) -> Array:
        return np.asarray(np.einsum("pm,mn,pn->p", along_x, terms, along_y, optimize=True))

    return np.column_stack(
        [
            total(w * (a**2 + nu * b**2), sx, sy),
            total(w * (b**2 + nu * a**2), sx, sy),
            -(1.0 - nu) * total(w * a * b, cx, cy),
            total(load / k2 * a, cx, sy),
            total(load / k2 * b, sx, cy),
        ]
    )
