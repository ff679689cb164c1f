"""Thin shells: clamped plates on irregular meshes, a hyperbolic paraboloid and a twisted strip."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.building.raw_mesh import gmsh_session
from impactfem.building.section import Material
from impactfem.building.shell_model import RX, RZ, UX, UY, UZ, Shells, line_load, shell_model
from impactfem.system.own_process import in_own_process
from impactfem.verify.row import Row
from impactfem.verify.shells.shell_meshes import Map, lines_at, panel, quadratic

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

STEEL = Material(E=200e9, nu=0.3, rho=8000.0)
UNIT_PRESSURE = (0.0, 0.0, 1.0)
CLAMPED = {0.1: 1.505e-3, 0.01: 1.268e-3, 1e-3: 1.26532e-3, 1e-4: 1.26532e-3}
"""Deflection of the centre of clamped square plates over q L⁴ / D, by t/L, for ν = 0.3, κ = 5/6."""
EDGE_MOMENT, CENTRE_MOMENT = 0.0513, 0.0229
"""Of the thin plate, over q L²."""
MINDLIN = "clamped plate of Mindlin, four digits (Ayad and Rigolot 2002)"
KIRCHHOFF = "clamped plate of Kirchhoff (Taylor and Govindjee 2004)"
HYPAR = {1e-2: (9.3355e-5, 1.6790e-3), 1e-3: (6.3941e-3, 1.1013e-2)}
"""Deflection of the middle of the free edge [m] and strain energy [N m], by t/L."""
TWISTED = {0.32: (1.0, 5.424e-3, 1.754e-3), 0.0032: (1e-6, 5.256e-3, 1.294e-3)}
"""By thickness: the force, and the tip's displacement along it where it acts along the tip's width
(in plane) and across it (out of plane)."""


def clamped_plates(cells: int = 16) -> list[Row]:
    """Square plates under uniform pressure on triangles of gmsh, from thick to very thin.

    Shear that is not reduced enough, or not stabilised, makes the thin ones too stiff: irregular
    meshes show it, plates on simple supports do not.
    """
    nodes, triangles = quadratic(*in_own_process(_square, cells))
    x, y, _ = nodes.T
    edge = np.minimum(np.minimum(x, 1.0 - x), np.minimum(y, 1.0 - y)) < 1e-9
    rows = []
    for t, reference in CLAMPED.items():
        model = shell_model(nodes, Shells(triangles, t, STEEL))
        held = model.hold(edge).hold(x >= 0.0, UX, UY, RZ)
        moved = held.static(model.area_load(UNIT_PRESSURE))
        rigidity = STEEL.E * t**3 / (12.0 * (1.0 - STEEL.nu**2))
        deflection = rigidity * float(moved[_nearest(nodes, (0.5, 0.5, 0.0)), UZ])
        theory = MINDLIN if t > 2e-3 else KIRCHHOFF
        found = [("deflection of the centre", reference, deflection, "q L⁴/D", 1e-3, theory)]
        if t < 2e-3:
            field = model.section_forces(moved)
            middle, centre = field.at(np.array([[0.0, 0.5, 0.0], [0.5, 0.5, 0.0]])).moment[:, 0]
            found += [
                ("M11 in the middle of an edge", -EDGE_MOMENT, middle, "q L²", 0.02, KIRCHHOFF),
                ("M11 at the centre", CENTRE_MOMENT, centre, "q L²", 0.02, KIRCHHOFF),
            ]
        rows += [
            Row(
                f"clamped plate, t/L = {t:g}",
                f"{quantity}, {cells} elements of gmsh a side",
                wanted,
                float(computed),
                unit,
                allowed,
                source,
            )
            for quantity, wanted, computed, unit, allowed, source in found
        ]
    return rows


def hyperbolic_paraboloid(
    thickness: tuple[float, ...] = (1e-2,), cells: int = 16, allowed: float = 0.01
) -> list[Row]:
    """The surface z = x² − y², |x|, |y| < 1/2 m, clamped at x = −1/2 m, under a weight of 8 kN/m3.

    Bent without stretching, the hardest for elements of flat facets: with elements of the size h
    on a radius R they are too stiff by 1 % at h²/(R t) = 0.5 and by 13 % at 2, whatever the shear.
    Half of the surface is computed.
    """
    rows = []
    for t in thickness:
        deflection, energy = HYPAR[t]
        nodes, triangles = panel(
            2 * cells,
            cells,
            lambda a, b: (a - 0.5, 0.5 * b, (a - 0.5) ** 2 - (0.5 * b) ** 2),
            0.15,
        )
        model = shell_model(nodes, Shells(triangles, t, STEEL))
        load = model.area_load((0.0, 0.0, -8000.0 * t))
        x, y, _ = nodes.T
        moved = model.hold(x < 1e-9 - 0.5).hold(y < 1e-9, UY, RX, RZ).static(load)
        tip = float(moved[_nearest(nodes, (0.5, 0.0, 0.25)), UZ])
        source = "Bathe, Iosilevich and Chapelle 2000, fine mesh of MITC16"
        rows += [
            Row(
                f"hyperbolic paraboloid, t/L = {t:g}",
                f"{quantity}, {cells} elements on half an edge",
                reference,
                computed,
                unit,
                allowed,
                source,
            )
            for quantity, reference, computed, unit in (
                ("deflection of the free edge's middle", deflection, -tip, "m"),
                ("strain energy of both halves", energy, float((load * moved).sum()), "N m"),
            )
        ]
    return rows


def hyperbolic_paraboloid_fine() -> list[Row]:
    """Thinner by ten, on elements of a quarter of the size."""
    return hyperbolic_paraboloid((1e-3,), 64, 5e-3)


def twisted_strip(
    thickness: tuple[float, ...] = (0.32,), cells: int = 4, allowed: float = 2e-3
) -> list[Row]:
    """A strip of 12 by 1.1 that turns by 90° about its middle line, clamped, a force at its tip."""
    length, width, material = 12.0, 1.1, Material(E=29e6, nu=0.22, rho=1.0)
    rows = []
    for t in thickness:
        nodes, triangles = panel(6 * cells, cells, _twisted(length, width), 0.15)
        model = shell_model(nodes, Shells(triangles, t, material))
        at_tip = np.abs(nodes[:, 0] - length) < 1e-9
        spread = line_load(nodes, lines_at(triangles, at_tip))
        force, *references = TWISTED[t]
        for reference, component, direction in zip(
            references, (UZ, UY), ("in plane", "out of plane"), strict=True
        ):
            load = np.zeros((len(nodes), 6))
            load[:, component] = force * spread
            moved = model.hold(nodes[:, 0] < 1e-9).static(load)
            found = moved[_nearest(nodes, (length, 0.0, 0.0)), component]
            rows.append(
                Row(
                    f"twisted strip, t = {t:g}",
                    f"tip displacement, force {direction}, {cells} elements across",
                    reference,
                    float(found),
                    "in",
                    allowed,
                    "MacNeal and Harder 1985" if t > 0.1 else "Belytschko, Wong and Stolarski 1989",
                )
            )
    return rows


def twisted_strip_fine() -> list[Row]:
    """A hundredth as thick: bent without stretching, on elements of a quarter of the size."""
    return twisted_strip((0.0032,), 16, 0.02)


def _twisted(length: float, width: float) -> Map:
    def place(a: Array, b: Array) -> tuple[Array, Array, Array]:
        turn, across = 0.5 * np.pi * a, width * (b - 0.5)
        return length * a, across * np.cos(turn), across * np.sin(turn)

    return place


def _nearest(nodes: Array, point: tuple[float, float, float]) -> int:
    return int(np.argmin(np.linalg.norm(nodes - point, axis=1)))


def _square(cells: int) -> tuple[Array, Ints]:
    """Vertices and triangles of the unit square by gmsh, with a vertex at its centre."""
    with gmsh_session() as gmsh:
        occ = gmsh.model.occ
        square, centre = occ.addRectangle(0.0, 0.0, 0.0, 1.0, 1.0), occ.addPoint(0.5, 0.5, 0.0)
        occ.synchronize()
        gmsh.model.mesh.embed(0, [centre], 2, square)
        for limit in ("Min", "Max"):
            gmsh.option.setNumber(f"Mesh.MeshSize{limit}", 1.0 / cells)
        gmsh.model.mesh.generate(2)
        tags, places, _ = gmsh.model.mesh.getNodes()
        _, corners = gmsh.model.mesh.getElementsByType(2)
    used, triangles = np.unique(corners, return_inverse=True)
    order = np.argsort(tags)
    vertices = np.reshape(places, (-1, 3))[order[np.searchsorted(tags, used, sorter=order)]]
    return vertices, triangles.reshape(-1, 3).astype(np.int64)
