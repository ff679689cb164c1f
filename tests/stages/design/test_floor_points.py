"""Which probes are on which floor, and their envelope."""

import numpy as np
import pytest

from impactfem.stages.design.floor_points import enveloped, floor_points
from impactfem.system.errors import ImpactfemError

NAMES = ("centre_2", "centre_1", "edge_1", "roof", "corner")
POSITION = np.array(
    [[2.0, 2.0, 6.0], [2.0, 2.0, 3.0], [2.0, 4.0, 3.0], [0.0, 0.0, 6.6], [0.0, 0.0, 5.97]]
)


def test_floors_from_the_lowest():
    floors, elsewhere = floor_points(NAMES, POSITION, {2: 0, 1: 1})
    assert [(f.floor, f.elevation, f.names) for f in floors] == [
        (1, 3.0, ("centre_1", "edge_1")),
        (2, 6.0, ("centre_2", "corner")),
    ]
    assert elsewhere == ("roof",)


def test_without_a_mass_centre():
    with pytest.raises(ImpactfemError, match="no probe at the mass centre"):
        floor_points(("edge_1", "centre_top"), POSITION[:2], {})


def test_envelope():
    floors, _ = floor_points(NAMES, POSITION, {2: 0, 1: 1})
    values = np.random.default_rng(0).random((2, 5, 3, 7))
    found = enveloped(values, floors, axis=1)
    assert found.shape == (2, 2, 3, 7)
    np.testing.assert_array_equal(found[:, 0], np.maximum(values[:, 1], values[:, 2]))
    np.testing.assert_array_equal(found[:, 1], np.maximum(values[:, 0], values[:, 4]))


def test_envelope_of_one_point_is_the_point():
    floors, _ = floor_points(("centre_1",), POSITION[1:2], {1: 0})
    values = np.random.default_rng(0).random((1, 3))
    np.testing.assert_array_equal(enveloped(values, floors, axis=0), values)
