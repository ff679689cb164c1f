"""Where a mesh touches itself without sharing nodes: points on cells, sides through triangles."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from impactfem.building.mesh import sides

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_CHUNK = 5000  # cells at a time, so that few of their near nodes are in memory at once


def nodes_on_triangles(nodes: Array, triangles: Ints, near: float) -> Ints:
    """Nodes that lie on a triangle, its sides included, without being one of its six.

    A node is on a triangle when it is within `near` of its plane and its projection is within
    `near` of its inside.

    Args:
        nodes: Coordinates, shape (n, 3) [m].
        triangles: Six-node triangles that have an area, shape (m, 6).
        near: What counts as touching [m].

    Returns:
        Pairs (triangle, node), shape (pairs, 2), by triangle.
    """
    vertices = nodes[triangles[:, :3]]
    centre = vertices.mean(axis=1)
    radius = np.linalg.norm(vertices - centre[:, None], axis=2).max(axis=1) + near
    normal, inward = _frames(vertices)
    found = []
    for t, n in _pairs(cKDTree(nodes), centre, radius):
        foreign = ~np.any(triangles[t] == n[:, None], axis=1)
        t, n = t[foreign], n[foreign]
        from_first = nodes[n] - vertices[t, 0]
        flat = np.abs(np.einsum("ij,ij->i", from_first, normal[t])) <= near
        t, n = t[flat], n[flat]
        heights = np.einsum("ijk,ijk->ij", nodes[n][:, None] - vertices[t], inward[t])
        inside = np.all(heights >= -near, axis=1)
        found.append(np.column_stack([t[inside], n[inside]]))
    return np.concatenate([np.zeros((0, 2), dtype=np.int64), *found])


def nodes_on_lines(nodes: Array, lines: Ints, near: float) -> Ints:
    """Nodes that lie on a line without being one of its three.

    Args:
        nodes: Coordinates, shape (n, 3) [m].
        lines: Three-node lines, shape (l, 3).
        near: What counts as touching [m].

    Returns:
        Pairs (line, node), shape (pairs, 2), by line.
    """
    start, end = nodes[lines[:, 0]], nodes[lines[:, 1]]
    length = np.linalg.norm(end - start, axis=1)
    tangent = (end - start) / length[:, None]
    found = []
    for e, n in _pairs(cKDTree(nodes), 0.5 * (start + end), 0.5 * length + near):
        foreign = ~np.any(lines[e] == n[:, None], axis=1)
        e, n = e[foreign], n[foreign]
        from_start = nodes[n] - start[e]
        along = np.einsum("ij,ij->i", from_start, tangent[e])
        away = np.linalg.norm(from_start - along[:, None] * tangent[e], axis=1)
        on = (away <= near) & (along >= -near) & (along <= length[e] + near)
        found.append(np.column_stack([e[on], n[on]]))
    return np.concatenate([np.zeros((0, 2), dtype=np.int64), *found])


def lines_through_triangles(nodes: Array, triangles: Ints, lines: Ints, near: float) -> Ints:
    """Lines, or sides of other triangles, that go through the inside of a triangle.

    Args:
        nodes: Coordinates, shape (n, 3) [m].
        triangles: Six-node triangles that have an area, shape (m, 6).
        lines: Three-node lines, shape (l, 3); the triangles' sides are added.
        near: What counts as touching [m]: ends that are nearer to the plane do not go through.

    Returns:
        Pairs (triangle, middle node of the line), shape (pairs, 2).
    """
    every = np.unique(np.concatenate([sides(triangles), lines]), axis=0)
    start, end = nodes[every[:, 0]], nodes[every[:, 1]]
    middle, half = 0.5 * (start + end), 0.5 * np.linalg.norm(end - start, axis=1)
    vertices = nodes[triangles[:, :3]]
    centre = vertices.mean(axis=1)
    radius = np.linalg.norm(vertices - centre[:, None], axis=2).max(axis=1)
    normal, inward = _frames(vertices)
    # Lines of about one length at a time: a few long ones would make all of them near to all.
    size = np.ceil(np.log2(half)).astype(np.int64)
    found = []
    for one in np.unique(size):
        own = np.flatnonzero(size == one)
        for t, e in _pairs(cKDTree(middle[own]), centre, radius + half[own].max()):
            e = own[e]
            d1 = np.einsum("ij,ij->i", start[e] - centre[t], normal[t])
            d2 = np.einsum("ij,ij->i", end[e] - centre[t], normal[t])
            across = (d1 * d2 < 0.0) & (np.minimum(np.abs(d1), np.abs(d2)) > near)
            t, e, d1, d2 = t[across], e[across], d1[across], d2[across]
            point = start[e] + (end[e] - start[e]) * (d1 / (d1 - d2))[:, None]
            heights = np.einsum("ijk,ijk->ij", point[:, None] - vertices[t], inward[t])
            inside = np.all(heights >= -near, axis=1)
            found.append(np.column_stack([t[inside], every[e[inside], 2]]))
    return np.concatenate([np.zeros((0, 2), dtype=np.int64), *found])


def _frames(vertices: Array) -> tuple[Array, Array]:
    """Unit normal of each triangle, and for each vertex the direction inwards from its side."""
    along = np.roll(vertices, -1, axis=1) - vertices
    normal = np.asarray(np.cross(along[:, 0], along[:, 1]), dtype=np.float64)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    inward = np.asarray(np.cross(normal[:, None], along), dtype=np.float64)
    inward /= np.linalg.norm(inward, axis=2)[:, :, None]
    return normal, inward


def _pairs(tree: cKDTree, centres: Array, radii: Array) -> Iterator[tuple[Ints, Ints]]:
    """Each centre with each point of the tree inside its radius, some centres at a time."""
    for first in range(0, len(centres), _CHUNK):
        some = slice(first, first + _CHUNK)
        lists = tree.query_ball_point(centres[some], radii[some], return_sorted=True)
        counts = np.array([len(one) for one in lists], dtype=np.int64)
        flat = np.fromiter(
            (i for one in lists for i in one), dtype=np.int64, count=int(counts.sum())
        )
        yield first + np.repeat(np.arange(len(counts)), counts), flat
