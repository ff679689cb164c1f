"""The side of a building on which the wall stands."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from impactfem.building.mesh import BuildingMesh
from impactfem.building.read_mesh import read_mesh
from impactfem.reduction.wall import wall_side
from impactfem.system.errors import InputError

from .conftest import slabs

FRAME = Path(__file__).parents[2] / "geometry" / "frame.msh"


def faults_of(mesh: BuildingMesh, floors: tuple[int, ...]) -> dict[str, str]:
    with pytest.raises(InputError) as caught:
        wall_side(mesh, floors, "tower.msh")
    assert {fault.file for fault in caught.value.faults} == {"tower.msh"}
    return {fault.key: fault.expected for fault in caught.value.faults}


@pytest.mark.parametrize("side", ["x-", "x+", "y-", "y+"])
def test_each_side(side: str) -> None:
    assert wall_side(slabs((side, side, side)), (2, 3), "tower.msh") == side


def test_a_mesh_from_a_file() -> None:
    # frame.toml: its neighbour stands along +y.
    assert wall_side(read_mesh(FRAME), (1, 2), FRAME) == "y+"


def test_floors_that_do_not_hit_may_stand_back() -> None:
    mesh = slabs(("x+", "y+", "y+"), shift={2: (0.0, -1.0)})
    assert wall_side(mesh, (3,), "tower.msh") == "y+"


@pytest.mark.parametrize("broken", ["missing", "empty"])
def test_floor_without_an_edge(broken: str) -> None:
    mesh = slabs(("y+", "y+", "y+"))
    edges = {k: lines for k, lines in mesh.edges.items() if k == 1}
    if broken == "empty":
        edges |= {k: np.zeros((0, 3), dtype=np.int64) for k in (2, 3)}
    faults = faults_of(replace(mesh, edges=edges), (1, 2, 3))
    assert set(faults) == {"edge_2", "edge_3"}
    assert all("no lines; expected those of the slab's edge" in text for text in faults.values())


def test_edge_that_is_not_straight() -> None:
    mesh = slabs(("y+", "y+", "y+"))
    mesh.nodes[9 + 7, 1] -= 0.05  # the middle of the edge of floor 2
    faults = faults_of(mesh, (1, 2, 3))
    assert set(faults) == {"edge_2"}
    assert "not straight along x or y, its nodes are up to 0.05 m off" in faults["edge_2"]


def test_oblique_edge() -> None:
    turn = np.deg2rad(10.0)
    mesh = slabs(2, turn=turn)
    faults = faults_of(mesh, (1, 2))
    assert set(faults) == {"edge_1", "edge_2"}
    assert f"up to {6.0 * np.sin(turn):.4g} m off" in faults["edge_1"]


def test_edges_on_different_sides() -> None:
    faults = faults_of(slabs(("y-", "x+", "y+")), (1, 2, 3))
    assert set(faults) == {"edge_1", "edge_2"}
    assert "faces y-, edge_3 y+; expected all on the side of the wall" in faults["edge_1"]


@pytest.mark.parametrize(
    ("shift", "word"), [((0.0, -0.5), "0.5 m behind"), ((0.0, 2e-3), "0.002 m before")]
)
def test_edges_not_in_one_plane(shift: tuple[float, float], word: str) -> None:
    faults = faults_of(slabs(("y+", "y+", "y+"), shift={2: shift}), (2, 3))
    assert set(faults) == {"edge_2"}
    assert f"is {word} edge_3; expected the edges of all floors" in faults["edge_2"]
    # Along the wall a floor may be shifted.
    assert wall_side(slabs(("y+", "y+"), shift={2: (1.0, 0.0)}), (1, 2), "tower.msh") == "y+"
