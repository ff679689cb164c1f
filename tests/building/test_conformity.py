"""What touches without sharing nodes, against a search over all pairs."""

import numpy as np
import pytest

from impactfem.building.mesh_checks import (
    lines_through_triangles,
    nodes_on_lines,
    nodes_on_triangles,
)

NEAR = 1e-3


def with_middles(points, cells):
    """Six-node triangles, or three-node lines, of plain ones."""
    nodes = [tuple(map(float, p)) for p in points]
    made = []
    for cell in cells:
        pairs = [(0, 1), (1, 2), (2, 0)] if len(cell) == 3 else [(0, 1)]
        middles = []
        for a, b in pairs:
            middle = tuple(0.5 * (np.array(nodes[cell[a]]) + np.array(nodes[cell[b]])))
            if middle not in nodes:
                nodes.append(middle)
            middles.append(nodes.index(middle))
        made.append([*cell, *middles])
    return np.array(nodes), np.array(made)


SQUARE = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]


@pytest.mark.parametrize(
    ("point", "on"),
    [
        ((0.5, 0.4, 0.0), [0]),  # inside the first one
        ((0.5, 0.0, 0.0), [0]),  # on a side, hanging
        ((0.5, 0.5, 0.0), [0, 1]),  # on the side they share
        ((0.5, 0.4, 0.0009), [0]),
        ((0.5, 0.4, 0.0011), []),
        ((0.5, -0.0009, 0.0), [0]),
        ((0.5, -0.0011, 0.0), []),
        ((3.0, 0.0, 0.0), []),
    ],
)
def test_a_node_on_triangles(point, on):
    nodes, triangles = with_middles([*SQUARE, point], [(0, 1, 2), (0, 2, 3)])
    found = nodes_on_triangles(nodes, triangles, NEAR)
    assert found.tolist() == [[t, 4] for t in on]


@pytest.mark.parametrize(
    ("point", "on"),
    [((0.5, 0.0, 0.0), True), ((1.0, 0.0, 0.0009), True), ((1.5, 0.0011, 0.0), False),
     ((2.5, 0.0, 0.0), False), ((-0.0011, 0.0, 0.0), False)],
)  # fmt: skip
def test_a_node_on_a_line(point, on):
    nodes, lines = with_middles([(0, 0, 0), (2, 0, 0), point], [(0, 1)])
    assert nodes_on_lines(nodes, lines, NEAR).tolist() == ([[0, 2]] if on else [])


@pytest.mark.parametrize(
    ("start", "end", "through"),
    [
        ((0.5, 0.4, -1.0), (0.6, 0.4, 1.0), True),
        ((1.0, 0.6, 0.01), (0.9, 0.6, 1.0), False),  # above it
        ((3.0, 0.4, -1.0), (3.0, 0.4, 1.0), False),  # beside it
        ((0.5, 0.4, 0.0), (0.5, 0.4, 1.0), False),  # ends on it: a node on the triangle
        ((0.1, 0.1, 0.0), (1.9, 0.2, 0.0), False),  # lies in it
    ],
)
def test_a_line_through_a_triangle(start, end, through):
    nodes, triangles = with_middles(SQUARE, [(0, 1, 2), (0, 2, 3)])
    own = len(nodes)
    middle = 0.5 * (np.array(start) + np.array(end))
    nodes = np.vstack([nodes, start, end, middle])
    found = lines_through_triangles(nodes, triangles, np.array([[own, own + 1, own + 2]]), NEAR)
    assert found.tolist() == ([[0, own + 2]] if through else [])


def test_sides_through_triangles():
    """A wall that goes through a slab without a node at its level."""
    wall = [(0.5, 1.0, -1.0), (1.5, 1.0, -1.0), (1.2, 1.0, 1.0)]
    nodes, triangles = with_middles([*SQUARE, *wall], [(0, 1, 2), (0, 2, 3), (4, 5, 6)])
    found = lines_through_triangles(nodes, triangles, np.zeros((0, 3), dtype=int), NEAR)
    cut = {(t, tuple(nodes[n].tolist())) for t, n in found.tolist()}
    # Both sides of the wall pierce the slab, and the slab's shared side pierces the wall.
    assert (2, (1.0, 1.0, 0.0)) in cut
    assert {place for t, place in cut if t < 2} == {(1.35, 1.0, 0.0), (0.85, 1.0, 0.0)}


def test_the_search_leaves_nothing_out():
    """Random triangles of very different sizes: the tree finds what a search of all pairs does."""
    random = np.random.default_rng(3)
    corners = random.uniform(0.0, 4.0, (60, 1, 3)) + random.normal(size=(60, 3, 3)) * (
        10.0 ** random.uniform(-1.5, 0.5, (60, 1, 1))
    )
    nodes, triangles = with_middles(corners.reshape(-1, 3), np.arange(180).reshape(60, 3).tolist())
    found = lines_through_triangles(nodes, triangles, np.zeros((0, 3), dtype=int), 1e-9)
    expected = set()
    for t, triangle in enumerate(triangles):
        p = nodes[triangle[:3]]
        for other in triangles:
            for a, b, m in ((0, 1, 3), (1, 2, 4), (2, 0, 5)):
                start, end = nodes[other[a]], nodes[other[b]]
                # start + s (end - start) = p0 + u (p1 - p0) + v (p2 - p0)
                system = np.column_stack([start - end, p[1] - p[0], p[2] - p[0]])
                if abs(np.linalg.det(system)) < 1e-12 or set(triangle) & {other[a], other[b]}:
                    continue
                s, u, v = np.linalg.solve(system, start - p[0])
                if 0 < s < 1 and u > 0 and v > 0 and u + v < 1:
                    expected.add((t, int(other[m])))
    assert len(expected) > 5
    assert set(map(tuple, found.tolist())) == expected
