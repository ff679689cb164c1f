import itertools

import numpy as np
import pytest

from impactfem.building.floor import contact_edge, edge_load, floor_load
from impactfem.building.mesh import Part

Y = np.array([0.0, 1.0, 0.0])


@pytest.fixture
def slab(panels):
    """A slab of 7 m × 2 m with five uneven sides along its edge at y = 2 m."""
    for start, length, n in ((3.0, 1.0, 1), (4.0, 4.0, 2), (8.0, 2.0, 2)):
        panels.panel((start, 0, 3), (length, 0, 0), (0, 2, 0), (n, 1), Part("floor", 1), 0.3)
    return panels.parts(edges={1: panels.sides_at((1, 2.0))}, base=panels.at((1, 0.0)))


def test_vertices_along_the_edge(slab):
    edge = contact_edge(slab.mesh, 1)
    assert edge.position == pytest.approx([0.0, 1.0, 3.0, 5.0, 6.0, 7.0])
    assert edge.weight == pytest.approx([0.5, 1.5, 2.0, 1.5, 1.0, 0.5])
    assert edge.means.shape == (11, 6)
    assert np.asarray(edge.means.sum(axis=0)).ravel() == pytest.approx(np.ones(6))


@pytest.mark.parametrize("power", [0, 1, 2])
def test_weighted_means_of_quadratic_motions(slab, power):
    """∫ N_i x^p ds / w_i by quadrature, N_i the hat of a vertex."""
    edge = contact_edge(slab.mesh, 1)
    ends = 3.0 + edge.position
    at, weight = np.polynomial.legendre.leggauss(4)
    expected = np.zeros(6)
    for k, (a, b) in enumerate(itertools.pairwise(ends)):
        x, w = 0.5 * (a + b) + 0.5 * (b - a) * at, 0.5 * (b - a) * weight
        expected[k] += w @ ((b - x) / (b - a) * x**power)
        expected[k + 1] += w @ ((x - a) / (b - a) * x**power)
    found = edge.means.T @ slab.mesh.nodes[edge.nodes, 0] ** power
    assert found == pytest.approx(expected / edge.weight, rel=1e-13)


def test_even_pressure_is_the_even_line_load(slab, assembled):
    """P_i = w_i / L is a pressure without steps: its nodal forces do not alternate."""
    model = assembled(slab)
    edge = contact_edge(slab.mesh, 1)
    G = edge.columns(model, Y)
    even = edge_load(slab.mesh, 1).vector(model, (0.0, 1.0, 0.0))
    assert G @ (edge.weight / 7.0) == pytest.approx(even, abs=1e-15)
    # Equal forces of all constraints are not even.
    assert np.abs(G @ np.full(6, 1.0 / 6.0) - even).max() > 1e-2


def test_displacement_towards_the_wall(slab, assembled):
    model = assembled(slab)
    r = model.rigid_body()
    G = contact_edge(slab.mesh, 1).columns(model, Y)
    assert G.T @ r[:, 1] == pytest.approx(np.ones(6))
    assert G.T @ r[:, 0] == pytest.approx(np.zeros(6), abs=1e-15)


def test_without_an_edge(slab):
    with pytest.raises(KeyError):
        contact_edge(slab.mesh, 2)


@pytest.mark.parametrize("power", [0, 1, 2])
def test_even_load_on_a_slab(slab, power):
    load = floor_load(slab.mesh, 1)
    x = slab.mesh.nodes[load.nodes, 0]
    exact = (10.0 ** (power + 1) - 3.0 ** (power + 1)) / (power + 1) / 7.0
    assert load.forces @ x**power == pytest.approx(exact, rel=1e-13)
    with pytest.raises(KeyError, match="floor 4 has no slab"):
        floor_load(slab.mesh, 4)


def test_what_stands_on_a_slab_takes_no_load(panels):
    panels.panel((0, 0, 3), (2, 0, 0), (0, 2, 0), (2, 2), Part("floor", 1), 0.3)
    panels.panel((0, 2, 3), (2, 0, 0), (0, 0, 1), (2, 1), Part("floor", 1, "acroterion"), 0.3)
    parts = panels.parts(edges={1: panels.sides_at((1, 2.0))}, base=panels.at((1, 0.0)))
    load = floor_load(parts.mesh, 1)
    assert parts.mesh.nodes[load.nodes, 2] == pytest.approx(np.full(len(load.nodes), 3.0))
    assert load.forces.sum() == pytest.approx(1.0)
