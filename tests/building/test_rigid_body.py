import numpy as np
import pytest

from impactfem.building.mesh import rigid_body


def test_by_hand():
    """A turn by b about x0 moves x by b × (x − x0)."""
    motions = rigid_body(np.array([[3.0, 5.0, 9.0]]), np.array([1.0, 1.0, 1.0]))
    # The arm is (2, 4, 8).
    assert motions[:3, :3].tolist() == np.eye(3).tolist()
    assert motions[3:, 3:].tolist() == np.eye(3).tolist()
    assert not motions[3:, :3].any()
    assert motions[:3, 3].tolist() == [0.0, -8.0, 4.0]
    assert motions[:3, 4].tolist() == [8.0, 0.0, -2.0]
    assert motions[:3, 5].tolist() == [-4.0, 2.0, 0.0]


def test_distances_stay():
    """Two points of a body keep their distance to first order."""
    points = np.random.default_rng(4).normal(size=(2, 3))
    u = rigid_body(points, np.array([0.3, -2.0, 5.0])).reshape(2, 6, 6)[:, :3]
    between = points[1] - points[0]
    assert between @ (u[1] - u[0]) == pytest.approx(np.zeros(6), abs=1e-14)


def test_of_no_point():
    assert rigid_body(np.zeros((0, 3)), np.zeros(3)).shape == (0, 6)
