from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

from impactfem.building.read_mesh import read_groups
from impactfem.building.section import BeamSection, Material
from impactfem.building.shell_model import RX, RY, RZ, UX, UY, UZ, Beams, Shells, shell_model
from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.factorisation import SingularMatrixError
from impactfem.system.errors import ImpactfemError

STEEL = Material(E=200e9, nu=0.3, rho=8000.0)
T, LENGTH, WIDTH = 0.1, 2.0, 0.5
FRAME = Path(__file__).parents[2] / "geometry" / "frame.msh"


def grid(n):
    """Vertices and linear triangles of the strip in n by 1 cells."""
    x, y = np.meshgrid(np.linspace(0.0, LENGTH, n + 1), [0.0, WIDTH], indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    first = 2 * np.arange(n)
    lower = np.column_stack([first, first + 2, first + 3])
    return points, np.concatenate([lower, np.column_stack([first, first + 3, first + 1])])


@pytest.fixture(scope="module")
def strip():
    points, triangles = grid(4)
    return shell_model(points, Shells(triangles, T, STEEL))


@pytest.fixture(scope="module")
def clamped(strip):
    return strip.hold(strip.nodes[:, 0] == 0.0)


def test_rows(strip):
    here = np.zeros(len(strip.nodes), dtype=bool)
    here[[2, 5]] = True
    for chosen in (here, [2, 5]):
        assert strip.rows(chosen, UX, RZ).tolist() == [12, 17, 30, 35]
        assert strip.rows(chosen).tolist() == [*range(12, 18), *range(30, 36)]
    assert strip.rows(2, UY).tolist() == [13]


def test_the_matrices_are_those_of_the_nodes(strip):
    assert abs(strip.K - strip.K.T).max() < 1e-12 * abs(strip.K).max()
    unit = np.zeros((len(strip.nodes), 6))
    unit[:, UY] = 1.0
    x = np.zeros_like(unit)
    x[:, UY] = strip.nodes[:, 0]
    mass = STEEL.rho * T * LENGTH * WIDTH
    assert unit.ravel() @ strip.M @ unit.ravel() == pytest.approx(mass, rel=1e-12)
    # First moment: only with the rows at their own nodes.
    assert unit.ravel() @ strip.M @ x.ravel() == pytest.approx(mass * 1.0, rel=1e-12)


def test_a_bar_in_tension(strip):
    root, tip = strip.nodes[:, 0] == 0.0, strip.nodes[:, 0] == LENGTH
    moved = np.zeros((len(strip.nodes), 6))
    moved[tip, UX] = 1e-3
    given = np.concatenate([strip.rows(root, UX), strip.rows(tip, UX)])
    still = strip.rows(root & (strip.nodes[:, 1] == 0.0), UY, UZ, RX, RY, RZ)
    found = strip.prescribed(moved.ravel(), np.concatenate([given, still])).reshape(-1, 6)
    assert np.allclose(found[:, UX], 0.5e-3 * strip.nodes[:, 0], rtol=1e-9, atol=1e-15)
    assert np.allclose(found[:, UY], -0.15e-3 * strip.nodes[:, 1], rtol=1e-9, atol=1e-15)
    force = (strip.K @ found.ravel())[strip.rows(tip, UX)].sum()
    assert force == pytest.approx(STEEL.E * T * 0.5 * 0.5e-3, rel=1e-9)
    # The same by a load on the edge: N L / (E t b).
    held = strip.hold(root, UX).hold(root & (strip.nodes[:, 1] == 0.0))
    pulled = held.static(held.edge_load(tip, (force, 0.0, 0.0)))
    assert pulled[:, :2] == pytest.approx(found[:, :2], rel=1e-8, abs=1e-14)


def test_modes_are_those_of_a_dense_solver(strip, clamped):
    K, M = (matrix[clamped.free][:, clamped.free].toarray() for matrix in (strip.K, strip.M))
    exact = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True)[:5]) / (2.0 * np.pi)
    frequency, shapes = clamped.modes(5)
    assert frequency == pytest.approx(exact, rel=1e-8)
    flat = shapes.reshape(5, -1)
    assert flat @ strip.M @ flat.T == pytest.approx(np.eye(5), abs=1e-8)
    assert not shapes[:, clamped.nodes[:, 0] == 0.0].any()
    loose, _ = strip.modes(8, shift=10.0)
    assert np.abs(loose[:6]).max() < 0.05 and loose[6] > 10.0


def test_a_model_that_nothing_holds_is_refused(strip):
    with pytest.raises(SingularMatrixError, match="mechanism"):
        strip.modes(2)
    with pytest.raises(SingularMatrixError, match="mechanism"):
        strip.static(strip.area_load((0.0, 0.0, 1.0)))


