"""The mesh that is shipped as a user's own, and the one of the paper's building."""

import numpy as np
import pytest

from impactfem.building.mesh import areas, sides
from impactfem.building.read_mesh import read_mesh


@pytest.fixture(scope="module")
def frame(frame_file):
    return read_mesh(frame_file)


def test_the_shipped_file_is_small_text(frame_file):
    content = frame_file.read_bytes()
    assert content.startswith(b"$MeshFormat\n4.1 0 8")
    assert len(content) < 200_000


def test_the_shipped_mesh(frame):
    assert frame.floors == (1, 2)
    assert frame.elevations == pytest.approx({1: 3.0, 2: 6.0})
    assert 300 < frame.elements < 1000
    assert [part.group for part in frame.shell_parts] == [
        "floor_1", "floor_2", "storey_1_west", "storey_2_west"
    ]  # fmt: skip
    area = areas(frame.nodes, frame.triangles)
    assert area.sum() == pytest.approx(2 * 6.0 * 4.0 + 2 * 4.0 * 3.0)
    # The wall's foot and the feet of two columns.
    feet = frame.nodes[frame.base]
    assert sorted({tuple(p) for p in feet[feet[:, 0] > 1.0].round(9)}) == [(6, 0, 0), (6, 4, 0)]
    assert np.ptp(feet[feet[:, 0] < 1.0][:, 1]) == pytest.approx(4.0)


def test_mid_nodes_are_in_the_middle(frame):
    for a, b, m in ((0, 1, 3), (1, 2, 4), (2, 0, 5)):
        middle = 0.5 * (frame.nodes[frame.triangles[:, a]] + frame.nodes[frame.triangles[:, b]])
        np.testing.assert_allclose(frame.nodes[frame.triangles[:, m]], middle, atol=1e-12)
    middle = frame.nodes[frame.lines[:, :2]].mean(axis=1)
    np.testing.assert_allclose(frame.nodes[frame.lines[:, 2]], middle, atol=1e-12)


def test_a_side_has_one_middle(frame):
    every = sides(frame.triangles)
    assert (every[:, 0] < every[:, 1]).all()
    assert len(np.unique(every, axis=0)) == len(np.unique(every[:, :2], axis=0))
