"""What the physical groups of a mesh file mean: parts with their cells, edges, centres, base."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from impactfem.building.mesh import BuildingMesh, place, sides
from impactfem.building.part import SCHEME, Mark, Part, parse_group
from impactfem.building.raw_mesh import Block, RawMesh
from impactfem.system.errors import Fault, InputError

Ints = NDArray[np.int64]

_KINDS = {0: "points", 1: "lines", 2: "surfaces", 3: "volumes"}
_SECOND_ORDER = {0: "Point", 1: "Line 3", 2: "Triangle 6"}
_FIRST_ORDER = ("Line 2", "Triangle 3", "Quadrilateral 4")
_DIMENSIONS = {"edge": (1,), "centre": (0,), "base": (0, 1)}


@dataclass
class _Sorted:
    """The cells of each part and mark, with gmsh's nodes."""

    parts: dict[Part, list[Ints]] = field(default_factory=lambda: defaultdict(list))
    marks: dict[Mark, list[Block]] = field(default_factory=lambda: defaultdict(list))

    def levels(self, *families: str) -> set[int]:
        return {part.level for part in self.parts if part.family in families}

    def nodes(self, mark: Mark) -> Ints:
        found: Ints = np.concatenate([block.nodes.ravel() for block in self.marks[mark]])
        return np.unique(found)


