"""The generator: what was asked is there, in full, and shares its nodes."""

import re
from dataclasses import replace

import numpy as np
import pytest

from impactfem.building.generate import generate
from impactfem.building.geometry import Beam, Column, Geometry, MeshSize, Wall
from impactfem.building.mesh import areas, radius_ratio, sides
from impactfem.building.read_mesh import read_mesh
from impactfem.system.errors import ImpactfemError, InputError


def small_box(**changes) -> Geometry:
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
            "floor_2_acroterion": 26.0 * 0.6,
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


def test_beams_are_sides_of_slab_triangles(small_mesh):
    for k in (1, 2):
        slab = {tuple(s) for s in sides(small_mesh.triangles[small_mesh.triangles_of("floor", k)])}
        beams = small_mesh.lines[small_mesh.lines_of("beam", k)]
        beams[:, :2].sort(axis=1)
        assert {tuple(line) for line in beams} <= slab


def test_columns_and_walls_share_nodes_with_the_slabs(small_mesh):
    for k in (1, 2):
        slab = np.unique(small_mesh.triangles[small_mesh.triangles_of("floor", k)])
        above = small_mesh.lines[small_mesh.lines_of("column", k)][:, :2]
        tops = above[np.isclose(small_mesh.nodes[above][:, :, 2], small_mesh.elevations[k])]
        assert len(tops) == 2
        assert np.isin(tops, slab).all()
        walls = np.unique(small_mesh.triangles[small_mesh.triangles_of("storey", k)])
        top = walls[np.isclose(small_mesh.nodes[walls, 2], small_mesh.elevations[k])]
        assert len(top) > 20
        assert np.isin(top, slab).all()


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


def test_triangles_are_good(small_mesh):
    q = radius_ratio(small_mesh.nodes, small_mesh.triangles)
    assert q.mean() > 0.9
    assert q.min() > 0.3


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
        beams=(Beam("b", (1,), (1.0, 1.5), (3.0, 1.5), 0.2, 0.3),),
        columns=(Column("c", (1,), (2.0, 0.75), 0.2, 0.2),),
    )
    mesh = made(geometry, tmp_path)
    assert len(mesh.lines_of("beam")) == 8
    assert len(mesh.lines_of("column")) in (4, 5)  # finer where it meets the slab
    area = areas(mesh.nodes, mesh.triangles)
    slab, wall = area[mesh.triangles_of("floor")].mean(), area[mesh.triangles_of("storey")].mean()
    assert slab < 0.6 * np.sqrt(3.0) / 4.0 * 0.5**2 * 2.0
    assert wall > 1.5 * slab


def test_a_column_in_a_wall_and_a_beam_on_a_wall(tmp_path):
    geometry = small_box(
        beams=(Beam("b", (1,), (0.0, 0.0), (0.0, 3.0), 0.2, 0.3),),
        columns=(
            Column("inside", (1,), (0.0, 1.0), 0.2, 0.2),
            Column("corner", (1,), (4.0, 3.0), 0.2, 0.2),
        ),
    )
    mesh = made(geometry, tmp_path)
    walls = {tuple(side) for side in sides(mesh.triangles[mesh.triangles_of("storey")])}
    lines = mesh.lines.copy()
    lines[:, :2].sort(axis=1)
    assert {tuple(line) for line in lines} <= walls


def test_a_wall_that_ends_on_another(tmp_path):
    inner = Wall("inner", (1,), (0.0, 1.2), (2.1, 1.2), 0.2)
    mesh = made(small_box(walls=(*small_box().walls, inner)), tmp_path)
    west, inside = (
        np.unique(mesh.triangles[mesh.triangle_part == i]) for i in (mesh_index(mesh, "west"),
                                                                     mesh_index(mesh, "inner"))
    )  # fmt: skip
    shared = mesh.nodes[np.intersect1d(west, inside)]
    np.testing.assert_allclose(shared[:, :2], np.broadcast_to([0.0, 1.2], (len(shared), 2)))
    assert np.ptp(shared[:, 2]) == pytest.approx(3.0)


def mesh_index(mesh, name):
    return [part.name for part in mesh.shell_parts].index(name)


def test_walls_on_each_other_are_refused(tmp_path):
    walls = (*small_box().walls, Wall("twice", (1,), (0.0, 1.0), (0.0, 2.0), 0.3))
    with pytest.raises(InputError, match=r"storey_1_twice: lies on storey_1_west at \(0\.000, 1"):
        generate(small_box(walls=walls), tmp_path / "no.msh", source="case.toml")
    assert not list(tmp_path.iterdir())


def test_beams_on_each_other_are_refused(tmp_path):
    beams = (
        Beam("one", (1,), (0.0, 1.0), (4.0, 1.0), 0.2, 0.3),
        Beam("two", (1,), (2.0, 1.0), (3.0, 1.0), 0.2, 0.3),
    )
    with pytest.raises(InputError, match=r"case\.toml: beam_1_two: lies on beam_1_one at"):
        generate(small_box(beams=beams), tmp_path / "no.msh", source="case.toml")


def test_names_and_numbers_are_refused_together(tmp_path):
    walls = (
        Wall("West wall", (1,), (0.0, 0.0), (0.0, 3.0), 0.2),
        Wall("east", (1, 2), (4.0, 0.0), (4.0, 3.0), 0.2),
        Wall("east", (1,), (2.0, 0.0), (2.0, 3.0), 0.2),
    )
    with pytest.raises(InputError) as caught:
        generate(small_box(walls=walls, impact_edge="z+"), tmp_path / "no.msh", source="case.toml")
    assert [str(fault) for fault in caught.value.faults] == [
        "case.toml: impact_edge = 'z+': expected one of x-, x+, y-, y+",
        "case.toml: storey = 'West wall': the name of a storey has a-z, 0-9 and single _ only",
        "case.toml: storey_2_east: expected a storey at 1 to 1",
        "case.toml: storey_1_east: duplicate name",
    ]


def test_a_folder_that_is_not_there_is_told(tmp_path):
    with pytest.raises(ImpactfemError, match=re.escape(str(tmp_path / "none"))):
        generate(small_box(), tmp_path / "none" / "made.msh")
