"""Warnings and faults of a mesh: the shipped frame with a mistake in it."""

import re
from dataclasses import replace

import numpy as np
import pytest

from impactfem.building.mesh import Part
from impactfem.building.mesh_checks import check_mesh
from impactfem.building.mesh_report import MeshReport
from impactfem.building.mesh_warnings import mesh_warnings
from impactfem.building.section import BeamSection, Sections, ShellSection
from impactfem.system.errors import InputError


def named(old, family, level):
    """A part in another group, named b; parts stay in the order that they had."""

    def of(parts):
        return tuple(Part(family, level, "b") if part.group == old else part for part in parts)

    return lambda mesh: replace(
        mesh, shell_parts=of(mesh.shell_parts), beam_parts=of(mesh.beam_parts)
    )


def lifted(by):
    """The wall of storey 2 ends above the slab that it stood on."""

    def change(mesh):
        walls = mesh.triangles_of("storey", 2)
        own = np.unique(mesh.triangles[walls])
        low = own[np.abs(mesh.nodes[own, 2] - 3.0) < 1e-9]
        number = np.arange(len(mesh.nodes))
        number[low] = len(mesh.nodes) + np.arange(len(low))
        triangles = mesh.triangles.copy()
        triangles[walls] = number[triangles[walls]]
        nodes = np.vstack([mesh.nodes, mesh.nodes[low] + [0.0, 0.0, by]])
        return replace(mesh, nodes=nodes, triangles=triangles)

    return change


def without(where):
    """Some nodes are not clamped."""
    return lambda mesh: replace(mesh, base=mesh.base[~where(mesh.nodes[mesh.base])])


ELSEWHERE = "48 cells are in another storey than the number of their group says"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda mesh: mesh, []),
        (named("storey_2_west", "storey", 1), [f"storey_1_b: {ELSEWHERE}"]),
        (named("storey_1_west", "storey", 2), [f"storey_2_b: {ELSEWHERE}"]),
        (named("beam_1_south", "beam", 2), ["beam_2_b: 8 cells are nearer to another floor than"]),
        (named("storey_2_west", "floor", 2), ["floor_2_b: 31 cells are nearer to another floor"]),
        (
            named("beam_2_south", "column", 2),
            ["column_2_b: 8 cells are horizontal at a floor, in a group of walls or columns"],
        ),
        (named("column_1_south_east", "column", 2), ["column_2_b: 3 cells are in another storey"]),
        (
            without(lambda at: np.linalg.norm(at - [6, 0, 0], axis=1) < 0.1),
            ["column_1_south_east: its lower end at (6.000, 0.000, 0.000) m stands on nothing"],
        ),
        (
            without(lambda at: (at[:, 0] < 0.1) & (at[:, 1] < 1.9)),
            ["storey_1_west: its lower rim at (0.000, 0.333, 0.000) m is joined to nothing"],
        ),
        (lifted(0.005), ["storey_2_west: its lower rim at (0.000, 3.667, 3.00"]),
        (lifted(0.1), ["storey_2_west: its lower rim at (0.000, 3.667, 3.10"]),
        (lifted(0.4), []),  # as a wall over a band of windows
        (lifted(-0.2), []),  # which hangs down beside the slab
        (
            lambda mesh: replace(mesh, base=np.append(mesh.base, mesh.centres[1])),
            ["base: 1 clamped nodes at floor 1 or above it, the first at"],
        ),
    ],
)
def test_a_mistake(frame, change, words):
    found = list(mesh_warnings(change(frame)))
    assert len(found) == len(words), found
    assert all(one.startswith(start) for one, start in zip(found, words, strict=True)), found


def test_the_report_has_them(frame):
    mesh = named("storey_2_west", "storey", 1)(frame)
    sections = Sections(
        (ShellSection(0.2),) * len(mesh.shell_parts),
        (BeamSection.beam(0.3, 0.5, 0.0),) * len(mesh.beam_parts),
    )
    assert "storey_1_b" in MeshReport.of(mesh, sections).warnings[0]
    assert not MeshReport.of(frame, sections).warnings


def edge(mesh, lines):
    return replace(mesh, edges={**mesh.edges, 1: lines})


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda lines, _: np.vstack([lines, lines[:, [1, 0, 2]]]), "8 lines more than once"),
        (lambda lines, x: lines[(x < 2.0) | (x > 4.0)], "a gap of 1.5 m, at"),
        (lambda lines, x: lines[x < 3.0], ""),  # a part of the side
        (lambda lines, x: lines[x < 0.7], ""),
    ],
)
def test_an_edge_in_one_piece(frame, change, words):
    """The load of 1 N on it would have another resultant."""
    lines = frame.edges[1]
    mesh = edge(frame, change(lines, frame.nodes[lines[:, 2], 0]))
    if not words:
        check_mesh(mesh, "own.msh")
        (text,) = mesh_warnings(mesh)
        assert re.match(r"edge_1: [\d.]+ m of a side of floor_1 that goes on at \(", text)
        return
    with pytest.raises(InputError, match=rf"edge_1: {words}.*floor_1"):
        check_mesh(mesh, "own.msh")


@pytest.mark.parametrize(
    ("inside", "words"),
    [(False, r"lines that are 4 m off one straight line of 6 m"), (True, r"\d+ lines inside the")],
)
def test_an_edge_that_is_no_side(frame, inside, words):
    """The whole rim of the slab, and all sides of its triangles."""
    own = frame.triangles[frame.slab(1)]
    every = np.vstack([own[:, columns] for columns in ([0, 1, 3], [1, 2, 4], [2, 0, 5])])
    _, first, count = np.unique(every[:, 2], return_index=True, return_counts=True)
    lines = every[first if inside else first[count == 1]]
    with pytest.raises(InputError, match=f"edge_1: {words}"):
        check_mesh(edge(frame, lines), "own.msh")
