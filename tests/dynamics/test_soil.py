"""Soil under rafts: fits, material damping, matrices; published values are benchmarks."""

import numpy as np
import pytest

from impactfem.dynamics.impedance import Curve, Impedance, fitted, hysteresis
from impactfem.dynamics.soil import HalfSpace, Soil, raft_mass, soil_of

NO_RAFT = np.zeros((6, 6))
SPACE = HalfSpace(300.0, 2000.0, 0.3)
HERTZ = 2.0 * np.pi * np.linspace(0.1, 50.0, 60)


def test_rectangles_turn_and_are_near_disks():
    """Turned, x and y swap; a square rocks as the disk with its moment of inertia."""
    B = 5.0
    components, _ = SPACE.rectangle(6.0 * B, 2.0 * B)
    turned, _ = SPACE.rectangle(2.0 * B, 6.0 * B)
    assert [turned[k] for k in (1, 0, 2, 4, 3, 5)] == components
    square, _ = SPACE.rectangle(2.0 * B, 2.0 * B)
    disk = SPACE.cones(4.0 * B**2, (4.0 / 3.0 * B**4,) * 2)
    assert square[3].stiffness == pytest.approx(disk[3].stiffness, rel=0.01)


@pytest.mark.parametrize("embedment", [0.0, 4.0])
@pytest.mark.parametrize("poisson", [0.2, 0.45])
def test_rectangles_are_passive(embedment, poisson):
    """Against the formulas they are in test_pais_kausel.py."""
    components, _ = HalfSpace(300.0, 2000.0, poisson).rectangle(46.2, 15.6, embedment)
    a = np.geomspace(1e-3, 1e3, 200) * 300.0 / 7.8
    assert all((one.at(a).imag > 0.0).all() for one in components)


def with_errors(omega, S):
    """A fit to a table, and its largest errors of stiffness and damping."""
    curve = Curve(omega, S)
    model = fitted(curve)
    return model, curve.misfit(model.at(omega)).largest()


def test_a_fit_finds_what_a_table_was_made_of():
    table = HERTZ[::3]
    made = Impedance(3e9, 2e7, 4e4, ((2e5, 30.0),), ((5e8, 90.0),))
    found, (stiffness, damping) = with_errors(table, made.at(table))
    assert stiffness < 0.01 and damping < 0.02
    assert found.stiffness == pytest.approx(3e9, rel=0.02)
    wrong = made.at(table) * (1.0 + 0.05 * np.sin(table))
    assert 0.03 < with_errors(table, wrong)[1].max() < 0.12


@pytest.mark.parametrize("ratio", [0.02, 0.05])
def test_a_table_of_material_damping_keeps_it(ratio):
    """K (1 + 2iζ) belongs to no causal model: what gives is the real part, not the damping."""
    table = 2.0 * np.pi * np.geomspace(0.5, 60.0, 48)
    found, error = with_errors(table, np.full(48, 1e9 * (1.0 + 2j * ratio)))
    inside = 2.0 * np.pi * np.geomspace(1.0, 20.0, 30)
    assert found.at(inside).imag / found.at(inside).real == pytest.approx(2.0 * ratio, rel=0.12)
    assert found.at(inside).real == pytest.approx(1e9, rel=0.1) and error.max() < 0.15
    assert found.stiffness > 0.79e9


def test_a_table_of_a_heavy_mass():
    """Least squares takes more than three iterations for each column there."""
    table = 2.0 * np.pi * np.geomspace(0.1, 100.0, 60)
    S = 1e9 - 2e5 * table**2 + 1e7j * table
    assert with_errors(table, S)[1].max() < 0.01


def test_a_table_of_rocking_keeps_its_power():
    """Damping that begins with ω³ is not hidden by the modulus of S."""
    table = 2.0 * np.pi * np.geomspace(0.3, 60.0, 50)
    b = table / 60.0
    S = 1e11 * (1.0 - 0.4 * b**2 / (1.2 + b**2) + 0.5j * b**3 / (1.0 + b**2))
    model, errors = with_errors(table, S)
    assert errors[1] < 0.1
    slow = np.array([0.05, 0.5]) * 2.0 * np.pi
    assert model.at(slow).imag[1] / model.at(slow).imag[0] > 500.0


