"""The side of a building on which the wall stands."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from impactfem.building.read_mesh import read_mesh
from impactfem.reduction.wall import wall_side
from impactfem.system.errors import InputError

from .conftest import slabs

FRAME = Path(__file__).parents[2] / "geometry" / "frame.msh"


@pytest.mark.parametrize("side", ["x-", "x+", "y-", "y+"])
def test_each_side(side):
    assert wall_side(slabs((side, side, side)), (2, 3), "tower.msh") == side


def test_a_mesh_from_a_file():
    # frame.toml: its neighbour stands along +y.
    assert wall_side(read_mesh(FRAME), (1, 2), FRAME) == "y+"


def bent():
    """The middle of the edge of floor 2 is off its line."""
    mesh = slabs(3)
    mesh.nodes[9 + 7, 1] -= 0.05
    return mesh


def with_edges(*floors, empty=False):
    """Three floors, of which these have edges; the others none, or one of no lines."""
    mesh = slabs(3)
    none = {k: np.zeros((0, 3), dtype=np.int64) for k in mesh.edges} if empty else {}
    return replace(mesh, edges=none | {k: mesh.edges[k] for k in floors})


NONE = "no lines; expected those of the slab's edge"
PLANE = "edge_3; expected the edges of all floors"


@pytest.mark.parametrize(
    ("mesh", "floors", "expected"),
    [
        (with_edges(1), (1, 2, 3), {"edge_2": NONE, "edge_3": NONE}),
        (with_edges(1, empty=True), (1, 2, 3), {"edge_2": NONE, "edge_3": NONE}),
        (
            bent(),
            (1, 2, 3),
            {"edge_2": "not straight along x or y, its nodes are up to 0.05 m off"},
        ),
        (
            slabs(2, turn=np.deg2rad(10.0)),
            (1, 2),
            dict.fromkeys(
                ("edge_1", "edge_2"), f"up to {6.0 * np.sin(np.deg2rad(10.0)):.4g} m off"
            ),
        ),
        (
            slabs(("y-", "x+", "y+")),
            (1, 2, 3),
            {
                "edge_1": "faces y-, edge_3 y+; expected all on the side of the wall",
                "edge_2": "faces x+, edge_3 y+; expected all on the side of the wall",
            },
        ),
        (slabs(3, shift={2: (0.0, -0.5)}), (2, 3), {"edge_2": f"is 0.5 m behind {PLANE}"}),
        (slabs(3, shift={2: (0.0, 2e-3)}), (2, 3), {"edge_2": f"is 0.002 m before {PLANE}"}),
    ],
)
def test_edges_that_no_wall_fits(mesh, floors, expected):
    with pytest.raises(InputError) as caught:
        wall_side(mesh, floors, "tower.msh")
    assert {fault.file for fault in caught.value.faults} == {"tower.msh"}
    found = {fault.key: fault.expected for fault in caught.value.faults}
    assert set(found) == set(expected)
    assert all(words in found[key] for key, words in expected.items()), found


def test_floors_may_stand_back_or_aside():
    """Those that do not hit, and any along the wall."""
    mesh = slabs(("x+", "y+", "y+"), shift={2: (0.0, -1.0)})
    assert wall_side(mesh, (3,), "tower.msh") == "y+"
    assert wall_side(slabs(2, shift={2: (1.0, 0.0)}), (1, 2), "tower.msh") == "y+"
