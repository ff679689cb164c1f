"""Cells of the whole model for a viewer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from impactfem.reduction.motion_grid import motion_grid

if TYPE_CHECKING:
    from .conftest import Frame


@pytest.mark.parametrize(("which", "corners", "ends"), [("vertices", 3, 2), ("all", 6, 3)])
def test_cells_are_those_of_the_mesh(frame: Frame, which: str, corners: int, ends: int) -> None:
    mesh = frame.parts.mesh
    grid = motion_grid(mesh, which)
    assert (grid.triangles.shape[1], grid.lines.shape[1]) == (corners, ends)
    assert np.array_equal(grid.nodes[grid.triangles], mesh.triangles[:, :corners])
    assert np.array_equal(grid.nodes[grid.lines], mesh.lines[:, :ends])
    assert np.array_equal(grid.points, mesh.nodes[grid.nodes])
    assert grid.cells == mesh.elements
    # Mid nodes are in the middle of what is drawn straight without them.
    assert (len(grid.nodes) == len(mesh.nodes)) == (which == "all")


def test_every_node_belongs_to_a_cell(frame: Frame) -> None:
    grid = motion_grid(frame.parts.mesh, "vertices")
    used = np.unique(np.concatenate([grid.triangles.ravel(), grid.lines.ravel()]))
    assert np.array_equal(used, np.arange(len(grid.nodes)))
