from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from impactfem.dynamics.damping import Rayleigh
from impactfem.sticks.stick import mass_on_spring
from impactfem.system.errors import ImpactfemError

from .conftest import damped_stick

UX, UY, UZ, RX, RY, RZ = range(6)
Y = np.array([0.0, 1.0, 0.0])


def test_matrices_are_symmetric_and_hold_all_mass(floors):
    stick = damped_stick("a", floors(3), axis=(10.0, 6.0), base=-2.0)
    assert stick.n == 18
    assert np.abs(stick.C - 0.6 * stick.M - 8e-4 * stick.K).max() < 1e-12 * np.abs(stick.C).max()
    for matrix in (stick.M, stick.C, stick.K):
        assert np.abs(matrix - matrix.T).max() <= 1e-12 * np.abs(matrix).max()
    assert np.linalg.eigvalsh(stick.K).min() > 0.0
    assert np.count_nonzero(stick.M - np.diag(np.diag(stick.M))) == 0
    r = stick.rigid_body()
    inertia = r.T @ stick.M @ r
    assert np.diag(inertia)[:3] == pytest.approx(3 * 240e3, rel=1e-14)
    # About the base point: J + M z² for x and y, J alone about z, and M z between uy and rx.
    z = np.array([3.5, 7.0, 10.5])
    assert inertia[RX, RX] == pytest.approx(3 * 2.9e6 + 240e3 * (z**2).sum())
    assert inertia[RY, RY] == pytest.approx(3 * 8.0e6 + 240e3 * (z**2).sum())
    assert inertia[RZ, RZ] == pytest.approx(3 * 10.9e6)
    assert inertia[UY, RX] == pytest.approx(-240e3 * z.sum())


def test_positions(floors):
    stick = damped_stick("a", floors(2), axis=(10.0, 6.0), base=-2.0, storey_points=[(2, 0.25)])
    # Storey 2 goes from 1.5 to 5.0.
    expected = [[10, 6, 1.5], [10, 6, 5.0], [10, 6, 1.5 + 0.25 * 3.5]]
    assert stick.positions == pytest.approx(np.array(expected, dtype=float))
    assert stick.storey_points == {(2, 0.25): 2}
    assert not stick.M[12:].any()


@settings(deadline=None, max_examples=20)
@given(st.lists(st.floats(0.05, 0.85), min_size=1, max_size=3, unique_by=lambda s: round(s, 2)))
def test_stiffness_does_not_depend_on_where_a_storey_is_cut(floors, heights):
    whole = damped_stick("a", floors(3))
    cut = damped_stick("a", floors(3), storey_points=[(2, s) for s in heights])
    kept, added = slice(0, whole.n), slice(whole.n, None)
    for name in ("K", "C"):
        A = getattr(cut, name) - (0.6 * cut.M if name == "C" else 0.0)
        B = getattr(whole, name) - (0.6 * whole.M if name == "C" else 0.0)
        follows = np.linalg.solve(A[added, added], A[added, kept])
        condensed = A[kept, kept] - A[kept, added] @ follows
        assert np.abs(condensed - B).max() < 1e-9 * np.abs(B).max()
    assert np.abs(cut.K[kept, kept] - whole.K).max() > 1e-3 * np.abs(whole.K).max()


def test_a_point_asked_twice_is_one_point(floors):
    stick = damped_stick("a", floors(2), storey_points=[(1, 0.5), (2, 0.5), (1, 0.5)])
    assert stick.storey_points == {(1, 0.5): 2, (2, 0.5): 3}
    assert len(stick.elements) == 4


def test_rigid_zone_in_closed_form(floors):
    # One floor on L = H - b of flexible length; P at the mass centre, b above the flexible end.
    H, b, P = 3.5, 0.8, 1e6
    stick = damped_stick("a", floors(1, below=b))
    section = stick.floors[0].section
    EI, GAv, L = section.E * section.Ix, section.G * section.Avy, H - b
    v = P * (L**3 / 3 + b * L**2 + b**2 * L) / EI + P * L / GAv
    u = np.linalg.solve(stick.K, P * np.eye(6)[UY])
    assert u[UY] == pytest.approx(v, rel=1e-12)
    assert u[RX] == pytest.approx(-P * (L**2 / 2 + b * L) / EI, rel=1e-12)


