"""Read a mesh of gmsh: a building's, whose groups follow the scheme, or one of any groups."""

from __future__ import annotations

import hashlib
import os
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from impactfem.building.mesh import (
    SCHEME,
    BuildingMesh,
    Mark,
    Part,
    joined_cells,
    parse_group,
    place,
    sides,
)
from impactfem.building.mesh_checks import check_mesh
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import Fault, InputError
from impactfem.system.executor import read_in_own_process
from impactfem.system.files import LARGEST_MESH, private_copy, read_bytes

EXPECTED = "a mesh of gmsh (.msh, format 2 or 4)"
_KINDS = {0: "points", 1: "lines", 2: "surfaces", 3: "volumes"}
_SECOND_ORDER = {0: "Point", 1: "Line 3", 2: "Triangle 6"}
_FIRST_ORDER = ("Line 2", "Triangle 3", "Quadrilateral 4")
_DIMENSIONS = {"edge": (1,), "centre": (0,), "base": (0, 1)}


def read_mesh(path: Path) -> BuildingMesh:
    """Read a mesh whose physical groups follow the scheme of docs/mesh-groups.md, and check it.

    gmsh, format 2 or 4, text or binary, of second order; it runs in a process of its own. Not
    collective.

    Raises:
        InputError: The file is not such a mesh, a group is missing or unknown, or the mesh does
            not hold together; every fault names its group and a place.
    """
    return _read_mesh(path, hashlib.sha256(_content(path)).hexdigest())


@lru_cache(maxsize=2)
def _read_mesh(path: Path, digest: str) -> BuildingMesh:
    # Kept: each stage of the 3D building needs its mesh, and a process of gmsh takes a second.
    mesh = assemble(read_in_own_process(read_raw, path, EXPECTED), path)
    check_mesh(mesh, path)
    return mesh


@dataclass(frozen=True, eq=False)
class Groups:
    """A mesh file by the names of its physical groups."""

    points: Array  #: Coordinates, shape (n, 3) [m].
    #: Points of the cells of each group, those of its highest dimension, shape (m, points a cell):
    #: 1 for points, 2 or 3 for lines, 3 or 6 for triangles.
    cells: dict[str, Index]
    nodes: dict[str, Index]  #: All points of each group, ascending.


def read_groups(path: Path | str) -> Groups:
    """Read a mesh of gmsh, of first or second order, whose physical groups have any names.

    gmsh runs in a process of its own. Not collective.

    Raises:
        InputError: The file is no such mesh, or a group has cells of several shapes.
    """
    raw = read_in_own_process(read_raw, Path(path), EXPECTED)
    faults, cells, nodes = [], {}, {}
    for group in dict.fromkeys(group for block in raw.blocks for group in block.groups):
        blocks = [block for block in raw.blocks if group in block.groups]
        nodes[group] = np.unique(np.concatenate([block.nodes.ravel() for block in blocks]))
        highest = [b for b in blocks if b.dimension == max(block.dimension for block in blocks)]
        kinds = sorted({block.kind for block in highest})
        if len(kinds) > 1:
            faults.append(
                Fault(path, group, ", ".join(kinds), "expected one kind of cells in a group")
            )
        else:
            cells[group] = np.concatenate([block.nodes for block in highest])
    if faults:
        raise InputError(faults)
    return Groups(points=raw.nodes, cells=cells, nodes=nodes)


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """The module gmsh between `initialize` and `finalize`; the same for every user and machine.

    To be used inside `in_own_process`; the working folder is another one afterwards.
    """
    import gmsh

    os.chdir("/")  # gmsh and its PETSc would read settings in the working folder
    # The user's own options are not read: they would change the mesh.
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        yield gmsh
    finally:
        gmsh.finalize()


@dataclass(frozen=True, eq=False)
class Block:
    """The cells of one type on one entity."""

    dimension: int  #: 0 to 3.
    kind: str  #: gmsh's name of the cells' type, as ``Triangle 6``.
    #: Indices of the cells' nodes in the mesh's coordinates, shape (cells, nodes a cell).
    nodes: Index
    #: Names of the physical groups of the entity; ``number 7`` for one without a name.
    groups: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class RawMesh:
    """All nodes and cells of a file."""

    nodes: Array  #: Coordinates in ascending order of gmsh's tags, shape (n, 3).
    blocks: tuple[Block, ...]  #: The cells.
    #: Name and dimension of each physical group, also of those without cells.
    groups: tuple[tuple[str, int], ...]


