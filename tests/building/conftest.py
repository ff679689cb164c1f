"""A small building and its mesh, the shipped mesh of a user, and meshes made panel by panel."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpi4py import MPI

from impactfem.building import shell_model
from impactfem.building.generate import generate
from impactfem.building.geometry import Bay, Beam, Column, Geometry, MeshSize, Parapet, Wall
from impactfem.building.mesh import BuildingMesh, Part
from impactfem.building.model import assemble_building
from impactfem.building.parts import BuildingParts, floor_masses
from impactfem.building.read_mesh import assemble, read_mesh, read_raw
from impactfem.building.section import BeamSection, Material, Materials, Sections, ShellSection
from impactfem.system.arrays import Array
from impactfem.system.executor import in_own_process
from impactfem.verify.shells import ROTATION

FRAME = Path(__file__).parents[2] / "geometry" / "frame.msh"


@pytest.fixture(scope="session")
def small_geometry():
    """8 m by 5 m, two storeys: beams that cross, end inside a slab, and lie on a wall's edge; a
    column under the mass centre and one alone; a window, and a door of two rectangles."""
    return Geometry(
        length=8.0,
        width=5.0,
        levels=(0.0, 3.0, 5.8),
        slab_thickness=0.25,
        walls=(
            Wall("south", (1, 2), (0.0, 0.0), (8.0, 0.0), 0.3),
            Wall("north", (1, 2), (0.0, 5.0), (8.0, 5.0), 0.3),
            Wall("inner", (1,), (8.0, 1.0), (6.0, 3.0), 0.2),
        ),
        bays=(
            Bay("window", "south", 1, 1.75, 0.9, 1.5, 1.2),
            Bay("door", "south", 1, 5.5, 0.0, 1.0, 2.1),
            Bay("door", "south", 1, 5.5, 2.1, 2.0, 0.4),
            Bay("hatch", "north", 2, 0.5, 2.3, 1.0, 0.5),
        ),
        beams=(
            Beam("long", (1, 2), (0.0, 2.5), (8.0, 2.5), BeamSection.beam(0.3, 0.5, -0.375)),
            Beam("cross", (1, 2), (3.0, 0.0), (3.0, 5.0), BeamSection.beam(0.3, 0.5)),
            Beam("oblique", (1,), (5.2, 1.1), (6.7, 3.9), BeamSection.beam(0.3, 0.5)),
            Beam("rim", (1,), (0.0, 0.0), (8.0, 0.0), BeamSection.beam(0.2, 0.3)),
            Beam("face", (2,), (0.0, 5.0), (8.0, 5.0), BeamSection.beam(0.2, 0.3)),
        ),
        columns=(
            Column("middle", (1, 2), (4.0, 2.5), BeamSection.column(0.4, 0.6)),
            Column("alone", (1, 2), (7.5, 4.1), BeamSection.column(0.4, 0.4)),
        ),
        parapet=Parapet(0.6, 0.2),
        size=MeshSize.uniform(1.0),
    )


@pytest.fixture(scope="session")
def small_file(small_geometry, tmp_path_factory):
    path = tmp_path_factory.mktemp("small") / "small.msh"
    generate(small_geometry, path)
    return path


@pytest.fixture(scope="session")
def small_raw(small_file):
    return in_own_process(read_raw, small_file)


@pytest.fixture(scope="session")
def small_mesh(small_raw, small_file):
    return assemble(small_raw, small_file)


@pytest.fixture(scope="session")
def generated(tmp_path_factory):
    """Mesh a geometry, all of one material, with required masses of its floors."""

    def make(geometry, material, required):
        path = tmp_path_factory.mktemp("generated") / "building.msh"
        generate(geometry, path)
        mesh = read_mesh(path)
        sections = geometry.sections(mesh.shell_parts, mesh.beam_parts)
        materials = Materials(
            (material,) * len(mesh.shell_parts), (material,) * len(mesh.beam_parts)
        )
        masses = floor_masses(mesh, sections, materials, required)
        return BuildingParts(mesh, sections, materials, masses.on_triangles), masses

    return make


@pytest.fixture(scope="session")
def frame_file():
    """The mesh that is shipped as a user's own: slabs of 6 m × 4 m at 3 m and 6 m."""
    return FRAME


@pytest.fixture(scope="session")
def frame():
    return read_mesh(FRAME)


