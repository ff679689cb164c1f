"""What is assembled: the mesh with sections, materials, dampings, and the masses of its floors."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.building.mesh import BuildingMesh, Part, areas, line_lengths
from impactfem.building.section import Material, Materials, Sections
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError
from impactfem.system.quantity import quantity, results, si

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class PartDamping:
    """Coefficients of the parts of a mesh; None where a part has the damping of the building."""

    shells: tuple[Rayleigh | None, ...]  #: Of each of the mesh's `shell_parts`, in their order.
    beams: tuple[Rayleigh | None, ...]  #: Of each of the mesh's `beam_parts`, in their order.

    @property
    def distinct(self) -> list[Rayleigh]:
        """The coefficients that occur, each once, ascending."""
        return sorted({d for d in (*self.shells, *self.beams) if d is not None})


@dataclass(frozen=True, eq=False)
class Kind:
    """Cells of one kind: slabs, walls, beams or columns of one material."""

    shells: bool  #: Whether they are triangles; else lines.
    storey: bool  #: Whether the storey factor acts on them.
    material: Material  #: Their material.
    number: Index  #: Of the triangles or lines of the mesh, shape (m,).
    cells: Index  #: Their nodes, shape (m, 6) or (m, 3).
    part: Index  #: Index into the mesh's `shell_parts` or `beam_parts` of each, shape (m,).


@dataclass(frozen=True, eq=False)
class BuildingParts:
    """A building ready for assembly."""

    mesh: BuildingMesh  #: Its mesh.
    sections: Sections  #: Sections of the mesh's parts, in their order.
    materials: Materials  #: Materials of the mesh's parts, in their order.
    #: Mass on the area of each triangle that is not the shells' own, shape (m,) [kg/m2].
    added_mass: Array
    drilling: float = 1.0  #: Factor of the drilling stiffness μ t.
    #: Dampings of its parts; None where all have that of the building.
    dampings: PartDamping | None = None

    def thickness(self) -> Array:
        """Thickness of each triangle, shape (m,) [m]."""
        by_part = np.array([section.thickness for section in self.sections.shells])
        return by_part[self.mesh.triangle_part]

    def slab_material(self, floor: int) -> Material:
        """The material of the slab of a floor: of its first part.

        Raises:
            KeyError: The floor has no slab.
        """
        for part, material in zip(self.mesh.shell_parts, self.materials.shells, strict=True):
            if (part.family, part.level) == ("floor", floor):
                return material
        raise KeyError(f"floor {floor} has no slab")

    def changed(self, other: BuildingParts, storeys: bool = False) -> tuple[Flags, Flags]:
        """Whether each triangle, and each line, differs in its properties from parts of one mesh.

        With `storeys` all walls and columns do.
        """

        def unlike(parts: Sequence[Part], *pairs: tuple[Sequence[Any], Sequence[Any]]) -> Flags:
            by_part = [[a != b for a, b in zip(*pair, strict=True)] for pair in pairs]
            by_part.append([storeys and part.scaled for part in parts])
            return np.asarray(np.any(by_part, axis=0), dtype=bool)

        mesh, own, its = self.mesh, self.materials, other.materials
        shells = unlike(mesh.shell_parts, (own.shells, its.shells))[mesh.triangle_part]
        shells |= self.thickness() != other.thickness()
        shells |= (self.added_mass != other.added_mass) | (self.drilling != other.drilling)
        sections = self.sections.beams, other.sections.beams
        return shells, unlike(mesh.beam_parts, (own.beams, its.beams), sections)[mesh.line_part]

    def kinds(self) -> list[Kind]:
        """The cells that are there: slabs, walls, beams and columns, of each material apart."""
        mesh, kinds = self.mesh, []
        for shells, parts, materials, cells, part in (
            (True, mesh.shell_parts, self.materials.shells, mesh.triangles, mesh.triangle_part),
            (False, mesh.beam_parts, self.materials.beams, mesh.lines, mesh.line_part),
        ):
            own = part.astype(np.int64)
            for storey, material in itertools.product((False, True), dict.fromkeys(materials)):
                of_kind = [
                    p.scaled == storey and m == material
                    for p, m in zip(parts, materials, strict=True)
                ]
                number = np.flatnonzero(np.array(of_kind, dtype=bool)[own])
                if number.size:
                    kinds.append(Kind(shells, storey, material, number, cells[number], own[number]))
        return kinds


class FloorMassError(SolutionError):
    """Masses of floors that cannot be had: what is wrong, each with the key of the structure."""

    def __init__(self, *wrong: tuple[str, str]) -> None:
        super().__init__("; ".join(message for message, _ in wrong))
        self.wrong = wrong


@dataclass(frozen=True)
class Strips:
    """Where the mass that is added on a slab lies; the rest of it lies evenly."""

    axis: int  #: Across the strips: 0 along x, 1 along y.
    edges: float  #: Part of it in two strips together, one along each edge.
    middle: float  #: Part of it in a strip in the middle.
    width: float  #: Of each strip [m].

    def density(self, points: Array, area: Array) -> Array:
        """Share of the mass on each triangle by its area, Σ density · area = 1, shape (m,) [1/m2].

        A triangle that the side of a strip cuts has the part of it that lies in the strip. By the
        corners of the triangles of the slab, shape (m, 3, 2) or (m, 3, 3) [m], and their areas.

        Raises:
            FloorMassError: The strips cover each other.
        """
        s = np.sort(points[..., self.axis], axis=1)
        low, high = float(s.min()), float(s.max())
        if 3.0 * self.width > (high - low) * (1.0 + 1e-9):
            expected = (
                f"strips of added mass {self.width:g} m wide; expected at most a third of the "
                f"slab's {high - low:g} m"
            )
            raise FloorMassError((expected, "added_mass"))

        def below(t: float) -> Array:
            """Part of each triangle, with a ≤ b ≤ c along the axis, that lies below t."""
            a, b, c = s.T
            tiny = 1e-12 * (high - low)
            rising = (t - a) ** 2 / np.maximum((b - a) * (c - a), tiny**2)
            falling = 1.0 - (c - t) ** 2 / np.maximum((c - b) * (c - a), tiny**2)
            return np.where(t <= a, 0.0, np.where(t >= c, 1.0, np.where(t < b, rising, falling)))

        middle, half = 0.5 * (low + high), 0.5 * self.width
        edges = below(low + self.width) + 1.0 - below(high - self.width)
        inner = below(middle + half) - below(middle - half)
        even = np.full(len(area), (1.0 - self.edges - self.middle) / area.sum())
        parts = self.edges * edges / (edges @ area) + self.middle * inner / (inner @ area)
        return np.asarray(even + parts)


@results
class FloorMasses:
    """The masses of the floors and of the base.

    A floor has its slab and beams, and of each wall and column the share by the lever rule: at
    the height z between floors k − 1 and k, the part (z − z_{k−1}) / (z_k − z_{k−1}) goes to
    floor k and the rest to floor k − 1. So half of a storey without bays goes to each.
    """

    parts: Array  #: Mass of the parts by floor, shape (n_floors,) [kg].
    added: Array = si("kg", "mass added on the slab", dims="floor", name="floor_added_mass")
    base: float = si("kg", "mass of the base, which does not move", name="base_mass")
    on_triangles: Array = si("kg/m2", "added mass", dims="triangle", name="added_mass")

    @property
    @quantity("kg", "mass of the floor", dims="floor", name="floor_mass")
    def floors(self) -> Array:
        """Mass of each floor, shape (n_floors,)."""
        return self.parts + self.added


def floor_masses(
    mesh: BuildingMesh,
    sections: Sections,
    materials: Materials,
    required: Array | None = None,
    eccentricity: tuple[float, float] = (0.0, 0.0),
    strips: Mapping[int, Strips] | None = None,
) -> FloorMasses:
    """Masses of the floors 1 to n_floors; what must be added on the slabs for required ones.

    It is spread evenly, or in strips. Where the centres of mass are moved, what lies on a slab and
    its own mass together become m (1 + c · (x − x̄)): the added mass is negative where it takes from
    the slab's.

    Required masses are given bottom to top, shape (n_floors,) [kg]; None adds nothing. Centres of
    mass are moved by the eccentricity along x and y [m]; strips are those of floors whose added
    mass does not lie evenly, by their numbers.

    Raises:
        FloorMassError: A floor's parts weigh more than is required, it has no slab, what lies on it
            cannot move its centre of mass so far, or its strips cover each other; of all floors.
    """
    area = areas(mesh.nodes, mesh.triangles)
    on_area = [m.rho * s.thickness for m, s in zip(materials.shells, sections.shells, strict=True)]
    shells = area * np.array(on_area)[mesh.triangle_part]
    shares = _shares(mesh, mesh.shell_parts, mesh.triangle_part, mesh.triangles[:, :3], shells)
    if len(mesh.lines):
        on_line = [m.rho * s.A for m, s in zip(materials.beams, sections.beams, strict=True)]
        beams = line_lengths(mesh) * np.array(on_line)[mesh.line_part]
        shares += _shares(mesh, mesh.beam_parts, mesh.line_part, mesh.lines[:, :2], beams)
    parts = shares[1:]
    on_triangles = np.zeros(len(area))
    if required is None and not any(eccentricity):
        return FloorMasses(parts, np.zeros_like(parts), float(shares[0]), on_triangles)
    added = np.zeros_like(parts) if required is None else np.asarray(required) - parts
    wrong: list[tuple[str, str]] = []
    heavy: list[str] = []
    for k, lacking in zip(mesh.floors, added, strict=True):
        slab, missing = mesh.slab(k), max(lacking, 0.0)
        if slab.size == 0:
            expected = f"floor {k} has no flat slab that could carry an added mass"
            wrong.append((expected, "floor_masses"))
            continue
        if lacking < 0.0:
            given = parts[k - 1] + lacking
            heavy.append(f"floor {k}: {parts[k - 1] / 1e3:.1f} t, floor table {given / 1e3:.1f} t")
        own_strips = (strips or {}).get(k)
        corners = mesh.nodes[mesh.triangles[slab, :3]]
        even = 1.0 / area[slab].sum()
        try:
            density = even if own_strips is None else own_strips.density(corners, area[slab])
        except FloorMassError as error:
            wrong += error.wrong
            continue
        on_triangles[slab] = missing * density
        if any(eccentricity):
            own = np.array(on_area)[mesh.triangle_part[slab]]
            floor = parts[k - 1] + missing
            mass = area[slab] * (own + on_triangles[slab])
            # m (1 + c · (x − x̄)), so that the static moment of the masses m grows by M e.
            x = corners[..., :2].mean(axis=1)
            x -= mass @ x / mass.sum()
            moment = floor * np.array(eccentricity)
            share = 1.0 + x @ np.linalg.solve((x.T * mass) @ x, moment)
            if share.min() >= 0.0:
                on_triangles[slab] = mass * share / area[slab] - own
            elif all(key != "mass_eccentricity" for _, key in wrong):  # one floor says it of all
                expected = (
                    f"the mass of floor {k}, {floor / 1e3:.4g} t, cannot move by "
                    f"{np.hypot(*eccentricity):.3g} m by what lies on its slab and its own, "
                    f"{mass.sum() / 1e3:.4g} t"
                )
                wrong.append((expected, "mass_eccentricity"))
    if heavy:
        expected = (
            f"the parts weigh more than the floor table gives ({'; '.join(heavy)}): raise its "
            "masses, reduce sections or density, or type floor_masses = false"
        )
        wrong.append((expected, "floor_masses"))
    if wrong:
        raise FloorMassError(*wrong)
    return FloorMasses(parts, added, float(shares[0]), on_triangles)


def lever_rule(
    mesh: BuildingMesh, parts: tuple[Part, ...], part: NDArray[np.int32], corners: Index
) -> tuple[Index, Array]:
    """The floor of each cell of some parts, and the share of its mass that belongs to it.

    The rest of a wall or a column belongs to the floor below, or to the base. `part` is the index
    into the parts of each cell, shape (m,); `corners` are its vertices, shape (m, 2) or (m, 3).
    """
    level = np.array([p.level for p in parts], dtype=np.int64)[part]
    standing = np.array([p.scaled for p in parts], dtype=bool)[part]
    elevation = np.array([mesh.nodes[mesh.base, 2].min(), *mesh.elevations.values()])
    z = mesh.nodes[corners, 2].mean(axis=1)
    below, above = elevation[level - 1], elevation[level]
    return level, np.where(standing, np.clip((z - below) / (above - below), 0.0, 1.0), 1.0)


def _shares(
    mesh: BuildingMesh,
    parts: tuple[Part, ...],
    part: NDArray[np.int32],
    corners: Index,
    mass: Array,
) -> Array:
    """Mass of cells by level: the base, then the floors."""
    level, upper = lever_rule(mesh, parts, part, corners)
    count = 1 + len(mesh.floors)
    lower = np.bincount(level - 1, mass * (1.0 - upper), count)
    return np.asarray(np.bincount(level, mass * upper, count) + lower)
