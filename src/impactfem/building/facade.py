"""The sides of the floors of a mesh, and loads on what stands behind them."""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse
from scipy.sparse.csgraph import connected_components

from impactfem.building.mesh import BuildingMesh, area_shares, outward_normal, rim
from impactfem.case.contacts import Vector
from impactfem.case.facade import ALIGNED, Facade, side_of
from impactfem.system.arrays import Array, Index

COLUMN = 1e-6
"""How far beside a column a force may be that acts on it [m]."""
SURFACE = 0.05
"""How far nodes may be behind the outermost ones and still be struck with them [m]."""


def facades(
    mesh: BuildingMesh, floor: int, side: str | None = None
) -> dict[str, tuple[Facade, Index]]:
    """The sides of a floor by their names, with their lines (ends, middle), shape (k, 3).

    First that of the group edge_K, "", then the others of its slab: boundaries of its flat
    triangles, in straight and connected pieces. With the side "" alone when it is asked for.
    """
    found: dict[str, tuple[Facade, Index]] = {}
    known = mesh.edges.get(floor, np.zeros((0, 3), dtype=np.int64))
    if len(known):
        found[""] = _facade(mesh, known, outward_normal(mesh, floor)), known
    if side == "":
        return found
    triangles = mesh.triangles[mesh.slab(floor)]
    if not len(triangles):
        return found
    lines, inside = rim(triangles)
    # Lines of the group are found by their middles.
    outer = ~np.isin(lines[:, 2], known[:, 2])
    lines, inner = lines[outer], mesh.nodes[triangles[inside[outer], :3], :2].mean(axis=1)
    x = mesh.nodes[lines[:, :2], :2]
    t = x[:, 1] - x[:, 0]
    length = np.linalg.norm(t, axis=1)[:, None]
    normal = np.column_stack([t[:, 1], -t[:, 0]]) / length
    normal *= np.sign(((x[:, 0] - inner) * normal).sum(axis=1))[:, None]
    # Neighbours with the same normal are one piece.
    ends = lines[:, :2].ravel()
    order = np.argsort(ends, kind="stable")
    a, b = order[:-1] // 2, order[1:] // 2
    joined = (np.diff(ends[order]) == 0) & (np.abs(normal[a] - normal[b]).max(axis=1) < ALIGNED)
    graph = scipy.sparse.coo_matrix((joined[joined], (a[joined], b[joined])), (len(lines),) * 2)
    pieces, piece_of = connected_components(graph, directed=False)
    for k in range(pieces):
        mine, outward = lines[piece_of == k], (length * normal)[piece_of == k].sum(axis=0)
        outward = np.round(outward / np.linalg.norm(outward), 12)
        facade = _facade(mesh, mine, np.append(outward, 0.0))
        name = side_of(facade.outward)
        number = 1 + sum(other.split("#")[0] == name for other in found)
        name += f"#{number}" if number > 1 else ""
        found[name] = replace(facade, side=name), mine
    return found


def _facade(mesh: BuildingMesh, lines: Index, outward: Array) -> Facade:
    """Of the line through the middle of some lines, without a name yet."""
    where = mesh.nodes[np.unique(lines), :2]
    t = np.array([-outward[1], outward[0]])
    t *= np.sign(t[np.argmax(np.abs(t))])
    s, middle = where @ t, where @ outward[:2]
    # Both ends on one line, also where nodes are a little off.
    across = 0.5 * (middle.min() + middle.max()) * outward[:2]
    (x0, y0), (x1, y1) = (across + end * t + 0.0 for end in (s.min(), s.max()))
    n: Vector = (float(outward[0]) + 0.0, float(outward[1]) + 0.0, 0.0)
    return Facade("", (float(x0), float(y0)), (float(x1), float(y1)), n)


