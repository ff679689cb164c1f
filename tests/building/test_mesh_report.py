"""The report of a mesh against what can be counted and measured by hand."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.building.mesh import side_lengths
from impactfem.building.mesh_report import MeshReport, free_edges
from impactfem.building.section import Material, Sections, ShellSection
from impactfem.building.shell_model import Shells, shell_model
from impactfem.verify.shells import panel


@pytest.fixture(scope="module")
def small_sections(small_geometry, small_mesh):
    return small_geometry.sections(small_mesh.shell_parts, small_mesh.beam_parts)


@pytest.fixture(scope="module")
def report(small_mesh, small_sections):
    return MeshReport.of(small_mesh, small_sections)


def test_counts(report, small_mesh):
    assert report.shells == len(small_mesh.triangles)
    assert report.beams == len(small_mesh.lines)
    assert report.elements == sum(level.elements for level in report.levels)
    assert 6 * report.nodes - report.free_dofs == 6 * len(small_mesh.base)
    families = ("floor", "storey", "beam", "column")
    assert [level.group for level in report.levels] == [
        f"{f}_{k}" for f in families for k in (1, 2)
    ]
    column = report.levels[-2]  # two of 3 m
    assert column.elements == len(small_mesh.lines_of("column", 1))
    assert column.nodes == 2 * column.elements + 2
    assert column.size == pytest.approx(2 * 3.0 / column.elements)
    assert column.quality_min is None


def test_nodes_obey_euler(report, small_mesh):
    """A slab without holes: vertices - sides + triangles = 1, and a middle node on each side."""
    slab = report.levels[0]
    corners = len(np.unique(small_mesh.triangles[small_mesh.triangles_of("floor", 1), :3]))
    assert corners - (slab.nodes - corners) + slab.elements == 1


def test_free_edges(report):
    """Rims, by hand: base and joints do not count."""
    ends = 4.0 * 3.0 + 2.0 * 3.0  # of the facades and of the inner wall
    window = 2.0 * (1.5 + 1.2)
    door = 2.0 * 2.1 + (2.0 - 1.0) + 2.0 * 0.4 + 2.0  # jambs, shoulders, jambs above, lintel
    hatch = 1.0 + 0.5 - 0.5  # in a corner under the slab: sill and a jamb, less the wall's end
    assert report.free_edges == pytest.approx(
        {
            "floor_1": 2.0 * 5.0,  # west and east stand on no wall
            "floor_2": 26.0,  # the top of the parapet
            "storey_1": ends + window + door,
            "storey_2": 4.0 * 2.8 + hatch,
        },
        rel=1e-12,
    )


def test_a_torn_joint_shows_as_a_free_edge(small_mesh):
    """The slab's nodes are not the walls' any more: the joints are free on both sides."""
    slab = small_mesh.triangles_of("floor", 1)
    triangles = small_mesh.triangles.copy()
    own, inverse = np.unique(triangles[slab], return_inverse=True)
    triangles[slab] = len(small_mesh.nodes) + inverse.reshape(len(slab), 6)
    nodes = np.vstack([small_mesh.nodes, small_mesh.nodes[own]])
    torn = free_edges(replace(small_mesh, nodes=nodes, triangles=triangles))
    assert torn["floor_1"] == pytest.approx(2.0 * (8.0 + 5.0))
    assert torn["storey_1"] == pytest.approx(free_edges(small_mesh)["storey_1"] + np.sqrt(8.0))


def test_size_over_thickness(small_mesh, small_sections):
    thin = Sections(
        tuple(replace(s, thickness=1e-3 * s.thickness) for s in small_sections.shells),
        small_sections.beams,
    )
    before, after = MeshReport.of(small_mesh, small_sections), MeshReport.of(small_mesh, thin)
    even = Sections(tuple(ShellSection(0.5) for _ in small_sections.shells), ())
    longest = side_lengths(small_mesh.nodes, small_mesh.triangles).max()
    assert MeshReport.of(small_mesh, even).size_over_thickness == pytest.approx(longest / 0.5)
    assert after.size_over_thickness == pytest.approx(1e3 * before.size_over_thickness)
    assert before.size_over_thickness < 8.0
    assert not before.warnings
    (warning,) = (text for text in after.warnings if "slender" not in text)
    assert "larger than 600 thicknesses," in warning
    assert "shells are verified" in warning


@pytest.mark.parametrize(("thickness", "seen"), [(0.05, True), (0.4, False)])
def test_facets_too_large_for_a_curved_surface_are_warned_of(thickness, seen):
    """A cylinder of R = 10 m in strips of 1.31 m by 1 m: h² / R = 0.27 m, and some more with the
    distance between the centres of triangles."""
    nodes, triangles = panel(
        12,
        5,
        lambda a, b: (10.0 * np.cos(0.5 * np.pi * a), 10.0 * np.sin(0.5 * np.pi * a), 5.0 * b),
    )
    parts = shell_model(nodes, Shells(triangles, thickness, Material(33e9, 0.2, 2500.0))).parts
    text = "\n".join(MeshReport.of(parts.mesh, parts.sections).warnings)
    assert ("facets too large" in text) == seen


def test_corners_and_planes_are_not_curved(small_mesh):
    thin = Sections(tuple(ShellSection(0.01) for _ in small_mesh.shell_parts), ())
    assert "curved" not in "\n".join(MeshReport.of(small_mesh, thin).warnings)


def test_dropped_nodes_and_poor_triangles_are_warned_of(small_mesh, small_sections):
    nodes = small_mesh.nodes.copy()
    a, b = small_mesh.triangles[small_mesh.triangles_of("floor", 1)[0], :2]
    nodes[a] = 0.02 * nodes[a] + 0.98 * nodes[b]
    poor = replace(small_mesh, nodes=nodes, dropped=np.array([[1.0, 2.0, 3.0]]))
    report = MeshReport.of(poor, small_sections)
    assert (report.dropped, report.duplicates) == (1, 0)
    nodes[0] = nodes[1]
    assert MeshReport.of(replace(poor, nodes=nodes), small_sections).duplicates == 1
    assert report.quality_min < 0.2
    text = "\n".join(report.warnings)
    assert "radius ratio below 0.2," in text
    assert "1 nodes of the file" in text
    assert "the first at (1.000, 2.000, 3.000) m" in text


def test_text(report):
    text = str(report)
    first = report.levels[0]
    assert text.splitlines()[1].split()[:3] == ["floor_1", str(first.elements), str(first.nodes)]
    dofs = f"{6 * report.nodes} degrees of freedom, {report.free_dofs} of them free"
    assert dofs in text
    assert "duplicate nodes: 0; nodes" in text
