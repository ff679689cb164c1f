"""Refuse a mesh that would be computed without a complaint and with a wrong result."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from impactfem.building.mesh import (
    BuildingMesh,
    line_lengths,
    outward_normal,
    place,
    radius_ratio,
    sides,
)
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import Fault, InputError

Names = NDArray[np.object_]

_CHUNK = 5000  # cells at a time, so that few of their near nodes are in memory at once

LARGEST = 2000.0
"""Extent that no building has [m]; one in millimetres has more."""
NEAR = 1e-3
"""Distance below which a node touches what it is not a node of [m]."""
COLLAPSED = 1e-3
"""Radius ratio below which a triangle has collapsed."""
STRAIGHT = 1e-6
"""How far a middle node may be from the middle of its side, over the extent."""
CROOKED = 0.01
"""How far nodes of an edge may be from one straight line, over its length."""


def check_mesh(mesh: BuildingMesh, file: Path | str) -> None:
    """Check that a mesh is in metres, has usable cells, holds together and stands on its base.

    Raises InputError, with one fault for each kind of fault and pair of parts, with the group and
    the first place, that names the file.
    """
    for check in (_numbers, _extent, _cells, _duplicates, _conforming, _standing, _edges):
        # The later checks need what the earlier ones have seen to.
        faults = [Fault(file, group, None, text) for group, text in check(mesh)]
        if faults:
            raise InputError(faults)


Faults = Iterator[tuple[str, str]]  # group and words


def _numbers(mesh: BuildingMesh) -> Faults:
    for cells, owner in ((mesh.triangles, shell_groups(mesh)), (mesh.lines, beam_groups(mesh))):
        bad = np.flatnonzero(~np.isfinite(mesh.nodes[cells]).all(axis=(1, 2)))
        for group, some, where in by_group(mesh, bad, cells, owner):
            yield (
                group,
                f"{len(some)} cells with coordinates that are not finite, the first at {where}; "
                "expected numbers",
            )


def _extent(mesh: BuildingMesh) -> Faults:
    extent = np.ptp(mesh.nodes, axis=0)
    if extent.max() > LARGEST:
        size = " x ".join(f"{x:g}" for x in extent)
        far = mesh.nodes[int(np.argmax(np.abs(mesh.nodes).max(axis=1)))]
        parts = [part.group for part in (*mesh.shell_parts, *mesh.beam_parts)]
        yield (
            parts[0],
            f"the mesh measures {size}, with a node at {place(far)}; expected metres, at most "
            f"{LARGEST:g} m (is it in millimetres?)",
        )


def _cells(mesh: BuildingMesh) -> Faults:
    """Collapsed triangles and lines, and sides that are not straight."""
    triangles, lines = mesh.triangles, mesh.lines
    shells, beams = shell_groups(mesh), beam_groups(mesh)
    flat = np.flatnonzero(radius_ratio(mesh.nodes, triangles) < COLLAPSED)
    short = np.flatnonzero(line_lengths(mesh) < NEAR)
    for what, bad, cells, owner in (
        ("collapsed triangles", flat, triangles, shells),
        ("lines without a length", short, lines, beams),
    ):
        for group, some, where in by_group(mesh, bad, cells, owner):
            yield group, f"{len(some)} {what}, the first at {where}"
    tolerance = STRAIGHT * float(np.ptp(mesh.nodes, axis=0).max())
    for cells, owner, ends, middle in (
        (triangles, shells, triangles[:, [[0, 1], [1, 2], [2, 0]]], triangles[:, 3:]),
        (lines, beams, lines[:, None, :2], lines[:, 2:]),
    ):
        gaps = np.linalg.norm(mesh.nodes[middle] - mesh.nodes[ends].mean(axis=2), axis=2)
        away = gaps.max(axis=1, initial=0.0)
        bent = np.flatnonzero(away > tolerance)
        for group, some, where in by_group(mesh, bent, cells, owner):
            yield (
                group,
                f"{len(some)} cells with sides that are not straight, the first at {where}: a "
                f"middle node is {away[some].max():.3g} m off; expected plane facets "
                "(Mesh.SecondOrderLinear = 1)",
            )


def _duplicates(mesh: BuildingMesh) -> Faults:
    pairs = cKDTree(mesh.nodes).query_pairs(NEAR, output_type="ndarray").astype(np.int64)
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    groups = _node_groups(mesh)
    seen: dict[tuple[str, ...], list[int]] = {}
    for i, j in pairs.tolist():
        seen.setdefault(tuple(sorted({groups[i], groups[j]})), []).append(i)
    for names, firsts in sorted(seen.items()):
        yield (
            ", ".join(names),
            f"{len(firsts)} pairs of nodes in one place, the first at "
            f"{place(mesh.nodes[firsts[0]])}; "
            "expected shared nodes (in gmsh: fragment the parts before meshing)",
        )
    for cells, corners, owner in (
        (mesh.triangles, mesh.triangles[:, :3], shell_groups(mesh)),
        (mesh.lines, mesh.lines[:, :2], beam_groups(mesh)),
    ):
        _, inverse, counts = np.unique(
            np.sort(corners, axis=1), axis=0, return_inverse=True, return_counts=True
        )
        repeated = np.flatnonzero(counts[inverse.ravel()] > 1)
        for group, some, where in by_group(mesh, repeated, cells, owner):
            yield group, f"{len(some)} cells share all vertices with another, the first at {where}"


def _conforming(mesh: BuildingMesh) -> Faults:
    shells, beams = shell_groups(mesh), beam_groups(mesh)
    owners = _node_groups(mesh)
    on_triangles = nodes_on_triangles(mesh.nodes, mesh.triangles, NEAR)
    on_lines = nodes_on_lines(mesh.nodes, mesh.lines, NEAR)
    through = lines_through_triangles(mesh.nodes, mesh.triangles, mesh.lines, NEAR)
    seen: dict[tuple[str, str], list[int]] = {}
    for pairs, groups in ((on_triangles, shells), (on_lines, beams), (through, shells)):
        for cell, node in pairs:
            both = str(owners[node]), str(groups[cell])
            seen.setdefault(both, []).append(int(node))
    for (a, b), some in sorted(seen.items()):
        count = len(set(some))
        what = "1 node lies" if count == 1 else f"{count} nodes lie"
        where = place(mesh.nodes[some[0]])
        yield (
            a,
            f"{what} on {b}, or {'its' if count == 1 else 'their'} lines pass through it, without "
            f"sharing a node there, the first at {where}; expected a conforming mesh "
            "(in gmsh: fragment the parts before meshing)",
        )


def _standing(mesh: BuildingMesh) -> Faults:
    """Parts of the mesh that no path of cells joins to the base: mechanisms."""
    n = len(mesh.nodes)
    cells = [*mesh.triangles.T[1:], *mesh.lines.T[1:]]
    firsts = [mesh.triangles[:, 0]] * 5 + [mesh.lines[:, 0]] * 2
    rows, columns = np.concatenate(firsts), np.concatenate(cells)
    graph = coo_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(n, n))
    count, piece = connected_components(graph, directed=False)
    held = np.zeros(count, dtype=bool)
    held[piece[mesh.base]] = True
    shells, beams = shell_groups(mesh), beam_groups(mesh)
    for loose in np.flatnonzero(~held):
        names = {
            *shells[np.flatnonzero(piece[mesh.triangles[:, 0]] == loose)].tolist(),
            *beams[np.flatnonzero(piece[mesh.lines[:, 0]] == loose)].tolist(),
        }
        nodes = np.flatnonzero(piece == loose)
        yield (
            ", ".join(sorted(names)),
            f"{len(nodes)} nodes, one at {place(mesh.nodes[nodes[0]])}, are not connected to the "
            "base: a mechanism",
        )


def _edges(mesh: BuildingMesh) -> Faults:
    """Edges that are no straight side of their slab in one piece."""
    for k, lines in mesh.edges.items():
        own = mesh.triangles[mesh.triangles_of("floor", k)]
        normal, _ = frames(mesh.nodes[own[:, :3]])
        # A parapet shares sides with the slab that it stands on.
        middles, count = np.unique(sides(own[np.abs(normal[:, 2]) > 0.5])[:, 2], return_counts=True)
        inner = np.isin(lines[:, 2], middles[count != 1])
        numbers, times = np.unique(lines[:, 2], return_counts=True)
        n = outward_normal(mesh, k)[:2]
        across = mesh.nodes[np.unique(lines), :2] @ n
        ends = np.sort(mesh.nodes[lines[:, :2], :2] @ [-n[1], n[0]], axis=1)
        order = np.argsort(ends[:, 0])
        # How far the next line begins behind the end of those before it.
        gaps = ends[order[1:], 0] - np.maximum.accumulate(ends[order, 1])[:-1]
        length = np.ptp(ends)
        if inner.any():
            what, at = f"{inner.sum()} lines inside the slab", lines[int(np.argmax(inner)), 2]
        elif len(numbers) < len(lines):
            what, at = f"{(times > 1).sum()} lines more than once", numbers[int(np.argmax(times))]
        elif np.ptp(across) > CROOKED * length:
            what = f"lines that are {np.ptp(across):.3g} m off one straight line of {length:.3g} m"
            at = lines[int(np.argmax(mesh.nodes[lines[:, 2], :2] @ -n)), 2]
        elif np.diff(ends).sum() > length + NEAR:
            what, at = (
                "lines one above another",
                lines[order[int(np.argmin(np.append(0.0, gaps)))], 2],
            )
        elif gaps.max(initial=0.0) > NEAR:
            what = f"a gap of {gaps.max():.3g} m"
            at = lines[order[int(np.argmax(gaps))], 2]
        else:
            continue
        yield (
            f"edge_{k}",
            f"{what}, at {place(mesh.nodes[at])}; expected the lines of one straight side of "
            f"floor_{k}, without a gap, each once (other sides need no group)",
        )


def shell_groups(mesh: BuildingMesh) -> Names:
    """The group of each triangle."""
    return np.array([part.group for part in mesh.shell_parts], dtype=object)[mesh.triangle_part]


def beam_groups(mesh: BuildingMesh) -> Names:
    """The group of each line."""
    return np.array([part.group for part in mesh.beam_parts], dtype=object)[mesh.line_part]


def _node_groups(mesh: BuildingMesh) -> Names:
    """One group of each node: a shell's where it has one."""
    groups = np.full(len(mesh.nodes), "", dtype=object)
    groups[mesh.lines] = beam_groups(mesh)[:, None]
    # Backwards, so that the first part that has the node is named.
    groups[mesh.triangles[::-1]] = shell_groups(mesh)[::-1, None]
    return groups


