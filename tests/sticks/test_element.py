import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from impactfem.sticks.element import Section, bending_stiffness, rigid_link, storey_stiffness

L = 3.0
UX, UY, UZ, RX, RY, RZ = range(6)
lengths = st.floats(0.1, 50.0)
rigidities = st.floats(1e3, 1e13)


def tip(section, load):
    """Motion of the upper end for a load there, the lower end clamped."""
    return np.linalg.solve(storey_stiffness(L, section)[6:, 6:], load)


def unit(component):
    return np.eye(6)[component]


@pytest.mark.parametrize(
    ("u", "r", "EI", "GAv", "sign"),
    [(UX, RY, "Iy", "Avx", 1.0), (UY, RX, "Ix", "Avy", -1.0)],
)
def test_cantilever_bends_as_the_closed_form(section, u, r, EI, GAv, sign):
    EI = section.E * getattr(section, EI)
    GAv = section.G * getattr(section, GAv)
    P, M = 1e6, 2e6
    under_load = tip(section, P * unit(u))
    assert under_load[u] == pytest.approx(P * L**3 / (3 * EI) + P * L / GAv, rel=1e-12)
    # The member's slope at its tip is P L² / (2 EI): dv/dz = -rx, du/dz = +ry.
    assert under_load[r] == pytest.approx(sign * P * L**2 / (2 * EI), rel=1e-12)
    under_moment = tip(section, M * unit(r))
    assert under_moment[r] == pytest.approx(M * L / EI, rel=1e-12)
    assert under_moment[u] == pytest.approx(sign * M * L**2 / (2 * EI), rel=1e-12)
    others = [c for c in range(6) if c not in (u, r)]
    assert not under_load[others].any() and not under_moment[others].any()


def test_axial_and_torsion(section):
    assert tip(section, 5e6 * unit(UZ))[UZ] == pytest.approx(5e6 * L / (section.E * section.A))
    assert tip(section, 5e6 * unit(RZ))[RZ] == pytest.approx(5e6 * L / (section.G * section.Iz))


@settings(deadline=None, max_examples=50)
@given(lengths, rigidities, rigidities)
def test_bending_stiffness_from_the_differential_equation(length, EI, GAv):
    # v' = φ + V/GA_v, φ' = m/EI, m' = -V, V' = 0, integrated by the matrix exponential in units
    # of length and EI/length², with V the shear on the upper face of a cut.
    g = GAv * length**2 / EI
    A = np.array([[0, 1, 0, 1 / g], [0, 0, 1, 0], [0, 0, 0, -1], [0, 0, 0, 0]], dtype=float)
    E = scipy.linalg.expm(A)
    to_forces = np.linalg.solve(E[:2, 2:], np.hstack([-E[:2, :2], np.eye(2)]))
    m1, V1 = to_forces
    m2, V2 = (E @ np.vstack([np.hstack([np.eye(2), np.zeros((2, 2))]), to_forces]))[2:]
    expected = np.array([-V1, -m1, V2, m2]) * EI / length**3
    lever = np.array([1.0, length, 1.0, length])
    found = bending_stiffness(length, EI, GAv) / np.outer(lever, lever)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_without_shear_strain_it_is_the_cubic_beam():
    k = bending_stiffness(2.0, 5.0, 1e30)
    assert k[0] == pytest.approx(np.array([7.5, 7.5, -7.5, 7.5]))
    assert k[1, 3] == pytest.approx(5.0) and k[1, 1] == pytest.approx(10.0)


def test_rigid_motions_give_no_force_through_oblique_links(section):
    """The element between two ends that rigid links tie to masters at -lower and -upper of them."""
    lower, upper = np.array([0.7, -0.4, 0.3]), np.array([-1.1, 0.2, -0.5])
    start = np.array([4.0, -2.0, 10.0])
    masters = start - lower, start + np.array([0.0, 0.0, L]) - upper
    T = scipy.linalg.block_diag(rigid_link(lower), rigid_link(upper))
    k = T.T @ storey_stiffness(L, section) @ T
    assert np.abs(k @ np.vstack([*map(rigid_link, masters)])).max() < 1e-12 * np.abs(k).max()
    # A master that is not where its link says: the same motions strain the member.
    elsewhere = masters[0], masters[1] + [0.1, 0.0, 0.0]
    assert np.abs(k @ np.vstack([*map(rigid_link, elsewhere)])).max() > 1e-4 * np.abs(k).max()


@settings(deadline=None, max_examples=30)
@given(lengths, *[st.floats(0.01, 100.0)] * 6)
def test_symmetric_positive_semidefinite_of_rank_6(length, A, Avx, Avy, Ix, Iy, Iz):
    k = storey_stiffness(length, Section(30e9, 12e9, A, Avx, Avy, Ix, Iy, Iz))
    assert np.array_equal(k, k.T)
    scale = 1.0 / np.sqrt(np.diag(k))
    values = np.linalg.eigvalsh(k * np.outer(scale, scale))
    assert np.abs(values[:6]).max() < 1e-12 < values[6]


def test_rigid_link_is_a_small_rotation():
    r, theta = np.array([1.2, -0.7, 2.5]), np.array([2e-6, -3e-6, 1e-6])
    turned = Rotation.from_rotvec(theta).apply(r) - r
    moved = rigid_link(r) @ np.concatenate([[0.1, 0.2, 0.3], theta])
    assert moved[:3] - [0.1, 0.2, 0.3] == pytest.approx(turned, abs=1e-10)
    assert np.abs(turned).max() > 1e-6
    assert np.array_equal(moved[3:], theta)
    against = rigid_link(-r) @ np.concatenate([[0.0, 0.0, 0.0], theta])
    assert against[:3] == pytest.approx(-turned, abs=1e-10)
    assert np.array_equal(rigid_link(np.zeros(3)), np.eye(6))
