from dataclasses import replace

import numpy as np
import pytest

from impactfem._fenicsx import cell_nodes, node_coordinates
from impactfem.building.assembly import local_cells
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