@pytest.mark.parametrize(("ratio", "rest", "off"), [(0.05, 0.82, 0.11), (0.2, 0.26, 0.40)])
def test_material_damping_over_its_band(ratio, rest, off):
    """The soil under it is stable up to what a case may have, and says how far it is off."""
    ω = 2.0 * np.pi * np.array([1.0, 3.0, 10.0, 20.0])
    model = hysteresis(ratio, ω[0], ω[-1])
    assert model.at(ω).imag == pytest.approx(2.0 * ratio, rel=0.04)
    assert model.at(2.0 * np.pi * np.sqrt(20.0)).real == pytest.approx(0.0, abs=1e-12)
    assert 1.0 + model.stiffness == pytest.approx(rest, abs=0.01)
    # Sway of a rectangle is a spring and a dashpot: the error is that of 1 + 2iζ.
    components, curves = SPACE.rectangle(20.0, 12.0)
    soil = soil_of(components, NO_RAFT, curves, ratio)
    assert np.linalg.eigvalsh(soil.static)[0] > 0.0
    every = 2.0 * np.pi * np.geomspace(1.0, 20.0, 300)
    wanted = np.array([one.at(every) + 2j * ratio * one.stiffness for one in components]).T
    found = np.diagonal(soil.impedance(every), axis1=1, axis2=2)
    worst = np.abs((found - wanted).real / np.abs(wanted)).max(axis=0)
    stated = soil.errors(ω[0], ω[-1])
    assert worst[:2] == pytest.approx(stated[:2, 0], rel=0.02) and worst[0] < off
    assert (stated[:2, 1] < 0.04).all()


@pytest.mark.parametrize(
    ("component", "a", "exact", "near"),
    [(2, 1.0, 0.807, 0.05), (2, 2.0, 0.288, 0.1), (2, 3.0, -0.460, 0.06), (3, 1.0, 0.816, 0.01),
     (3, 2.0, 0.601, 0.01)],
)  # fmt: skip
def test_cones_are_near_a_disk_on_soil_that_keeps_its_volume(component, a, exact, near):
    """The real part over K, by rings of constant pressure on the half-space (ν = 0.5).

    Without the trapped masses it is 1.0 in vertical motion.
    """
    disk = HalfSpace(1.0, 1.0, 0.5).cones(np.pi, (np.pi / 4.0, np.pi / 4.0))[component]
    assert disk.at(a).real / disk.stiffness == pytest.approx(exact, abs=near)


def test_mass_of_a_raft():
    """A box about the middle of its top, by points."""
    x, y, z = (size * (np.arange(40) + 0.5) / 40 - size / 2 for size in (8.0, 6.0, 2.0))
    points = np.stack(np.meshgrid(x, y, z - 1.0), axis=-1).reshape(-1, 3)
    expected = np.zeros((6, 6))
    for p in points:
        cross = np.array([[0, -p[2], p[1]], [p[2], 0, -p[0]], [-p[1], p[0], 0]])
        J = np.hstack([np.eye(3), -cross])
        expected += J.T @ J * 1e6 / len(points)
    found = raft_mass(1e6, 2.0, (36 / 12, 64 / 12))
    assert np.abs(found - expected).max() < 1e-3 * expected.max()


def test_moved_to_another_point():
    """A horizontal spring 2 m below resists a rotation by k h²."""
    K = np.diag([1e9, 1e9, 1e9, 1e10, 1e10, 1e10])
    T = np.eye(6)
    T[0, 4], T[1, 3] = -2.0, 2.0
    moved = Soil(NO_RAFT, NO_RAFT, NO_RAFT, K, NO_RAFT).moved(T)
    assert moved.static[4, 4] == pytest.approx(1e10 + 4e9)
    assert moved.static[0, 4] == pytest.approx(-2e9)
