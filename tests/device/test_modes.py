import numpy as np
import pytest

from impactfem.device.beam import Beam
from impactfem.device.modes import device_modes
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import ImpactfemError


def closed_form(m, h, J, k, kappa):
    """Squares of ω of a body on a spring across and one about: a quadratic."""
    # det [k - ω² m, -ω² m h; -ω² m h, κ - ω² (J + m h²)] = 0
    return np.sort(np.roots([m * J, -(k * (J + m * h**2) + kappa * m), k * kappa]))


def test_rigid_body_against_the_quadratic(pump):
    found = device_modes(pump())
    for axis, about, J, k, kappa in ((1, 3, 220.0, 1.2e8, 3.0e7), (0, 4, 240.0, 1.4e8, 2.5e7)):
        mine = found.effective_mass[axis] > 1.0
        squares = closed_form(1500.0, 0.46, J, k, kappa)
        assert found.omega[mine] ** 2 == pytest.approx(squares, rel=1e-9)
        assert found.effective_mass[axis].sum() == pytest.approx(1500.0, rel=1e-9)
        assert found.effective_mass[about].sum() == pytest.approx(J + 1500.0 * 0.46**2, rel=1e-9)
        # The lower mode leans over: it acts above the mass centre; the moments add up to m h.
        assert found.height[mine][0] > 0.46 > 0.0 > found.height[mine][1]
        moment = found.height[mine] @ found.effective_mass[axis, mine]
        assert moment == pytest.approx(1500.0 * 0.46, rel=1e-9)


def test_a_blocked_mass_is_left_over(pump):
    found = device_modes(pump())
    assert np.diag(found.rigid_mass) == pytest.approx([0, 0, 1500.0, 0, 0, 190.0], abs=1e-6)
    assert found.share[2].max() == 0.0
    free = device_modes(pump(z=1.0e9, rz=1.0e7))
    assert np.abs(np.diag(free.rigid_mass)).max() < 1e-6
    assert np.isnan(free.height[np.argmax(free.effective_mass[2])])
    assert free.share.sum(axis=1) == pytest.approx(1.0)


def test_damping_ratios(pump):
    found = device_modes(pump())
    wanted = Rayleigh.through(0.02, 30.0, 80.0).ratio(found.frequency)
    assert found.damping == pytest.approx(wanted, rel=1e-9)
    assert found.proportional


def test_reaction_masses(pump):
    found = device_modes(pump())
    whole = found.reaction_mass.sum(axis=0) + found.rigid_mass
    assert whole == pytest.approx(pump().J, abs=1e-6)
    assert found.reaction_mass[0, 1, 1] == pytest.approx(found.effective_mass[1, 0])


def test_modes_below_a_frequency(pump):
    found = device_modes(pump())
    low = found.below(40.0)
    assert low.frequency.size == 2 and low.below(None) is low
    assert low.rigid_mass[1, 1] == pytest.approx(
        found.effective_mass[1, found.frequency > 40.0].sum()
    )


def test_overdamped_modes_are_refused(pump):
    device = pump(Beam(0.46, 8e7, 8e7, mass=45.9))
    found = device_modes(device)
    found.below(3000.0).refuse_overdamped(device)
    with pytest.raises(
        ImpactfemError, match=r"mode at .* Hz is damped by 2.*; expected less than 100 %"
    ):
        found.refuse_overdamped(device)
