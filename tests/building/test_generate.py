"""The generator: what was asked is there, in full, and shares its nodes."""

import re
from dataclasses import replace

import numpy as np
import pytest

from impactfem.building.generate import generate
from impactfem.building.geometry import Beam, Column, Geometry, MeshSize, Wall
from impactfem.building.mesh import areas
from impactfem.building.mesh_checks import check_mesh
from impactfem.building.read_mesh import read_mesh
from impactfem.building.section import BeamSection
from impactfem.system.errors import ImpactfemError, InputError

pytestmark = pytest.mark.usefixtures("gmsh_each_time")


def small_box(**changes):
    """One storey on two walls, some ten elements."""
    box = Geometry(
        length=4.0,
        width=3.0,
        levels=(1.0, 4.0),
        slab_thickness=0.2,
        walls=(
            Wall("west", (1,), (0.0, 0.0), (0.0, 3.0), 0.2),
            Wall("east", (1,), (4.0, 0.0), (4.0, 3.0), 0.2),
        ),
        size=MeshSize.uniform(1.5),
    )
    return replace(box, **changes)


def made(geometry, tmp_path, **options):
    path = tmp_path / "made.msh"
    generate(geometry, path, **options)
    return read_mesh(path)


def by_group(mesh, values, own, parts):
    total = np.bincount(own, weights=values, minlength=len(parts))
    return {part.group: value for part, value in zip(parts, total, strict=True)}


def test_areas_are_those_of_the_drawing(small_mesh):
    area = areas(small_mesh.nodes, small_mesh.triangles)
    found = by_group(small_mesh, area, small_mesh.triangle_part, small_mesh.shell_parts)
    assert found == pytest.approx(
        {
            "floor_1": 40.0,
            "floor_2": 40.0,
            "floor_2_parapet": 26.0 * 0.6,
            "storey_1_south": 8.0 * 3.0 - 1.5 * 1.2 - 1.0 * 2.1 - 2.0 * 0.4,
            "storey_1_north": 24.0,
            "storey_1_inner": np.sqrt(8.0) * 3.0,
            "storey_2_south": 8.0 * 2.8,
            "storey_2_north": 8.0 * 2.8 - 0.5,
        },
        rel=1e-12,
    )


def test_lengths_are_those_of_the_drawing(small_mesh):
    ends = small_mesh.nodes[small_mesh.lines[:, :2]]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    found = by_group(small_mesh, length, small_mesh.line_part, small_mesh.beam_parts)
    oblique = np.hypot(1.5, 2.8)
    assert found == pytest.approx(
        {"beam_1_long": 8.0, "beam_1_cross": 5.0, "beam_1_oblique": oblique, "beam_1_rim": 8.0,
         "beam_2_long": 8.0, "beam_2_cross": 5.0, "beam_2_face": 8.0,
         "column_1_middle": 3.0, "column_2_middle": 2.8,
         "column_1_alone": 3.0, "column_2_alone": 2.8},
        rel=1e-12,
    )  # fmt: skip


def test_marks(small_mesh):
    nodes = small_mesh.nodes
    for k, z in ((1, 3.0), (2, 5.8)):
        np.testing.assert_allclose(nodes[small_mesh.centres[k]], [4.0, 2.5, z], atol=1e-9)
        edge = nodes[small_mesh.edges[k]]
        np.testing.assert_allclose(edge[..., 1:], np.broadcast_to([5.0, z], (*edge.shape[:2], 2)))
        assert np.linalg.norm(edge[:, 1] - edge[:, 0], axis=1).sum() == pytest.approx(8.0)
        np.testing.assert_allclose(edge[:, 2], edge[:, :2].mean(axis=1), atol=1e-9)
    base = nodes[small_mesh.base]
    np.testing.assert_allclose(base[:, 2], 0.0, atol=1e-9)
    # The door is not clamped, the columns' feet are.
    south = base[np.isclose(base[:, 1], 0.0)]
    assert not np.any((south[:, 0] > 5.001) & (south[:, 0] < 5.999))
    for foot in ((4.0, 2.5), (7.5, 4.1)):
        assert np.any(np.linalg.norm(base[:, :2] - foot, axis=1) < 1e-9)
    everything = np.flatnonzero(np.isclose(nodes[:, 2], 0.0))
    np.testing.assert_array_equal(small_mesh.base, everything)


@pytest.mark.parametrize(
    ("side", "axis", "value"), [("x-", 0, 0.0), ("x+", 0, 4.0), ("y-", 1, 0.0), ("y+", 1, 3.0)]
)
def test_impact_edge(side, axis, value, tmp_path):
    mesh = made(small_box(impact_edge=side), tmp_path)
    np.testing.assert_allclose(mesh.nodes[mesh.edges[1]][..., axis], value, atol=1e-9)
    assert mesh.elevations == pytest.approx({1: 4.0})