def by_group(
    mesh: BuildingMesh, bad: Index, cells: Index, owner: Names
) -> Iterator[tuple[str, Index, str]]:
    """Some cells by their group, and the place of the first of them."""
    for group in sorted(set(owner[bad].tolist())):
        some = bad[owner[bad] == group]
        yield group, some, place(mesh.nodes[cells[some[0]]].mean(axis=0))


def nodes_on_triangles(nodes: Array, triangles: Index, near: float) -> Index:
    """Nodes that lie on a triangle, its sides included, without being one of its six.

    A node is on a triangle that has an area when it is within `near` [m] of its plane and its
    projection is within `near` of its inside. Pairs (triangle, node), shape (pairs, 2).
    """
    vertices = nodes[triangles[:, :3]]
    centre = vertices.mean(axis=1)
    radius = np.linalg.norm(vertices - centre[:, None], axis=2).max(axis=1) + near
    normal, inward = frames(vertices)
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    for t, n in _pairs(cKDTree(nodes), centre, radius):
        foreign = ~np.any(triangles[t] == n[:, None], axis=1)
        t, n = t[foreign], n[foreign]
        from_first = nodes[n] - vertices[t, 0]
        flat = np.abs(np.einsum("ij,ij->i", from_first, normal[t])) <= near
        t, n = t[flat], n[flat]
        heights = np.einsum("ijk,ijk->ij", nodes[n][:, None] - vertices[t], inward[t])
        inside = np.all(heights >= -near, axis=1)
        pairs.append(np.column_stack([t[inside], n[inside]]))
    return np.concatenate(pairs)


