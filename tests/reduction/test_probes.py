"""Nodes of the frame whose motion is wanted."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.case.transient import Probe as CaseProbe
from impactfem.case.transient import Transient
from impactfem.reduction.probes import checked_probes, covered_points, motion_grid, standard_probes
from impactfem.system.errors import InputError
from one_building import building_of


@pytest.fixture
def mesh(frame):
    return frame.parts.mesh


def case_of(*probes, envelopes=()):
    """A building with these probes, and anchors of a device that ask for some."""
    anchors = [SimpleNamespace(envelope=names) for names in envelopes]
    return SimpleNamespace(
        case=SimpleNamespace(path=Path("case.toml")),
        wave_floor=None,
        transient=SimpleNamespace(),
        numbered_probes=tuple(enumerate(probes)),
        numbered_devices=((0, SimpleNamespace(anchor_points=anchors)),),
    )


def requested(mesh, **keys):
    """Name, place and distance of the probes of one table."""
    probe = CaseProbe.model_validate({"name": "mine", **keys})
    found = checked_probes(case_of(probe), mesh)[len(standard_probes(mesh)) :]
    return [(p.name, mesh.nodes[p.node].round(9).tolist(), round(p.distance, 9)) for p in found]


def test_those_that_are_always_there(mesh):
    found = {p.name: mesh.nodes[p.node].round(9).tolist() for p in standard_probes(mesh)}
    line = {f"line_{k + 1}": [3.0, 4.0 - 0.5 * k, 6.0] for k in range(9)}
    # Along y lie nodes every 4/6 m and 4/12 m; the line's points are taken to the nearest one.
    for name, point in line.items():
        assert np.linalg.norm(np.array(found.pop(name)) - point) < 0.2
    assert found == {
        "centre_1": [3, 2, 3],
        "centre_2": [3, 2, 6],
        "edge_1": [3, 4, 3],
        "edge_2": [3, 4, 6],
    }


@pytest.mark.parametrize("side", ["y-", "x-", "x+"])
def test_line_begins_at_the_impact_edge_on_any_side(mesh, side):
    """The same frame, turned by quarters about z."""
    turns = {"x-": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], "y-": np.diag([-1, -1, 1])}
    turn = np.array(turns.get(side, np.array(turns["x-"]).T), dtype=float)
    turned = replace(mesh, nodes=mesh.nodes @ turn.T)
    line = [p.node for p in standard_probes(turned) if p.name.startswith("line_")]
    start, end = turned.nodes[line[0]], turned.nodes[line[-1]]
    assert start == pytest.approx(turn @ [3, 4, 6], abs=1e-9)
    assert end == pytest.approx(turn @ [3, 0, 6], abs=1e-9)


def test_points(mesh):
    assert requested(mesh, point=["0 m", "4 m", "6 m"]) == [("mine", [0, 4, 6], 0)]
    assert requested(mesh, point=["0 m", "4 m", "6.3 m"]) == [("mine", [0, 4, 6], 0.3)]
    # A point within a metre is told by its distance, not refused.
    assert requested(mesh, point=["6.9 m", "4 m", "6 m"])[0][2] == 0.9
    ends = {"from": ["0 m", "0 m", "3 m"], "to": ["600 cm", "0 m", "3 m"], "count": 3}
    line = [(f"mine_{k}", [3 * (k - 1), 0, 3], 0) for k in (1, 2, 3)]
    assert requested(mesh, **ends) == line


@pytest.mark.parametrize(
    ("group", "where"),
    [
        ("edge_2", {1: 4.0, 2: 6.0}),
        ("centre_1", {0: 3.0, 1: 2.0, 2: 3.0}),
        ("floor_1", {2: 3.0}),
        ("beam_2_east", {0: 6.0, 2: 6.0}),
    ],
)
def test_groups(mesh, group, where):
    found = requested(mesh, group=group)
    there = np.all([np.isclose(mesh.nodes[:, k], x) for k, x in where.items()], axis=0)
    assert [name for name, _, _ in found] == [f"mine_{k + 1}" for k in range(there.sum())]
    assert sorted(place for _, place, _ in found) == sorted(mesh.nodes[there].round(9).tolist())


def test_group_with_clamped_nodes(mesh):
    """Of a wall that stands on the base only the free nodes; of the base none."""
    assert min(place[2] for _, place, _ in requested(mesh, group="storey_1_west")) > 0.0
    for group in ("base", "floor_9", "edge_3", "centre_3", "storey_1_east", "beam_1"):
        message = f"the probe's group {group} has no free nodes in this mesh"
        with pytest.raises(InputError, match=message):
            requested(mesh, group=group)


def test_every_probe_of_a_case_that_is_outside(frame):
    probes = [
        CaseProbe.model_validate({"name": name, **keys})
        for name, keys in {
            "far": {"point": ["0 m", "80 m", "3 m"]},
            "good": {"point": ["0 m", "4 m", "3 m"]},
            "roof": {"group": "beam_7"},
            "row": {"from": ["0 m", "4 m", "3 m"], "to": ["0 m", "40 m", "3 m"], "count": 2},
            "half": {"from": ["0 m", "-9 m", "3 m"], "to": ["0 m", "9 m", "3 m"], "count": 2},
        }.items()
    ]
    transient = Transient(time_step=1e-3, probes=tuple(probes))
    case = frame.case.model_copy(update={"transient": transient})
    with pytest.raises(InputError) as caught:
        checked_probes(building_of(case), frame.parts.mesh)
    found = [(fault.key, fault.expected.split(":")[0]) for fault in caught.value.faults]
    assert found == [
        (
            "transient.probes[0].point",
            "the probe far at (0.000, 80.000, 3.000) m is outside the building",
        ),
        ("transient.probes[2].group", "the probe's group beam_7 has no free nodes in this mesh"),
        (
            "transient.probes[3].to",
            "the probe row_2 at (0.000, 40.000, 3.000) m is outside the building",
        ),
        (
            "transient.probes[4].from",
            "the probe half_1 at (0.000, -9.000, 3.000) m is outside the building",
        ),
    ]
    good = transient.model_copy(update={"probes": tuple(probes[1:2])})
    case = frame.case.model_copy(update={"transient": good})
    assert checked_probes(building_of(case), frame.parts.mesh)[-1].name == "good"


def test_half_of_large_elements_counts(mesh):
    """On a coarse mesh a point inside an element may be farther than a metre from all nodes."""
    coarse = replace(mesh, nodes=4.0 * mesh.nodes)
    assert requested(coarse, point=["24 m", "16 m", "25.3 m"])[0][2] == 1.3
    with pytest.raises(InputError, match=r"is 1\.5 m away"):
        requested(coarse, point=["24 m", "16 m", "25.5 m"])


CORNER = CaseProbe(name="corner", point=(6.0, 4.0, 6.0))
RIM = CaseProbe(name="rim", group="edge_2")


def test_names_and_patterns_by_anchor(mesh):
    envelopes = ("corner", "centre_*"), (), ("centre_2", "rim_1")
    found = covered_points(case_of(CORNER, RIM, envelopes=envelopes), mesh)
    assert set(found.names) == {"centre_1", "centre_2", "corner", "rim_1"}
    names = [[found.names[k] for k in points] for points in found.of_anchor]
    assert names[0] == ["centre_1", "centre_2", "corner"] and names[1] == []
    assert set(names[2]) == {"centre_2", "rim_1"}
    node = found.nodes[found.names.index("corner")]
    assert mesh.nodes[node] == pytest.approx([6.0, 4.0, 6.0])
    none = covered_points(case_of(CORNER, RIM, envelopes=((), ())), mesh)
    assert (none.nodes, none.of_anchor) == ((), ((), ()))
    # How many nodes a group has only the mesh knows.
    other = case_of(CORNER, RIM, envelopes=(("corner", "rim_999"),))
    with pytest.raises(InputError, match="envelope = 'rim_999': expected"):
        covered_points(other, mesh)


@pytest.mark.parametrize(("which", "corners", "ends"), [("vertices", 3, 2), ("all", 6, 3)])
def test_cells_are_those_of_the_mesh(mesh, which, corners, ends):
    grid = motion_grid(mesh, which)
    assert (grid.triangles.shape[1], grid.lines.shape[1]) == (corners, ends)
    assert np.array_equal(grid.nodes[grid.triangles], mesh.triangles[:, :corners])
    assert np.array_equal(grid.nodes[grid.lines], mesh.lines[:, :ends])
    assert np.array_equal(grid.points, mesh.nodes[grid.nodes])
    assert grid.cells == len(mesh.triangles) + len(mesh.lines)
    # Mid nodes are in the middle of what is drawn straight without them.
    assert (len(grid.nodes) == len(mesh.nodes)) == (which == "all")
    # Every node belongs to a cell.
    used = np.unique(np.concatenate([grid.triangles.ravel(), grid.lines.ravel()]))
    assert np.array_equal(used, np.arange(len(grid.nodes)))
