import numpy as np
import pytest

from impactfem.building.floor import edge_load
from impactfem.building.mesh import Part

THROUGH = (0.0, 1.0, 0.0)


@pytest.fixture
def slab(panels):
    """A slab of 7 m with five uneven edges, its edge at y = 2 m not centred at the origin."""
    for start, length, n in ((3.0, 1.0, 1), (4.0, 4.0, 2), (8.0, 2.0, 2)):
        panels.panel((start, 0, 3), (length, 0, 0), (0, 2, 0), (n, 1), Part("floor", 1), 0.3)
    return panels.parts(edges={1: panels.sides_at((1, 2.0))}, base=panels.at((1, 0.0)))


@pytest.mark.parametrize("e", [0.0, 0.8, -2.0])
def test_resultant_and_moment(slab, e):
    """1 N at the distance e from the middle of the edge, x = 6.5 m."""
    load = edge_load(slab.mesh, 1, e)
    x = slab.mesh.nodes[load.nodes, 0]
    assert load.forces.sum() == pytest.approx(1.0, rel=1e-13)
    assert load.forces @ (x - 6.5) == pytest.approx(e, abs=1e-12)


@pytest.mark.parametrize("power", [0, 1, 2])
def test_work_on_quadratic_motions(slab, power):
    """∫ q x^p dx by quadrature: nodal forces do the work of the line load on P2 motions."""
    e = 0.8
    load = edge_load(slab.mesh, 1, e)
    x, weight = np.polynomial.legendre.leggauss(4)
    x, weight = 6.5 + 3.5 * x, 3.5 * weight
    q = (1.0 + 12.0 * e * (x - 6.5) / 49.0) / 7.0
    nodal = slab.mesh.nodes[load.nodes, 0] ** power
    assert load.forces @ nodal == pytest.approx(np.sum(weight * q * x**power), rel=1e-13)


def test_on_the_rows_of_the_model(slab, assembled):
    """The work on the rigid-body motions of the slab is the resultant at its place."""
    model = assembled(slab)
    load = edge_load(slab.mesh, 1, 0.8)
    work = model.rigid_body().T @ load.vector(model, THROUGH)
    # F = e_y at (7.3, 2, 3) m: M = x × F = (−3, 0, 7.3).
    assert work == pytest.approx([0.0, 1.0, 0.0, -3.0, 0.0, 7.3], abs=1e-12)


def test_an_oblique_load(slab, assembled):
    model = assembled(slab)
    load = edge_load(slab.mesh, 1)
    oblique = load.vector(model, (0.6, 0.8, 0.0))
    parts = 0.6 * load.vector(model, (1.0, 0.0, 0.0)) + 0.8 * load.vector(model, THROUGH)
    assert oblique == pytest.approx(parts, abs=1e-15)


def test_clamped_nodes_take_their_share_away(panels, assembled):
    """Half of the edge's forces are on clamped nodes; they go to the ground."""
    panels.panel((0, 0, 0), (2, 0, 0), (0, 1, 0), (2, 1), Part("floor", 1), 0.3)
    parts = panels.parts(edges={1: panels.sides_at((1, 1.0))}, base=panels.at((0, 0.0)))
    load = edge_load(parts.mesh, 1)
    on_base = load.forces[np.isin(load.nodes, parts.mesh.base)].sum()
    assert on_base == pytest.approx(1.0 / 12.0)
    vector = load.vector(assembled(parts), THROUGH)
    assert vector.sum() == pytest.approx(1.0 - 1.0 / 12.0)


def test_a_floor_without_an_edge(slab):
    with pytest.raises(KeyError):
        edge_load(slab.mesh, 2)