def _content(path: Path) -> bytes:
    """Read the bytes of a mesh file; InputError where it cannot be read."""
    content = read_bytes(path, EXPECTED, LARGEST_MESH)
    if isinstance(content, Fault):
        raise InputError([content])
    return content


def read_raw(path: Path) -> RawMesh:
    """Read a file with gmsh, which must be a mesh; to be run inside `in_own_process`.

    gmsh reads a copy in a new folder, because it runs the script ``<mesh>.opt`` next to a mesh.
    ImpactfemError where there is no space for the copy.
    """
    content = _content(path)
    head = content[:65536]
    # gmsh runs a file that begins with anything else as a script.
    start = head.find(b"$MeshFormat") if head.startswith((b"$MeshFormat", b"$Comments")) else -1
    words = head[start:].split()[1:2] if start >= 0 else []
    version = words[0].decode(errors="replace") if words else ""
    if not version:
        mark = ", but a byte order mark at its beginning" * head.startswith(b"\xef\xbb\xbf")
        raise InputError([Fault(path, "", None, f"no $MeshFormat{mark}; expected {EXPECTED}")])
    if version.split(".")[0] not in ("2", "4"):
        raise InputError([Fault(path, "$MeshFormat", version, f"expected {EXPECTED}")])
    try:
        with private_copy(content, "mesh.msh") as copy, gmsh_session() as gmsh:
            return _read(gmsh, copy, path)
    except UnicodeDecodeError as error:  # gmsh gives names as they stand there
        fault = Fault(path, "", None, f"a name that is not UTF-8; expected {EXPECTED}")
        raise InputError([fault]) from error


def _read(gmsh: Any, copy: Path, path: Path) -> RawMesh:
    """Read the copy of a mesh file, which faults name by its own path."""

    def refused(reason: object) -> InputError:
        words = str(reason).replace(str(copy), path.name)
        return InputError([Fault(path, "", None, f"{words}; expected {EXPECTED}")])

    gmsh.logger.start()
    try:
        gmsh.merge(str(copy))
    except Exception as error:  # gmsh raises nothing more special
        raise refused(error) from error
    errors = [line for line in gmsh.logger.get() if line.startswith("Error")]
    if errors:
        raise refused(errors[0])
    model = gmsh.model
    tags, nodes, _ = model.mesh.getNodes()
    order = np.argsort(tags)
    tags, nodes = tags[order], nodes.reshape(-1, 3)[order]
    names = {
        (dimension, tag): model.getPhysicalName(dimension, tag) or f"number {tag}"
        for dimension, tag in model.getPhysicalGroups()
    }
    blocks = []
    for dimension, entity in model.getEntities():
        of_entity = model.getPhysicalGroupsForEntity(dimension, entity)
        groups = tuple(sorted({names[dimension, int(tag)] for tag in of_entity}))
        kinds, cells, members = model.mesh.getElements(dimension, entity)
        for kind, numbers, flat in zip(kinds, cells, members, strict=True):
            indices = np.searchsorted(tags, flat).reshape(len(numbers), -1).astype(np.int64)
            if len(groups) > 1:
                # Format 2 repeats a cell for each group that it is in.
                _, first = np.unique(indices, axis=0, return_index=True)
                indices = indices[np.sort(first)]
            name = model.mesh.getElementProperties(kind)[0]
            blocks.append(Block(dimension, name, indices, groups))
    every = tuple((name, dimension) for (dimension, _), name in sorted(names.items()))
    return RawMesh(np.ascontiguousarray(nodes), tuple(blocks), every)


