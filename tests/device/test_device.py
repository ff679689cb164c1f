import numpy as np
import pytest

from impactfem.device.device import coupled, refuse_mechanism
from impactfem.device.modes import device_modes
from impactfem.device.parts import Beam
from impactfem.system.errors import ImpactfemError


def test_columns_and_names(pump, altered):
    device = pump()
    assert device.anchors == 1 and device.inputs == ("x", "y", "z", "rx", "ry", "rz")
    assert device.column("rx") == 3
    with pytest.raises(ImpactfemError, match="no component 'w' of anchor 1"):
        device.column("w")
    with pytest.raises(ImpactfemError, match="component 'y' of anchor 2"):
        device.column("y", 2)
    two = altered(
        L=np.hstack([device.L, 0 * device.L]),
        r=np.hstack([device.r, 0 * device.r]),
        J=np.kron(np.diag([1.0, 0.0]), device.J),
    )
    assert two.inputs[6:8] == ("2.x", "2.y") and two.column("y", 2) == 7
    assert altered(J=1.1 * device.J).J[0, 0] == pytest.approx(1650.0)  # more mass than it shows
    with pytest.raises(ImpactfemError, match="six components an anchor"):
        altered(L=device.L[:, :5], r=device.r[:, :5], J=device.J[:5, :5])
    with pytest.raises(ImpactfemError, match=r"device pump: a mechanism.*base rx"):
        pump(rx=0.0)


def test_rayleigh_and_one_ratio(pump, altered):
    device = pump()
    law = device.damping
    assert pytest.approx(law.alpha * device.M + law.beta * device.K) == device.C
    same = altered(damping=0.03)
    assert device_modes(same).damping == pytest.approx(0.03)
    assert device_modes(same).proportional


def test_a_damper_couples_the_modes(altered):
    found = device_modes(altered(dampers=np.diag([1e5, 0.0, 0.0, 0.0])))
    assert not found.proportional
    assert device_modes(altered(dampers=np.zeros((4, 4)))).proportional


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("M", lambda M: M + np.eye(4, k=1), "device pump: M is not symmetric"),
        ("K", lambda K: K + np.max(K) * np.eye(4, k=1), "device pump: K is not symmetric"),
        ("J", lambda J: J + np.eye(6, k=1), "device pump: J is not symmetric"),
        ("L", lambda L: L[:, :5], r"L needs shape \(4, 6\)"),
        ("K", lambda K: np.nan * K, "K holds a value that is not a finite number"),
        ("dampers", lambda _: np.eye(3), r"dampers needs shape \(4, 4\)"),
        ("M", lambda M: 0.0 * M, "nothing that moves has a mass"),
        ("J", lambda J: 0.9 * J, "its mass is indefinite"),
        ("damping", lambda _: 1.2, "expected 0 <= ratio < 1"),
    ],
)
def test_bad_matrices_are_refused(altered, pump, name, change, words):
    with pytest.raises(ImpactfemError, match=words):
        altered(**{name: change(getattr(pump(), name))})


def test_motions_of_a_mechanism_are_named():
    with pytest.raises(ImpactfemError, match=r"device d: a mechanism.* motion base rx; expected"):
        refuse_mechanism("d", np.diag([1.0, 0.0]), ["base y", "base rx"])
    K = 1e6 * np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    with pytest.raises(ImpactfemError, match="motion a with b; expected"):
        refuse_mechanism("d", K, ["a", "b", "c"])
    K[0, 0] *= 1.0 + 1e-6
    refuse_mechanism("d", K, ["a", "b", "c"])
    # Units do not matter.
    refuse_mechanism("d", np.diag([1e12, 1e-6]), ["a", "b"])
    with pytest.raises(ImpactfemError, match="motion b;"):
        refuse_mechanism("d", np.diag([1e12, -1e-6]), ["a", "b"])


def test_a_rigid_motion_costs_nothing(pump):
    device = pump(Beam(0.46, 8e7, 8e7, mass=45.9), z=1e9, rz=1e7)
    M, C, K = coupled(device)
    assert M[:6, :6] == pytest.approx(device.J, abs=1e-9)
    for matrix in (C, K):
        assert np.abs(matrix[:, :6]).max() < 1e-12 * np.abs(matrix).max()