def columns_along(
    mesh: BuildingMesh, storey: int, facade: Facade, elevation: float, force: Vector
) -> Array:
    """Positions along a side where forces meet columns that stand without a wall, ascending [m].

    The columns stand below the floor of the side and are cut at an elevation [m]; the forces act
    along a horizontal unit vector.
    """
    lines = _columns(mesh, storey)
    low, high = np.moveaxis(mesh.nodes[lines[:, :2]], 1, 0)
    rise = high[:, 2] - low[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        part = (elevation - low[:, 2]) / rise
        here = (np.abs(rise) > 0.0) & (part >= 0.0) & (part <= 1.0)
    at = (low[here] + part[here, None] * (high - low)[here])[:, :2]
    # Where the lines through them along the force meet the side.
    n, t, f = (np.array(v[:2]) for v in (facade.outward, facade.along, force))
    relative = at - np.array(facade.start)
    s: Array = relative @ t - relative @ n * (f @ t) / (f @ n)
    return np.unique(s.round(9))


def _columns(mesh: BuildingMesh, storey: int) -> Index:
    """Lines of the columns of a storey that share no node with its walls."""
    lines = mesh.lines[mesh.lines_of("column", storey)]
    walls = mesh.triangles[mesh.triangles_of("storey", storey)]
    alone: Index = lines[~np.isin(lines, walls).any(axis=1)]
    return alone


def patch_load(
    mesh: BuildingMesh,
    storey: int,
    facade: Facade,
    place: tuple[float, float],
    width: float,
    force: Vector,
) -> tuple[Index, Array] | str:
    """Forces on the walls or columns of a storey over a square patch, with the resultant 1 N.

    The force comes from a side of the floor above, along a horizontal unit vector; its place is the
    position s where its line meets the side, and the elevation z [m]. The patch is as wide as high
    [m]. Where a column stands alone there, with nothing before it, its nodes take the force. They
    are f_i = w_i (a + b (s_i − s) + c (z_i − z)), w_i the area of wall that a node stands for,
    with the resultant 1 N, and no moment about the point s, z of the patch.

    Gives the nodes and their forces [N], or what is there instead in words.
    """
    triangles = mesh.triangles[mesh.triangles_of("storey", storey)]
    lines = mesh.lines[mesh.lines_of("column", storey)]
    nodes = np.setdiff1d(np.union1d(triangles, lines), mesh.base)
    s0, z = place
    n, t, f = (np.array(v[:2]) for v in (facade.outward, facade.along, force))
    relative = mesh.nodes[nodes, :2] - np.array(facade.start)
    depth, s, height = relative @ n, relative @ t, mesh.nodes[nodes, 2]
    # An oblique force goes on behind the side: s where it meets what stands there.
    at = s0 + depth * (f @ t) / (f @ n)
    inside = (np.abs(s - at) <= 0.5 * width + 1e-9) & (np.abs(height - z) <= 0.5 * width + 1e-9)
    if not inside.any():
        return f"no node of its walls and columns is within {0.5 * width:g} m of the point"
    outermost = depth[inside].max()
    struck = np.abs(s - at) < COLUMN
    struck &= inside & (depth >= outermost - SURFACE) & np.isin(nodes, _columns(mesh, storey))
    inside = struck if struck.sum() > 1 else inside
    chosen = inside & (depth >= outermost - SURFACE)
    on = triangles[np.isin(triangles, nodes[depth >= outermost - SURFACE]).all(axis=1)]
    area = area_shares(mesh.nodes, on)[nodes[chosen]]
    # Walls that stand on edge, and columns, have lines of nodes there.
    weight = area if (area > 0.0).sum() > 2 else np.ones(chosen.sum())
    along, up = (s - at)[chosen], height[chosen] - z
    forces = _balanced(weight, along / width, up / width)
    if forces is None:
        return (
            f"its walls and columns within {0.5 * width:g} m of the point, {along.min():.3g} to "
            f"{along.max():.3g} m along the side and {up.min():.3g} to {up.max():.3g} m in height "
            "from it, do not take its moment"
        )
    return nodes[chosen], forces


def _balanced(weight: Array, along: Array, up: Array) -> Array | None:
    """Forces w_i (a + b s_i + c z_i) with the resultant 1 N and no moment about the origin.

    None where nodes do not take the moment.
    """
    unit = np.array([1.0, 0.0, 0.0])
    arms = np.array([np.ones(len(weight)), along, up])
    normal = np.linalg.pinv((arms * weight) @ arms.T, rcond=1e-10)
    forces: Array = weight * (normal @ unit @ arms)
    if np.abs(arms @ forces - unit).max() > 1e-9:
        return None
    # One step of iterative refinement: the normal equations lose half of the digits.
    forces += weight * (normal @ (unit - arms @ forces) @ arms)
    return forces


@dataclass(frozen=True)
class Strip:
    """A part of the walls and columns of a storey that the edge of a slab strikes."""

    begin: float  #: first position along the side [m]
    end: float  #: last position along the side [m]
    z: float  #: elevation of the middle of the slab [m]
    depth: float  #: of the slab [m]


def strip_load(
    mesh: BuildingMesh, storey: int, facade: Facade, strip: Strip, at: float, force: Vector
) -> tuple[Index, Array] | str:
    """Forces on the walls and columns of a storey over a strip, with the resultant 1 N.

    The nodes are those of the elements that the strip meets and of what stands outermost there.
    They take f_i = w_i (a + b (s_i − s) + c (z_i − z)), w_i the area of wall that a node stands
    for, with the resultant 1 N at the position s (`at`) [m] and at the level of the strip. Columns
    share it equally where there are no walls.

    Gives the nodes and their forces [N], or what is there instead in words.
    """
    n, t, f = (np.array(v[:2]) for v in (facade.outward, facade.along, force))
    relative = mesh.nodes[:, :2] - np.array(facade.start)
    depth, height = relative @ n, mesh.nodes[:, 2]
    # An oblique force goes on behind the side: its position where the line meets the side.
    s = relative @ t - depth * (f @ t) / (f @ n)
    low, high = strip.z - 0.5 * strip.depth, strip.z + 0.5 * strip.depth
    walls = mesh.triangles[mesh.triangles_of("storey", storey)]
    columns = mesh.lines[mesh.lines_of("column", storey)]
    met = []
    for elements in (walls, columns):
        along, up = s[elements], height[elements]
        inside = (along.max(axis=1) >= strip.begin) & (along.min(axis=1) <= strip.end)
        met.append(elements[inside & (up.max(axis=1) >= low) & (up.min(axis=1) <= high)])
    nodes = np.setdiff1d(np.union1d(*(elements.ravel() for elements in met)), mesh.base)
    if not len(nodes):
        return f"no wall or column from {strip.begin:.4g} to {strip.end:.4g} m along the side"
    outer = nodes[depth[nodes] >= depth[nodes].max() - SURFACE]
    on = met[0][np.isin(met[0], np.append(outer, mesh.base)).all(axis=1)]
    area = area_shares(mesh.nodes, on)[outer]
    weight = area if (area > 0.0).sum() > 2 else np.ones(len(outer))
    size = max(strip.end - strip.begin, float(np.ptp(height[outer])))
    forces = _balanced(weight, (s[outer] - at) / size, (height[outer] - strip.z) / size)
    if forces is None:
        return (
            f"its walls and columns from {strip.begin:.4g} to {strip.end:.4g} m along the side, "
            f"{height[outer].min():.4g} to {height[outer].max():.4g} m high, do not take its moment"
        )
    return outer, forces
