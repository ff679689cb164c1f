"""The mesh generator: a geometry becomes a conforming gmsh mesh of second order.

All surfaces, lines and points are fragmented at once, so that whatever meets shares its nodes; the
groups are named from what each input became.
"""

import math
from collections import defaultdict
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from impactfem.building.geometry import PARAPET, SIDES, Geometry, Wall
from impactfem.building.mesh import NAME, Mark, Part, place
from impactfem.building.read_mesh import gmsh_session
from impactfem.system.errors import Fault, ImpactfemError, InputError
from impactfem.system.executor import in_own_process
from impactfem.system.files import atomic

Point = tuple[float, float, float]
Entity = tuple[int, int]
Inputs = list[tuple[Part | Mark, Entity]]  # the entities before the fragment, in order
Groups = dict[Part | Mark, dict[int, set[int]]]  # tags by dimension

_FRONTAL_DELAUNAY = 6
_NEAR = 1e-5  # gmsh's bounding boxes are larger than the entities by 1e-7 m [m]


def generate(geometry: Geometry, path: Path, *, source: str = "", binary: bool = True) -> None:
    """Make the mesh of a building: MSH 4.1, second order, plane facets and straight edges.

    The same geometry gives the same mesh. gmsh runs in a process of its own. Not collective.

    Args:
        geometry: What is built.
        path: The file to write.
        source: What the geometry comes from, for messages; the case file.
        binary: Whether the file is binary: smaller and faster, with the same numbers.

    Raises:
        InputError: Parts lie on each other, or a name or a number of a floor is not usable.
        ImpactfemError: The file cannot be written, or gmsh failed.
    """
    source = source or str(path)
    # Faults that would make groups wrong: names, doubles, floors that are not there.
    faults = []
    seen: set[Part] = set()
    levels = set(geometry.floors)
    if geometry.impact_edge not in SIDES:
        expected = f"expected one of {', '.join(SIDES)}"
        faults.append(Fault(source, "impact_edge", geometry.impact_edge, expected))
    for family, name, numbers in (
        *(("storey", w.name, w.storeys) for w in geometry.walls),
        *(("beam", b.name, b.floors) for b in geometry.beams),
        *(("column", c.name, c.storeys) for c in geometry.columns),
    ):
        if not NAME.fullmatch(name):
            expected = f"the name of a {family} has a-z, 0-9 and single _ only"
            faults.append(Fault(source, family, name, expected))
        for k in numbers:
            part = Part(family, k, name)
            if k not in levels:
                expected = f"expected a {family} at 1 to {max(levels, default=0)}"
                faults.append(Fault(source, part.group, None, expected))
            elif part in seen:
                faults.append(Fault(source, part.group, None, "duplicate name"))
            seen.add(part)
    if faults:
        raise InputError(faults)
    with atomic(path) as temporary:
        # gmsh chooses the format by the file's suffix.
        made = temporary.with_name(f"{temporary.name}.msh")
        try:
            in_own_process(_generate, geometry, made.absolute(), source, binary)
            made.replace(temporary)
        finally:
            made.unlink(missing_ok=True)


def _generate(geometry: Geometry, path: Path, source: str, binary: bool) -> None:
    with gmsh_session() as gmsh:
        try:
            inputs = _draw(gmsh.model.occ, geometry)
            _, became = gmsh.model.occ.fragment([entity for _, entity in inputs], [])
            gmsh.model.occ.synchronize()
            groups = _groups(gmsh.model, geometry, inputs, became, source)
            for name in sorted(groups, key=lambda name: name.group):
                for dimension, tags in sorted(groups[name].items()):
                    gmsh.model.addPhysicalGroup(dimension, sorted(tags), name=name.group)
            # One constant size a family, on its entities and their boundaries; the least counts.
            field, sizes, fields = gmsh.model.mesh.field, asdict(geometry.size), []
            for family, size in sizes.items():
                tags_of: dict[int, set[int]] = {1: set(), 2: set()}
                for name, by_dimension in groups.items():
                    if isinstance(name, Part) and name.family == family:
                        for dimension, tags in by_dimension.items():
                            tags_of[dimension] |= tags
                if not tags_of[1] | tags_of[2]:
                    continue
                fields.append(field.add("Constant"))
                field.setNumber(fields[-1], "VIn", size)
                field.setNumber(fields[-1], "VOut", max(sizes.values()))
                field.setNumbers(fields[-1], "CurvesList", sorted(tags_of[1]))
                field.setNumbers(fields[-1], "SurfacesList", sorted(tags_of[2]))
            least = field.add("Min")
            field.setNumbers(least, "FieldsList", fields)
            field.setAsBackgroundMesh(least)
            gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)
            gmsh.option.setNumber("Mesh.MeshSizeMax", max(sizes.values()))
            gmsh.option.setNumber("Mesh.Algorithm", _FRONTAL_DELAUNAY)
            gmsh.option.setNumber("Mesh.SecondOrderLinear", 1)
            gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
            gmsh.option.setNumber("Mesh.Binary", int(binary))
            gmsh.model.mesh.generate(2)
            gmsh.model.mesh.setOrder(2)
            gmsh.write(str(path))
        except InputError:
            raise
        except Exception as error:  # gmsh raises nothing more special
            raise ImpactfemError(f"gmsh cannot mesh the building of {source}: {error}") from error


