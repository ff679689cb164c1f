from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from mpi4py import MPI
from petsc4py import PETSc
from scipy.sparse import random as random_sparse

from impactfem._fenicsx import cell_nodes, node_coordinates
from impactfem.building.assembly import (
    Numbering,
    added,
    bisect,
    global_matrix,
    local_cells,
    number_nodes,
    shared_out,
    without,
    without_zeros,
)
from impactfem.building.model import assemble_building
from impactfem.building.parts import BeamCells, BuildingParts
from impactfem.system.errors import SolutionError


@pytest.fixture
def cells(house):
    return {"triangles": house.mesh.triangles, "lines": house.mesh.lines}


@pytest.mark.parametrize("kind", ["triangles", "lines"])
def test_a_node_is_where_the_mesh_has_it(house, cells, kind):
    nodes = house.mesh.nodes
    local = local_cells(nodes, cells[kind])
    assert node_coordinates(local.space) == pytest.approx(nodes[local.nodes], abs=1e-12)
    assert sorted(local.nodes) == np.unique(cells[kind]).tolist()


@pytest.mark.parametrize("kind", ["triangles", "lines"])
def test_a_cell_has_the_nodes_of_the_cell_it_was(house, cells, kind):
    """Some cells only, in an order that is not the mesh's."""
    chosen = np.random.default_rng(1).permutation(cells[kind])[: len(cells[kind]) // 2]
    local = local_cells(house.mesh.nodes, chosen)
    found = np.sort(local.nodes[cell_nodes(local.space)], axis=1)
    assert sorted(local.cells) == list(range(len(chosen)))
    assert found.tolist() == np.sort(chosen[local.cells], axis=1).tolist()


def test_corners_may_start_anywhere(house):
    """The same triangle, written from another corner and the other way round."""
    triangles = house.mesh.triangles[:3].copy()
    triangles[1] = triangles[1][[1, 2, 0, 4, 5, 3]]
    triangles[2] = triangles[2][[0, 2, 1, 5, 4, 3]]
    local = local_cells(house.mesh.nodes, triangles)
    assert node_coordinates(local.space) == pytest.approx(house.mesh.nodes[local.nodes], abs=1e-12)


def test_where_three_panels_meet_a_node_is_one(house):
    local = local_cells(house.mesh.nodes, house.mesh.triangles)
    assert len(local.nodes) == len(set(local.nodes))


@pytest.mark.parametrize(("kind", "row"), [("triangles", 4), ("lines", 2)])
def test_a_curved_edge_is_refused(house, cells, kind, row):
    nodes = house.mesh.nodes.copy()
    middle = cells[kind][0, row]
    nodes[middle] += [0.0, 0.0, 0.05]
    bent = replace(house.mesh, nodes=nodes)
    with pytest.raises(SolutionError, match=rf"node {middle} at .* m lies 0.05 m from its edge's"):
        local_cells(bent.nodes, cells[kind])


def test_middles_in_another_order_are_refused(house):
    triangles = house.mesh.triangles[:1, [0, 1, 2, 4, 5, 3]]
    with pytest.raises(SolutionError, match="expected straight edges with mid nodes in the middle"):
        local_cells(house.mesh.nodes, triangles)


@dataclass(frozen=True)
class OneOf:
    """Stands for a rank of several, where nothing is sent."""

    rank: int
    size: int


def test_each_cell_on_one_rank(house: BuildingParts) -> None:
    shares = [shared_out(OneOf(rank, 3), house) for rank in range(3)]
    for k, kind in enumerate(shares[0].kinds):
        cells = np.concatenate([share.cells_here[k] for share in shares])
        assert np.array_equal(np.sort(cells), np.arange(len(kind.cells)))
    owned = np.concatenate([share.numbering.owned for share in shares])
    assert np.array_equal(np.sort(owned), np.arange(len(house.mesh.nodes)))
    assert all(share.cells_here[0].size for share in shares)


def test_free_rows(house: BuildingParts) -> None:
    share = shared_out(MPI.COMM_SELF, house)
    model = assemble_building(MPI.COMM_SELF, house)
    assert share.free.sum() == model.n_free < 6 * len(house.mesh.nodes)
    nodes = share.numbering.owned[share.free[::6]]
    assert np.array_equal(nodes, model.nodes)
    assert not np.isin(nodes, house.mesh.base).any()


def test_parts_of_the_cells(house: BuildingParts) -> None:
    mesh = house.mesh
    for kind in shared_out(MPI.COMM_SELF, house).kinds:
        parts = mesh.beam_parts if isinstance(kind, BeamCells) else mesh.shell_parts
        assert {parts[p].scaled for p in np.unique(kind.part)} == {kind.storey}
        cells, of_cell = (
            (mesh.lines, mesh.line_part)
            if isinstance(kind, BeamCells)
            else (mesh.triangles, mesh.triangle_part)
        )
        known = {tuple(cell): part for cell, part in zip(cells, of_cell, strict=True)}
        assert [known[tuple(cell)] for cell in kind.cells] == list(kind.part)


RNG = np.random.default_rng(7)


@pytest.mark.parametrize("parts", [1, 2, 3, 4, 7])
def test_parts_weigh_about_the_same(parts):
    points = RNG.random((500, 3)) * [46.0, 15.0, 30.0]
    weights = RNG.choice([3.0, 6.0], 500)
    part = bisect(points, weights, parts)
    weight = np.bincount(part, weights, parts)
    # Each cut is off by less than one point; a point weighs 6 of at least 330.
    assert len(weight) == parts
    assert np.abs(weight - weights.sum() / parts).max() < 6.0 * np.ceil(np.log2(parts) + 1)


def test_the_longest_side_is_cut():
    x, y = np.meshgrid(np.arange(12.0), np.arange(3.0))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(36)])
    part = bisect(points, np.ones(36), 3)
    # Thirds of the length, 12 points each.
    assert part.tolist() == (points[:, 0] // 4).astype(int).tolist()


def test_a_heavy_point_is_alone():
    points = np.arange(5.0)[:, None] * [1.0, 0.0, 0.0]
    part = bisect(points, np.array([4.0, 1.0, 1.0, 1.0, 1.0]), 2)
    assert part.tolist() == [0, 1, 1, 1, 1]


def test_the_same_every_time():
    points = np.round(RNG.random((200, 3)), 1)  # with ties
    first, second = (bisect(points.copy(), np.ones(200), 5) for _ in range(2))
    assert first.tolist() == second.tolist()


def test_more_parts_than_points():
    part = bisect(np.eye(3), np.ones(3), 8)
    assert len(set(part)) == 3 and part.min() >= 0 and part.max() < 8


def test_no_point():
    assert bisect(np.zeros((0, 3)), np.zeros(0), 2).shape == (0,)


TRIANGLES = np.array([[0, 1, 2, 3, 4, 5], [2, 1, 6, 4, 7, 8]])
LINES = np.array([[6, 9, 10]])


def of_ranks(size, *parts, n_nodes=11):
    comms = [SimpleNamespace(rank=rank, size=size) for rank in range(size)]
    ranks = [np.array(part) for part in parts]
    return [number_nodes(comm, n_nodes, [TRIANGLES, LINES], ranks) for comm in comms]


def test_a_shared_node_is_of_the_lowest_rank():
    zero, one, two = of_ranks(3, [2, 0], [1])
    # Rank 0 has the second triangle, rank 1 the line but not its shared end.
    assert sorted(zero.owned) == [1, 2, 4, 6, 7, 8]
    assert sorted(one.owned) == [9, 10]
    assert sorted(two.owned) == [0, 3, 5]


def test_rows_follow_the_ranks():
    numberings = of_ranks(3, [2, 0], [1])
    order = np.concatenate([numbering.owned for numbering in numberings])
    for numbering in numberings:
        assert sorted(numbering.place) == list(range(11))
        assert numbering.place[order].tolist() == list(range(11))


def test_a_rank_without_cells():
    numberings = of_ranks(4, [3, 3], [1])
    assert [len(numbering.owned) for numbering in numberings] == [0, 3, 0, 8]


def test_one_rank_keeps_the_order_of_the_mesh():
    (alone,) = of_ranks(1, [0, 0], [0])
    assert alone.place.tolist() == alone.owned.tolist() == list(range(11))


def test_a_node_without_cells():
    with pytest.raises(SolutionError, match="node 11 belongs to no shell and no beam"):
        of_ranks(1, [0, 0], [0], n_nodes=13)


NODES = np.array([3, 0, 2])
PLACE = np.array([2, 0, 3, 1])  # of the nodes 0 to 3


@pytest.fixture
def numbering():
    return Numbering(PETSc.COMM_SELF.tompi4py(), PLACE, np.argsort(PLACE))


@pytest.fixture
def local():
    """A matrix of three nodes, as PETSc's and as an array."""

    def make(seed=0):
        full = random_sparse(18, 18, 0.3, "csr", random_state=seed)
        matrix = PETSc.Mat().createAIJ(
            full.shape, bsize=6, csr=(full.indptr, full.indices, full.data), comm=PETSc.COMM_SELF
        )
        matrix.assemble()
        return matrix, full.toarray()

    return make


def expected(values):
    """The blocks of the nodes 3, 0 and 2 at the places 1, 2 and 3; node 1 has the place 0."""
    full = np.zeros((24, 24))
    rows = (6 * np.array([1, 2, 3])[:, None] + np.arange(6)).ravel()
    full[np.ix_(rows, rows)] = values
    return full


def test_blocks_go_to_the_places_of_their_nodes(local, numbering, csr):
    matrix, values = local()
    made = global_matrix(matrix, NODES, numbering)
    assert made.getType() == "seqaij"
    assert csr(made).toarray() == pytest.approx(expected(values), rel=1e-15)


def test_without_cells(numbering, csr):
    made = global_matrix(None, np.empty(0, dtype=np.int64), numbering)
    assert made.getSize() == (24, 24) and csr(made).nnz == 0


def test_a_sum_of_different_patterns(local, numbering, csr):
    (one, first), (two, second) = local(1), local(2)
    made = added([global_matrix(m, NODES, numbering) for m in (one, two)], numbering)
    assert csr(made).toarray() == pytest.approx(expected(first + second), rel=1e-14)


def test_a_sum_of_nothing(numbering, csr):
    made = added([], numbering)
    assert made.getSize() == (24, 24) and not csr(made).toarray().any()


def test_zeros_leave_the_pattern(local, csr):
    matrix, values = local()
    before = csr(matrix).nnz
    row, column = np.argwhere(values)[5]
    matrix.setValue(int(row), int(column), 0.0)
    matrix.assemble()
    values[row, column] = 0.0
    kept = without_zeros(matrix)
    assert kept.getBlockSize() == 6 and csr(kept).nnz == before - 1
    assert csr(kept).toarray().tolist() == values.tolist()


def test_free_rows_and_columns_stay(local, numbering, csr):
    matrix, values = local()
    made = global_matrix(matrix, NODES, numbering)
    free = np.concatenate([np.arange(6), np.arange(12, 24)])
    kept = without(made, free)
    assert kept.getBlockSize() == 6
    assert csr(kept).toarray() == pytest.approx(expected(values)[np.ix_(free, free)], rel=1e-15)
