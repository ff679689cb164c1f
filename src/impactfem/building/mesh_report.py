"""What there is to know of a mesh before it is used: counts, quality, free edges, warnings."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from impactfem.building.mesh import (
    DOFS,
    FOLD,
    SHELLS,
    BuildingMesh,
    areas,
    line_lengths,
    normals,
    place,
    radius_ratio,
    rim,
    shared_sides,
    side_lengths,
)
from impactfem.building.mesh_checks import NEAR, by_group, shell_groups
from impactfem.building.mesh_warnings import mesh_warnings
from impactfem.building.section import Sections
from impactfem.building.slender import SlenderTriangles
from impactfem.system.arrays import Array

SIZE_OVER_THICKNESS = 600.0
"""Plates are verified up to it (`impactfem verify --only clamped_plate`)."""
CURVED = 2.0
"""Largest h² / (R t) of thin shells on curved surfaces, made of flat facets of the size h: at it
they are too stiff by 1 % where they bend without stretching, at 9 by 12 % (hemisphere, hyperbolic
paraboloid and twisted strip; `impactfem verify --only hyperbolic_paraboloid`)."""
POOR = 0.2
"""Radius ratio below which a triangle is worth a look."""
TOO_STIFF = 0.03
"""Allowed error of the bending stiffness due to slender triangles."""


@dataclass(frozen=True)
class LevelReport:
    """All parts of a family at a level."""

    group: str  #: What the names of their groups begin with (``beam_3``).
    elements: int  #: Number of triangles or lines.
    nodes: int  #: Number of their nodes, shared ones included.
    size: float  #: Mean length of the elements' sides [m].
    quality_min: float | None = None  #: Least radius ratio of the triangles; None for lines.
    quality_mean: float | None = None  #: Their mean.
    #: Largest side of the triangles over the thickness; None for lines.
    size_over_thickness: float | None = None

    def __str__(self) -> str:
        line = f"{self.group:<9}  {self.elements:>8}  {self.nodes:>8}  {self.size:8.3f}"
        if self.quality_min is None:
            return line
        quality = f"{self.quality_min:5.3f}  {self.quality_mean:6.3f}"
        return f"{line}  {quality}  {self.size_over_thickness:14.2f}"


@dataclass(frozen=True)
class MeshReport:
    """A mesh in numbers; as text, in lines."""

    levels: tuple[LevelReport, ...]  #: Slabs, walls, beams and columns by level.
    shells: int  #: Number of triangles.
    beams: int  #: Number of lines.
    nodes: int  #: Number of nodes.
    free_dofs: int  #: Degrees of freedom that are not clamped.
    quality_min: float  #: Least radius ratio of the triangles, 1 for an equilateral one.
    quality_mean: float  #: Their mean.
    worst: str  #: Where the least one is.
    size_over_thickness: float  #: Largest side over thickness.
    #: Length of the sides that belong to one triangle and are not clamped, by family and level
    #: (``floor_1``, ``storey_1``) [m]: the rims of slabs, walls and bays. A wall that should stand
    #: on a slab and does not shows here.
    free_edges: dict[str, float]
    duplicates: int  #: Number of pairs of nodes in one place.
    dropped: int  #: Number of nodes of the file that no shell or beam uses.
    warnings: tuple[str, ...]  #: What is worth a look, in words.

    @classmethod
    def of(cls, mesh: BuildingMesh, sections: Sections) -> MeshReport:
        """Describe a mesh; the sections give the thicknesses."""
        q = radius_ratio(mesh.nodes, mesh.triangles)
        lengths, of_lines = side_lengths(mesh.nodes, mesh.triangles), line_lengths(mesh)
        thickness = np.array([section.thickness for section in sections.shells])[mesh.triangle_part]
        slender = lengths.max(axis=1) / thickness
        levels = []
        for family, k in itertools.product(("floor", "storey", "beam", "column"), mesh.floors):
            shells = family in SHELLS
            cells = mesh.triangles_of(family, k) if shells else mesh.lines_of(family, k)
            if not len(cells):
                continue
            nodes, size = (mesh.triangles, lengths) if shells else (mesh.lines, of_lines)
            used, mean = len(np.unique(nodes[cells])), float(size[cells].mean())
            quality = (q[cells].min(), q[cells].mean(), slender[cells].max()) if shells else ()
            report = LevelReport(f"{family}_{k}", len(cells), used, mean, *map(float, quality))
            levels.append(report)
        worst = int(np.argmin(q))
        return cls(
            levels=tuple(levels),
            shells=len(mesh.triangles),
            beams=len(mesh.lines),
            nodes=len(mesh.nodes),
            free_dofs=DOFS * (len(mesh.nodes) - len(mesh.base)),
            quality_min=float(q[worst]),
            quality_mean=float(q.mean()),
            worst=place(mesh.nodes[mesh.triangles[worst, :3]].mean(axis=0)),
            size_over_thickness=float(slender.max()),
            free_edges=free_edges(mesh),
            duplicates=len(cKDTree(mesh.nodes).query_pairs(NEAR, output_type="ndarray")),
            dropped=len(mesh.dropped),
            warnings=(
                *mesh_warnings(mesh),
                *_warnings(mesh, q, slender, lengths.max(axis=1)),
                *_slender(mesh, thickness, lengths.max(axis=1)),
            ),
        )

    @property
    def elements(self) -> int:
        """Number of shell and beam elements."""
        return self.shells + self.beams

    def __str__(self) -> str:
        edges = ", ".join(f"{name} {length:.2f}" for name, length in self.free_edges.items())
        lines = [
            "part       elements     nodes  size [m]  q min  q mean  size/thickness",
            *map(str, self.levels),
            f"all        {self.elements:>8}  {self.nodes:>8}  {'':>8}  {self.quality_min:5.3f}  "
            f"{self.quality_mean:6.3f}  {self.size_over_thickness:14.2f}",
            "",
            f"{self.shells} shells and {self.beams} beams; {DOFS * self.nodes} degrees of freedom, "
            f"{self.free_dofs} of them free",
            f"q: radius ratio, 1 for an equilateral triangle; the least one is at {self.worst}",
            f"duplicate nodes: {self.duplicates}; nodes of no element, dropped: {self.dropped}",
            f"free edges [m]: {edges}",
            *(f"warning: {text}" for text in self.warnings),
        ]
        return "\n".join(lines)


def free_edges(mesh: BuildingMesh) -> dict[str, float]:
    """Length of the sides that belong to one triangle and are not clamped [m].

    By family and level, ``floor_1`` to ``storey_8``; 0.0 where there is none.
    """
    lines, triangle = rim(mesh.triangles)
    free = ~np.isin(lines, mesh.base).all(axis=1)
    ends, part = mesh.nodes[lines[free, :2]], mesh.triangle_part[triangle[free]]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    by_part = np.bincount(part, weights=length, minlength=len(mesh.shell_parts))
    total: dict[str, float] = {}
    for part, of_part in zip(mesh.shell_parts, by_part.tolist(), strict=True):
        name = f"{part.family}_{part.level}"
        total[name] = total.get(name, 0.0) + of_part
    return total


def _warnings(mesh: BuildingMesh, q: Array, slender: Array, longest: Array) -> Iterator[str]:
    """By radius ratio, longest side h and h / t of each triangle."""
    centre = mesh.nodes[mesh.triangles[:, :3]].mean(axis=1)
    normal = normals(mesh.nodes, mesh.triangles)
    a, b, _ = shared_sides(mesh.triangles)
    # h² / (R t) of triangles on a curved surface, 0 on a plane: 1 / R is the angle between two
    # facets, no corner, over the distance of their centres, the largest over the shared sides.
    across = np.linalg.norm(np.cross(normal[a], normal[b]), axis=1)
    smooth = (across > np.sin(FOLD / 1e3)) & (across < np.sin(FOLD))
    a, b = a[smooth], b[smooth]
    bend = np.arcsin(across[smooth]) / np.linalg.norm(centre[a] - centre[b], axis=1)
    curved = np.zeros(len(mesh.triangles))
    for triangle in (a, b):
        np.maximum.at(curved, triangle, longest[triangle] * slender[triangle] * bend)

    def worst(triangle: int) -> str:
        group = mesh.shell_parts[mesh.triangle_part[triangle]].group
        return f"the worst in {group} at {place(centre[triangle])}"

    thin, coarse, poor = slender > SIZE_OVER_THICKNESS, curved > CURVED, q < POOR
    if thin.any():
        t = int(np.argmax(slender))
        yield (
            f"{thin.sum()} triangles are larger than {SIZE_OVER_THICKNESS:g} thicknesses, "
            f"{worst(t)} with {slender[t]:.0f}: beyond what the shells are verified for"
        )
    if coarse.any():
        t = int(np.argmax(curved))
        yield (
            f"{coarse.sum()} triangles are flat facets too large for the curved surface they stand "
            f"for, {worst(t)} with size² / (radius · thickness) = {curved[t]:.1f}: above "
            f"{CURVED:g} a thin shell may be too stiff by more than 1 %"
        )
    if poor.any():
        t = int(np.argmin(q))
        count = f"{poor.sum()} triangles have a radius ratio below {POOR:g}"
        yield f"{count}, {worst(t)} with {q[t]:.3f}"
    if len(mesh.dropped):
        yield (
            f"{len(mesh.dropped)} nodes of the file belong to no shell or beam and are dropped, "
            f"the first at {place(mesh.dropped[0])}"
        )


def _slender(mesh: BuildingMesh, thickness: Array, longest: Array) -> Iterator[str]:
    """By thickness and longest side of each triangle."""
    found = SlenderTriangles.of(mesh, thickness)
    errors, sizes = np.zeros((2, len(longest)))
    errors[found.cells] = found.error
    sizes[found.cells] = found.allowed_scale(TOO_STIFF) * longest[found.cells]
    proportions = longest**2 / np.maximum(
        2.0 * areas(mesh.nodes, mesh.triangles), np.finfo(float).tiny
    )
    bad = np.flatnonzero(errors > TOO_STIFF)
    for group, cells, _ in by_group(mesh, bad, mesh.triangles, shell_groups(mesh)):
        worst = cells[int(np.argmax(errors[cells]))]
        at = place(mesh.nodes[mesh.triangles[worst, :3]].mean(axis=0))
        size = f"{max(np.floor(100.0 * sizes[cells].min()), 1.0) / 100.0:.2f}"
        yield (
            f"{group}: {len(cells)} triangles are slender, up to {proportions[cells].max():.3g} "
            f"times as long as wide, the worst at {at}. Slender triangles make a thin plate too "
            f"stiff in bending: deflections out of its plane are up to "
            f"{_percent(errors[worst])} % too small, its natural frequencies up to "
            f"{_percent((1.0 - errors[worst]) ** -0.5 - 1.0)} % too high. This affects modes, "
            f"accelerations and floor spectra of {group}. Use sides of at most {size} m: "
            f'{mesh.shell_parts[mesh.triangle_part[worst]].family}_size = "{size} m" in '
            f"[buildings.structure.mesh], or Mesh.MeshSizeMax = {size} in gmsh"
        )


def _percent(error: float) -> int:
    """Rounded up."""
    return int(np.ceil(100.0 * error))
