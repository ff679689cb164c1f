"""Groups: what a building's mesh must have, and what is refused, with the group and a place."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from impactfem.building.mesh import Part
from impactfem.building.read_mesh import Block, RawMesh, assemble
from impactfem.system.errors import InputError

FILE = Path("own.msh")
PLACE = r"\(-?\d+\.\d{3}, -?\d+\.\d{3}, -?\d+\.\d{3}\) m"


def renamed(raw: RawMesh, names: dict[str, str | None]) -> RawMesh:
    """The mesh with groups that have another name, or, with None, are not there."""
    blocks = []
    for block in raw.blocks:
        groups = [names.get(group, group) for group in block.groups]
        blocks.append(replace(block, groups=tuple(group for group in groups if group)))
    every = [(names.get(group, group), dimension) for group, dimension in raw.groups]
    return RawMesh(raw.nodes, tuple(blocks), tuple((g, d) for g, d in every if g))


def without(raw: RawMesh, *groups: str) -> RawMesh:
    """The mesh without the cells of some groups."""
    blocks = tuple(block for block in raw.blocks if not set(block.groups) & set(groups))
    kept = tuple((g, d) for g, d in raw.groups if g not in groups)
    return RawMesh(raw.nodes, blocks, kept)


def edited(raw: RawMesh, group: str, **changes) -> RawMesh:
    blocks = tuple(replace(b, **changes) if group in b.groups else b for b in raw.blocks)
    return replace(raw, blocks=blocks)


def faults(raw: RawMesh) -> list[str]:
    with pytest.raises(InputError) as caught:
        assemble(raw, FILE)
    assert {fault.file for fault in caught.value.faults} == {FILE}
    return [f"{fault.key}: {fault.expected}" for fault in caught.value.faults]


def test_the_mesh_as_it_is(small_raw):
    mesh = assemble(small_raw, FILE)
    assert Part("floor", 2, "acroterion") in mesh.shell_parts
    assert len(mesh.dropped) == 0
    assert mesh.triangles.max() < len(mesh.nodes)
    np.testing.assert_array_equal(
        np.unique(np.concatenate([mesh.triangles.ravel(), mesh.lines.ravel()])),
        np.arange(len(mesh.nodes)),
    )


@pytest.mark.parametrize(
    ("group", "expected"),
    [
        ("base", "base: missing group; expected the lines or points that are clamped"),
        ("edge_1", "edge_1: missing group; expected the lines of the slab's edge"),
        ("centre_2", "centre_2: missing group; expected the node at the floor's mass centre"),
        ("floor_1", "floor_1: missing group; floor_2 is above it"),
    ],
)
def test_a_missing_group(small_raw, group, expected):
    (fault,) = faults(without(small_raw, group))
    assert fault.startswith(expected)


def test_no_floor_at_all(small_raw):
    slabs = [group for group, _ in small_raw.groups if group.startswith("floor")]
    assert faults(without(small_raw, *slabs)) == [
        "floor_1: missing group; expected the slabs as floor_<k>"
    ]


def test_no_storey_at_all(small_raw):
    walls = [g for g, _ in small_raw.groups if g.startswith(("storey", "column"))]
    assert (
        "storey_1: missing group; expected walls as storey_<k> or columns as column_<k>"
        in faults(without(small_raw, *walls))
    )


def test_a_storey_of_columns_alone_is_one(small_raw):
    walls = [g for g, _ in small_raw.groups if g.startswith("storey_2")]
    assert assemble(without(small_raw, *walls), FILE).floors == (1, 2)


def test_a_storey_without_walls_and_columns(small_raw):
    storey = [g for g, _ in small_raw.groups if g.startswith(("storey_2", "column_2"))]
    assert faults(without(small_raw, *storey)) == [
        "storey_2: missing group; expected walls or columns below floor_2"
    ]


def test_a_number_above_the_top(small_raw):
    names = {"beam_2_face": "beam_3_face", "edge_2": "edge_4"}
    assert faults(renamed(small_raw, names)) == [
        "edge_2: missing group; expected the lines of the slab's edge that faces the other "
        "building",
        "beam_3_face: expected a number from 1 to 2, that of the top floor",
        "edge_4: expected a number from 1 to 2, that of the top floor",
    ]


def test_an_unknown_name(small_raw):
    (fault,) = faults(renamed(small_raw, {"storey_1_inner": "wall_1_inner"}))
    assert fault.startswith("wall_1_inner: unknown physical group; expected floor_<k>[_<part>]")


def test_the_wrong_dimension(small_raw):
    names = {"storey_1_inner": "beam_1_inner", "beam_1_rim": "storey_1_rim"}
    assert faults(renamed(small_raw, names)) == [
        "storey_1_rim: a group of lines; expected surfaces",
        "beam_1_inner: a group of surfaces; expected lines",
    ]


def test_cells_without_a_group(small_raw):
    (fault,) = faults(renamed(small_raw, {"storey_1_inner": None}))
    assert fault.startswith(": ")
    assert "cells of surfaces without a physical group, the first at (" in fault
    (fault,) = faults(renamed(small_raw, {"beam_1_oblique": None}))
    assert "cells of lines without a physical group, the first at (" in fault


def test_points_without_a_group_are_let_be(small_raw):
    corner = Block(0, "Point", np.array([[5]]), ())
    mesh = assemble(replace(small_raw, blocks=(*small_raw.blocks, corner)), FILE)
    assert len(mesh.centres) == 2


def test_cells_in_two_groups(small_raw):
    found = faults(edited(small_raw, "storey_1_inner", groups=("floor_1", "storey_1_inner")))
    assert any(f.startswith("floor_1, storey_1_inner: ") for f in found)
    assert any("cells, the first at (" in f and "in two groups" in f for f in found)


def test_a_line_may_be_a_beam_an_edge_and_the_base(small_raw):
    """As in the generated mesh: the beam on the face is the impact edge as well."""
    shared = [b.groups for b in small_raw.blocks if len(b.groups) > 1]
    assert ("beam_2_face", "edge_2") in shared
    mesh = assemble(small_raw, FILE)
    on_face = mesh.lines[mesh.line_part == mesh.beam_parts.index(Part("beam", 2, "face"))]
    np.testing.assert_array_equal(np.unique(on_face), np.unique(mesh.edges[2]))


def test_first_order(small_raw):
    blocks = tuple(
        replace(b, nodes=b.nodes[:, : b.dimension + 1], kind=kind)
        for b in small_raw.blocks
        for kind in [("Point", "Line 2", "Triangle 3")[b.dimension]]
    )
    (fault,) = faults(replace(small_raw, blocks=blocks))
    assert "first-order cells, the first at (" in fault
    assert "expected a mesh of second order (gmsh -order 2" in fault


def test_quadrangles(small_raw):
    (fault,) = faults(edited(small_raw, "storey_1_inner", kind="Quadrilateral 9"))
    assert fault.startswith("storey_1_inner: ")
    assert fault.endswith("expected triangles with 6 nodes and lines with 3")


def test_nodes_of_no_element_are_dropped(small_raw):
    nodes = np.vstack([[99.0, 98.0, 97.0], small_raw.nodes])
    blocks = tuple(replace(b, nodes=b.nodes + 1) for b in small_raw.blocks)
    mesh = assemble(replace(small_raw, nodes=nodes, blocks=blocks), FILE)
    np.testing.assert_array_equal(mesh.dropped, [[99.0, 98.0, 97.0]])
    np.testing.assert_array_equal(mesh.nodes, assemble(small_raw, FILE).nodes)


def test_an_edge_that_is_not_the_slab_s(small_raw):
    names = {"edge_1": "edge_2", "edge_2": "edge_1"}
    found = faults(renamed(small_raw, names))
    assert [f.split(" at")[0] for f in found] == ["edge_1:", "edge_2:"]
    assert found[0].endswith("expected lines that are sides of triangles of floor_1")


def test_a_centre_outside_the_slab(small_raw, small_mesh):
    names = {"centre_1": "centre_2", "centre_2": "centre_1"}
    found = faults(renamed(small_raw, names))
    expected = "at (4.000, 2.500, 5.800) m: expected a node of floor_1 (in gmsh: a point embedded"
    assert found[0].startswith(f"centre_1: {expected}")


def test_two_centres(small_raw):
    more = Block(0, "Point", np.array([[5]]), ("centre_1",))
    (fault,) = faults(replace(small_raw, blocks=(*small_raw.blocks, more)))
    assert fault.startswith("centre_1: at (")
    assert fault.endswith("2 nodes; expected one")


def test_a_base_of_points_alone(small_raw, small_mesh):
    points = Block(0, "Point", np.array([[3], [1]]), ("base",))
    raw = without(small_raw, "base")
    mesh = assemble(
        RawMesh(raw.nodes, (*raw.blocks, points), (*raw.groups, ("base", 0))), FILE
    )  # fmt: skip
    np.testing.assert_array_equal(mesh.base, [1, 3])


def test_a_base_off_the_structure(small_raw):
    nodes = np.vstack([small_raw.nodes, [4.0, 4.0, -1.0]])
    point = Block(0, "Point", np.array([[len(small_raw.nodes)]]), ("base",))
    raw = replace(small_raw, nodes=nodes, blocks=(*small_raw.blocks, point))
    assert faults(raw) == [
        "base: at (4.000, 4.000, -1.000) m: expected nodes of walls, columns, slabs or beams"
    ]
