"""What there is to know of a mesh before it is used: counts, quality, free edges, warnings."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from impactfem.building.mesh import BuildingMesh, place, radius_ratio, side_lengths, sides
from impactfem.building.mesh_checks import NEAR
from impactfem.building.section import Sections

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SIZE_OVER_THICKNESS = 600.0
"""Plates are verified up to it (`impactfem verify --only clamped_plate`)."""
CURVED = 2.0
"""Largest h² / (R t) of thin shells on curved surfaces, made of flat facets of the size h: at it
they are too stiff by 1 % where they bend without stretching, at 9 by 12 % (hemisphere, hyperbolic
paraboloid and twisted strip; `impactfem verify --only hyperbolic_paraboloid`)."""
FOLD = np.radians(30.0)
"""Angle between facets above which they meet at a corner and not on a curved surface."""
POOR = 0.2
"""Radius ratio below which a triangle is worth a look."""
_DOFS = 6


@dataclass(frozen=True)
class PartReport:
    """One part of a mesh, or all parts of a family at a level.

    Args:
        group: Its physical group, or what the groups begin with (``beam_3``).
        elements: Number of its triangles or lines.
        nodes: Number of its nodes, those it shares included.
        size: Mean length of the elements' sides [m].
        quality_min: Least radius ratio of its triangles; None for lines.
        quality_mean: Their mean.
        size_over_thickness: Largest side of its triangles over the thickness; None for lines.
    """

    group: str
    elements: int
    nodes: int
    size: float
    quality_min: float | None = None
    quality_mean: float | None = None
    size_over_thickness: float | None = None


@dataclass(frozen=True)
class MeshReport:
    """A mesh in numbers.

    Args:
        parts: The parts, shells first.
        levels: The same by family and level: slabs, walls, beams, columns.
        shells: Number of triangles.
        beams: Number of lines.
        nodes: Number of nodes.
        dofs: Six a node.
        free_dofs: Those that are not clamped.
        quality_min: Least radius ratio of the triangles, 1 for an equilateral one.
        quality_mean: Their mean.
        worst: Where the least one is.
        size_over_thickness: Largest side over thickness.
        free_edges: Length of the sides that belong to one triangle and are not clamped, by family
            and level (``floor_1``, ``storey_1``) [m]: the rims of slabs, walls and bays. A wall
            that should stand on a slab and does not shows here.
        duplicates: Number of pairs of nodes in one place.
        dropped: Number of nodes of the file that no shell or beam uses.
        warnings: What is worth a look, in words.
    """

    parts: tuple[PartReport, ...]
    levels: tuple[PartReport, ...]
    shells: int
    beams: int
    nodes: int
    dofs: int
    free_dofs: int
    quality_min: float
    quality_mean: float
    worst: str
    size_over_thickness: float
    free_edges: dict[str, float]
    duplicates: int
    dropped: int
    warnings: tuple[str, ...]

    @property
    def elements(self) -> int:
        """Number of shell and beam elements."""
        return self.shells + self.beams

    def as_dict(self) -> dict[str, Any]:
        """The report in values that JSON holds."""
        return {**asdict(self), "elements": self.elements}

    def __str__(self) -> str:
        return self.as_text()

    def as_text(self) -> str:
        """The report in lines of text; parts by family and level."""
        lines = [
            "part       elements     nodes  size [m]  q min  q mean  size/thickness",
            *map(_part_line, self.levels),
            f"all        {self.elements:>8}  {self.nodes:>8}  {'':>8}  {self.quality_min:5.3f}  "
            f"{self.quality_mean:6.3f}  {self.size_over_thickness:14.2f}",
        ]
        lines += [
            "",
            f"{self.shells} shells and {self.beams} beams; {self.dofs} degrees of freedom, "
            f"{self.free_dofs} of them free",
            f"q: radius ratio, 1 for an equilateral triangle; the least one is at {self.worst}",
            f"duplicate nodes: {self.duplicates}; nodes of no element, dropped: {self.dropped}",
            "free edges [m]: "
            + ", ".join(f"{name} {length:.2f}" for name, length in self.free_edges.items()),
            *(f"warning: {text}" for text in self.warnings),
        ]
        return "\n".join(lines)


def mesh_report(mesh: BuildingMesh, sections: Sections) -> MeshReport:
    """Describe a mesh.

    Args:
        mesh: The mesh.
        sections: Its sections, for the thicknesses.
    """
    elements = _Elements.of(mesh, sections)
    q, slender = elements.q, elements.slender
    worst = int(np.argmin(q))
    pairs = cKDTree(mesh.nodes).query_pairs(NEAR, output_type="ndarray")
    return MeshReport(
        parts=tuple(elements.by_part()),
        levels=tuple(elements.by_level()),
        shells=len(mesh.triangles),
        beams=len(mesh.lines),
        nodes=len(mesh.nodes),
        dofs=_DOFS * len(mesh.nodes),
        free_dofs=_DOFS * (len(mesh.nodes) - len(mesh.base)),
        quality_min=float(q[worst]),
        quality_mean=float(q.mean()),
        worst=place(mesh.nodes[mesh.triangles[worst, :3]].mean(axis=0)),
        size_over_thickness=float(slender.max()),
        free_edges=free_edges(mesh),
        duplicates=len(pairs),
        dropped=len(mesh.dropped),
        warnings=tuple(_warnings(mesh, elements)),
    )


@dataclass(frozen=True, eq=False)
class _Elements:
    """Size and shape of the elements of a mesh.

    Args:
        mesh: The mesh.
        q: Radius ratio of each triangle, shape (n_triangles,).
        lengths: Lengths of their sides, shape (n_triangles, 3) [m].
        slender: Largest side over thickness, shape (n_triangles,).
        line_lengths: Of the lines, shape (n_lines,) [m].
    """

    mesh: BuildingMesh
    q: Array
    lengths: Array
    slender: Array
    line_lengths: Array

    @classmethod
    def of(cls, mesh: BuildingMesh, sections: Sections) -> _Elements:
        lengths = side_lengths(mesh.nodes, mesh.triangles)
        thickness = np.array([one.thickness for one in sections.shells])[mesh.triangle_part]
        ends = mesh.nodes[mesh.lines[:, :2]]
        return cls(
            mesh=mesh,
            q=radius_ratio(mesh.nodes, mesh.triangles),
            lengths=lengths,
            slender=lengths.max(axis=1) / thickness,
            line_lengths=np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1),
        )

    def curved(self) -> Array:
        """h² / (R t) of each triangle on a curved surface, 0 on a plane, shape (n_triangles,).

        h is the longest side; 1 / R the angle between two facets, no corner, over the distance of
        their centres, the largest over the sides that two triangles share.
        """
        mesh = self.mesh
        vertices = mesh.nodes[mesh.triangles[:, :3]]
        normal = np.cross(vertices[:, 1] - vertices[:, 0], vertices[:, 2] - vertices[:, 0])
        normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
        middles = sides(mesh.triangles)[:, 2]
        owner = np.tile(np.arange(len(mesh.triangles)), 3)
        order = np.argsort(middles, kind="stable")
        _, first, counts = np.unique(middles[order], return_index=True, return_counts=True)
        pairs = first[counts == 2]
        a, b = owner[order[pairs]], owner[order[pairs + 1]]
        across = np.linalg.norm(np.cross(normal[a], normal[b]), axis=1)
        angle = np.arcsin(np.minimum(across, 1.0))
        distance = np.linalg.norm(vertices[a].mean(axis=1) - vertices[b].mean(axis=1), axis=1)
        smooth = (across > np.sin(FOLD / 1e3)) & (across < np.sin(FOLD))
        a, b, bend = a[smooth], b[smooth], (angle / distance)[smooth]
        found = np.zeros(len(mesh.triangles))
        for triangle in (a, b):
            longest = self.lengths[triangle].max(axis=1)
            np.maximum.at(found, triangle, longest * self.slender[triangle] * bend)
        return found

    def by_part(self) -> list[PartReport]:
        mesh = self.mesh
        return [
            self.report(part.group, part.dimension, np.flatnonzero(owner == i))
            for of_kind, owner in (
                (mesh.shell_parts, mesh.triangle_part),
                (mesh.beam_parts, mesh.line_part),
            )
            for i, part in enumerate(of_kind)
        ]

    def by_level(self) -> list[PartReport]:
        mesh = self.mesh
        return [
            self.report(f"{family}_{k}", dimension, cells(family, k))
            for family, dimension, cells in (
                ("floor", 2, mesh.triangles_of),
                ("storey", 2, mesh.triangles_of),
                ("beam", 1, mesh.lines_of),
                ("column", 1, mesh.lines_of),
            )
            for k in mesh.floors
            if len(cells(family, k))
        ]

    def report(self, group: str, dimension: int, own: Ints) -> PartReport:
        """The triangles (dimension 2) or lines (1) with some numbers."""
        if dimension == 1:
            size = float(self.line_lengths[own].mean())
            return PartReport(group, len(own), len(np.unique(self.mesh.lines[own])), size)
        return PartReport(
            group=group,
            elements=len(own),
            nodes=len(np.unique(self.mesh.triangles[own])),
            size=float(self.lengths[own].mean()),
            quality_min=float(self.q[own].min()),
            quality_mean=float(self.q[own].mean()),
            size_over_thickness=float(self.slender[own].max()),
        )


def free_edges(mesh: BuildingMesh) -> dict[str, float]:
    """Length of the sides that belong to one triangle and are not clamped [m].

    Returns:
        By family and level, ``floor_1`` to ``storey_8``; 0.0 where there is none.
    """
    every = sides(mesh.triangles)
    owner = np.tile(mesh.triangle_part, 3)
    _, first, counts = np.unique(every[:, 2], return_index=True, return_counts=True)
    alone = first[counts == 1]
    clamped = np.zeros(len(mesh.nodes), dtype=bool)
    clamped[mesh.base] = True
    alone = alone[~clamped[every[alone]].all(axis=1)]
    ends = mesh.nodes[every[alone, :2]]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    by_part = np.bincount(owner[alone], weights=length, minlength=len(mesh.shell_parts))
    total: dict[str, float] = {}
    for part, one in zip(mesh.shell_parts, by_part, strict=True):
        name = f"{part.family}_{part.level}"
        total[name] = total.get(name, 0.0) + float(one)
    return total


def _warnings(mesh: BuildingMesh, elements: _Elements) -> list[str]:
    q, slender = elements.q, elements.slender
    found = []
    centre = mesh.nodes[mesh.triangles[:, :3]].mean(axis=1)
    groups = [part.group for part in mesh.shell_parts]
    thin = np.flatnonzero(slender > SIZE_OVER_THICKNESS)
    if thin.size:
        worst = thin[np.argmax(slender[thin])]
        found.append(
            f"{len(thin)} triangles are larger than {SIZE_OVER_THICKNESS:g} thicknesses, the worst "
            f"in {groups[mesh.triangle_part[worst]]} at {place(centre[worst])} with "
            f"{slender[worst]:.0f}: beyond what the shells are verified for"
        )
    curved = elements.curved()
    coarse = np.flatnonzero(curved > CURVED)
    if coarse.size:
        worst = coarse[np.argmax(curved[coarse])]
        found.append(
            f"{len(coarse)} triangles are flat facets too large for the curved surface they stand "
            f"for, the worst in {groups[mesh.triangle_part[worst]]} at {place(centre[worst])} with "
            f"size² / (radius · thickness) = {curved[worst]:.1f}: above {CURVED:g} a thin shell "
            "may be too stiff by more than 1 %"
        )
    poor = np.flatnonzero(q < POOR)
    if poor.size:
        worst = poor[np.argmin(q[poor])]
        found.append(
            f"{len(poor)} triangles have a radius ratio below {POOR:g}, the worst in "
            f"{groups[mesh.triangle_part[worst]]} at {place(centre[worst])} with {q[worst]:.3f}"
        )
    if len(mesh.dropped):
        found.append(
            f"{len(mesh.dropped)} nodes of the file belong to no shell or beam and are dropped, "
            f"the first at {place(mesh.dropped[0])}"
        )
    return found


def _part_line(part: PartReport) -> str:
    line = f"{part.group:<9}  {part.elements:>8}  {part.nodes:>8}  {part.size:8.3f}"
    if part.quality_min is None:
        return line
    return (
        f"{line}  {part.quality_min:5.3f}  {part.quality_mean:6.3f}  "
        f"{part.size_over_thickness:14.2f}"
    )
