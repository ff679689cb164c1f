import numpy as np
import pytest

from impactfem.device.from_matrices import from_matrices
from impactfem.device.modes import device_modes
from impactfem.system.errors import ImpactfemError

K = 1e6 * np.array([[1.0, -1.0, 0.0], [-1.0, 3.0, -2.0], [0.0, -2.0, 2.0]])
M = np.array([[5.0, 1.0, 0.0], [1.0, 50.0, 0.0], [0.0, 0.0, 7.0]])


def test_a_mass_between_two_anchors():
    device = from_matrices("d", M, K, {0: 1, 2: 7}, 0.02, anchors=2)
    assert device.r[0, [1, 7]] == pytest.approx([1 / 3, 2 / 3])
    assert device.L[0, [1, 7]] == pytest.approx([50 / 3 + 1.0, 100 / 3])
    between = 1e6 * 1.0 * 2.0 / 3.0
    found = device.anchor_stiffness[np.ix_([1, 7], [1, 7])]
    assert found == pytest.approx(between * np.array([[1.0, -1.0], [-1.0, 1.0]]))
    # All of it moving together weighs what the matrix says.
    together = np.zeros(12)
    together[[1, 7]] = 1.0
    assert together @ device.J @ together == pytest.approx(M.sum())
    assert device_modes(device).frequency == pytest.approx([np.sqrt(3e6 / 50.0) / (2 * np.pi)])


def test_one_anchor_has_no_stiffness_of_its_own():
    device = from_matrices("d", M, K, {0: 1}, 0.02)
    assert not device.anchor_stiffness.any()
    assert device.r[:, 1] == pytest.approx([1.0, 1.0])
    assert device.motions == ("degree of freedom 1", "degree of freedom 2")


def test_bad_input_is_refused():
    with pytest.raises(ImpactfemError, match="one square shape"):
        from_matrices("d", M[:2], K, {0: 1}, 0.02)
    with pytest.raises(ImpactfemError, match="each of the 6 components"):
        from_matrices("d", M, K, {0: 1, 2: 1}, 0.02)
    with pytest.raises(ImpactfemError, match="each of the 6 components"):
        from_matrices("d", M, K, {0: 1, 2: 7}, 0.02)
    with pytest.raises(ImpactfemError, match="2 motions need as many names"):
        from_matrices("d", M, K, {0: 1}, 0.02, motions=("a",))
    loose = K.copy()
    loose[0, :] = loose[:, 0] = 0.0
    loose[1, 1] = 2e6
    with pytest.raises(ImpactfemError, match=r"a mechanism.* motion a with b"):
        from_matrices("d", M, loose, {0: 1}, 0.02, motions=("a", "b"))