def assemble(raw: RawMesh, file: Path) -> BuildingMesh:
    """Make the building's mesh from the cells of a file, which faults name.

    Raises:
        InputError: A group is missing, unknown or of the wrong dimension; cells are of first
            order, in no group or in two; an edge, a centre or the base is not on the structure.
    """
    groups = _Sorted(raw, file)
    groups.check_names()
    groups.sort()
    if not groups.faults:
        groups.check_levels()
    groups.check()
    parts = sorted(groups.parts)
    shell_parts = tuple(part for part in parts if part.dimension == 2)
    beam_parts = tuple(part for part in parts if part.dimension == 1)
    cells = {part: np.concatenate(groups.parts[part]) for part in parts}
    triangles, triangle_part = joined_cells([cells[part] for part in shell_parts], 6)
    lines, line_part = joined_cells([cells[part] for part in beam_parts], 3)
    # Nodes that shells and beams use are numbered from 0 in the file's order.
    used = np.unique(np.concatenate([triangles.ravel(), lines.ravel()]))
    number = np.full(len(raw.nodes), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    floor_of = np.array([p.level if p.family == "floor" else 0 for p in shell_parts])[triangle_part]
    slabs = {k: triangles[floor_of == k] for k in sorted(groups.levels("floor"))}
    edges = {k: number[groups.edge(k, slabs[k])] for k in slabs}
    centres = {k: int(number[groups.centre(k, slabs[k])]) for k in slabs}
    base = groups.base(number)
    groups.check()
    return BuildingMesh(
        nodes=raw.nodes[used],
        triangles=number[triangles],
        triangle_part=triangle_part.astype(np.int32),
        lines=number[lines],
        line_part=line_part.astype(np.int32),
        shell_parts=shell_parts,
        beam_parts=beam_parts,
        edges=edges,
        centres=centres,
        base=base,
        dropped=raw.nodes[np.setdiff1d(np.arange(len(raw.nodes)), used)],
    )


class _Sorted:
    """The cells of a file by part and mark, with gmsh's nodes; collects what is wrong with them."""

    def __init__(self, raw: RawMesh, file: Path) -> None:
        self.raw, self.file = raw, file
        self.parts: dict[Part, list[Index]] = defaultdict(list)
        self.marks: dict[Mark, list[Index]] = defaultdict(list)
        self.faults: list[Fault] = []

    def fault(self, group: str, expected: str, value: object | None = None) -> None:
        self.faults.append(Fault(self.file, group, value, expected))

    def check(self) -> None:
        if self.faults:
            raise InputError(self.faults)

    def levels(self, *families: str) -> set[int]:
        return {part.level for part in self.parts if part.family in families}

    def check_names(self) -> None:
        for group, dimension in self.raw.groups:
            meaning = parse_group(group)
            if meaning is None:
                self.fault(group, f"unknown physical group; expected {SCHEME}")
                continue
            allowed: tuple[int, ...] = (
                (meaning.dimension,) if isinstance(meaning, Part) else _DIMENSIONS[meaning.kind]
            )
            if dimension not in allowed:
                expected = " or ".join(_KINDS[d] for d in allowed)
                self.fault(group, f"a group of {_KINDS[dimension]}; expected {expected}")

    def sort(self) -> None:
        """Sort the cells by part and mark; what cannot be sorted is a fault."""
        nowhere: dict[int, list[Block]] = defaultdict(list)
        first_order: list[Block] = []
        for block in self.raw.blocks:
            meanings = [meaning for group in block.groups if (meaning := parse_group(group))]
            parts = [meaning for meaning in meanings if isinstance(meaning, Part)]
            where = f"{len(block.nodes)} cells, the first at {self._first_place(block)}"
            if block.kind in _FIRST_ORDER:
                first_order.append(block)
            elif block.kind != _SECOND_ORDER.get(block.dimension):
                expected = f"{where}; expected triangles with 6 nodes and lines with 3"
                self.fault(", ".join(block.groups), expected, block.kind)
            elif len(parts) > 1:
                self.fault(
                    ", ".join(part.group for part in parts),
                    f"{where}: in two groups; expected one each (in format 2 groups share no "
                    "entity number)",
                )
            elif block.dimension > 0 and not block.groups:
                nowhere[block.dimension].append(block)
            for meaning in meanings:
                if isinstance(meaning, Part):
                    self.parts[meaning].append(block.nodes)
                else:
                    self.marks[meaning].append(block.nodes)
        if first_order:
            self.fault(
                ", ".join(first_order[0].groups),
                f"{sum(len(block.nodes) for block in first_order)} first-order cells, the first at "
                f"{self._first_place(first_order[0])}; expected a mesh of second order "
                "(gmsh -order 2, or Mesh.ElementOrder = 2) of triangles and lines",
            )
        for dimension, blocks in sorted(nowhere.items()):
            self.fault(
                "",
                f"{sum(len(block.nodes) for block in blocks)} cells of {_KINDS[dimension]} without "
                f"a physical group, the first at {self._first_place(blocks[0])}; expected every "
                "part in a group (and a file saved without Mesh.SaveAll or partitions)",
            )

    def check_levels(self) -> None:
        """Groups that every building needs, and levels that do not go together."""
        floors, storeys = self.levels("floor"), self.levels("storey", "column")
        top = max(floors, default=0)
        if not floors:
            self.fault("floor_1", "missing group; expected the slabs as floor_<k>")
        if not storeys:
            expected = "missing group; expected walls as storey_<k> or columns as column_<k>"
            self.fault("storey_1", expected)
        if Mark("base") not in self.marks:
            self.fault("base", "missing group; expected the lines or points that are clamped")
        below = 0
        for k in sorted(floors):
            if k > below + 1:
                first, last = f"floor_{below + 1}", f"floor_{k - 1}"
                groups = first if first == last else f"{first} to {last}"
                self.fault(groups, f"missing group; floor_{k} is above it")
            below = k
            if storeys and k not in storeys:
                expected = f"missing group; expected walls or columns below floor_{k}"
                self.fault(f"storey_{k}", expected)
            for kind, what in (
                ("edge", "the lines of the slab's edge that faces the other building"),
                ("centre", "the node at the floor's mass centre"),
            ):
                if Mark(kind, k) not in self.marks:
                    self.fault(f"{kind}_{k}", f"missing group; expected {what}")
        named: list[Part | Mark] = [part for part in self.parts if part.family != "floor"]
        named += self.marks
        for meaning in sorted(named, key=lambda meaning: meaning.group):
            if floors and meaning.level > top:
                expected = f"expected a number from 1 to {top}, that of the top floor"
                self.fault(meaning.group, expected, meaning.level)

    def edge(self, k: int, slab: Index) -> Index:
        lines: Index = np.concatenate(self.marks[Mark("edge", k)])
        ordered = lines.copy()
        ordered[:, :2].sort(axis=1)
        known = set(map(tuple, sides(slab).tolist()))
        stray = [line for line in ordered.tolist() if tuple(line) not in known]
        if stray:
            expected = f"expected lines that are sides of triangles of floor_{k}"
            self._refuse(Mark("edge", k), stray[0][2], expected)
        return lines

    def centre(self, k: int, slab: Index) -> int:
        mark = Mark("centre", k)
        nodes = self._nodes(mark)
        if len(nodes) != 1:
            self._refuse(mark, int(nodes[1]), f"{len(nodes)} nodes; expected one")
        elif nodes[0] not in slab:
            expected = f"expected a node of floor_{k} (in gmsh: a point embedded in the slab)"
            self._refuse(mark, int(nodes[0]), expected)
        return int(nodes[0])

    def base(self, number: Index) -> Index:
        nodes = self._nodes(Mark("base"))
        numbers = number[nodes]
        if np.any(numbers < 0):
            expected = "expected nodes of walls, columns, slabs or beams"
            self._refuse(Mark("base"), int(nodes[np.argmax(numbers < 0)]), expected)
        return np.sort(numbers)

    def _nodes(self, mark: Mark) -> Index:
        nodes: Index = np.concatenate([cells.ravel() for cells in self.marks[mark]])
        return np.unique(nodes)

    def _refuse(self, mark: Mark, node: int, expected: str) -> None:
        self.fault(mark.group, f"at {place(self.raw.nodes[node])}: {expected}")

    def _first_place(self, block: Block) -> str:
        return place(self.raw.nodes[block.nodes[0]].mean(axis=0))
