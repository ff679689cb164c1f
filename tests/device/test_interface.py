from dataclasses import fields, replace

import numpy as np
import pytest

from impactfem.device.beam import Beam
from impactfem.device.body import Body
from impactfem.device.device import Device
from impactfem.device.from_matrices import from_matrices
from impactfem.device.interface import MountedDevice, interface_of
from impactfem.device.modes import device_modes
from impactfem.system.errors import ImpactfemError

SHAPES = np.random.default_rng(5).standard_normal((6, 9))


def altered(device, **changes):
    given = {f.name: getattr(device, f.name) for f in fields(Device) if f.init}
    return Device(**{**given, **changes})


def test_devices_side_by_side(pump):
    body = Body.at_height(40.0, 0.2, 1.0, 2.0, 3.0)
    devices = [
        MountedDevice("a", pump(), SHAPES),
        MountedDevice("b", body, 2.0 * SHAPES),
        MountedDevice("c", pump(mass=90.0), 3.0 * SHAPES),
    ]
    found = interface_of(devices)
    n = len(pump().motions)
    assert found.M.shape == (18 + 2 * n, 18 + 2 * n)
    assert np.array_equal(found.shapes[6:12], 2.0 * SHAPES)
    assert [list(rows) for rows in found.modes] == [
        list(range(18, 18 + n)),
        [],
        list(range(18 + n, 18 + 2 * n)),
    ]
    for one, rows, own in zip(devices, found.anchors, found.modes, strict=True):
        assert found.M[np.ix_(rows, rows)] == pytest.approx(one.mass)
        assert found.M[np.ix_(own, own)] == pytest.approx(np.eye(len(own)), abs=1e-12)
        others = np.setdiff1d(np.arange(len(found.M)), np.concatenate([rows, own]))
        for matrix in (found.M, found.C, found.K):
            assert not matrix[np.ix_(rows, others)].any() and not matrix[np.ix_(own, others)].any()
    omega = np.sqrt(np.diag(found.K)[found.modes[0]])
    assert omega == pytest.approx(device_modes(pump()).omega)
    assert found.own[0] @ found.own[0].T == pytest.approx(np.linalg.inv(pump().M))
    # Along a translation of the ground everything moves as one mass.
    mass = found.R.T @ found.M @ found.R
    assert mass == pytest.approx(np.diag(3 * [1500.0 + 40.0 + 90.0]))
    assert not found.R[18:].any() and found.R[:18].any()


def test_drag_holds_the_whole_device(pump):
    still, dragged = (
        interface_of([MountedDevice("d", pump(), SHAPES, drag=drag)]).C for drag in (False, True)
    )
    assert not still[:6].any()
    assert dragged[:6, :6] == pytest.approx(pump().drag_coefficient() * pump().J)
    with pytest.raises(ImpactfemError, match="it has no Rayleigh damping"):
        interface_of([MountedDevice("d", pump(damping=0.02), SHAPES, drag=True)])
    body = Body.at_height(40.0, 0.2, 1.0, 2.0, 3.0)
    with pytest.raises(ImpactfemError, match="device d: a rigid body has no Rayleigh damping"):
        interface_of([MountedDevice("d", body, SHAPES, drag=True)])


def test_motions_without_mass_are_left_out(pump):
    device = pump(Beam(0.46, 8e7, 8e7))
    found = interface_of([MountedDevice("d", device, SHAPES)])
    assert np.linalg.matrix_rank(device.M) == len(found.modes[0]) < len(device.motions)
    damped = np.zeros_like(device.M)
    damped[-7, -7] = 1e4
    with pytest.raises(ImpactfemError, match="device d: a damper acts on a motion without mass"):
        interface_of([MountedDevice("d", altered(device, dampers=damped), SHAPES)])
    # On a motion with mass it may be.
    heavy = pump(Beam(0.46, 8e7, 8e7, mass=45.9))
    one = MountedDevice("d", altered(heavy, dampers=damped), SHAPES)
    modal = interface_of([one]).C[6:, 6:]
    assert np.abs(modal - np.diag(np.diag(modal))).max() > 1.0


def test_a_stiffness_between_anchors_must_leave_translations_free():
    K = 1e6 * np.array([[1.0, -1.0, 0.0], [-1.0, 3.0, -2.0], [0.0, -2.0, 2.0]])
    device = from_matrices("d", np.diag([0.0, 50.0, 0.0]), K, {0: 1, 2: 7}, 0.02, anchors=2)
    one = MountedDevice("d", device, np.vstack([SHAPES, SHAPES]))
    assert interface_of([one]).K[1, 7] == pytest.approx(-2e6 / 3.0)
    K[1, 1] += 1e5
    held = from_matrices("d", np.diag([0.0, 50.0, 0.0]), K, {0: 1, 2: 7}, 0.02, anchors=2)
    with pytest.raises(ImpactfemError, match="resists a translation of all of them"):
        interface_of([replace(one, device=held)])


def test_bad_shapes_are_refused(pump):
    with pytest.raises(ImpactfemError, match=r"device d: the shapes .* need 6 rows.*\(3, 9\)"):
        interface_of([MountedDevice("d", pump(), SHAPES[:3])])
    with pytest.raises(ImpactfemError, match="not a finite number"):
        interface_of([MountedDevice("d", pump(), SHAPES * np.inf)])
