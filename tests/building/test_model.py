from dataclasses import dataclass, replace

import numpy as np
import pytest
import scipy.linalg
from mpi4py import MPI
from scipy.sparse.linalg import eigsh

from impactfem._fenicsx import node_coordinates
from impactfem.building.assembly import bisect, local_cells, shared_out
from impactfem.building.mesh import Part
from impactfem.building.model import action_of_cells, assemble_building, damping_matrix
from impactfem.building.parts import PartDamping
from impactfem.building.section import BeamSection, Material, Materials
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import SolutionError

SHELL = Part("floor", 1)


@pytest.fixture(scope="module")
def model(house, assembled):
    return assembled(house)


def shells_and_beams(house):
    """Mass and centre of each cell of the house [kg], [m]."""
    mesh, found = house.mesh, []
    for triangle, part in zip(mesh.triangles, mesh.triangle_part, strict=True):
        a, b, c = mesh.nodes[triangle[:3]]
        area = 0.5 * np.linalg.norm(np.cross(b - a, c - a))
        found.append((2500.0 * area * house.sections.shells[part].thickness, (a + b + c) / 3.0))
    for line, part in zip(mesh.lines, mesh.line_part, strict=True):
        a, b, _ = mesh.nodes[line]
        section = house.sections.beams[part]
        mass = 2500.0 * np.linalg.norm(b - a) * section.A
        found.append((mass, 0.5 * (a + b) + section.offset))
    return found


def test_clamped_nodes_are_not_in_the_matrices(model, house):
    mesh = house.mesh
    assert sorted(model.nodes) == np.setdiff1d(np.arange(len(mesh.nodes)), mesh.base).tolist()
    assert model.n_free == 6 * len(model.nodes) == model.fixed.getSize()[0]
    assert model.n_nodes == len(mesh.nodes)
    assert model.coordinates.tolist() == mesh.nodes[model.nodes].tolist()


def test_mass_and_its_centre(model, house):
    """x m = ∫ ρ x: the first moments of the total are those of the cells."""
    masses, centres = zip(*shells_and_beams(house), strict=True)
    mass, first = sum(masses), np.array(masses) @ np.array(centres)
    assert model.total[:3, :3] == pytest.approx(mass * np.eye(3), rel=1e-12, abs=1e-8)
    moments = [[0.0, first[2], -first[1]], [-first[2], 0.0, first[0]], [first[1], -first[0], 0.0]]
    assert model.total[:3, 3:] == pytest.approx(np.array(moments), rel=1e-11, abs=1e-7)
    assert model.total == pytest.approx(model.total.T, rel=1e-12, abs=1e-7)


def test_rigid_body_motions_of_the_free_house(house, assembled, csr):
    """Joints of three and four shells, an eccentric beam and columns: six motions cost nothing."""
    free = assembled(replace(house, mesh=replace(house.mesh, base=np.empty(0, dtype=np.int64))))
    K = csr(free.stiffness(0.13))
    motions = free.rigid_body()
    assert np.abs(K @ motions).max() < 1e-13 * np.abs(K).max() * np.abs(motions).max()
    M = csr(free.mass)
    assert motions.T @ (M @ motions) == pytest.approx(free.total, rel=1e-12, abs=1e-7)
    assert free.ground == pytest.approx(M @ motions, rel=1e-12, abs=1e-7)
    # `about` is what M and the motions about another point give.
    ground, total = free.about(np.array([1.0, -2.0, 5.0]))
    other = free.rigid_body((1.0, -2.0, 5.0))
    assert ground == pytest.approx(M @ other, rel=1e-11, abs=1e-7)
    assert total == pytest.approx(other.T @ ground, rel=1e-11, abs=1e-6)
    assert abs(total - free.total).max() > 1e3
    # Shifted by less than the first elastic eigenvalue: six are zero, and no seventh.
    values = np.sort(eigsh(K, 8, M, sigma=-1e3, return_eigenvectors=False))
    assert np.abs(values[:6]).max() < 1e-8 * values[6]


def test_ground_motion_takes_the_base_along(model, csr):
    """M r with the base: the parts of M between free and clamped nodes count."""
    free_part = csr(model.mass) @ model.rigid_body()
    missing = model.ground - free_part
    above_a_cell = np.repeat(model.coordinates[:, 2] > 2.0, 6)
    assert np.abs(missing[above_a_cell]).max() < 1e-9
    assert np.abs(missing[~above_a_cell]).max() > 1.0


