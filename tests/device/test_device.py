from dataclasses import fields

import numpy as np
import pytest

from impactfem.device.device import Device
from impactfem.device.modes import device_modes
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import ImpactfemError


@pytest.fixture
def altered(pump):
    """The pump with some of its matrices replaced."""
    sound = pump()
    given = {f.name: getattr(sound, f.name) for f in fields(Device) if f.init}
    return lambda **changes: Device(**{**given, **changes})


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


def test_rayleigh_and_one_ratio(pump, altered):
    device = pump()
    law = device.damping
    assert pytest.approx(law.alpha * device.M + law.beta * device.K) == device.C
    assert device.drag_coefficient() == device.damping.alpha
    same = altered(damping=0.03)
    assert device_modes(same).damping == pytest.approx(0.03)
    assert device_modes(same).proportional
    with pytest.raises(ImpactfemError, match="device pump: it has no Rayleigh damping"):
        same.drag_coefficient()
    with pytest.raises(ImpactfemError, match="expected 0 <= ratio < 1"):
        altered(damping=1.2)


def test_a_damper_couples_the_modes(altered):
    found = device_modes(altered(dampers=np.diag([1e5, 0.0, 0.0, 0.0])))
    assert not found.proportional
    assert device_modes(altered(dampers=np.zeros((4, 4)))).proportional


@pytest.mark.parametrize("name", ["M", "K", "J"])
def test_skew_matrices_are_refused(altered, pump, name):
    matrix = getattr(pump(), name).copy()
    matrix[0, 1] += 1.0
    with pytest.raises(ImpactfemError, match=f"device pump: {name} is not symmetric"):
        altered(**{name: matrix})


def test_bad_shapes_and_values_are_refused(altered, pump):
    device = pump()
    with pytest.raises(ImpactfemError, match=r"L needs shape \(4, 6\)"):
        altered(L=device.L[:, :5])
    with pytest.raises(ImpactfemError, match="K holds a value that is not a finite number"):
        altered(K=np.full((4, 4), np.nan))
    with pytest.raises(ImpactfemError, match="six components an anchor"):
        altered(L=device.L[:, :5], r=device.r[:, :5], J=device.J[:5, :5])
    with pytest.raises(ImpactfemError, match=r"dampers needs shape \(4, 4\)"):
        altered(dampers=np.eye(3))


def test_bad_masses_are_refused(altered, pump):
    device = pump()
    with pytest.raises(ImpactfemError, match="nothing that moves has a mass"):
        altered(M=0 * device.M, L=0 * device.L)
    with pytest.raises(ImpactfemError, match="its mass is indefinite"):
        altered(J=0.9 * device.J)
    assert altered(J=1.1 * device.J).J[0, 0] == pytest.approx(1650.0)


def test_a_mechanism_is_refused(pump):
    with pytest.raises(ImpactfemError, match=r"device pump: a mechanism.*base rx"):
        pump(rx=0.0)


def test_rayleigh_is_kept(pump):
    assert isinstance(pump().damping, Rayleigh)
