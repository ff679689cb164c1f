"""Inertias of the floors of a mesh and sections of its storeys, as a floor table has them."""

from __future__ import annotations

import itertools

import numpy as np

from impactfem.building.mesh import areas, line_lengths
from impactfem.building.parts import BuildingParts, FloorMasses, lever_rule
from impactfem.system.arrays import Array

UNITS = {"mass": "kg", "Jx": "kg m2", "Jy": "kg m2", "Jz": "kg m2"}
UNITS |= {"A": "m2", "Avy": "m2", "Avx": "m2", "Ix": "m4", "Iy": "m4"}
"""Columns of a floor table that a mesh has, with their SI units."""
CUTS = 12
"""Heights in a storey at which it is cut, evenly apart: no opening of a tenth of it is missed."""


def floor_properties(parts: BuildingParts, masses: FloorMasses) -> dict[str, Array]:
    """The columns of `UNITS` of a floor table, shape (n_floors,) each.

    Of a floor: its mass [kg], with that of walls and columns by the lever rule, and the inertias of
    a plane floor about its centre of mass [kg m2]: J_x = Σ m y², J_y = Σ m x², J_z = J_x + J_y. In
    addition `ex` and `ey`, how far the centre of mass is from the node of the floor [m].

    Of the storey below it: the section of walls and columns where openings leave the least area,
    A [m2] and I_x = Σ ∫ y² dA, I_y about its centroid [m4]. A wall at an angle α to y counts with
    A cos² α in the shear area A_vy along y and with the rest in A_vx along x [m2], a column with
    its gross shear areas (`BeamSection.in_plan`).
    """
    mesh, n = parts.mesh, len(parts.mesh.floors)
    centre = mesh.nodes[[mesh.centres[k] for k in mesh.floors]]
    # Moments about the node of each floor. The middles of the sides integrate a quadratic over a
    # triangle, ends and middle in the ratio 1 : 1 : 4 over a line.
    rho = np.array([m.rho for m in parts.materials.shells])
    on_area = rho[mesh.triangle_part] * parts.thickness()
    area = areas(mesh.nodes, mesh.triangles)
    first, second = np.zeros((2, n)), np.zeros((2, n))
    corners, sides = mesh.triangles[:, :3], mesh.triangles[:, 3:]
    thirds = np.full(3, 1.0 / 3.0)
    cells = [(mesh.shell_parts, mesh.triangle_part, corners, sides, on_area * area, thirds)]
    if len(mesh.lines):
        sections = zip(parts.materials.beams, parts.sections.beams, strict=True)
        on_line = np.array([m.rho * s.A for m, s in sections])[mesh.line_part]
        weights = np.array([1.0, 1.0, 4.0]) / 6.0
        both = (mesh.beam_parts, mesh.line_part, mesh.lines[:, :2], mesh.lines)
        cells.append((*both, on_line * line_lengths(mesh), weights))
    for of, part, corners, points, mass, weights in cells:
        level, upper = lever_rule(mesh, of, part, corners)
        for floor, share in ((level, upper), (level - 1, 1.0 - upper)):
            own = floor > 0  # what belongs to the base does not move
            away = mesh.nodes[points[own], :2] - centre[floor[own] - 1, None, :2]
            for moments, power in ((first, 1), (second, 2)):
                of_cell = np.einsum("cqi,q,c->ic", away**power, weights, (mass * share)[own])
                moments += [np.bincount(floor[own] - 1, one, n) for one in of_cell]
    # Added mass lies on the slabs alone.
    for k in mesh.floors:
        slab = mesh.slab(k)
        away = mesh.nodes[mesh.triangles[slab, 3:], :2] - centre[k - 1, :2]
        third = parts.added_mass[slab] * area[slab] / 3.0
        first[:, k - 1] += np.einsum("cqi,c->i", away, third)
        second[:, k - 1] += np.einsum("cqi,c->i", away**2, third)
    e = first / masses.floors
    jy, jx = second - masses.floors * e**2
    found = {"mass": masses.floors, "Jx": jx, "Jy": jy, "Jz": jx + jy, "ex": e[0], "ey": e[1]}
    levels = [float(mesh.nodes[mesh.base, 2].min()), *mesh.elevations.values()]
    # Just off even parts: a plane through a row of nodes would cut a triangle in one point.
    shares = (np.arange(CUTS) + 0.5000001) / CUTS
    storeys = []
    for k, (low, high) in enumerate(itertools.pairwise(levels), start=1):
        cuts = [_cut(parts, k, low + share * (high - low)) for share in shares]
        # Rounding must not choose between cuts that are equal but for it.
        storeys.append(min(cuts, key=lambda section: round(section[0], 9)))
    return found | dict(zip(("A", "Avy", "Avx", "Ix", "Iy"), np.array(storeys).T, strict=True))


def _cut(parts: BuildingParts, level: int, height: float) -> tuple[float, ...]:
    """A, Avy, Avx, Ix and Iy of a storey at a height [m]."""
    mesh = parts.mesh
    own = mesh.triangles_of("storey", level)
    corners = mesh.nodes[mesh.triangles[own, :3]]
    above = corners[..., 2] - height
    cut = (above.max(axis=1) > 0.0) & (above.min(axis=1) < 0.0)
    corners, above, thickness = corners[cut], above[cut], parts.thickness()[own[cut]]
    # The corner that is alone on its side of the plane; the cut joins the sides that leave it.
    single = (above > 0.0).sum(axis=1) == 1
    alone = np.where(single, np.argmax(above, axis=1), np.argmin(above, axis=1))
    rows = np.arange(len(alone))
    ends = []
    for step in (1, 2):
        other = (alone + step) % 3
        share = above[rows, alone] / (above[rows, alone] - above[rows, other])
        a, b = corners[rows, alone], corners[rows, other]
        ends.append((a + share[:, None] * (b - a))[:, :2])
    p, q = ends
    length = np.linalg.norm(q - p, axis=1)
    A = thickness * length
    cosine = np.abs(q - p) / np.maximum(length, 1e-300)[:, None]
    middle, second = 0.5 * (p + q), A[:, None] * (q - p) ** 2 / 12.0
    lines = mesh.lines_of("column", level)
    z = mesh.nodes[mesh.lines[lines, :2], 2] - height
    lines = lines[z[:, 0] * z[:, 1] < 0.0]
    sections = [parts.sections.beams[k] for k in mesh.line_part[lines]]
    every = np.append(A, [s.A for s in sections])
    places = np.vstack([middle, mesh.nodes[mesh.lines[lines, 2], :2]])
    in_plan = np.array([s.in_plan() for s in sections]).reshape(-1, 4)
    inertias = np.vstack([second, in_plan[:, :1:-1]])
    if not every.size:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    away = places - every @ places / every.sum()
    iy, ix = (inertias + every[:, None] * away**2).sum(axis=0)
    avz, avy = A @ cosine**2 + in_plan[:, :2].sum(axis=0)
    return float(every.sum()), float(avy), float(avz), float(ix), float(iy)
