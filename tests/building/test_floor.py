import itertools
from dataclasses import replace

import numpy as np
import pytest

from impactfem.building import geometry
from impactfem.building.floor import contact_edge, edge_load, floor_bar, floor_load, linear
from impactfem.building.mesh import Part
from impactfem.building.section import BeamSection, Material

Y = np.array([0.0, 1.0, 0.0])


@pytest.fixture
def slab(panels):
    """A slab of 7 m with five uneven edges, its edge at y = 2 m not centred at the origin."""
    for start, length, n in ((3.0, 1.0, 1), (4.0, 4.0, 2), (8.0, 2.0, 2)):
        panels.panel((start, 0, 3), (length, 0, 0), (0, 2, 0), (n, 1), Part("floor", 1), 0.3)
    return panels.parts(edges={1: panels.sides_at((1, 2.0))}, base=panels.at((1, 0.0)))


@pytest.mark.parametrize("e", [0.0, 0.8, -2.0])
def test_work_on_quadratic_motions(slab, e):
    """Of 1 N at the distance e from the middle of the edge, x = 6.5 m: ∫ q x^p dx by quadrature."""
    load = edge_load(slab.mesh, 1, line=linear(0.0, 7.0, 3.5 + e))
    x, weight = np.polynomial.legendre.leggauss(4)
    x, weight = 6.5 + 3.5 * x, 3.5 * weight
    q = (1.0 + 12.0 * e * (x - 6.5) / 49.0) / 7.0
    nodes = slab.mesh.nodes[load.nodes, 0]
    for power in range(3):
        work = load.forces @ nodes**power
        assert work == pytest.approx(np.sum(weight * q * x**power), rel=1e-13)
    assert load.forces @ (nodes - 6.5) == pytest.approx(e, abs=1e-12)


@pytest.mark.parametrize("s", [0.0, 1.23, 5.0, 7.0])
def test_a_force_at_a_point_of_the_edge(slab, s):
    """Its work on a quadratic motion is the motion there."""
    load = edge_load(slab.mesh, 1, line=((s, 1.0),))
    along = slab.mesh.nodes[load.nodes, 0]
    along = along - slab.mesh.nodes[slab.mesh.edges[1], 0].min()
    for power in range(3):
        assert load.forces @ along**power == pytest.approx(s**power, abs=1e-12)


def test_clamped_nodes_take_their_share_away(panels, assembled):
    """Half of the edge's forces are on clamped nodes; they go to the ground."""
    panels.panel((0, 0, 0), (2, 0, 0), (0, 1, 0), (2, 1), Part("floor", 1), 0.3)
    parts = panels.parts(edges={1: panels.sides_at((1, 1.0))}, base=panels.at((0, 0.0)))
    load = edge_load(parts.mesh, 1)
    on_base = load.forces[np.isin(load.nodes, parts.mesh.base)].sum()
    assert on_base == pytest.approx(1.0 / 12.0)
    assert load.vector(assembled(parts), Y).sum() == pytest.approx(1.0 - 1.0 / 12.0)


def test_floors_that_lack_an_edge_or_a_slab(slab):
    for made in (edge_load, contact_edge):
        with pytest.raises(KeyError):
            made(slab.mesh, 2)
    with pytest.raises(KeyError, match="floor 4"):
        floor_load(slab.mesh, 4)
    with pytest.raises(KeyError, match="floor 3"):
        floor_bar(slab, 3, 1)


def test_vertices_along_the_edge(slab):
    edge = contact_edge(slab.mesh, 1)
    assert edge.position == pytest.approx([0.0, 1.0, 3.0, 5.0, 6.0, 7.0])
    assert edge.weight == pytest.approx([0.5, 1.5, 2.0, 1.5, 1.0, 0.5])
    assert edge.means.shape == (11, 6)
    assert np.asarray(edge.means.sum(axis=0)).ravel() == pytest.approx(np.ones(6))


