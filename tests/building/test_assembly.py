from dataclasses import dataclass, replace

import numpy as np
import pytest

from impactfem._fenicsx import node_coordinates
from impactfem.building.assembly import (
    bisect,
    local_cells,
    shared_out,
)
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


@pytest.mark.parametrize(("kind", "row"), [("triangles", 4), ("lines", 2)])
def test_a_curved_edge_is_refused(house, cells, kind, row):
    nodes = house.mesh.nodes.copy()
    middle = cells[kind][0, row]
    nodes[middle] += [0.0, 0.0, 0.05]
    bent = replace(house.mesh, nodes=nodes)
    with pytest.raises(SolutionError, match=rf"node {middle} at .* m lies 0.05 m from its edge's"):
        local_cells(bent.nodes, cells[kind])
    if kind == "triangles":
        # Middles in another order.
        with pytest.raises(SolutionError, match="expected straight edges with mid nodes in the mi"):
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
    part = bisect(points, weights, parts)
    weight = np.bincount(part, weights, parts)
    # Each cut is off by less than one point; a point weighs 6 of at least 330.
    assert len(weight) == parts
    assert np.abs(weight - weights.sum() / parts).max() < 6.0 * np.ceil(np.log2(parts) + 1)


def test_a_heavy_point_is_alone():
    points = np.arange(5.0)[:, None] * [1.0, 0.0, 0.0]
    part = bisect(points, np.array([4.0, 1.0, 1.0, 1.0, 1.0]), 2)
    assert part.tolist() == [0, 1, 1, 1, 1]


def test_more_parts_than_points():
    part = bisect(np.eye(3), np.ones(3), 8)
    assert len(set(part)) == 3 and part.min() >= 0 and part.max() < 8
