from dataclasses import replace

import numpy as np
import pytest

from impactfem.sticks.calibration import Bounds, Parameters, Target, assess, calibrate, family_modes
from impactfem.sticks.element import COMPONENTS
from impactfem.sticks.modes import modes
from impactfem.system.errors import ImpactfemError, SolutionError

from .conftest import damped_stick

TRUE = Parameters(0.37, np.array([4.1, 3.3, 3.0]), 0.45, 0.15)
BOUNDS = Bounds(
    factor=(0.05, 1.0),
    height_min=np.array([3.0, 2.8, 3.0]),
    height_max=np.array([4.6, 3.8, 3.0]),
    height=10.4,
    rigid_depth=0.6,
)
START = Parameters(1.0, np.array([3.5, 3.4, 3.0]), 0.2, 0.4)
SOFTER = {"a": 1.0, "b": 0.6}


@pytest.fixture
def make(floors):
    """Building b has softer walls than a, the rest is shared."""

    def stick(name, parameters):
        s = parameters.factor * SOFTER[name]
        built = []
        for floor, height in zip(floors(3), parameters.heights, strict=True):
            section = replace(floor.section, E=s * floor.section.E, G=s * floor.section.G)
            zones = {"below": parameters.below, "above": parameters.above}
            built.append(replace(floor, section=section, height=float(height), **zones))
        return damped_stick(name, built)

    return stick


def targets_of(make, parameters, *, direction="y", names="ab", numbers=(1, 2, 3)):
    found = []
    for name in names:
        frequency, mass = family_modes(make(name, parameters), direction)
        found += [Target(name, k, frequency[k - 1], mass[k - 1]) for k in numbers]
    return found


def fit(make, targets, bounds=BOUNDS, *, direction="y", starts=3, start=START, seed=0):
    return calibrate(
        make, targets, bounds, direction=direction, start=start, starts=starts, seed=seed
    )


@pytest.mark.parametrize("direction", ["x", "y"])
def test_family_modes_are_those_of_the_whole_stick(make, direction):
    stick = make("a", TRUE)
    whole = modes(stick)
    family = whole.of_family(direction)
    frequency, mass = family_modes(stick, direction)
    assert frequency == pytest.approx(whole.frequency[family], rel=1e-9)
    expected = whole.effective_mass[COMPONENTS.index(direction), family]
    assert mass == pytest.approx(expected, rel=1e-6, abs=1e-6 * mass.max())
    assert mass.sum() == pytest.approx(720e3, rel=1e-9)


@pytest.mark.parametrize("direction", ["x", "y"])
def test_a_stick_is_found_again_from_its_own_modes(make, direction):
    result = fit(make, targets_of(make, TRUE, direction=direction), direction=direction)
    assert np.abs(result.frequency_error).max() < 2e-4
    assert np.abs(result.mass_error).max() < 2e-3
    found = result.parameters
    assert found.factor == pytest.approx(TRUE.factor, rel=0.02)
    assert found.heights == pytest.approx(TRUE.heights, rel=0.02)
    assert found.below == pytest.approx(TRUE.below, abs=0.05)
    # The start was not there.
    begin = assess(make, result.targets, START, direction=direction)
    assert np.abs(begin.frequency_error).max() > 0.1


def test_what_is_kept(make):
    targets = [Target("a", 1, 3.1, 500e3), Target("a", 2, 9.9, 100e3)]
    found = fit(make, targets).parameters
    assert found.heights.sum() == pytest.approx(10.4, abs=1e-6)
    assert found.below + found.above == pytest.approx(0.6)
    assert 0.0 <= found.below <= 0.6
    assert np.all(found.heights >= BOUNDS.height_min - 1e-9)
    assert np.all(found.heights <= BOUNDS.height_max + 1e-9)
    assert found.heights[2] == 3.0
    assert BOUNDS.factor[0] <= found.factor <= BOUNDS.factor[1]


def test_the_same_seed_gives_the_same_result(make):
    targets = targets_of(make, TRUE)
    one, other = fit(make, targets, starts=2, seed=3), fit(make, targets, starts=2, seed=3)
    assert np.array_equal(one.frequency, other.frequency)
    assert np.array_equal(one.parameters.heights, other.parameters.heights)


def fixed(**changes):
    heights = TRUE.heights
    bounds = replace(BOUNDS, height_min=heights, height_max=heights, height=float(heights.sum()))
    return replace(bounds, **changes)


def test_factor_goes_with_the_square_of_the_frequencies(make):
    targets = [replace(one, frequency=1.1 * one.frequency) for one in targets_of(make, TRUE)]
    result = fit(make, targets, fixed(), starts=2)
    assert result.parameters.factor == pytest.approx(1.21 * TRUE.factor, rel=1e-3)
    assert np.array_equal(result.parameters.heights, TRUE.heights)
    # No further than the bound.
    result = fit(make, targets, fixed(factor=(0.05, 0.4)), starts=2)
    assert result.parameters.factor == pytest.approx(0.4)
    assert result.frequency_error.max() < -0.01


