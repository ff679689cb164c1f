from dataclasses import fields

import numpy as np
import pytest
import scipy.linalg

from impactfem.device.device import Device, coupled, refuse_mechanism
from impactfem.device.models import from_matrices
from impactfem.device.modes import device_modes
from impactfem.device.parts import Beam
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


BEAM = Beam(0.46, 8e7, 8e7, mass=45.9)


@pytest.mark.parametrize("coordinates", ["absolute", "relative"])
def test_a_rigid_motion_costs_nothing(pump, coordinates):
    device = pump(BEAM, z=1e9, rz=1e7)
    found = coupled(device, coordinates)
    rigid = np.vstack([np.eye(6), device.r if coordinates == "absolute" else 0 * device.r])
    assert np.abs(found.K @ rigid).max() < 1e-12 * np.abs(found.K).max()
    assert np.abs(found.C @ rigid).max() < 1e-12 * np.abs(found.C).max()
    assert np.abs(found.own @ rigid).max() < 1e-12
    assert rigid.T @ found.M @ rigid == pytest.approx(device.J, abs=1e-9)
    dragged = coupled(device, coordinates, drag=True)
    assert rigid.T @ dragged.C @ rigid == pytest.approx(device.drag_coefficient() * device.J)
    assert np.array_equal(dragged.K, found.K) and np.array_equal(dragged.M, found.M)


def test_drag_is_rayleigh_damping_of_all_degrees_of_freedom(pump):
    device = pump(BEAM)
    found = coupled(device, "absolute", drag=True)
    wanted = device.damping.alpha * found.M + device.damping.beta * found.K
    size = np.abs(wanted).max()
    assert np.abs(found.C - wanted).max() < 1e-12 * size
    assert np.abs(coupled(device).C - wanted).max() > 1e-4 * size


def test_a_device_on_a_floor_is_one_model():
    """A floor and a device of two masses, put together by the interface and as one chain."""
    k, c, m, n = 4e5, 9e4, 30.0, 20.0
    K = np.array([[k, -k, 0.0], [-k, k + c, -c], [0.0, -c, c]])
    device = from_matrices("d", np.diag([0.0, m, n]), K, {0: 1}, 0.02)
    floor_mass, floor_stiffness = 500.0, 7e6
    whole_K = K.copy()
    whole_K[0, 0] += floor_stiffness
    wanted = scipy.linalg.eigvalsh(whole_K, np.diag([floor_mass, m, n]))
    y, others = 1, [6, 7]
    for coordinates in ("absolute", "relative"):
        part = coupled(device, coordinates)
        M, K_all = part.M.copy(), part.K.copy()
        M[y, y] += floor_mass
        K_all[y, y] += floor_stiffness
        keep = np.ix_([y, *others], [y, *others])
        assert scipy.linalg.eigvalsh(K_all[keep], M[keep]) == pytest.approx(wanted, rel=1e-10)
    assert part.interface == 6 and part.coordinates == "relative"


def test_bad_requests_are_refused(pump):
    with pytest.raises(ImpactfemError, match="the coordinates are one of"):
        coupled(pump(), "modal")
    with pytest.raises(ImpactfemError, match="it has no Rayleigh damping"):
        coupled(pump(damping=0.02), drag=True)
    assert coupled(pump(damping=0.02)).C.any()