@pytest.mark.parametrize("power", [0, 1, 2])
@pytest.mark.parametrize(
    ("spacing", "position"),
    [(None, [0, 1, 3, 5, 6, 7]), (1.5, [0, 3, 5, 7]), (2.5, [0, 3, 7]), (9.0, [0, 7])],
)
def test_weighted_means_of_quadratic_motions(slab, power, spacing, position):
    """∫ N_i x^p ds / w_i by quadrature, N_i the hat of a point of contact."""
    edge = contact_edge(slab.mesh, 1, spacing)
    assert edge.position == pytest.approx(position)
    ends = 3.0 + edge.position
    at, weight = np.polynomial.legendre.leggauss(4)
    expected = np.zeros(len(position))
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
    even = edge_load(slab.mesh, 1).vector(model, Y)
    assert G @ (edge.weight / 7.0) == pytest.approx(even, abs=1e-15)
    # Equal forces of all constraints are not even.
    assert np.abs(G @ np.full(6, 1.0 / 6.0) - even).max() > 1e-2


def test_displacement_towards_the_wall(slab, assembled):
    model = assembled(slab)
    r = model.rigid_body()
    G = contact_edge(slab.mesh, 1).columns(model, Y)
    load = edge_load(slab.mesh, 1)
    oblique = 0.6 * load.vector(model, (1.0, 0.0, 0.0)) + 0.8 * load.vector(model, Y)
    assert load.vector(model, (0.6, 0.8, 0.0)) == pytest.approx(oblique, abs=1e-15)
    assert G.T @ r[:, 1] == pytest.approx(np.ones(6))
    assert G.T @ r[:, 0] == pytest.approx(np.zeros(6), abs=1e-15)


@pytest.mark.parametrize("power", [0, 1, 2])
def test_even_load_on_a_slab(slab, power):
    load = floor_load(slab.mesh, 1)
    x = slab.mesh.nodes[load.nodes, 0]
    exact = (10.0 ** (power + 1) - 3.0 ** (power + 1)) / (power + 1) / 7.0
    assert load.forces @ x**power == pytest.approx(exact, rel=1e-13)


def test_what_stands_on_a_slab_takes_no_load(panels):
    panels.panel((0, 0, 3), (2, 0, 0), (0, 2, 0), (2, 2), Part("floor", 1), 0.3)
    panels.panel((0, 2, 3), (2, 0, 0), (0, 0, 1), (2, 1), Part("floor", 1, "parapet"), 0.3)
    parts = panels.parts(edges={1: panels.sides_at((1, 2.0))}, base=panels.at((1, 0.0)))
    load = floor_load(parts.mesh, 1)
    assert parts.mesh.nodes[load.nodes, 2] == pytest.approx(np.full(len(load.nodes), 3.0))
    assert load.forces.sum() == pytest.approx(1.0)


E, NU, RHO = 30e9, 0.2, 2500.0
LX, LY, HEIGHT, SLAB, MASSES = 6.0, 9.0, 4.0, 0.25, np.array([120e3, 150e3])
EVERY = (1, 2)
GABLE = geometry.Wall("gable", EVERY, (0.0, 0.0), (0.0, LY), 0.2)
FACADE = geometry.Wall("facade", EVERY, (0.0, LY), (LX, LY), 0.3)
COLUMN = geometry.Column("post", EVERY, (LX, 0.0), BeamSection.column(0.4, 0.5))
ALONG = geometry.Beam("along", EVERY, (3.0, 0.0), (3.0, LY), BeamSection.beam(0.3, 0.5))
ACROSS = geometry.Beam("across", EVERY, (0.0, 4.5), (LX, 4.5), BeamSection.beam(0.2, 0.4))
SKEW = geometry.Beam("skew", EVERY, (0.0, 0.0), (LX, LY), BeamSection.beam(0.2, 0.3))