def _draw(occ: Any, geometry: Geometry) -> Inputs:
    inputs: Inputs = []
    Lx, Ly = geometry.length, geometry.width
    corners = [(0.0, 0.0), (Lx, 0.0), (Lx, Ly), (0.0, Ly)]
    first = ("y-", "x+", "y+", "x-").index(geometry.impact_edge)
    impact = corners[first], corners[(first + 1) % 4]
    for k in geometry.floors:
        below, z = geometry.levels[k - 1], geometry.levels[k]
        inputs.append((Part("floor", k), _plane(occ, [(x, y, z) for x, y in corners])))
        for wall in geometry.walls:
            if k in wall.storeys:
                for face in _wall(occ, geometry, wall, k):
                    inputs.append((Part("storey", k, wall.name), face))
        for beam in geometry.beams:
            if k in beam.floors:
                inputs.append(
                    (Part("beam", k, beam.name), _line(occ, (*beam.start, z), (*beam.end, z)))
                )
        for column in geometry.columns:
            if k in column.storeys:
                line = _line(occ, (*column.place, below), (*column.place, z))
                inputs.append((Part("column", k, column.name), line))
        inputs.append((Mark("edge", k), _line(occ, (*impact[0], z), (*impact[1], z))))
        inputs.append((Mark("centre", k), (0, occ.addPoint(Lx / 2.0, Ly / 2.0, z))))
    if geometry.parapet is not None:
        z = geometry.levels[-1]
        top = z + geometry.parapet.height
        for (x1, y1), (x2, y2) in zip(corners, corners[1:] + corners[:1], strict=True):
            around = [(x1, y1, z), (x2, y2, z), (x2, y2, top), (x1, y1, top)]
            inputs.append((Part("floor", geometry.floors[-1], PARAPET), _plane(occ, around)))
    return inputs


def _wall(occ: Any, geometry: Geometry, wall: Wall, k: int) -> list[Entity]:
    """The faces of a wall in storey k, its bays cut out."""
    (x1, y1), (x2, y2) = wall.start, wall.end
    L = math.hypot(x2 - x1, y2 - y1)
    below, above = geometry.levels[k - 1], geometry.levels[k]

    def rectangle(s1: float, s2: float, z1: float, z2: float) -> Entity:
        ends = [(x1 + (x2 - x1) * s / L, y1 + (y2 - y1) * s / L) for s in (s1, s2)]
        return _plane(occ, [(*ends[0], z1), (*ends[1], z1), (*ends[1], z2), (*ends[0], z2)])

    whole = rectangle(0.0, L, below, above)
    holes = []
    for bay in geometry.bays:
        if bay.wall == wall.name and bay.storey == k:
            s, sill = bay.centre - bay.width / 2.0, below + bay.sill
            holes.append(rectangle(s, s + bay.width, sill, sill + bay.height))
    if not holes:
        return [whole]
    return list(occ.cut([whole], holes)[0])


def _line(occ: Any, start: Point, end: Point) -> Entity:
    return 1, occ.addLine(occ.addPoint(*start), occ.addPoint(*end))


def _plane(occ: Any, corners: list[Point]) -> Entity:
    points = [occ.addPoint(*corner) for corner in corners]
    turned = [*points[1:], points[0]]
    sides = [occ.addLine(p, q) for p, q in zip(points, turned, strict=True)]
    return 2, occ.addPlaneSurface([occ.addCurveLoop(sides)])


def _groups(
    model: Any, geometry: Geometry, inputs: Inputs, became: list[list[Entity]], source: str
) -> Groups:
    """The entities of each part and mark, by dimension."""
    groups: Groups = defaultdict(lambda: defaultdict(set))
    owner: dict[Entity, Part] = {}
    faults = []
    for (name, _), pieces in zip(inputs, became, strict=True):
        for dimension, tag in pieces:
            groups[name][dimension].add(tag)
            if not isinstance(name, Part):
                continue
            other = owner.setdefault((dimension, tag), name)
            if other != name:
                box = np.array(model.getBoundingBox(dimension, tag)).reshape(2, 3)
                where = f"lies on {other.group} at {place(box.mean(axis=0))}"
                faults.append(Fault(source, name.group, None, where))
    if faults:
        raise InputError(faults)
    base, foot = Mark("base"), geometry.levels[0]
    for part, by_dimension in list(groups.items()):
        if isinstance(part, Part) and part.scaled and part.level == 1:
            dimension = part.dimension
            entities = [(dimension, tag) for tag in sorted(by_dimension[dimension])]
            for d, tag in model.getBoundary(entities, combined=False, oriented=False):
                box = model.getBoundingBox(d, tag)
                if abs(box[2] - foot) < _NEAR and abs(box[5] - foot) < _NEAR:
                    groups[base][d].add(tag)
    return groups