def test_without_a_rigid_depth_there_is_no_split(make):
    plain = replace(TRUE, below=0.0, above=0.0)
    result = fit(make, targets_of(make, plain), fixed(rigid_depth=0.0), starts=1)
    assert result.parameters.below == result.parameters.above == 0.0
    assert result.parameters.factor == pytest.approx(plain.factor, rel=1e-9)


def test_weights(make):
    good = targets_of(make, TRUE, names="a")
    wrong = replace(good[1], frequency=2 * good[1].frequency, effective_mass=None)
    ignored = fit(make, [good[0], replace(wrong, frequency_weight=0.0), good[2]], starts=1)
    assert np.abs(ignored.frequency_error[[0, 2]]).max() < 1e-3
    pulled = fit(make, [good[0], wrong, good[2]], starts=1)
    assert np.abs(pulled.frequency_error[[0, 2]]).max() > 0.05
    mass = replace(good[0], effective_mass=0.5 * good[0].effective_mass, mass_weight=0.0)
    assert np.abs(fit(make, [mass, *good[1:]], starts=1).frequency_error).max() < 1e-3


@pytest.mark.parametrize("height", [8.7, 11.5])
def test_heights_that_cannot_add_up(make, height):
    expected = rf"between 8.8 m and 11.4 m in all cannot add up to calib.*= {height}"
    with pytest.raises(ImpactfemError, match=expected):
        fit(make, targets_of(make, TRUE), replace(BOUNDS, height=height))


@pytest.mark.parametrize("digit", [-1, 0, 1])
def test_heights_that_add_up_but_for_rounding(make, digit):
    heights = np.array([3.3, 3.3, 3.3])
    height = 9.9 * (1.0 + digit * 1e-12)
    assert heights.sum() != 9.9  # in binary
    bounds = fixed(height_min=heights, height_max=heights, height=height)
    found = fit(make, targets_of(make, TRUE), bounds, starts=1)
    assert np.array_equal(found.parameters.heights, heights)
    with pytest.raises(ImpactfemError, match="cannot add up"):
        fit(make, targets_of(make, TRUE), replace(bounds, height=height + 1e-6), starts=1)


@pytest.mark.parametrize("mode", [7, 100])
def test_a_mode_that_is_not_there(make, mode):
    targets = [Target("a", 6, 90.0, None), Target("b", mode, 100.0, None)]
    expected = f"the targets name mode {mode} of building b, which has 6 modes of bending along y"
    with pytest.raises(ImpactfemError, match=expected):
        assess(make, targets, START, direction="y")
    with pytest.raises(ImpactfemError, match=expected):
        fit(make, targets, starts=1)
    assert assess(make, targets[:1], START, direction="y").frequency.size == 1


def test_without_a_weight_on_any_frequency(make):
    targets = [replace(target, frequency_weight=0.0) for target in targets_of(make, TRUE)]
    with pytest.raises(ImpactfemError, match="frequency_weight above 0"):
        fit(make, targets, starts=1)
    # One is enough, and to look at given values none is needed.
    one = [*targets[:-1], replace(targets[-1], frequency_weight=1.0)]
    assert fit(make, one, fixed(), starts=1).frequency_error[-1] == pytest.approx(0.0, abs=1e-6)
    assert np.isfinite(assess(make, targets, START, direction="y").frequency).all()


def test_no_result(make):
    # Masses that are not numbers: no start leads anywhere.
    with pytest.raises(SolutionError, match="result from 2 starts"):
        fit(make, [Target("a", 1, 3.0, float("nan"))], fixed(), starts=2)


def test_assess_changes_nothing(make):
    targets = targets_of(make, TRUE, names="b", numbers=(2,))
    at_start = assess(make, targets, START, direction="y")
    assert at_start.parameters is START and at_start.targets == tuple(targets)
    frequency, mass = family_modes(make("b", START), "y")
    assert at_start.frequency == pytest.approx(frequency[[1]])
    assert at_start.effective_mass == pytest.approx(mass[[1]])
    assert at_start.frequency_error == pytest.approx(frequency[[1]] / targets[0].frequency - 1)
    assert at_start.mass_error == pytest.approx(mass[[1]] / targets[0].effective_mass - 1)
    assert np.abs(at_start.frequency_error).max() > 0.1
    exact = assess(make, targets, TRUE, direction="y")
    assert not exact.frequency_error.any() and not exact.mass_error.any()


def test_a_mass_that_is_no_target_has_no_error(make):
    targets = [Target("a", 1, 3.0, None), Target("a", 2, 9.0, 100e3)]
    result = assess(make, targets, START, direction="y")
    assert np.isnan(result.mass_error[0]) and np.isfinite(result.mass_error[1])