def test_rigid_zones_stiffen(floors):
    def top(**zones):
        stick = damped_stick("a", floors(3, **zones))
        return np.linalg.solve(stick.K, np.eye(stick.n)[-6 + UY])[-6 + UY]

    none = top(below=0.0, above=0.0)
    assert top(below=0.4, above=0.1) < 0.95 * none
    assert top(below=0.8, above=0.2) < top(below=0.4, above=0.1)
    # The zone above the highest floor holds nothing.
    low = damped_stick("a", floors(1, above=0.0))
    assert np.array_equal(low.K, damped_stick("a", floors(1, above=3.0)).K)


@pytest.mark.parametrize(("below", "above"), [(3.5, 0.0), (2.0, 1.5), (2.0, 2.0)])
def test_no_flexible_length(floors, below, above):
    with pytest.raises(ImpactfemError, match=r"storey below floor \d"):
        damped_stick("a", floors(3, below=below, above=above))


def test_unknown_floor_names_the_known_ones(floors):
    stick = damped_stick("west", [replace(f, number=2 * f.number) for f in floors(2)])
    assert stick.floor_master(4) == 1
    with pytest.raises(ImpactfemError, match="floor 3; its floors: 2, 4"):
        stick.floor_master(3)


def test_point_mass_of_a_floor(floors):
    stick = damped_stick("a", floors(2))
    M, (Jx, Jy, Jz) = 240e3, (2.9e6, 8.0e6, 10.9e6)
    assert stick.point_mass(1, (0.0, 6.0, 0.0), Y) == pytest.approx(M)
    e = 4.0
    assert stick.point_mass(1, (e, 6.0, 0.0), Y) == pytest.approx(1 / (1 / M + e**2 / Jz))
    both = 1 / (1 / M + e**2 / Jz + 0.5**2 / Jx)
    assert stick.point_mass(0, (-e, 6.0, 0.5), Y) == pytest.approx(both)
    vertical = 1 / (1 / M + 6.0**2 / Jx + e**2 / Jy)
    assert stick.point_mass(0, (e, 6.0, 9.0), np.array([0.0, 0.0, -1.0])) == pytest.approx(vertical)


def test_point_mass_inside_a_storey(floors):
    low, high = floors(2)
    stick = damped_stick("a", [low, replace(high, mass=100e3)], storey_points=[(1, 0.5), (2, 0.25)])
    middle, base = stick.storey_points[2, 0.25], stick.storey_points[1, 0.5]
    expected = 1 / (0.25**2 / 100e3 + 0.75**2 / 240e3)
    assert stick.point_mass(middle, (0.0, 6.0, 0.0), Y) == pytest.approx(expected)
    # The clamped base gives way to nothing.
    assert stick.point_mass(base, (0.0, 6.0, 0.0), Y) == pytest.approx(240e3 / 0.25)


def test_translation_of_an_offset_point(floors):
    stick = damped_stick("a", floors(2))
    u = np.zeros(12)
    u[6:] = [0.1, 0.2, 0.3, 0.01, 0.02, 0.03]
    # u + θ × r with r = (1, 2, 3).
    expected = [0.1 + 0.02 * 3 - 0.03 * 2, 0.2 + 0.03 * 1 - 0.01 * 3, 0.3 + 0.01 * 2 - 0.02 * 1]
    assert stick.translation(1, (1.0, 2.0, 3.0)) @ u == pytest.approx(np.array(expected))
    assert not (stick.translation(0, (1.0, 2.0, 3.0)) @ u).any()