@pytest.fixture(scope="module")
def parts(generated):
    """A building of two floors, with the beams that are given."""
    made = {}

    def make(*beams, edge="y+"):
        if (beams, edge) not in made:
            built = geometry.Geometry(
                length=LX,
                width=LY,
                levels=(0.0, HEIGHT, 2 * HEIGHT),
                slab_thickness=SLAB,
                walls=(GABLE, FACADE),
                beams=beams,
                columns=(COLUMN,),
                parapet=geometry.Parapet(0.6, 0.2),
                impact_edge=edge,
                size=geometry.MeshSize.uniform(1.5),
            )
            made[beams, edge], _ = generated(built, Material(E, NU, RHO), MASSES)
        return made[beams, edge]

    return make


def test_sums_by_hand(parts):
    bar = floor_bar(parts(ALONG, ACROSS), 1, 1)
    assert bar.length == LY
    assert bar.stiffness == pytest.approx(E * (LX * SLAB / (1.0 - NU**2) + 0.3 * 0.5))
    # Two half storeys: the gable and the column are spread, the facade is at the upper end.
    gable, facade, post = (RHO * HEIGHT * a for a in (0.2 * LY, 0.3 * LX, 0.2))
    # The column stands in the edge y = 0.
    assert bar.end_mass == pytest.approx((post, facade))
    assert bar.standing_mass == pytest.approx(gable)
    total = bar.slab_mass + bar.standing_mass + sum(bar.end_mass)
    assert total == pytest.approx(MASSES[0])
    assert bar.speed == pytest.approx(np.sqrt(bar.stiffness / (bar.slab_mass / LY)))
    assert bar.crossing == pytest.approx(LY / bar.speed)


def test_upstands_of_the_top_floor(parts):
    """The parapet stands on the edges: two sides at the ends, two along the bar."""
    bar, below = (floor_bar(parts(ALONG, ACROSS), k, 1) for k in (2, 1))
    upstand = RHO * 0.6 * 0.2
    half = 0.5 * RHO * HEIGHT
    assert bar.end_mass == pytest.approx(
        (half * 0.2 + upstand * LX, half * 0.3 * LX + upstand * LX)
    )
    assert bar.standing_mass == pytest.approx(half * 0.2 * LY + 2.0 * upstand * LY)
    assert bar.slab_mass + bar.standing_mass + sum(bar.end_mass) == pytest.approx(MASSES[1])
    assert bar.stiffness == pytest.approx(below.stiffness)


def test_without_beams_along_x_and_at_an_angle(parts):
    bare = floor_bar(parts(), 1, 1)
    assert bare.stiffness == pytest.approx(E * LX * SLAB / (1.0 - NU**2))
    along_x = floor_bar(parts(edge="x+"), 1, 1 - parts(edge="x+").mesh.edge_axis(1))
    assert along_x.length == LX
    assert along_x.stiffness == pytest.approx(E * LY * SLAB / (1.0 - NU**2))
    # The post is in the edge x = 6 m, the gable in x = 0.
    assert along_x.end_mass == pytest.approx((RHO * HEIGHT * 0.2 * LY, RHO * HEIGHT * 0.2))
    ell = np.hypot(LX, LY)
    skew = floor_bar(parts(SKEW), 1, 1)
    share = E * 0.2 * 0.3 * (LY / ell) ** 4 * ell / LY
    assert skew.stiffness == pytest.approx(bare.stiffness + share)
    # The same mass in all: a beam's own is not added a second time.
    assert skew.slab_mass == pytest.approx(bare.slab_mass)


def test_added_mass_slows_the_wave(parts):
    loaded = parts()
    bare = replace(loaded, added_mass=np.zeros_like(loaded.added_mass))
    assert floor_bar(bare, 1, 1).speed == pytest.approx(np.sqrt(E / (RHO * (1.0 - NU**2))))
    assert floor_bar(loaded, 1, 1).speed < 0.8 * floor_bar(bare, 1, 1).speed