def test_loads_are_consistent(strip):
    x, y, _ = strip.nodes.T
    pressure = strip.area_load((1.0, 2.0, -3.0))
    assert pressure.sum(axis=0) == pytest.approx([1.0, 2.0, -3.0, 0.0, 0.0, 0.0], rel=1e-14)
    assert x @ pressure[:, 2] == pytest.approx(-3.0 * 1.0, rel=1e-14)
    edge = strip.edge_load(y == WIDTH, (0.0, 5.0, 0.0))
    assert edge.sum(axis=0).tolist() == pytest.approx([0.0, 5.0, 0.0, 0.0, 0.0, 0.0])
    # Exact for what quadratic functions hold: the mean of x² is L²/3.
    assert x**2 @ edge[:, 1] == pytest.approx(5.0 * LENGTH**2 / 3.0, rel=1e-13)
    at = strip.nodal_load([3, 4], (0.0, 0.0, 7.0), (1.0, 0.0, 0.0))
    assert at.sum(axis=0).tolist() == [0.0, 0.0, 14.0, 2.0, 0.0, 0.0]
    weight = strip.ground_load((0.0, 0.0, 9.81))
    assert weight.sum(axis=0)[2] == pytest.approx(-9.81 * 800.0, rel=1e-12)
    with pytest.raises(ImpactfemError, match="no side of"):
        strip.edge_load([0], (1.0, 0.0, 0.0))


def test_parts_have_their_own_section_material_and_added_mass():
    points, triangles = grid(2)
    halves = np.split(triangles[np.argsort(points[triangles].mean(axis=1)[:, 0])], 2)
    heavy = replace(STEEL, rho=16000.0, E=100e9)
    section = BeamSection.rectangle(0.2, 0.4)
    model = shell_model(
        points,
        Shells(halves[0], 0.1, STEEL),
        Beams(np.array([[0, 2], [2, 4]]), section, heavy),
        Shells(halves[1], 0.3, heavy, added_mass=50.0),
    )
    mass = -model.ground_load((0.0, 0.0, 1.0))[:, 2].sum()
    area = 0.5 * LENGTH * WIDTH
    own = area * (STEEL.rho * 0.1 + heavy.rho * 0.3 + 50.0) + LENGTH * heavy.rho * section.A
    assert mass == pytest.approx(own, rel=1e-12)
    assert model.area_load((0.0, 0.0, 1.0), part=2)[:, 2].sum() == pytest.approx(area)
    with pytest.raises(ImpactfemError, match="no triangles"):
        model.area_load((0.0, 0.0, 1.0), part=1)
    # Two strips in series: N L/(2 t b) (1/E₁ + 1/E₂) without the beams.
    bars = [
        Shells(half, T, replace(m, nu=0.0)) for half, m in zip(halves, (STEEL, heavy), strict=True)
    ]
    two = shell_model(points, *bars)
    two = two.hold(two.nodes[:, 0] == 0.0)
    moved = two.static(two.edge_load(two.nodes[:, 0] == LENGTH, (1e6, 0.0, 0.0)))
    exact = 1e6 * 1.0 / (T * WIDTH) * (1.0 / STEEL.E + 1.0 / heavy.E)
    assert moved[-1, UX] != 0.0
    assert moved[two.nodes[:, 0] == LENGTH, UX] == pytest.approx(exact, rel=1e-9)


def test_a_point_mass_lowers_the_frequency(clamped):
    """Rayleigh: ω² = k / m for a mass much above that of the strip."""
    tip = int(np.argmax(clamped.nodes[:, 0]))
    loaded = clamped.add_mass(tip, 1e6)
    k = 1.0 / clamped.static(clamped.nodal_load(tip, (0.0, 0.0, 1.0)))[tip, UZ]
    assert loaded.modes(1)[0][0] == pytest.approx(np.sqrt(k / 1e6) / (2.0 * np.pi), rel=1e-3)
    assert clamped.modes(1)[0][0] > 10.0 * loaded.modes(1)[0][0]


