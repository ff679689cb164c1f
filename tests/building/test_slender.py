"""The estimated error of slender triangles against computed plates."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.building.generate import generate
from impactfem.building.geometry import Geometry, MeshSize, Wall
from impactfem.building.mesh import rim
from impactfem.building.mesh_report import TOO_STIFF, MeshReport
from impactfem.building.read_mesh import read_mesh
from impactfem.building.shell_model import RX, RY, RZ, UX, UY, UZ, Shells, shell_model
from impactfem.building.slender import SlenderTriangles
from impactfem.verify.shells import ROTATION, STEEL, flat, panel

SIDE = 10.0
FINE = 32


def plate(across, along, thickness, angle=90.0, turn=None, distortion=0.0):
    """A rhombic plate of 10 m with cells of two triangles, and whether a node is on its rim."""
    turned = SIDE * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0.0])
    nodes, triangles = panel(across, along, flat((SIDE, 0.0, 0.0), tuple(turned)), distortion)
    return on_rim(nodes if turn is None else nodes @ turn.T, triangles, thickness)


def on_rim(nodes, triangles, thickness):
    model = shell_model(nodes, Shells(triangles, thickness, STEEL))
    border = np.zeros(len(model.nodes), dtype=bool)
    border[np.unique(rim(model.triangles)[0])] = True
    return model, border


def compliance(model, held):
    """Work of a unit pressure on a plate in the plane z = 0."""
    everywhere = np.ones(len(model.nodes), dtype=bool)
    held = held.hold(everywhere, UX, UY, RZ)
    load = held.area_load((0.0, 0.0, 1.0))
    return float((held.static(load) * load).sum())


def clamped(model, border):
    return compliance(model, model.hold(border, UZ, RX, RY))


def supported(model, border):
    return compliance(model, model.hold(border, UZ))


def cantilever(model, border):
    root = border & (model.nodes[:, 0] < 1e-9)
    return compliance(model, model.hold(root, UZ, RX, RY))


def l_shape(across, along, thickness):
    nodes, triangles = panel(across, along, flat((SIDE, 0.0, 0.0), (0.0, SIDE, 0.0)))
    centre = nodes[triangles].mean(axis=1)
    kept, triangles = np.unique(
        triangles[(centre[:, :2] < SIDE / 2).any(axis=1)], return_inverse=True
    )
    return on_rim(nodes[kept], triangles.reshape(-1, 3), thickness)


def estimated(model, thickness):
    mesh = model.parts.mesh
    found = SlenderTriangles.of(mesh, np.full(len(mesh.triangles), thickness))
    return float(found.error.max(initial=0.0))


@pytest.mark.parametrize("thickness", [0.1, 0.01])
@pytest.mark.parametrize("rows", [2, 4, 8])
@pytest.mark.parametrize("aspect", [8, 16])
def test_clamped_plates_of_slender_cells(aspect, rows, thickness):
    """The error is at most 3 %, or the estimate is above it and no more than four times as large.

    Half of the estimate would be too small for the coarse ones.
    """
    model, border = plate(aspect * rows, rows, thickness)
    error = 1.0 - clamped(model, border) / clamped(*plate(FINE, FINE, thickness))
    figure = estimated(model, thickness)
    assert error < max(figure, TOO_STIFF)
    if rows == 2:
        assert error > max(0.5 * figure, 0.4)


@pytest.mark.parametrize(
    ("support", "angle", "across", "along"),
    [
        (clamped, 60.0, 4, 32),
        (clamped, 45.0, 32, 4),
        (clamped, 30.0, 16, 2),
        (supported, 90.0, 32, 2),
        (supported, 45.0, 32, 4),
        (cantilever, 90.0, 2, 32),
        (cantilever, 60.0, 32, 2),
    ],
)
def test_other_supports_and_skewed_plates(support, angle, across, along):
    thickness = 0.1
    model, border = plate(across, along, thickness, angle)
    error = 1.0 - support(model, border) / support(*plate(FINE, FINE, thickness, angle))
    assert error < max(estimated(model, thickness), TOO_STIFF)


@pytest.mark.parametrize(("across", "along"), [(32, 4), (64, 4), (64, 8)])
def test_a_re_entrant_corner(across, along):
    """Without the term of the corner the estimate of 64 x 8 cells would be too small."""
    thickness = 0.01
    model, border = l_shape(across, along, thickness)
    error = 1.0 - supported(model, border) / supported(*l_shape(FINE, FINE, thickness))
    assert TOO_STIFF < error < estimated(model, thickness)


def test_columns_shorten_the_span():
    """16 bays of 5 m over point supports: cells of 2.5 m are half a bay."""
    thickness, size = 0.1, 4 * 5.0
    works = []
    for cells in ((32, 8), (FINE, FINE)):
        nodes, triangles = panel(*cells, flat((size, 0.0, 0.0), (0.0, size, 0.0)))
        model, border = on_rim(nodes, triangles, thickness)
        grid = (np.abs(model.nodes / 5.0 - np.round(model.nodes / 5.0)) < 1e-9).all(axis=1)
        works.append(compliance(model, model.hold(grid, UZ).hold(border, UZ, RX, RY)))
        if cells != (FINE, FINE):
            mesh = model.parts.mesh
            thick = np.full(len(mesh.triangles), thickness)
            without = SlenderTriangles.of(mesh, thick)
            columns = replace(mesh, base=np.flatnonzero(grid))
            figure = SlenderTriangles.of(columns, thick).error.max()
    error = 1.0 - works[0] / works[1]
    assert without.error.max() < TOO_STIFF < error < figure


@pytest.mark.parametrize("cells", [(8, 8), (16, 16), (5, 4)])
def test_well_shaped_triangles_have_no_estimate(cells):
    assert estimated(plate(*cells, 1e-4)[0], 1e-4) == 0.0


def test_thick_plates_have_no_estimate():
    thickness = 2.0
    model, border = plate(32, 2, thickness)
    assert clamped(model, border) / clamped(*plate(FINE, FINE, thickness)) > 0.95
    assert estimated(model, thickness) == 0.0


def test_the_estimate_does_not_depend_on_place_and_numbering():
    thickness = 0.1
    model, _ = plate(32, 4, thickness, distortion=0.2)
    turned, _ = plate(32, 4, thickness, turn=ROTATION, distortion=0.2)
    assert estimated(turned, thickness) == pytest.approx(estimated(model, thickness), rel=1e-9)
    mesh = model.parts.mesh
    order = [1, 2, 0, 4, 5, 3]
    other = replace(mesh, triangles=mesh.triangles[::-1, order])
    found = SlenderTriangles.of(other, np.full(len(mesh.triangles), thickness))
    assert found.error.max() == pytest.approx(estimated(model, thickness), rel=1e-9)


def test_strips_have_a_long_span():
    """A strip of 8 m by 0.6 m, as a parapet, bends along itself near its ends alone."""
    nodes, triangles = panel(8, 2, flat((8.0, 0.0, 0.0), (0.0, 0.6, 0.0)))
    model, border = on_rim(nodes, triangles, 0.2)
    fine = on_rim(*panel(64, 6, flat((8.0, 0.0, 0.0), (0.0, 0.6, 0.0))), 0.2)
    assert 1.0 - clamped(model, border) / clamped(*fine) < TOO_STIFF
    assert estimated(model, 0.2) < TOO_STIFF


def test_the_warning_names_the_part_the_error_and_a_size_that_helps():
    thickness = 0.1
    model, _ = plate(16, 2, thickness)
    parts = model.parts
    (warning,) = MeshReport.of(parts.mesh, parts.sections).warnings
    group = parts.mesh.shell_parts[0].group
    percent = int(np.ceil(100.0 * estimated(model, thickness)))
    assert warning.startswith(f"{group}: 64 triangles")
    assert f"up to {percent} %" in warning
    size = float(warning.split('floor_size = "')[1].split(" m")[0])
    rows = int(np.ceil(np.hypot(SIDE, SIDE / 16) / size))
    finer, finer_border = plate(16, rows, thickness)
    assert not MeshReport.of(finer.parts.mesh, finer.parts.sections).warnings
    assert 1.0 - clamped(finer, finer_border) / clamped(*plate(FINE, FINE, thickness)) < TOO_STIFF


@pytest.mark.parametrize(("size", "seen"), [(2.5, True), (0.25, False)])
def test_generated_meshes_are_warned_of(size, seen, tmp_path):
    """Two walls 0.3 m apart make a strip of the slab that is narrower than its cells."""
    length, width = 4.0, 2.5
    geometry = Geometry(
        length=length,
        width=width,
        levels=(0.0, 3.0),
        slab_thickness=0.02,
        walls=(
            Wall("south", (1,), (0.0, 0.0), (length, 0.0), 0.3),
            Wall("inner", (1,), (0.0, 0.3), (length, 0.3), 0.3),
            Wall("north", (1,), (0.0, width), (length, width), 0.3),
        ),
        bays=(),
        beams=(),
        columns=(),
        parapet=None,
        size=MeshSize.uniform(size),
    )
    path = tmp_path / "strip.msh"
    generate(geometry, path)
    mesh = read_mesh(path)
    sections = geometry.sections(mesh.shell_parts, mesh.beam_parts)
    warnings = MeshReport.of(mesh, sections).warnings
    assert any("slender" in text and text.startswith("floor_1: ") for text in warnings) == seen
