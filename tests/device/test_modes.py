import numpy as np
import pytest

from impactfem.device.modes import Target, device_modes, fit_device
from impactfem.device.parts import Beam
from impactfem.system.errors import ImpactfemError, SolutionError


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
    with pytest.raises(ImpactfemError, match=r"2.*; expected less than 100"):
        found.refuse_overdamped(device)


def targets_of(device):
    modes = device_modes(device)
    mine = modes.effective_mass[1] > 1.0
    pairs = zip(modes.frequency[mine], modes.effective_mass[1, mine], strict=True)
    return tuple(Target(float(f), float(m)) for f, m in pairs)


def test_known_parameters_are_found(pump):
    targets = targets_of(pump(mass=1234.0, rx=2.0e7))
    found = fit_device(
        lambda mass, about: pump(mass=mass, rx=about), {"mass": 900.0, "about": 5e7}, targets
    )
    assert found.parameters == pytest.approx({"mass": 1234.0, "about": 2.0e7}, rel=1e-8)
    assert abs(found.frequency_deviation).max() < 1e-9
    assert abs(found.mass_deviation).max() < 1e-9


def test_what_remains_is_given(pump):
    targets = targets_of(pump(Beam(0.46, 8e7, 8e7, elements=1)))
    by_all = fit_device(lambda about: pump(rx=about), {"about": 3e7}, targets)
    by_frequency = fit_device(lambda about: pump(rx=about), {"about": 3e7}, targets, masses=False)
    assert 1e-3 < abs(by_all.frequency_deviation).max() < 0.2
    both = [(f.frequency_deviation**2).sum() for f in (by_frequency, by_all)]
    assert both[0] < both[1]


def test_without_masses(pump):
    found = fit_device(lambda about: pump(rx=about), {"about": 1e7}, (Target(25.0),))
    assert found.frequency == pytest.approx([25.0])
    assert found.mass_deviation != found.mass_deviation  # nan


def test_bad_fits_are_refused(pump):
    with pytest.raises(ImpactfemError, match="2 parameters to 1 values"):
        fit_device(lambda a, b: pump(rx=a, y=b), {"a": 1e7, "b": 1e8}, (Target(25.0),))
    with pytest.raises(ImpactfemError, match="must be positive"):
        fit_device(lambda a: pump(rx=a), {"a": -1e7}, (Target(25.0),))
    with pytest.raises(SolutionError, match="along y, 3 are requested"):
        fit_device(lambda a: pump(rx=a), {"a": 1e7}, (Target(25.0), Target(80.0), Target(90.0)))