def test_element_forces_hold_the_load_above(floors):
    stick = damped_stick("a", floors(3), storey_points=[(2, 0.5)])
    loads = np.zeros((4, 6))
    loads[0, UY], loads[1, UZ], loads[2, :3] = 1e6, -2e6, [3e5, 7e5, -1e6]
    loads[2, RZ] = 4e6
    u = np.linalg.solve(stick.K, loads.ravel())
    forces = stick.element_forces(u)
    assert forces.shape == (4, 6) and [e.storey for e in stick.elements] == [0, 1, 1, 2]
    # The lower half of storey 2 carries what the upper one does.
    assert forces[1, [UX, UY, UZ, RZ]] == pytest.approx(forces[2, [UX, UY, UZ, RZ]], rel=1e-8)
    forces = forces[[0, 2, 3]]
    above = np.cumsum(loads[2::-1], axis=0)[::-1]
    # What the storey does to the part above is the opposite of the loads on it.
    assert forces[:, :3] == pytest.approx(-above[:, :3], rel=1e-8)
    assert forces[:, RZ] == pytest.approx(-4e6, rel=1e-8)
    # Moment at the upper end of storey 2, 0.4 m under floor 2 and 3.9 m under floor 3.
    assert forces[1, RX] == pytest.approx(7e5 * 3.9, rel=1e-8)
    assert forces[1, RY] == pytest.approx(-3e5 * 3.9, rel=1e-8)
    # Many times at once.
    history = stick.element_forces(np.array([u, np.zeros_like(u), 2 * u]))[:, [0, 2, 3]]
    assert history == pytest.approx(np.array([forces, 0 * forces, 2 * forces]))


@pytest.mark.parametrize("s", [0.2, 0.5, 0.85])
def test_a_blow_inside_a_storey_shears_the_part_below_it(floors, s):
    stick = damped_stick("a", floors(3), storey_points=[(2, s)])
    P, load = 1e6, np.zeros(stick.n)
    load[6 * stick.storey_points[2, s] + UY] = P
    shear = stick.element_forces(np.linalg.solve(stick.K, load))[:, UY]
    # Storey 1, both parts of storey 2, storey 3: nothing of it arrives above the blow.
    assert shear == pytest.approx([-P, -P, 0.0, 0.0], abs=1e-7 * P)


@pytest.mark.parametrize("s", [0.0, 0.1 / 3.5, 3.1 / 3.5, 1.0, -0.1, 1.5, float("nan")])
def test_a_point_at_the_end_of_a_storey_is_refused(floors, s):
    expected = rf"below floor 2 needs .* rigid zones, 0.02857 to 0.8857, got {s:g};"
    with pytest.raises(ImpactfemError, match=expected):
        damped_stick("a", floors(2), storey_points=[(2, s)])
    for inside in (0.029, 0.885):
        assert damped_stick("a", floors(2), storey_points=[(2, inside)]).n == 18


def test_a_point_in_an_undamped_storey_is_refused(floors):
    expected = "contact point inside the storey below floor 2 has no mass and needs damping"
    with pytest.raises(ImpactfemError, match=expected):
        damped_stick("a", floors(2), damping=Rayleigh(0.6, 0.0), storey_points=[(2, 0.5)])
    # Without a point none is needed.
    assert damped_stick("a", floors(2), damping=Rayleigh(0.6, 0.0)).n == 12


def test_a_mass_on_a_spring():
    m, f, xi = 3e3, 2.5, 0.04
    k = m * (2.0 * np.pi * f) ** 2
    stick = mass_on_spring("m", m, frequency=f, damping_ratio=xi, position=(1.0, 2.0, 5.0))
    assert pytest.approx(k * np.eye(6)) == stick.K and pytest.approx(m * np.eye(6)) == stick.M
    assert pytest.approx(2.0 * xi * np.sqrt(k * m) * np.eye(6)) == stick.C
    assert stick.positions.tolist() == [[1.0, 2.0, 5.0]] and stick.floor_master(1) == 0
    u = np.array([0.0, 1e-2, 0.0, 0.0, 0.0, 0.0])
    # The spring pulls the mass back.
    assert stick.element_forces(u)[0] == pytest.approx(-k * u)
    same = mass_on_spring("m", m, k, dashpot=2.0 * xi * np.sqrt(k * m))
    assert pytest.approx(stick.C) == same.C and pytest.approx(stick.K) == same.K


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"mass": 0.0, "stiffness": 1.0}, "a mass above 0 kg"),
        ({"mass": 1.0}, "either a stiffness or a frequency"),
        ({"mass": 1.0, "stiffness": 1.0, "frequency": 1.0}, "either a stiffness or a frequency"),
        ({"mass": 1.0, "stiffness": -1.0}, "no value below 0"),
        (
            {"mass": 1.0, "stiffness": 1.0, "damping_ratio": 0.1, "dashpot": 1.0},
            "either damping_ratio or dashpot",
        ),
    ],
)
def test_oscillators_that_are_refused(values, expected):
    with pytest.raises(ImpactfemError, match=expected):
        mass_on_spring("m", **values)
