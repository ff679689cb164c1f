from dataclasses import replace

import numpy as np
import pytest

from impactfem.device.anchor_force import anchor_force
from impactfem.device.beam import Beam
from impactfem.device.quantity import anchor_forces, own_accelerations, own_motions
from impactfem.system.errors import ImpactfemError

STEP = 1e-3


def test_forces_of_a_static_load_are_the_weight(pump):
    for device in (pump(), pump(Beam(0.46, 8e7, 8e7, mass=45.9))):
        found = anchor_forces(device)
        assert found.names[:4] == ("force x", "force y", "force z", "moment x")
        assert found.units[2:4] == ("N", "N m")
        assert found.static(device) == pytest.approx(-device.J, rel=1e-9, abs=1e-8)


def test_forces_are_those_of_the_integration(pump, shaking):
    """Undamped, Q = c x + d ä is the force at every instant; damping adds what it carries."""
    motion = shaking()
    device = pump(damping=0.0)
    q = anchor_forces(device)
    run = anchor_force(device, motion, STEP)
    found = q.own @ run.motion + q.acceleration @ motion
    assert found == pytest.approx(run.force, abs=1e-9 * np.abs(run.force).max())
    damped = anchor_force(pump(), motion, STEP)
    off = q.own @ damped.motion + q.acceleration @ motion - damped.force
    assert 1e-3 < np.abs(off).max() / np.abs(damped.force).max() < 0.2


def test_displacements_of_the_base(pump, shaking):
    device = pump()
    q = own_motions(device)
    assert q.names == tuple(f"displacement base {c}" for c in ("x", "y", "rx", "ry"))
    assert q.units == ("m", "m", "rad", "rad")
    run = anchor_force(device, shaking(), STEP)
    assert np.array_equal(q.own @ run.motion, run.motion)
    # A spring gives way by its force over its stiffness.
    assert q.static(device)[1, 1] == pytest.approx(-1500.0 / 1.2e8)
    with pytest.raises(ImpactfemError, match="no own motion whose name begins with 'top'"):
        own_motions(device, "top")


def test_absolute_accelerations_of_a_static_load_are_the_anchors(pump):
    device = pump(z=1e9, rz=1e7)
    q = own_accelerations(device)
    assert q.static(device) == pytest.approx(device.r, abs=1e-9)
    assert q.names[0] == "acceleration base x" and q.units[3] == "rad/s2"
    one = own_accelerations(device, ["base rx"])
    assert one.own == pytest.approx(q.own[[3]])
    with pytest.raises(ImpactfemError, match="no own motion 'base w'"):
        own_accelerations(device, ["base w"])


def test_quantities_are_joined(pump):
    device = pump()
    both = own_motions(device) + anchor_forces(device)
    assert len(both.names) == 10 == both.own.shape[0]
    assert both.static(device)[4:] == pytest.approx(anchor_forces(device).static(device))
    with pytest.raises(ImpactfemError, match="10 quantities need as many units and rows"):
        replace(both, own=both.own[:9])