def test_the_factor_scales_walls_and_columns_alone(model, csr):
    before = model.fixed.norm()
    model.stiffness().scale(7.0)  # a copy: the model keeps its own
    assert model.fixed.norm() == before
    fixed, storeys = csr(model.fixed), csr(model.storeys)
    expected = fixed + 0.5 * storeys
    assert abs(csr(model.stiffness(0.5)) - expected).max() < 1e-15 * abs(expected).max()
    x, y, z = model.coordinates.T
    between = np.repeat(np.isclose(z, 1.5) | np.isclose(z, 4.75), 6)  # of walls and columns
    slab = np.repeat(np.isclose(z, 3.0) & (x > 2.0) & (x < 4.0) & (y > 0.0), 6)  # slab and beam
    assert abs(fixed[between]).max() == 0.0 < abs(storeys[between]).max()
    assert abs(storeys[slab]).max() == 0.0 < abs(fixed[slab]).max()


def test_rows(model, house):
    clamped = int(house.mesh.base[0])
    asked = np.array([model.nodes[5], clamped, model.nodes[0], model.nodes[-1]])
    last = 6 * (len(model.nodes) - 1)
    assert model.rows(asked).tolist() == [30, -1, 0, last]
    with pytest.raises(IndexError):
        model.rows(np.array([model.n_nodes]))
    assert model.rows(np.empty(0, dtype=np.int64)).size == 0


def test_a_node_without_cells(house, assembled):
    nodes = np.vstack([house.mesh.nodes, [9.0, 9.0, 9.0]])
    with pytest.raises(SolutionError, match=f"node {len(nodes) - 1} belongs"):
        assembled(replace(house, mesh=replace(house.mesh, nodes=nodes)))


def test_the_order_of_cells_and_nodes_changes_nothing(house, model, assembled, csr):
    """The same house with nodes renumbered and cells shuffled, node by node."""
    mesh, rng = house.mesh, np.random.default_rng(2)
    new = rng.permutation(len(mesh.nodes))  # new number of each node
    nodes = np.empty_like(mesh.nodes)
    nodes[new] = mesh.nodes
    order = rng.permutation(len(mesh.triangles))
    shuffled = replace(
        mesh,
        nodes=nodes,
        triangles=new[mesh.triangles[order]],
        triangle_part=mesh.triangle_part[order],
        lines=new[mesh.lines],
        base=np.sort(new[mesh.base]),
    )
    other = assembled(replace(house, mesh=shuffled))
    rows = (other.rows(new[model.nodes])[:, None] + np.arange(6)).ravel()
    for one, two in ((model.stiffness(), other.stiffness()), (model.mass, other.mass)):
        first, second = csr(one), csr(two)[rows][:, rows]
        assert abs(first - second).max() < 1e-13 * abs(first).max()


def soft_storeys(house):
    """The house with walls and columns of half of E, of the same ν and ρ."""

    def of(parts, materials):
        return tuple(
            replace(m, E=0.5 * m.E) if part.scaled else m
            for part, m in zip(parts, materials, strict=True)
        )

    mesh, own = house.mesh, house.materials
    shells, beams = of(mesh.shell_parts, own.shells), of(mesh.beam_parts, own.beams)
    return replace(house, materials=Materials(shells, beams))


def test_materials_of_parts(house, model, assembled, csr):
    """Half of E in walls and columns is half of their stiffness: the factor acts on it as well."""
    mixed = assembled(soft_storeys(house))
    for one, other, factor in (
        (mixed.fixed, model.fixed, 1.0),
        (mixed.storeys, model.storeys, 0.5),
        (mixed.mass, model.mass, 1.0),
    ):
        expected = factor * csr(other)
        assert abs(csr(one) - expected).max() < 1e-13 * abs(expected).max()
    assert (
        abs(csr(mixed.stiffness(0.13)) - csr(model.stiffness(0.065))).max()
        < 1e-13 * abs(csr(model.stiffness(0.065))).max()
    )
    assert abs(csr(mixed.stiffness()) - csr(model.stiffness())).max() > 1e6


def test_what_a_change_of_some_cells_does(house, model, assembled, csr):
    """Of the changed cells alone: the difference of two whole buildings."""
    other = replace(soft_storeys(house), added_mass=house.added_mass + 100.0)
    cells = house.changed(other)
    scaled = [part.scaled for part in house.mesh.beam_parts]
    assert cells[1].tolist() == np.array(scaled)[house.mesh.line_part].tolist()
    assert cells[0].all()
    assert house.changed(replace(house, added_mass=house.added_mass.copy()))[0].any() == 0
    rows = (6 * model.nodes[:, None] + np.arange(6)).ravel()
    X = np.random.default_rng(1).standard_normal((6 * len(house.mesh.nodes), 3))
    X[np.setdiff1d(np.arange(len(X)), rows)] = 0.0  # clamped
    known = {}
    both = [action_of_cells(parts, cells, 0.7, X, known) for parts in (house, other)]
    # Slabs and walls differ in their mass, columns in Young's modulus alone; beams do not.
    assert len(known) == 2 + 2 + 1
    changed = assembled(other)
    for k, of in enumerate((lambda m: m.stiffness(0.7), lambda m: m.mass)):
        expected = (csr(of(changed)) - csr(of(model))) @ X[rows]
        found = both[1][k][rows] - both[0][k][rows]
        assert abs(found - expected).max() < 1e-11 * abs(expected).max()
    # A factor on all walls and columns changes their cells, and no others.
    cells = house.changed(house, storeys=True)
    low, high = (action_of_cells(house, cells, factor, X)[0] for factor in (0.5, 0.6))
    expected = 0.1 * csr(model.storeys) @ X[rows]
    assert abs((high - low)[rows] - expected).max() < 1e-11 * abs(expected).max()