def nodes_on_lines(nodes: Array, lines: Index, near: float) -> Index:
    """Nodes within `near` [m] of a line that are none of its three: pairs (line, node)."""
    start, end = nodes[lines[:, 0]], nodes[lines[:, 1]]
    length = np.linalg.norm(end - start, axis=1)
    tangent = (end - start) / length[:, None]
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    for e, n in _pairs(cKDTree(nodes), 0.5 * (start + end), 0.5 * length + near):
        foreign = ~np.any(lines[e] == n[:, None], axis=1)
        e, n = e[foreign], n[foreign]
        from_start = nodes[n] - start[e]
        along = np.einsum("ij,ij->i", from_start, tangent[e])
        away = np.linalg.norm(from_start - along[:, None] * tangent[e], axis=1)
        on = (away <= near) & (along >= -near) & (along <= length[e] + near)
        pairs.append(np.column_stack([e[on], n[on]]))
    return np.concatenate(pairs)


def lines_through_triangles(nodes: Array, triangles: Index, lines: Index, near: float) -> Index:
    """Lines, or sides of other triangles, that go through the inside of a triangle.

    Ends that are nearer than `near` [m] to its plane do not go through. Pairs (triangle, middle
    node of the line), shape (pairs, 2).
    """
    every = np.unique(np.concatenate([sides(triangles), lines]), axis=0)
    start, end = nodes[every[:, 0]], nodes[every[:, 1]]
    middle, half = 0.5 * (start + end), 0.5 * np.linalg.norm(end - start, axis=1)
    vertices = nodes[triangles[:, :3]]
    centre = vertices.mean(axis=1)
    radius = np.linalg.norm(vertices - centre[:, None], axis=2).max(axis=1)
    normal, inward = frames(vertices)
    # Lines of about one length at a time: a few long ones would make all of them near to all.
    size = np.ceil(np.log2(half)).astype(np.int64)
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    for of_size in np.unique(size):
        some = np.flatnonzero(size == of_size)
        for t, e in _pairs(cKDTree(middle[some]), centre, radius + half[some].max()):
            e = some[e]
            d1 = np.einsum("ij,ij->i", start[e] - centre[t], normal[t])
            d2 = np.einsum("ij,ij->i", end[e] - centre[t], normal[t])
            across = (d1 * d2 < 0.0) & (np.minimum(np.abs(d1), np.abs(d2)) > near)
            t, e, d1, d2 = t[across], e[across], d1[across], d2[across]
            point = start[e] + (end[e] - start[e]) * (d1 / (d1 - d2))[:, None]
            heights = np.einsum("ijk,ijk->ij", point[:, None] - vertices[t], inward[t])
            inside = np.all(heights >= -near, axis=1)
            pairs.append(np.column_stack([t[inside], every[e[inside], 2]]))
    return np.concatenate(pairs)


def frames(vertices: Array) -> tuple[Array, Array]:
    """Unit normal of each triangle, and for each vertex the direction inwards from its side."""
    along = np.roll(vertices, -1, axis=1) - vertices
    normal = np.asarray(np.cross(along[:, 0], along[:, 1]), dtype=np.float64)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    inward = np.asarray(np.cross(normal[:, None], along), dtype=np.float64)
    inward /= np.linalg.norm(inward, axis=2)[:, :, None]
    return normal, inward


def _pairs(tree: cKDTree, centres: Array, radii: Array) -> Iterator[tuple[Index, Index]]:
    """Each centre with each point of the tree inside its radius, some centres at a time."""
    for first in range(0, len(centres), _CHUNK):
        some = slice(first, first + _CHUNK)
        lists = tree.query_ball_point(centres[some], radii[some], return_sorted=True)
        counts = np.array([len(near) for near in lists], dtype=np.int64)
        flat = np.fromiter((i for near in lists for i in near), dtype=np.int64)
        yield first + np.repeat(np.arange(len(counts)), counts), flat
