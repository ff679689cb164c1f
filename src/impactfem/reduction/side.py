"""The side of the building on which the wall stands, by the impact edges of its mesh."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

from impactfem.building.mesh import BuildingMesh, outward_normal
from impactfem.system.errors import Fault, InputError

Side = Literal["x-", "x+", "y-", "y+"]

IN_PLANE = 1e-4
"""How far nodes of the edges may be from one plane [m]: a hundredth of the paper's gap."""


def wall_side(mesh: BuildingMesh, floors: tuple[int, ...], file: Path | str) -> Side:
    """The side that the edges of the floors face, and whether one plane wall can stand there.

    Not collective.

    Args:
        mesh: The mesh.
        floors: Numbers of the floors that may hit the wall.
        file: Where the mesh comes from, for messages.

    Raises:
        InputError: With every fault: a floor without an edge, an edge that is not straight along x
            or y, edges on different sides or not in one plane.
    """
    expected = "no lines; expected those of the slab's edge that may hit the wall"
    faults = [Fault(file, f"edge_{k}", None, expected) for k in floors if not _has_edge(mesh, k)]
    if faults:
        raise InputError(faults)
    sides = {k: _side(mesh, k) for k in floors}
    for k, (_, _, spread) in sides.items():
        if spread > IN_PLANE:
            expected = (
                f"the edge is not straight along x or y, its nodes are up to {spread:.4g} m off; "
                "expected one that lies flat against a plane wall"
            )
            faults.append(Fault(file, f"edge_{k}", None, expected))
    if faults:
        raise InputError(faults)
    top = max(floors)
    side, position, _ = sides[top]
    for k, (other, own, _) in sides.items():
        if other != side:
            expected = f"faces {other}, edge_{top} {side}; expected all on the side of the wall"
            faults.append(Fault(file, f"edge_{k}", None, expected))
        elif abs(own - position) > IN_PLANE:
            expected = (
                f"is {abs(own - position):.4g} m {'before' if own > position else 'behind'} "
                f"edge_{top}; expected the edges of all floors that may hit the wall in one plane"
            )
            faults.append(Fault(file, f"edge_{k}", None, expected))
    if faults:
        raise InputError(faults)
    return side


def _has_edge(mesh: BuildingMesh, floor: int) -> bool:
    return floor in mesh.edges and len(mesh.edges[floor]) > 0


def _side(mesh: BuildingMesh, floor: int) -> tuple[Side, float, float]:
    """Side of an edge, its outermost position along the normal, and how far nodes are from it."""
    normal = outward_normal(mesh, floor)
    axis = int(np.argmax(np.abs(normal)))
    sign = 1.0 if normal[axis] > 0.0 else -1.0
    along = sign * mesh.nodes[np.unique(mesh.edges[floor]), axis]
    named: dict[tuple[int, float], Side] = {
        (0, -1.0): "x-",
        (0, 1.0): "x+",
        (1, -1.0): "y-",
        (1, 1.0): "y+",
    }
    return named[axis, sign], float(along.max()), float(np.ptp(along))