@dataclass
class Panels:
    """Panels and lines with shared nodes; points that coincide are one node."""

    points: list[Array] = field(default_factory=list)
    numbers: dict[tuple[float, ...], int] = field(default_factory=dict)
    triangles: list[list[int]] = field(default_factory=list)
    triangle_parts: list[Part] = field(default_factory=list)
    lines: list[list[int]] = field(default_factory=list)
    line_parts: list[Part] = field(default_factory=list)
    sections: dict[Part, Any] = field(default_factory=dict)
    materials: dict[Part, Material] = field(default_factory=dict)
    alternate: bool = True  #: whether the diagonals of neighbouring squares cross

    def node(self, point):
        key = tuple(float(x) + 0.0 for x in np.round(point, 9))
        if key not in self.numbers:
            self.numbers[key] = len(self.points)
            self.points.append(point)
        return self.numbers[key]

    def cell(self, part, *points):
        """A triangle of three points, or a beam element of two."""
        corners = [np.array(point, dtype=float) for point in points]
        ends = ((0, 1), (1, 2), (2, 0))[: 2 * len(corners) - 3]
        nodes = [
            self.node(x) for x in (*corners, *((corners[a] + corners[b]) / 2 for a, b in ends))
        ]
        surface = len(corners) == 3
        (self.triangles if surface else self.lines).append(nodes)
        (self.triangle_parts if surface else self.line_parts).append(part)
        section = ShellSection(0.2) if surface else BeamSection.beam(0.2, 0.2)
        self.sections.setdefault(part, section)

    def panel(self, corner, a, b, n, part, thickness=0.2):
        """A parallelogram from a corner along the vectors a and b, in n[0] by n[1] pairs."""
        self.sections[part] = ShellSection(thickness)
        origin, along_a, along_b = (np.array(v, dtype=float) for v in (corner, a, b))
        for i in range(n[0]):
            for j in range(n[1]):
                square = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                p, q, r, s = (origin + along_a * k / n[0] + along_b * m / n[1] for k, m in square)
                same = (i + j) % 2 or not self.alternate
                for corners in ((p, q, r), (p, r, s)) if same else ((p, q, s), (q, r, s)):
                    self.cell(part, *corners)

    def line(self, start, end, n, part, section):
        """A line of n beam elements."""
        self.sections[part] = section
        first, last = np.array(start, dtype=float), np.array(end, dtype=float)
        for i in range(n):
            self.cell(part, *(first + (last - first) * k / n for k in (i, i + 1)))

    def at(self, *conditions):
        """Nodes where each (axis, coordinate) holds."""
        found = [all(abs(x[k] - value) < 1e-9 for k, value in conditions) for x in self.points]
        return np.flatnonzero(found)

    def sides_at(self, *conditions):
        """Sides of triangles, as lines (ends, middle), where each (axis, coordinate) holds."""
        there = set(self.at(*conditions))
        found = {
            (*sorted((t[i], t[j])), t[m])
            for t in self.triangles
            for i, j, m in ((0, 1, 3), (1, 2, 4), (2, 0, 5))
            if {t[i], t[j]} <= there
        }
        return np.array(sorted(found), dtype=np.int64)

    def parts(self, *, base=(), centres=None, edges=None, turn=None, added=None, drilling=1.0):
        """The building, of concrete and turned in space by a matrix of rotation."""
        shell_parts = tuple(sorted(set(self.triangle_parts)))
        beam_parts = tuple(sorted(set(self.line_parts)))
        mesh = BuildingMesh(
            nodes=np.array(self.points) @ (np.eye(3) if turn is None else turn.T),
            triangles=np.array(self.triangles, dtype=np.int64).reshape(-1, 6),
            triangle_part=np.array([shell_parts.index(p) for p in self.triangle_parts], np.int32),
            lines=np.array(self.lines, dtype=np.int64).reshape(-1, 3),
            line_part=np.array([beam_parts.index(p) for p in self.line_parts], np.int32),
            shell_parts=shell_parts,
            beam_parts=beam_parts,
            edges=edges or {},
            centres=centres or {},
            base=np.array(sorted(base), dtype=np.int64),
        )
        sections = Sections(
            tuple(self.sections[p] for p in shell_parts),
            tuple(self.sections[p] for p in beam_parts),
        )
        if added is None:
            added = np.zeros(len(mesh.triangles))
        concrete = Material(33e9, 0.2, 2500.0)
        materials = Materials(
            tuple(self.materials.get(p, concrete) for p in shell_parts),
            tuple(self.materials.get(p, concrete) for p in beam_parts),
        )
        return BuildingParts(mesh, sections, materials, added, drilling)


@pytest.fixture(scope="session")
def new_panels():
    return Panels


@pytest.fixture
def panels():
    return Panels()


@pytest.fixture(scope="session")
def house():
    """Two slabs of 4 m by 3 m at 3 m and 6.5 m, on two walls and a column.

    The wall at x = 2 m meets the slabs inside: three shells at an edge on floor 2, four on
    floor 1. A beam hangs below floor 1 at y = 3 m; floor 2 has a parapet at y = 0.
    """
    p = Panels()
    levels = (0.0, 3.0, 6.5)
    for k in (1, 2):
        foot, z = levels[k - 1], levels[k]
        up = (0.0, 0.0, z - foot)
        p.panel((0, 0, z), (4, 0, 0), (0, 3, 0), (4, 3), Part("floor", k), 0.3)
        p.panel((0, 0, foot), (4, 0, 0), up, (4, 2), Part("storey", k, "south"), 0.5)
        p.panel((2, 0, foot), (0, 2, 0), up, (2, 2), Part("storey", k, "inner"), 0.4)
        p.line((4, 3, foot), (4, 3, z), 2, Part("column", k), BeamSection.column(0.4, 0.6))
    p.panel((0, 0, 6.5), (4, 0, 0), (0, 0, 0.6), (4, 1), Part("floor", 2, "parapet"), 0.2)
    p.line((0, 3, 3), (4, 3, 3), 4, Part("beam", 1), BeamSection.beam(0.3, 0.5, -0.4))
    centres = {k: int(p.at((0, 2.0), (1, 1.0), (2, levels[k]))[0]) for k in (1, 2)}
    edges = {k: p.sides_at((1, 3.0), (2, levels[k])) for k in (1, 2)}
    return p.parts(base=p.at((2, 0.0)), centres=centres, edges=edges)


@pytest.fixture(scope="session")
def assembled():
    """Assemble a building on this process alone."""
    return lambda parts: assemble_building(MPI.COMM_SELF, parts)


@pytest.fixture(scope="session")
def csr():
    """A matrix of PETSc on one rank as one of SciPy."""
    return shell_model.csr


@pytest.fixture(scope="session")
def turn():
    """A rotation that leaves no axis where it was."""
    return ROTATION
