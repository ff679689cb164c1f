from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from impactfem.sticks.element import COMPONENTS
from impactfem.sticks.modes import FAMILIES, modes, natural_modes
from impactfem.sticks.stick import mass_on_spring
from impactfem.system.errors import SolutionError

from .conftest import damped_stick

UY, RX = 1, 3


@pytest.fixture
def stick(floors):
    return damped_stick("a", floors(3), axis=(5.0, 1.0), base=2.0)


def test_frequencies_against_the_plain_eigenvalue_problem(stick):
    values = np.linalg.eigvals(np.linalg.solve(stick.M, stick.K)).real
    found = modes(stick)
    assert found.frequency == pytest.approx(np.sqrt(np.sort(values)) / (2 * np.pi), rel=1e-9)
    assert np.all(np.diff(found.frequency) > 0.0)
    assert found.frequency.size == stick.n


def test_shapes_are_orthonormal(stick):
    found = modes(stick)
    assert np.abs(found.shape.T @ stick.M @ found.shape - np.eye(stick.n)).max() < 1e-9
    squares = (2 * np.pi * found.frequency) ** 2
    stiffness = found.shape.T @ stick.K @ found.shape
    assert np.abs(stiffness - np.diag(squares)).max() < 1e-9 * squares.max()


def test_effective_masses_add_up_to_the_total_in_all_directions(stick):
    found = modes(stick)
    assert found.total[:3] == pytest.approx(720e3)
    assert found.total[3] == pytest.approx(3 * 2.9e6 + 240e3 * (3.5**2 + 7.0**2 + 10.5**2))
    assert found.effective_mass.shape == (6, 18)
    assert found.effective_mass.sum(axis=1) == pytest.approx(found.total, rel=1e-10)
    some = found.effective_mass[:, 1:].sum(axis=1) / found.total
    assert some.min() < 0.95  # the first mode counts


def test_families_in_natural_order(stick):
    found = modes(stick)
    sizes = {name: found.of_family(name).size for name in FAMILIES}
    assert sizes == {"x": 6, "y": 6, "z": 3, "rz": 3}
    # EI and GA_v along y are smaller.
    assert found.frequency[found.of_family("y")[0]] < found.frequency[found.of_family("x")[0]]
    for name in FAMILIES:
        family = found.of_family(name)
        mass = found.effective_mass[COMPONENTS.index(name), family]
        assert mass.sum() == pytest.approx(found.total[COMPONENTS.index(name)], rel=1e-9)
        assert np.all(np.diff(found.frequency[family]) > 0.0)
    other = found.effective_mass[COMPONENTS.index("x"), found.of_family("y")]
    assert other.max() < 1e-12 * found.total[0]


def test_points_without_mass_drop_out(floors, stick):
    pointed = damped_stick("a", floors(3), axis=(5, 1), base=2, storey_points=[(1, 0.5), (3, 0.3)])
    plain, found = modes(stick), modes(pointed)
    assert found.frequency == pytest.approx(plain.frequency, rel=1e-9)
    assert found.shape.shape == (30, 18)
    assert found.effective_mass.sum(axis=1) == pytest.approx(plain.total, rel=1e-9)


def test_one_mass():
    found = modes(mass_on_spring("m", 4.0, 4.0 * (2 * np.pi * 3.0) ** 2))
    assert found.frequency == pytest.approx(3.0)


def test_a_mechanism_is_refused():
    stick = mass_on_spring("m", 4.0, 100.0)
    K = stick.K.copy()
    both = np.ix_([UY, RX], [UY, RX])
    K[both] = 100.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    with pytest.raises(SolutionError, match="building m: the stiffness"):
        modes(replace(stick, K=K))
    K[both] = 100.0 * np.array([[1.1, -1.0], [-1.0, 1.1]])
    assert modes(replace(stick, K=K)).frequency.size == 6


@pytest.mark.parametrize("value", [0.0, -1.0])
def test_a_component_without_stiffness_is_refused(floors, value):
    sound = damped_stick("a", floors(2))
    K = sound.K.copy()
    for component in (UY, 6 + 2, 6 + 5):
        broken = K.copy()
        broken[component, component] = value
        with pytest.raises(SolutionError, match="stiffness matrix"):
            modes(replace(sound, K=broken))
    assert modes(replace(sound, K=K)).frequency.size == 12


lengths = st.floats(2.5, 6.0)


@settings(deadline=None, max_examples=25)
@given(st.integers(1, 5), lengths, st.floats(0.2, 3.0), st.floats(0.2, 3.0), st.floats(0.5, 2.0))
def test_a_square_stick_has_clean_families(floors, n, height, area, moment, mass):
    """Modes along x and y have the same frequencies; any mixture of a pair would be a mode, too."""
    areas, moments = {"Avx": area, "Avy": area}, {"Ix": moment, "Iy": moment, "Iz": moment}
    square = replace(floors(1)[0].section, A=4.0 * area, **areas, **moments)
    alike = {"mass": mass * 240e3, "inertia": (2.9e6, 2.9e6, 5.8e6)}
    stick = damped_stick("a", floors(n, section=square, height=height, **alike))
    found = modes(stick)
    sizes = {name: found.of_family(name).size for name in FAMILIES}
    assert sizes == {"x": 2 * n, "y": 2 * n, "z": n, "rz": n}
    for name, components in FAMILIES.items():
        family = found.of_family(name)
        others = [k for k in range(stick.n) if k % 6 not in components]
        assert not found.shape[np.ix_(others, family)].any()
        total = found.total[COMPONENTS.index(name)]
        assert found.effective_mass[COMPONENTS.index(name), family].sum() == pytest.approx(total)
    along = [found.frequency[found.of_family(name)] for name in "xy"]
    assert along[0] == pytest.approx(along[1], rel=1e-9)


def test_against_the_plain_eigenvalue_problem():
    rng = np.random.default_rng(2)
    A, B = rng.standard_normal((2, 5, 5))
    M, K = A @ A.T + np.eye(5), B @ B.T + np.eye(5)
    omega, shape = natural_modes(M, K)
    assert omega**2 == pytest.approx(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real))
    assert shape.T @ M @ shape == pytest.approx(np.eye(5), abs=1e-10)
    assert shape.T @ K @ shape == pytest.approx(np.diag(omega**2), abs=1e-9 * omega[-1] ** 2)


def test_motions_without_mass_drop_out():
    # A mass behind two springs in series.
    K = np.array([[3.0, -2.0], [-2.0, 2.0]])
    omega, shape = natural_modes(np.diag([0.0, 4.0]), K)
    assert omega == pytest.approx([np.sqrt((1.0 * 2.0 / 3.0) / 4.0)])
    assert shape[0, 0] / shape[1, 0] == pytest.approx(2.0 / 3.0)
    assert natural_modes(np.diag([1.0, 4.0]), K)[0].size == 2


def test_equal_parts_that_do_not_couple_stay_apart():
    K = np.kron(np.eye(2), np.array([[3.0, -1.0], [-1.0, 2.0]]))
    omega, shape = natural_modes(np.eye(4), K)
    assert omega[0] == pytest.approx(omega[1], rel=1e-12)
    for column in shape.T:
        assert not column[:2].any() or not column[2:].any()
    K[0, 3] = K[3, 0] = 1e-3
    mixed = natural_modes(np.eye(4), K)[1]
    assert np.all(np.abs(mixed).min(axis=0) > 0.0)