def test_the_same_geometry_gives_the_same_file(small_geometry, small_file, tmp_path):
    again = tmp_path / "again.msh"
    generate(small_geometry, again)
    assert again.read_bytes() == small_file.read_bytes()


def test_text_and_binary_files_hold_the_same_mesh(tmp_path):
    one = made(small_box(), tmp_path, binary=False)
    assert (tmp_path / "made.msh").read_text().startswith("$MeshFormat\n4.1 0 8")
    other = made(small_box(), tmp_path)
    # A text file has 16 digits, so the last bit of some is lost.
    np.testing.assert_allclose(one.nodes, other.nodes, rtol=1e-15, atol=1e-15)
    np.testing.assert_array_equal(one.triangles, other.triangles)


def test_target_size_by_part(tmp_path):
    geometry = small_box(
        size=MeshSize(floor=0.5, storey=1.0, beam=0.25, column=0.75),
        beams=(Beam("b", (1,), (1.0, 1.5), (3.0, 1.5), BeamSection.beam(0.2, 0.3)),),
        columns=(Column("c", (1,), (2.0, 0.75), BeamSection.column(0.2, 0.2)),),
    )
    mesh = made(geometry, tmp_path)
    assert len(mesh.lines_of("beam")) == 8
    assert len(mesh.lines_of("column")) in (4, 5)  # finer where it meets the slab
    area = areas(mesh.nodes, mesh.triangles)
    slab, wall = area[mesh.triangles_of("floor")].mean(), area[mesh.triangles_of("storey")].mean()
    assert slab < 0.6 * np.sqrt(3.0) / 4.0 * 0.5**2 * 2.0
    assert wall > 1.5 * slab


INNER = Wall("inner", (1,), (0.0, 1.2), (2.1, 1.2), 0.2)
RIM = Beam("b", (1,), (0.0, 0.0), (0.0, 3.0), BeamSection.beam(0.2, 0.3))
POST = BeamSection.column(0.2, 0.2)
POSTS = Column("inside", (1,), (0.0, 1.0), POST), Column("corner", (1,), (4.0, 3.0), POST)


def test_what_meets_shares_its_nodes(small_mesh, tmp_path):
    """`check_mesh` finds nodes on cells that are not theirs, and pieces that do not hang together.

    A beam on the edge of a wall, columns in it and at its end, a wall that ends on another.
    """
    check_mesh(small_mesh, "small.msh")
    made(small_box(beams=(RIM,), columns=POSTS), tmp_path)
    mesh = made(small_box(walls=(*small_box().walls, INNER)), tmp_path)
    names = [part.name for part in mesh.shell_parts]
    west, inside = (
        np.unique(mesh.triangles[mesh.triangle_part == names.index(name)])
        for name in ("west", "inner")
    )
    shared = mesh.nodes[np.intersect1d(west, inside)]
    assert np.ptp(shared, axis=0) == pytest.approx([0.0, 0.0, 3.0], abs=1e-9)


TWICE = Wall("twice", (1,), (0.0, 1.0), (0.0, 2.0), 0.3)
ONE = Beam("one", (1,), (0.0, 1.0), (4.0, 1.0), BeamSection.beam(0.2, 0.3))
TWO = Beam("two", (1,), (2.0, 1.0), (3.0, 1.0), BeamSection.beam(0.2, 0.3))


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (
            {"walls": (*small_box().walls, TWICE)},
            r"storey_1_twice: lies on storey_1_west at \(0\.000, 1",
        ),
        ({"beams": (ONE, TWO)}, "beam_1_two: lies on beam_1_one at"),
    ],
)
def test_parts_on_each_other_are_refused(change, expected, tmp_path):
    with pytest.raises(InputError, match=rf"case\.toml: {expected}"):
        generate(small_box(**change), tmp_path / "no.msh", source="case.toml")
    assert not list(tmp_path.iterdir())


def test_names_and_numbers_are_refused_together(tmp_path):
    walls = (
        Wall("West wall", (1,), (0.0, 0.0), (0.0, 3.0), 0.2),
        Wall("east", (1, 2), (4.0, 0.0), (4.0, 3.0), 0.2),
        Wall("east", (1,), (2.0, 0.0), (2.0, 3.0), 0.2),
    )
    with pytest.raises(InputError) as caught:
        generate(small_box(walls=walls, impact_edge="z+"), tmp_path / "no.msh", source="case.toml")
    assert [(fault.key, fault.value) for fault in caught.value.faults] == [
        ("impact_edge", "z+"),
        ("storey", "West wall"),
        ("storey_2_east", None),
        ("storey_1_east", None),
    ]


def test_a_folder_that_is_not_there_is_told(tmp_path):
    with pytest.raises(ImpactfemError, match=re.escape(str(tmp_path / "none"))):
        generate(small_box(), tmp_path / "none" / "made.msh")
