"""Which modes bend the building."""

import numpy as np

from impactfem.stages.building.targets import LEAST_SHARE, bending_modes


def test_modes_that_move_the_mass():
    masses = np.array([600.0, 0.0, 9.9, 200.0, 10.0])
    assert bending_modes(masses, 1000.0).tolist() == [0, 3, 4]
    assert bending_modes(masses, 1000.0, 0.5).tolist() == [0]


def test_none_of_local_modes():
    assert bending_modes(np.full(5, 0.9 * LEAST_SHARE * 1000.0), 1000.0).size == 0
