"""Refuse a mesh that would be computed without a complaint and with a wrong result."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from impactfem.building.conformity import (
    lines_through_triangles,
    nodes_on_lines,
    nodes_on_triangles,
)
from impactfem.building.mesh import BuildingMesh, place
from impactfem.building.quality import radius_ratio
from impactfem.system.errors import Fault, InputError

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Names = NDArray[np.object_]

LARGEST = 2000.0
"""Extent that no building has [m]; one in millimetres has more."""
NEAR = 1e-3
"""Distance below which a node touches what it is not a node of [m]."""
COLLAPSED = 1e-3
"""Radius ratio below which a triangle has collapsed."""
STRAIGHT = 1e-6
"""How far a middle node may be from the middle of its side, over the extent."""


def check_mesh(mesh: BuildingMesh, file: Path | str) -> None:
    """Check that a mesh is in metres, has usable cells, holds together and stands on its base.

    Args:
        mesh: The mesh.
        file: Where it comes from, for messages.

    Raises:
        InputError: One fault for each kind of fault and pair of parts, with the group and the first
            place.
    """
    for check in (_extent, _cells, _duplicates, _conforming, _standing):
        # The later checks need what the earlier ones have seen to.
        faults = [Fault(file, group, None, text) for group, text in check(mesh)]
        if faults:
            raise InputError(faults)


Found = Iterator[tuple[str, str]]


def _extent(mesh: BuildingMesh) -> Found:
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


def _cells(mesh: BuildingMesh) -> Found:
    """Collapsed triangles and lines, and sides that are not straight."""
    triangles, lines = mesh.triangles, mesh.lines
    flat = np.flatnonzero(radius_ratio(mesh.nodes, triangles) < COLLAPSED)
    ends = mesh.nodes[lines[:, :2]]
    short = np.flatnonzero(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) < NEAR)
    for what, own, cells, owner in (
        ("collapsed triangles", flat, triangles, _shell_groups(mesh)),
        ("lines without a length", short, lines, _beam_groups(mesh)),
    ):
        for group, some in _by_group(own, owner):
            where = place(mesh.nodes[cells[some[0]]].mean(axis=0))
            yield group, f"{len(some)} {what}, the first at {where}"
    tolerance = STRAIGHT * float(np.ptp(mesh.nodes, axis=0).max())
    for cells, owner, corners in (
        (triangles, _shell_groups(mesh), ((0, 1, 3), (1, 2, 4), (2, 0, 5))),
        (lines, _beam_groups(mesh), ((0, 1, 2),)),
    ):
        away = np.zeros(len(cells))
        for a, b, m in corners:
            middle = 0.5 * (mesh.nodes[cells[:, a]] + mesh.nodes[cells[:, b]])
            gap = np.linalg.norm(mesh.nodes[cells[:, m]] - middle, axis=1)
            away = np.maximum(away, gap)
        for group, some in _by_group(np.flatnonzero(away > tolerance), owner):
            where = place(mesh.nodes[cells[some[0]]].mean(axis=0))
            yield (
                group,
                f"{len(some)} cells with sides that are not straight, the first at {where}: a "
                f"middle node is {away[some].max():.3g} m off; expected plane facets "
                "(Mesh.SecondOrderLinear = 1)",
            )


def _duplicates(mesh: BuildingMesh) -> Found:
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
    for cells, owner, vertices in (
        (mesh.triangles, _shell_groups(mesh), 3),
        (mesh.lines, _beam_groups(mesh), 2),
    ):
        if not len(cells):
            continue
        _, inverse, counts = np.unique(
            np.sort(cells[:, :vertices], axis=1), axis=0, return_inverse=True, return_counts=True
        )
        repeated = np.flatnonzero(counts[inverse.ravel()] > 1)
        for group, some in _by_group(repeated, owner):
            where = place(mesh.nodes[cells[some[0]]].mean(axis=0))
            yield group, f"{len(some)} cells share all vertices with another, the first at {where}"


def _conforming(mesh: BuildingMesh) -> Found:
    shells, beams = _shell_groups(mesh), _beam_groups(mesh)
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


def _standing(mesh: BuildingMesh) -> Found:
    """Parts of the mesh that no path of cells joins to the base: mechanisms."""
    n = len(mesh.nodes)
    cells = [*mesh.triangles.T[1:], *mesh.lines.T[1:]]
    firsts = [mesh.triangles[:, 0]] * 5 + [mesh.lines[:, 0]] * 2
    rows, columns = np.concatenate(firsts), np.concatenate(cells)
    graph = coo_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(n, n))
    count, piece = connected_components(graph, directed=False)
    held = np.zeros(count, dtype=bool)
    held[piece[mesh.base]] = True
    shells, beams = _shell_groups(mesh), _beam_groups(mesh)
    for loose in np.flatnonzero(~held):
        names = {
            *shells[np.flatnonzero(piece[mesh.triangles[:, 0]] == loose)].tolist(),
            *beams[np.flatnonzero(piece[mesh.lines[:, 0]] == loose)].tolist(),
        }
        own = np.flatnonzero(piece == loose)
        yield (
            ", ".join(sorted(names)),
            f"{len(own)} nodes, one at {place(mesh.nodes[own[0]])}, are not connected to the base: "
            "a mechanism",
        )


def _shell_groups(mesh: BuildingMesh) -> Names:
    """The group of each triangle."""
    return np.array([part.group for part in mesh.shell_parts], dtype=object)[mesh.triangle_part]


def _beam_groups(mesh: BuildingMesh) -> Names:
    """The group of each line."""
    return np.array([part.group for part in mesh.beam_parts], dtype=object)[mesh.line_part]


def _node_groups(mesh: BuildingMesh) -> Names:
    """One group of each node: a shell's where it has one."""
    groups = np.full(len(mesh.nodes), "", dtype=object)
    groups[mesh.lines] = _beam_groups(mesh)[:, None]
    # Backwards, so that the first part that has the node is named.
    groups[mesh.triangles[::-1]] = _shell_groups(mesh)[::-1, None]
    return groups


def _by_group(cells: Ints, owner: Names) -> Iterator[tuple[str, Ints]]:
    """These cells by their group."""
    sets: dict[str, list[int]] = {}
    for cell in cells:
        sets.setdefault(str(owner[cell]), []).append(int(cell))
    for group, some in sorted(sets.items()):
        yield group, np.array(some)
