from dataclasses import replace

import numpy as np
import pytest

from impactfem.device import anchor_force as module
from impactfem.device.anchor_force import (
    anchor_force,
    anchor_forces,
    base_imbalance,
    own_accelerations,
    own_motions,
)
from impactfem.device.models import from_matrices
from impactfem.device.parts import Beam
from impactfem.sticks.element import COMPONENTS
from impactfem.system.errors import ImpactfemError, SolutionError

STEP = 1e-3


def test_modes_above_the_limit_follow_rigidly(pump, shaking):
    slow = np.zeros((6, 2001))
    slow[1] = 1.0 - np.cos(2 * np.pi * 0.5 * STEP * np.arange(2001))
    device = pump(Beam(0.46, 8e7, 8e7, mass=45.9))
    rigid = anchor_force(device, slow, STEP, maximum_frequency=1.0)
    assert rigid.modal.shape[0] == 0
    assert rigid.force == pytest.approx(-device.J @ slow, abs=1e-9)
    full = anchor_force(device, slow, STEP, maximum_frequency=3000.0)
    assert full.force[1] == pytest.approx(rigid.force[1], abs=2e-3 * full.largest[1])
    assert rigid.motion[1] == pytest.approx(full.motion[1], abs=1e-3 * np.abs(full.motion[1]).max())
    quick = shaking()
    both = [anchor_force(device, quick, STEP, maximum_frequency=f).force[1] for f in (1.0, 3000.0)]
    assert np.abs(both[0] - both[1]).max() > 0.5 * np.abs(both[0]).max()


def test_wrong_modes_break_the_balance(pump, shaking, monkeypatch):
    right = module.oscillator_response

    def wrong(*arguments):
        response = right(*arguments)
        response.relative_displacement[:] *= 1.0 + 1e-5
        return response

    monkeypatch.setattr(module, "oscillator_response", wrong)
    with pytest.raises(SolutionError, match="inertia force"):
        anchor_force(pump(), shaking(), STEP)


def test_a_stiffness_between_anchors_needs_the_displacement(shaking):
    K = 1e6 * np.array([[1.0, -1.0, 0.0], [-1.0, 3.0, -2.0], [0.0, -2.0, 2.0]])
    device = from_matrices("d", np.diag([0.0, 50.0, 0.0]), K, {0: 1, 2: 7}, 0.02, anchors=2)
    motion = shaking(anchors=2)
    with pytest.raises(ImpactfemError, match="expected their displacement"):
        anchor_force(device, motion, STEP)
    shift = np.zeros_like(motion)
    shift[1] = 1e-3
    moved = anchor_force(device, motion, STEP, displacement=shift).force
    still = anchor_force(device, motion, STEP, displacement=0.0 * shift).force
    assert (moved - still)[1] == pytest.approx(-2e6 / 3.0 * 1e-3)
    assert (moved - still)[7] == pytest.approx(2e6 / 3.0 * 1e-3)


@pytest.mark.parametrize(
    ("beam", "motion", "words"),
    [
        (None, np.zeros((3, 9)), r"device pump: the acceleration .* needs shape \(6"),
        (None, np.full((6, 9), np.nan), "not a finite number"),
        (Beam(0.46, 8e7, 8e7, mass=45.9), np.zeros((6, 9)), "is damped by"),
    ],
)
def test_bad_motions_are_refused(pump, altered, shaking, beam, motion, words):
    with pytest.raises(ImpactfemError, match="damping couples"):
        anchor_force(altered(dampers=np.diag([1e5, 0.0, 0.0, 0.0])), shaking(), STEP)
    with pytest.raises(ImpactfemError, match=words):
        anchor_force(pump(beam), motion, STEP)


def test_forces_and_moments_have_each_their_own_scale(pump):
    forces = np.array([[4e3], [5e3], [0.0], [20.0], [10.0], [0.0]])
    assert base_imbalance(pump(), forces, forces) == 0.0
    for row, worst in ((1, 2e-4), (3, 5e-2)):
        wrong = forces.copy()
        wrong[row] += 1.0
        assert base_imbalance(pump(), forces, wrong) == pytest.approx(worst)


def test_blocked_motions_are_not_compared(pump):
    forces = np.full((6, 3), 100.0)
    springs = forces.copy()
    # Along z and about z the pump's base is blocked.
    springs[[2, 5]] = 0.0
    assert base_imbalance(pump(), forces, springs) == 0.0
    assert base_imbalance(pump(z=1e9), forces, springs) == pytest.approx(1.0)
    assert base_imbalance(pump(), forces[:, :0], springs[:, :0]) == 0.0
    device = pump(Beam(0.46, 8e7, 8e7), **dict.fromkeys(COMPONENTS, np.inf))
    assert np.isnan(base_imbalance(device, np.ones((6, 2)), np.ones((6, 2))))


def test_masses_on_the_anchor_press_without_a_spring():
    """40 kg of 100 kg sit on the anchor; without its acceleration nothing can be compared."""
    M, k = np.diag([40.0, 60.0]), 5e5
    device = from_matrices("mast", M, k * np.array([[1.0, -1.0], [-1.0, 1.0]]), {0: 1}, 0.02)
    inertia, springs, a = np.zeros((3, 6, 2))
    a[1] = 2.0, 3.0
    springs[1] = -200.0, -100.0
    inertia[1] = springs[1] - 40.0 * a[1]
    assert np.isnan(base_imbalance(device, inertia, springs))
    assert base_imbalance(device, inertia, springs, a) < 1e-15
    assert base_imbalance(device, inertia, springs, 0.5 * a) == pytest.approx(60.0 / 280.0)


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
    with pytest.raises(ImpactfemError, match="begins with 'top'"):
        own_motions(device, "top")


def test_absolute_accelerations_of_a_static_load_are_the_anchors(pump):
    device = pump(z=1e9, rz=1e7)
    q = own_accelerations(device)
    assert q.static(device) == pytest.approx(device.r, abs=1e-9)
    assert q.names[0] == "acceleration base x" and q.units[3] == "rad/s2"


def test_quantities_are_joined(pump):
    device = pump()
    both = own_motions(device) + anchor_forces(device)
    assert len(both.names) == 10 == both.own.shape[0]
    assert both.static(device)[4:] == pytest.approx(anchor_forces(device).static(device))
    with pytest.raises(ImpactfemError, match="10 quantities need"):
        replace(both, own=both.own[:9])
