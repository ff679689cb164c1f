"""Sticks on the floors of a 3D model: matched modes, families, points inside storeys."""

import numpy as np
import pytest
import scipy.linalg

from impactfem.dynamics.damping import Rayleigh
from impactfem.sticks.condensed import condensed_stick, decoupled, floor_mass
from impactfem.sticks.modes import modes, natural_modes
from impactfem.sticks.stick import build_stick, on_floor_matrices

N = 3


@pytest.fixture(scope="module")
def stick(floors):
    return build_stick("a", floors(N), damping=Rayleigh(0.6, 8e-4))


@pytest.fixture(scope="module")
def model(stick):
    """Its floors as those of a 3D model: flexibility, mass, modes, effective masses."""
    found = modes(stick)
    effective = found.effective_mass.T / found.total
    return np.linalg.inv(stick.K), stick.M, found.frequency, found.shape, effective


def test_a_stick_is_its_own(stick, model):
    made = condensed_stick(*model)
    scale = np.sqrt(np.outer(np.diag(stick.K), np.diag(stick.K)))
    assert np.abs(made.K - stick.K).max() < 1e-9 * scale.max()
    assert made.frequency == pytest.approx(made.model_frequency, rel=1e-9)
    assert made.mac == pytest.approx(1.0)
    # Three along x and y, and one of torsion, whose higher modes are less than 1 % of its mass
    # or there as well.
    assert 7 <= len(made.number) <= 9


def test_matched_modes_are_exact_and_others_stay(stick, model):
    """The 3D model is 10 % stiffer in the matched modes than its flexibility says."""
    F, M, frequency, shape, effective = model
    made = condensed_stick(F, M, 1.1 * frequency, shape, effective)
    assert made.frequency == pytest.approx(made.model_frequency, rel=1e-9)
    every = natural_modes(M, made.K)[0] / (2.0 * np.pi)
    rest = np.delete(frequency, made.number - 1)
    expected = np.sort([*made.model_frequency, *rest])
    assert every == pytest.approx(expected, rel=1e-9)


def test_modes_that_the_floors_do_not_have_are_not_matched(model):
    """Of slabs: the floors have a tenth of the modal mass."""
    F, M, frequency, shape, effective = model
    weak = shape.copy()
    weak[:, 0] *= np.sqrt(0.1)
    assert 1 not in condensed_stick(F, M, frequency, weak, effective).number
    assert 1 in condensed_stick(*model).number


def test_families_that_hardly_couple(model):
    F = model[0]
    scale = np.sqrt(np.outer(np.diag(F), np.diag(F)))
    for part, coupled in ((0.005, False), (0.05, True)):
        with_part = F + part * scale
        assert (decoupled(with_part)[0, 1] != 0.0) == coupled
        assert decoupled(with_part)[0, 6] == with_part[0, 6]


def test_mass_of_an_eccentric_floor():
    """About its node: m e of the first moment, J + m e² of the second."""
    M = floor_mass(np.array([2.0]), np.array([[3.0, 5.0, 7.0]]), np.array([[0.3, -0.4]]))
    assert np.diag(M) == pytest.approx([2, 2, 2, 3 + 2 * 0.16, 5 + 2 * 0.09, 7 + 2 * 0.25])
    assert (M[0, 5], M[1, 5]) == pytest.approx((0.8, 0.6))
    assert pytest.approx(M.T) == M


def test_points_inside_storeys_keep_the_stiffness_of_the_floors(floors, stick):
    """Without a force on the point the floors have K; a force on it bends the storey as well."""
    K = 1.3 * stick.K
    with_point = build_stick("a", floors(N), damping=Rayleigh(0.6, 8e-4), storey_points=((2, 0.4),))
    made = on_floor_matrices(with_point, K, stick.M)
    n = 6 * N
    floors_alone = made.K[:n, :n] - made.K[:n, n:] @ np.linalg.solve(made.K[n:, n:], made.K[n:, :n])
    assert np.abs(floors_alone - K).max() < 1e-9 * np.abs(K).max()
    assert scipy.linalg.eigvalsh(made.K).min() > 0.0
    load = np.zeros((made.n, 1))
    load[n] = 1.0
    moved = np.linalg.solve(made.K, load)
    by_floors = stick.storey_motion(2, 0.4)[0] @ moved[:n]
    assert moved[n, 0] > 1.001 * by_floors[0]


def test_forces_in_storeys_balance_the_floors(floors, stick):
    """K of another building: the shear below a floor is the sum of the forces above."""
    u = np.random.default_rng(3).normal(size=6 * N) * np.tile([1, 1, 0.1, 0.1, 0.1, 0.1], N)
    made = on_floor_matrices(stick, 1.3 * stick.K, stick.M)
    forces = made.element_forces(u)
    assert forces == pytest.approx(1.3 * stick.element_forces(u), rel=1e-9)
    loads = (made.K @ u).reshape(N, 6)
    assert forces[0, :2] == pytest.approx(-loads[:, :2].sum(axis=0))
    assert forces[2, 5] == pytest.approx(-loads[2, 5])
