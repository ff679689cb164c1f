import pytest

from impactfem.device.beam import Beam
from impactfem.device.fit import Target, fit_device
from impactfem.device.modes import device_modes
from impactfem.system.errors import ImpactfemError, SolutionError


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
    with pytest.raises(ImpactfemError, match="a fit of 2 parameters to 1 values"):
        fit_device(lambda a, b: pump(rx=a, y=b), {"a": 1e7, "b": 1e8}, (Target(25.0),))
    with pytest.raises(ImpactfemError, match="must be positive"):
        fit_device(lambda a: pump(rx=a), {"a": -1e7}, (Target(25.0),))
    with pytest.raises(SolutionError, match="2 modes move it along y, 3 are asked for"):
        fit_device(lambda a: pump(rx=a), {"a": 1e7}, (Target(25.0), Target(80.0), Target(90.0)))
