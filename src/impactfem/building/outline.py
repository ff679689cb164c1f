"""Plans of the floors of a mesh: the corners of their slabs, from the axis of the stick."""

import numpy as np

from impactfem.building.mesh import BuildingMesh, areas, rim
from impactfem.case.buildings import Building
from impactfem.case.facade import ALIGNED, Point, axis_in_plan
from impactfem.case.plan import Polygon, area, counterclockwise, moved
from impactfem.system.arrays import Array, Index

DECIMALS = 3
"""Decimals of the coordinates of corners [m]."""
SAME = 0.01
"""Part of the area of a slab by which that within its boundary may differ: bent sides."""


def mesh_plans(mesh: BuildingMesh, building: Building) -> dict[Polygon, list[int]]:
    """Return the plans of the slabs of a mesh, each with the numbers of its floors.

    A plan has its corners in counterclockwise order from the axis of the building. A floor without
    one closed outer boundary has no plan.

    Args:
        mesh: The mesh.
        building: The building, with the place of its axis.
    """
    nodes = mesh.nodes[np.unique(mesh.triangles[mesh.triangles_of("floor")]), :2]
    (x0, y0), (x1, y1) = nodes.min(axis=0).tolist(), nodes.max(axis=0).tolist()
    axis = axis_in_plan(building.axis, (x0, y0), (x1, y1))
    plans: dict[Polygon, list[int]] = {}
    for floor in mesh.floors:
        outline = _outline(mesh, floor)
        if outline is not None:
            plan = moved(counterclockwise(outline), (-axis[0], -axis[1]))
            rounded = tuple((round(x, DECIMALS) + 0.0, round(y, DECIMALS) + 0.0) for x, y in plan)
            plans.setdefault(rounded, []).append(floor)
    return plans


def _outline(mesh: BuildingMesh, floor: int) -> Polygon | None:
    """Return the corners of the outer boundary of a slab; None without a slab that has one."""
    triangles = mesh.triangles[mesh.slab(floor)]
    if not len(triangles):
        return None
    loops = [_corners(mesh.nodes[loop, :2]) for loop in _loops(rim(triangles)[0][:, :2])]
    loops.sort(key=lambda corners: -abs(area(corners)))
    # All but the largest are holes, unless the slab has several parts.
    sizes = [abs(area(corners)) for corners in loops]
    size = float(areas(mesh.nodes, triangles).sum())
    one_part = bool(sizes) and abs(2.0 * sizes[0] - sum(sizes) - size) <= SAME * size
    return loops[0] if one_part else None


def _loops(lines: Index) -> list[list[int]]:
    """Return the closed boundaries that lines form, (k, 2); none where more than two lines meet."""
    ends: dict[int, list[int]] = {}
    for p, q in lines.tolist():
        ends.setdefault(p, []).append(q)
        ends.setdefault(q, []).append(p)
    if any(len(one) != 2 for one in ends.values()):
        return []
    loops, left = [], dict.fromkeys(ends)
    while left:
        node: int | None = next(iter(left))
        loop = list[int]()
        while node is not None:
            loop.append(node)
            del left[node]
            node = next((one for one in ends[node] if one in left), None)
        loops.append(loop)
    return loops


def _corners(points: Array) -> Polygon:
    """Return the points of a closed boundary, (n, 2), where its direction changes."""
    along = np.roll(points, -1, axis=0) - points
    along /= np.linalg.norm(along, axis=1)[:, None]
    before = np.roll(along, 1, axis=0)
    turn = before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0]
    corners: list[Point] = [(x, y) for x, y in points[np.abs(turn) > ALIGNED].tolist()]
    # The lowest corner first, so that alike floors have the same plan.
    first = min(range(len(corners)), key=lambda k: np.round(corners[k], DECIMALS).tolist())
    ordered = counterclockwise((*corners[first:], *corners[:first]))
    return ordered if ordered[0] == corners[first] else (ordered[-1], *ordered[:-1])