def test_transient_of_one_mode_is_that_of_an_oscillator(clamped):
    """Under M φ a(t) only the mode φ moves; a step gives q = (1 − e^(−ξωt) (…)) / ω²."""
    frequency, shapes = clamped.modes(1)
    omega, xi = 2.0 * np.pi * frequency[0], 0.05
    load = (clamped.M @ shapes[0].ravel()).reshape(-1, 6)
    dt = 1.0 / frequency[0] / 400.0
    tip = int(np.argmax(np.abs(shapes[0][:, UZ])))
    history = clamped.transient(
        load, np.ones(801), dt, damping=Rayleigh(2.0 * xi * omega), probes=clamped.rows(tip, UZ)
    )
    t, damped = history.time, omega * np.sqrt(1.0 - xi**2)
    decay = np.exp(-xi * omega * t)
    q = 1.0 - decay * (np.cos(damped * t) + xi * omega / damped * np.sin(damped * t))
    exact = shapes[0][tip, UZ] * q / omega**2
    found = history.motion["displacement"][:, 0]
    assert np.abs(found - exact).max() < 5e-4 * np.abs(exact).max()
    assert history.energy.residual < 1e-9
    # Without the damping it is another motion.
    free = clamped.transient(load, np.ones(801), dt, probes=clamped.rows(tip, UZ))
    assert np.abs(free.motion["displacement"][:, 0] - exact).max() > 0.1 * np.abs(exact).max()


def test_transient_records_all_rows_and_takes_several_loads(clamped):
    loads = [clamped.area_load((0.0, 0.0, 1.0)), clamped.ground_load((1.0, 0.0, 0.0))]
    history = clamped.transient(loads, np.ones((5, 2)), 1e-4)
    u = history.motion["displacement"].reshape(5, -1, 6)
    assert u.shape[1] == len(clamped.nodes) and not u[:, clamped.held].any()
    assert np.abs(u[-1, ~clamped.held]).min() >= 0.0 and u[-1].any()
    with pytest.raises(ImpactfemError, match="2 loads with 1 amplitudes"):
        clamped.transient(loads, np.ones(5), 1e-4)


def test_linear_and_quadratic_cells_share_their_middles():
    points, triangles = grid(2)
    # A point without a cell is held.
    loose = shell_model(np.vstack([points, [9.0, 9.0, 9.0]]), Shells(triangles, T, STEEL))
    assert np.flatnonzero(loose.held.all(axis=1)).tolist() == [len(points)]
    loose = loose.hold(loose.nodes[:, 0] == 0.0)
    assert not loose.static(loose.area_load((0.0, 0.0, 1.0)))[len(points)].any()
    whole = shell_model(points, Shells(triangles, T, STEEL))
    half = Shells(whole.triangles[:2], T, STEEL), Shells(whole.triangles[2:, :3], T, STEEL)
    for mixed in (shell_model(whole.nodes, *half), shell_model(whole.nodes, *half[::-1])):
        # Of 9 sides, 6 are those of the quadratic cells, which keep their middles.
        assert len(mixed.nodes) == len(whole.nodes) + 3
        first, second = (m.hold(m.nodes[:, 0] == 0.0) for m in (whole, mixed))
        u, v = (m.static(m.area_load((0.0, 0.0, 1.0))) for m in (first, second))
        assert v[: len(points)] == pytest.approx(u[: len(points)], rel=1e-9, abs=1e-15)


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ([], "expected shells or beams"),
        ([Shells(np.array([[0, 1, 9]]), T, STEEL)], "points 0 to 9; there are 6"),
        ([Shells(np.array([[0, 1]]), T, STEEL)], r"expected cells of shape \(m, 3\) or \(m, 6\)"),
        ([Shells(grid(2)[1], 0.0, STEEL)], "a thickness above 0 m"),
        (
            [Beams(np.array([[0, 1]]), BeamSection.column(0.2, 0.2), STEEL)],
            "parallel to the reference",
        ),
    ],
)
def test_what_cannot_be_assembled_or_held_is_refused(strip, parts, expected):
    with pytest.raises(ImpactfemError, match="middles of sides"):
        strip.hold(grid(4)[0][:, 0] == 0.0)
    with pytest.raises(ImpactfemError, match="nodes 0 to 999"):
        strip.rows([0, 999])
    with pytest.raises(ImpactfemError, match=expected):
        shell_model(grid(2)[0], *parts)


def test_a_mesh_file_by_its_groups():
    groups = read_groups(FRAME)
    assert {"floor_1", "storey_1_west", "base", "centre_2"} <= set(groups.cells)
    concrete = Material(33e9, 0.2, 2500.0)
    sections = {"beam": BeamSection.beam(0.3, 0.5), "column": BeamSection.column(0.4, 0.4)}
    parts = []
    for name, cells in groups.cells.items():
        family = name.partition("_")[0]
        if family in ("floor", "storey"):
            parts.append(Shells(cells, 0.25, concrete))
        elif family in sections:
            parts.append(Beams(cells, sections[family], concrete))
    model = shell_model(groups.points, *parts).hold(groups.nodes["base"])
    assert 1.0 < model.modes(1)[0][0] < 30.0
