import numpy as np
import pytest

from impactfem.device.mechanism import refuse_mechanism
from impactfem.system.errors import ImpactfemError


def test_a_motion_without_stiffness_is_named():
    with pytest.raises(ImpactfemError, match=r"device d: a mechanism.* motion base rx; expected"):
        refuse_mechanism("d", np.diag([1.0, 0.0]), ["base y", "base rx"])


def test_a_motion_of_several_is_named():
    K = 1e6 * np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    with pytest.raises(ImpactfemError, match="motion a with b; expected"):
        refuse_mechanism("d", K, ["a", "b", "c"])
    K[0, 0] *= 1.0 + 1e-6
    refuse_mechanism("d", K, ["a", "b", "c"])


def test_units_do_not_matter():
    refuse_mechanism("d", np.diag([1e12, 1e-6]), ["a", "b"])
    with pytest.raises(ImpactfemError, match="motion b;"):
        refuse_mechanism("d", np.diag([1e12, -1e-6]), ["a", "b"])
