import numpy as np
import pytest

from impactfem.building.section import BeamSection
from impactfem.verify.shell_meshes import building_mesh, flat, lines_at, panel
from impactfem.verify.shell_model import RX, RZ, UX, UY, UZ, Material, shell_model

STEEL = Material(E=200e9, nu=0.3, rho=8000.0)
T = 0.1


@pytest.fixture(scope="module")
def strip():
    nodes, triangles = panel(4, 1, flat((2.0, 0.0, 0.0), (0.0, 0.5, 0.0)))
    return shell_model(building_mesh(nodes, triangles), STEEL, T)


def test_rows(strip):
    here = np.zeros(len(strip.nodes), dtype=bool)
    here[[2, 5]] = True
    assert strip.rows(here, UX, RZ).tolist() == [12, 17, 30, 35]
    assert strip.rows(here).tolist() == [*range(12, 18), *range(30, 36)]


def test_the_matrices_are_those_of_the_nodes(strip):
    assert abs(strip.K - strip.K.T).max() < 1e-12 * abs(strip.K).max()
    unit = np.zeros((len(strip.nodes), 6))
    unit[:, UY] = 1.0
    x = np.zeros_like(unit)
    x[:, UY] = strip.nodes[:, 0]
    mass = STEEL.rho * T * 2.0 * 0.5
    assert unit.ravel() @ strip.M @ unit.ravel() == pytest.approx(mass, rel=1e-12)
    # First moment: only with the rows at their own nodes.
    assert unit.ravel() @ strip.M @ x.ravel() == pytest.approx(mass * 1.0, rel=1e-12)


def test_a_bar_in_tension(strip):
    root, tip = strip.nodes[:, 0] == 0.0, strip.nodes[:, 0] == 2.0
    moved = np.zeros((len(strip.nodes), 6))
    moved[tip, UX] = 1e-3
    given = np.concatenate([strip.rows(root, UX), strip.rows(tip, UX)])
    still = strip.rows(root & (strip.nodes[:, 1] == 0.0), UY, UZ, RX, 4, RZ)
    found = strip.prescribed(moved.ravel(), np.concatenate([given, still])).reshape(-1, 6)
    assert np.allclose(found[:, UX], 0.5e-3 * strip.nodes[:, 0], rtol=1e-9, atol=1e-15)
    assert np.allclose(found[:, UY], -0.15e-3 * strip.nodes[:, 1], rtol=1e-9, atol=1e-15)
    force = (strip.K @ found.ravel())[strip.rows(tip, UX)].sum()
    assert force == pytest.approx(STEEL.E * T * 0.5 * 0.5e-3, rel=1e-9)
    back = strip.displacement(strip.K @ found.ravel(), given, still).reshape(-1, 6)
    assert np.all(back[tip, UX] == 0.0)


def test_frequencies_are_those_of_a_dense_solver(strip):
    scipy_linalg = pytest.importorskip("scipy.linalg")
    root = strip.rows(strip.nodes[:, 0] == 0.0)
    free = np.setdiff1d(np.arange(strip.K.shape[0]), root)
    K, M = (matrix[free][:, free].toarray() for matrix in (strip.K, strip.M))
    exact = np.sqrt(scipy_linalg.eigh(K, M, eigvals_only=True)[:5]) / (2.0 * np.pi)
    assert strip.frequencies(5, root) == pytest.approx(exact, rel=1e-8)
    loose = strip.frequencies(8, shift=1.0)
    assert np.abs(loose[:6]).max() < 1e-2 and loose[6] > 10.0


def test_parts_have_their_own_thickness_and_beams_their_section():
    nodes, triangles = panel(2, 1, flat((2.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    part = (nodes[triangles].mean(axis=1)[:, 0] > 1.0).astype(np.int64)
    lines = lines_at(triangles, nodes[:, 1] == 0.0)
    mesh = building_mesh(nodes, triangles, part, lines)
    model = shell_model(mesh, STEEL, 0.1, 0.3, beam=BeamSection.rectangle(0.2, 0.4))
    unit = np.zeros((len(nodes), 6))
    unit[:, UZ] = 1.0
    mass = unit.ravel() @ model.M @ unit.ravel()
    assert mass == pytest.approx(STEEL.rho * (0.1 + 0.3 + 2.0 * 0.08), rel=1e-12)