def assemble(raw: RawMesh, file: Path) -> BuildingMesh:
    """Make the building's mesh from the cells of a file.

    Args:
        raw: Nodes and cells.
        file: The file, for messages.

    Raises:
        InputError: A group is missing, unknown or of the wrong dimension; cells are of first
            order, in no group or in two; an edge, a centre or the base is not on the structure.
    """
    found = _Sorted()
    faults = [*_name_faults(raw, file), *_sort(raw, found, file)]
    faults = faults or list(_missing(found, file))
    if faults:
        raise InputError(faults)
    parts = sorted(found.parts)
    shell_parts = tuple(part for part in parts if part.dimension == 2)
    beam_parts = tuple(part for part in parts if part.dimension == 1)
    triangles, triangle_part = _joined(found, shell_parts, 6)
    lines, line_part = _joined(found, beam_parts, 3)
    used = np.unique(np.concatenate([triangles.ravel(), lines.ravel()]))
    number = np.full(len(raw.nodes), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    unused = np.setdiff1d(np.arange(len(raw.nodes)), used)
    shell_level = np.array(
        [part.level if part.family == "floor" else 0 for part in shell_parts], dtype=np.int64
    )
    slabs = {k: triangles[shell_level[triangle_part] == k] for k in sorted(found.levels("floor"))}
    marks = _Marks(raw, found, slabs, number, file)
    edges = {k: marks.edge(k) for k in slabs}
    centres = {k: marks.centre(k) for k in slabs}
    base = marks.base()
    if marks.faults:
        raise InputError(marks.faults)
    return BuildingMesh(
        nodes=raw.nodes[used],
        triangles=number[triangles],
        triangle_part=triangle_part,
        lines=number[lines],
        line_part=line_part,
        shell_parts=shell_parts,
        beam_parts=beam_parts,
        edges=edges,
        centres=centres,
        base=base,
        dropped=raw.nodes[unused],
    )


def _name_faults(raw: RawMesh, file: Path) -> Iterable[Fault]:
    for group, dimension in raw.groups:
        meaning = parse_group(group)
        if meaning is None:
            yield Fault(file, group, None, f"unknown physical group; expected {SCHEME}")
            continue
        if isinstance(meaning, Part):
            allowed: tuple[int, ...] = (meaning.dimension,)
        else:
            allowed = _DIMENSIONS[meaning.kind]
        if dimension not in allowed:
            expected = " or ".join(_KINDS[d] for d in allowed)
            yield Fault(file, group, None, f"a group of {_KINDS[dimension]}; expected {expected}")


def _sort(raw: RawMesh, found: _Sorted, file: Path) -> Iterable[Fault]:
    """Sort the cells by part and mark; what cannot be sorted is a fault."""
    nowhere: dict[int, list[Block]] = defaultdict(list)
    first_order: list[Block] = []
    for block in raw.blocks:
        meanings = [meaning for group in block.groups if (meaning := parse_group(group))]
        own = [meaning for meaning in meanings if isinstance(meaning, Part)]
        where = f"{len(block.nodes)} cells, the first at {_first_place(raw, block)}"
        if block.kind in _FIRST_ORDER:
            first_order.append(block)
        elif block.kind != _SECOND_ORDER.get(block.dimension):
            group = ", ".join(block.groups)
            expected = "expected triangles with 6 nodes and lines with 3"
            yield Fault(file, group, block.kind, f"{where}; {expected}")
        elif len(own) > 1:
            group = ", ".join(part.group for part in own)
            expected = (
                "in two groups; expected one each (in format 2 groups share no entity number)"
            )
            yield Fault(file, group, None, f"{where}: {expected}")
        elif block.dimension > 0 and not block.groups:
            nowhere[block.dimension].append(block)
        for part in own:
            found.parts[part].append(block.nodes)
        for meaning in meanings:
            if isinstance(meaning, Mark):
                found.marks[meaning].append(block)
    if first_order:
        count = sum(len(block.nodes) for block in first_order)
        group = ", ".join(first_order[0].groups)
        expected = "expected a mesh of second order (gmsh -order 2, or Mesh.ElementOrder = 2)"
        place = _first_place(raw, first_order[0])
        yield Fault(
            file,
            group,
            None,
            f"{count} first-order cells, the first at {place}; expected {expected}",
        )
    for dimension, blocks in sorted(nowhere.items()):
        count = sum(len(block.nodes) for block in blocks)
        yield Fault(
            file,
            "",
            None,
            f"{count} cells of {_KINDS[dimension]} without a physical group, the first at "
            f"{_first_place(raw, blocks[0])}; expected every part in a group "
            "(and a file saved without Mesh.SaveAll)",
        )


def _missing(found: _Sorted, file: Path) -> Iterable[Fault]:
    """Groups that every building needs, and levels that do not go together."""
    floors = found.levels("floor")
    storeys = found.levels("storey", "column")
    top = max(floors, default=0)
    if not floors:
        yield Fault(file, "floor_1", None, "missing group; expected the slabs as floor_<k>")
    if not storeys:
        expected = "missing group; expected walls as storey_<k> or columns as column_<k>"
        yield Fault(file, "storey_1", None, expected)
    if Mark("base") not in found.marks:
        expected = "missing group; expected the lines or points that are clamped"
        yield Fault(file, "base", None, expected)
    for k in range(1, top + 1):
        if k not in floors:
            yield Fault(file, f"floor_{k}", None, f"missing group; floor_{top} is above it")
            continue
        if storeys and k not in storeys:
            expected = f"missing group; expected walls or columns below floor_{k}"
            yield Fault(file, f"storey_{k}", None, expected)
        for kind, what in (
            ("edge", "the lines of the slab's edge that faces the other building"),
            ("centre", "the node at the floor's mass centre"),
        ):
            if Mark(kind, k) not in found.marks:
                yield Fault(file, f"{kind}_{k}", None, f"missing group; expected {what}")
    if not floors:
        return
    named: list[Part | Mark] = [part for part in found.parts if part.family != "floor"]
    named += found.marks
    for meaning in sorted(named, key=lambda meaning: meaning.group):
        if meaning.level > top:
            expected = f"expected a number from 1 to {top}, that of the top floor"
            yield Fault(file, meaning.group, meaning.level, expected)


def _joined(found: _Sorted, parts: tuple[Part, ...], width: int) -> tuple[Ints, NDArray[np.int32]]:
    cells = [np.concatenate(found.parts[part]) for part in parts]
    own = np.repeat(np.arange(len(parts), dtype=np.int32), [len(some) for some in cells])
    return np.concatenate([np.zeros((0, width), dtype=np.int64), *cells]), own


class _Marks:
    """The groups that only point at nodes, in the numbers of the mesh; collects their faults."""

    def __init__(
        self, raw: RawMesh, found: _Sorted, slabs: dict[int, Ints], number: Ints, file: Path
    ) -> None:
        self._raw, self._found, self._slabs = raw, found, slabs
        self._number, self._file = number, file
        self.faults: list[Fault] = []

    def _refuse(self, mark: Mark, node: int, expected: str) -> None:
        where = place(self._raw.nodes[node])
        self.faults.append(Fault(self._file, mark.group, None, f"at {where}: {expected}"))

    def edge(self, k: int) -> Ints:
        mark = Mark("edge", k)
        lines = np.concatenate([block.nodes for block in self._found.marks[mark]])
        ordered = lines.copy()
        ordered[:, :2].sort(axis=1)
        known = {tuple(int(n) for n in side) for side in sides(self._slabs[k])}
        for line in ordered:
            if tuple(int(n) for n in line) not in known:
                expected = f"expected lines that are sides of triangles of floor_{k}"
                self._refuse(mark, int(line[2]), expected)
                break
        own: Ints = self._number[lines]
        return own

    def centre(self, k: int) -> int:
        mark = Mark("centre", k)
        nodes = self._found.nodes(mark)
        if len(nodes) != 1:
            self._refuse(mark, int(nodes[1]), f"{len(nodes)} nodes; expected one")
        elif nodes[0] not in self._slabs[k]:
            expected = f"expected a node of floor_{k} (in gmsh: a point embedded in the slab)"
            self._refuse(mark, int(nodes[0]), expected)
        return int(self._number[nodes[0]])

    def base(self) -> Ints:
        mark = Mark("base")
        nodes = self._found.nodes(mark)
        own = self._number[nodes]
        if np.any(own < 0):
            expected = "expected nodes of walls, columns, slabs or beams"
            self._refuse(mark, int(nodes[np.argmax(own < 0)]), expected)
        return np.sort(own)


def _first_place(raw: RawMesh, block: Block) -> str:
    return place(raw.nodes[block.nodes[0]].mean(axis=0))