def test_cells_of_a_material_are_apart_and_none_is_lost(house):
    kinds = soft_storeys(house).kinds()
    assert [(k.storey, k.material.E) for k in kinds] == 2 * [(False, 33e9), (True, 16.5e9)]
    mesh, shells = house.mesh, house.materials.shells
    steel = Material(200e9, 0.3, 7850.0)
    one = replace(house, materials=replace(house.materials, shells=(steel, *shells[1:])))
    cells = [len(kind.cells) for kind in one.kinds()]
    assert len(cells) == 5 and sum(cells) == len(mesh.triangles) + len(mesh.lines)
    first = next(kind for kind in one.kinds() if kind.material == steel)
    assert len(first.cells) == np.count_nonzero(mesh.triangle_part == 0)
    assert one.slab_material(1) == steel and one.slab_material(2) != steel
    with pytest.raises(KeyError, match="floor 3"):
        one.slab_material(3)


FACTOR = 0.4
WHOLE = Rayleigh(0.3, 2e-4)
OWN = Rayleigh(1.2, 5e-5)


def dense(matrix):
    return np.asarray(matrix[:, :], dtype=np.float64)


def added_damping(parts, own):
    """With the dampings of parts by their names."""
    both = parts.mesh.shell_parts, parts.mesh.beam_parts
    dampings = PartDamping(*(tuple(own.get(part.group) for part in some) for some in both))
    return dense(damping_matrix(MPI.COMM_SELF, parts, dampings, FACTOR, WHOLE))


def test_added_mass_is_damped_with_its_slab(house):
    """A slab of 4 m by 3 m and 30 cm with 500 kg/m2 on it, moved along x."""
    mesh = house.mesh
    slab = np.flatnonzero(mesh.triangle_part == mesh.shell_parts.index(Part("floor", 2)))
    added = np.zeros(len(mesh.triangles))
    added[slab] = 500.0
    loaded = replace(house, added_mass=added)
    mass = 12.0 * (0.3 * 2500.0 + 500.0)
    only_mass = {"floor_2": Rayleigh(OWN.alpha, WHOLE.beta)}
    for parts, expected in ((loaded, mass), (house, 12.0 * 0.3 * 2500.0)):
        C = added_damping(parts, only_mass)
        along = np.zeros(len(C))
        along[0::6] = 1.0
        assert along @ C @ along == pytest.approx((OWN.alpha - WHOLE.alpha) * expected, rel=1e-12)
    # That on another slab is not.
    C = added_damping(loaded, {"floor_1": Rayleigh(OWN.alpha, WHOLE.beta)})
    assert along @ C @ along == pytest.approx((OWN.alpha - WHOLE.alpha) * 12.0 * 750.0, rel=1e-12)


def quadratic_bar(lengths, EA, rhoA):
    """Stiffness and mass of each quadratic element of a bar that stands on its first node.

    By the integrals of the shape functions at both ends and in the middle (Bathe, section 5.3).
    """
    k = np.array([[7.0, 1.0, -8.0], [1.0, 7.0, -8.0], [-8.0, -8.0, 16.0]]) / 3.0
    m = np.array([[4.0, -1.0, 2.0], [-1.0, 4.0, 2.0], [2.0, 2.0, 16.0]]) / 30.0
    nodes = np.array([[2 * e, 2 * e + 2, 2 * e + 1] for e in range(len(lengths))])
    return (
        nodes,
        [a / h * k for a, h in zip(EA, lengths, strict=True)],
        [a * h * m for a, h in zip(rhoA, lengths, strict=True)],
    )


def complex_frequencies(M, C, K):
    """|s| and −Re s/|s| of the roots of s²M + sC + K above the real axis, ascending."""
    n = len(M)
    state = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, np.hstack([K, C]))]])
    s = scipy.linalg.eigvals(state)
    s = s[s.imag > 0.0]
    order = np.argsort(np.abs(s))
    return np.abs(s)[order], (-s.real / np.abs(s))[order]


