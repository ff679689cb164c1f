import math

import numpy as np
import pytest

from impactfem.device.springs import BaseSprings
from impactfem.system.errors import ImpactfemError

EVERY = {"x": 1.0, "y": 2.0, "z": math.inf, "rx": 4.0, "ry": 5.0, "rz": math.inf}


def test_one_spring_a_direction():
    springs = BaseSprings.of_directions(**EVERY)
    assert springs.free.tolist() == [0, 1, 3, 4]
    assert np.diag(springs.stiffness).tolist() == [1.0, 2.0, 0.0, 4.0, 5.0, 0.0]


def test_a_missing_or_unknown_direction_is_refused():
    with pytest.raises(ImpactfemError, match="a stiffness for each of x, y, z, rx, ry, rz"):
        BaseSprings.of_directions(x=1.0)
    with pytest.raises(ImpactfemError, match="a stiffness for each of"):
        BaseSprings.of_directions(**EVERY, w=1.0)
    with pytest.raises(ImpactfemError, match="is not a number"):
        BaseSprings.of_directions(**{**EVERY, "x": math.nan})


def test_a_matrix_must_be_symmetric_where_it_is_free():
    k = np.diag(np.arange(1.0, 7.0))
    k[0, 4] = k[4, 0] = 0.5
    assert BaseSprings(k, np.zeros(6, dtype=bool)).free.size == 6
    k[4, 0] = 0.4
    with pytest.raises(ImpactfemError, match="symmetric and finite"):
        BaseSprings(k, np.zeros(6, dtype=bool))
    blocked = np.array([True, False, False, False, False, False])
    assert BaseSprings(k, blocked).free.size == 5
    with pytest.raises(ImpactfemError, match=r"shape \(6, 6\) and 6 marks"):
        BaseSprings(k[:5, :5], blocked)
