import numpy as np
import pytest

from impactfem.building.shell_model import line_load
from impactfem.verify.shells import (
    ROTATION,
    flat,
    joined,
    lines_at,
    panel,
)

UNIT = flat((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


def areas(nodes, triangles):
    a, b, c = (nodes[triangles[:, i], :2] for i in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


@pytest.mark.parametrize("distortion", [0.0, 0.3])
def test_a_rectangle(distortion):
    nodes, triangles = panel(5, 3, flat((4.0, 0.0, 0.0), (0.0, 2.0, 0.0)), distortion)
    assert len(nodes) == 11 * 7 and len(triangles) == 30
    found = areas(nodes, triangles)
    assert np.all(found > 0.0) and found.sum() == pytest.approx(8.0, rel=1e-14)
    assert bool(np.ptp(found) < 1e-12) is (distortion == 0.0)
    for mid, (i, j) in enumerate(((0, 1), (1, 2), (2, 0))):
        middle = 0.5 * (nodes[triangles[:, i]] + nodes[triangles[:, j]])
        assert np.array_equal(nodes[triangles[:, 3 + mid]], middle)
    assert np.array_equal(np.unique(triangles), np.arange(len(nodes)))


def test_facets_of_a_curved_panel_are_flat():
    nodes, triangles = panel(2, 4, lambda a, b: (np.cos(b), np.sin(b), a))
    radius = np.linalg.norm(nodes[:, :2], axis=1)
    vertices = np.unique(triangles[:, :3])
    assert np.allclose(radius[vertices], 1.0, rtol=1e-15)
    chord = np.cos(0.125)
    assert radius.min() == pytest.approx(chord, rel=1e-14)


def test_panels_that_meet_share_their_nodes():
    other = flat((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    nodes, triangles, of = joined([panel(2, 2, UNIT), panel(2, 3, other, 0.2)])
    assert len(nodes) == 25 + 35 - 5 and np.array_equal(np.bincount(of), [8, 12])
    edge = (nodes[:, 1] == 0.0) & (nodes[:, 2] == 0.0)
    assert edge.sum() == 5
    assert {0, 1} == set(of[np.isin(triangles, np.flatnonzero(edge)).any(axis=1)])
    apart = flat((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1e-6, 0.0))
    assert len(joined([panel(2, 2, UNIT), panel(2, 3, apart)])[0]) == 60


def test_lines_and_their_load():
    nodes, triangles = panel(3, 2, flat((3.0, 0.0, 0.0), (0.0, 2.0, 0.0)), 0.2)
    lines = lines_at(triangles, nodes[:, 0] == 3.0)
    assert lines.shape == (2, 3)
    load = line_load(nodes, lines)
    assert np.all(load[nodes[:, 0] < 3.0] == 0.0)
    # Exact for what P2 holds: 1, y and y² over a uniform load of resultant 1 on 0 ≤ y ≤ 2.
    for power, mean in enumerate((1.0, 1.0, 4.0 / 3.0)):
        assert load @ nodes[:, 1] ** power == pytest.approx(mean, rel=1e-14)


def test_the_rotation_is_one():
    assert np.allclose(ROTATION @ ROTATION.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(ROTATION) == pytest.approx(1.0)
    assert np.abs(ROTATION).max() < 0.7