def test_bar_of_two_parts(panels):
    """Frequencies and damping ratios along a bar, against matrices made by hand."""
    section = BeamSection.column(0.4, 0.4)
    panels.line((0, 0, 0), (0, 0, 2), 2, Part("column", 1), section)
    panels.line((0, 0, 2), (0, 0, 5), 2, Part("column", 2), section)
    parts = panels.parts(base=panels.at((2, 0.0)))
    model = assemble_building(MPI.COMM_SELF, parts)
    upper = Rayleigh(4.0, 3e-5)
    C = WHOLE.alpha * dense(model.mass) + WHOLE.beta * dense(model.stiffness(FACTOR))
    C += added_damping(parts, {"column_2": upper})
    along = slice(2, None, 6)
    found = complex_frequencies(
        dense(model.mass)[along, along],
        C[along, along],
        dense(model.stiffness(FACTOR))[along, along],
    )
    nodes, k, m = quadratic_bar(
        np.array([1.0, 1.0, 1.5, 1.5]), np.full(4, FACTOR * 33e9 * 0.16), np.full(4, 2500 * 0.16)
    )
    M, B, K = (np.zeros((9, 9)) for _ in range(3))
    for e, damping in enumerate((WHOLE, WHOLE, upper, upper)):
        here = np.ix_(nodes[e], nodes[e])
        M[here] += m[e]
        K[here] += k[e]
        B[here] += damping.matrix(k[e], m[e])
    expected = complex_frequencies(M[1:, 1:], B[1:, 1:], K[1:, 1:])
    assert len(found[0]) == len(expected[0]) > 5
    assert found[0] == pytest.approx(expected[0], rel=1e-9)
    assert found[1] == pytest.approx(expected[1], rel=1e-9)
    # The ratios of one damping for all are others.
    same = complex_frequencies(
        M[1:, 1:], WHOLE.alpha * M[1:, 1:] + WHOLE.beta * K[1:, 1:], K[1:, 1:]
    )
    assert np.abs(found[1][:3] / same[1][:3] - 1.0).max() > 0.1


@pytest.fixture
def cells(house):
    return {"triangles": house.mesh.triangles, "lines": house.mesh.lines}


@pytest.mark.parametrize("kind", ["triangles", "lines"])
def test_a_node_is_where_the_mesh_has_it(house, cells, kind):
    nodes = house.mesh.nodes
    local = local_cells(nodes, cells[kind])
    assert node_coordinates(local.space) == pytest.approx(nodes[local.nodes], abs=1e-12)
    assert sorted(local.nodes) == np.unique(cells[kind]).tolist()


@pytest.mark.parametrize(("kind", "row"), [("triangles", 4), ("lines", 2)])
def test_a_curved_edge_is_refused(house, cells, kind, row):
    nodes = house.mesh.nodes.copy()
    middle = cells[kind][0, row]
    nodes[middle] += [0.0, 0.0, 0.05]
    bent = replace(house.mesh, nodes=nodes)
    with pytest.raises(SolutionError, match=rf"node {middle} at .* 0.05 m"):
        local_cells(bent.nodes, cells[kind])
    if kind == "triangles":
        # Middles in another order.
        with pytest.raises(SolutionError, match="expected straight edges"):
            local_cells(house.mesh.nodes, cells[kind][:1, [0, 1, 2, 4, 5, 3]])


@dataclass(frozen=True)
class OneOf:
    """Stands for a rank of several, where nothing is sent."""

    rank: int
    size: int


def test_each_cell_on_one_rank(house):
    shares = [shared_out(OneOf(rank, 3), house) for rank in range(3)]
    for k, kind in enumerate(shares[0].kinds):
        cells = np.concatenate([share.cells_here[k] for share in shares])
        assert np.array_equal(np.sort(cells), np.arange(len(kind.cells)))
    owned = np.concatenate([share.owned for share in shares])
    assert np.array_equal(np.sort(owned), np.arange(len(house.mesh.nodes)))
    assert all(share.cells_here[0].size for share in shares)


RNG = np.random.default_rng(7)


@pytest.mark.parametrize("parts", [1, 2, 3, 4, 7])
def test_parts_weigh_about_the_same(parts):
    points = RNG.random((500, 3)) * [46.0, 15.0, 30.0]
    weights = RNG.choice([3.0, 6.0], 500)
    weight = np.bincount(bisect(points, weights, parts), weights, parts)
    # Each cut is off by less than one point; a point weighs 6 of at least 330.
    assert len(weight) == parts
    assert np.abs(weight - weights.sum() / parts).max() < 6.0 * np.ceil(np.log2(parts) + 1)


def test_a_heavy_point_is_alone():
    points = np.arange(5.0)[:, None] * [1.0, 0.0, 0.0]
    part = bisect(points, np.array([4.0, 1.0, 1.0, 1.0, 1.0]), 2)
    assert part.tolist() == [0, 1, 1, 1, 1]
