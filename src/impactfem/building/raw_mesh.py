"""A mesh file as gmsh reads it, before anything is known of what its groups mean."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.system.errors import Fault, InputError

Ints = NDArray[np.int64]
EXPECTED = "a mesh of gmsh (.msh, format 2 or 4)"


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """The module gmsh between `initialize` and `finalize`; the same for every user and machine.

    To be used inside `in_own_process`.
    """
    import gmsh

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
    """The cells of one type on one entity.

    Args:
        dimension: 0 to 3.
        kind: gmsh's name of the cells' type, as ``Triangle 6``.
        nodes: Indices of the cells' nodes in the mesh's coordinates, shape (cells, nodes a cell).
        groups: Names of the physical groups of the entity; ``number 7`` for one without a name.
    """

    dimension: int
    kind: str
    nodes: Ints
    groups: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class RawMesh:
    """All nodes and cells of a file.

    Args:
        nodes: Coordinates in ascending order of gmsh's tags, shape (n, 3).
        blocks: The cells.
        groups: Name and dimension of each physical group, also of those without cells.
    """

    nodes: NDArray[np.float64]
    blocks: tuple[Block, ...]
    groups: tuple[tuple[str, int], ...]


def read_raw(path: Path) -> RawMesh:
    """Read a file with gmsh; to be run inside `in_own_process`.

    Raises:
        InputError: The file is not a mesh that gmsh reads.
    """
    _check_header(path)
    try:
        return _read(path)
    except UnicodeDecodeError as error:  # gmsh gives names as they stand there
        fault = Fault(path, "", None, f"a name that is not UTF-8; expected {EXPECTED}")
        raise InputError([fault]) from error


def _read(path: Path) -> RawMesh:
    with gmsh_session() as gmsh:
        gmsh.logger.start()
        try:
            gmsh.merge(str(path))
        except Exception as error:  # gmsh raises nothing more special
            raise InputError([Fault(path, "", None, f"{error}; expected {EXPECTED}")]) from error
        errors = [line for line in gmsh.logger.get() if line.startswith("Error")]
        if errors:
            raise InputError([Fault(path, "", None, f"{errors[0]}; expected {EXPECTED}")])
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
            own = model.getPhysicalGroupsForEntity(dimension, entity)
            groups = tuple(sorted({names[dimension, int(tag)] for tag in own}))
            kinds, cells, members = model.mesh.getElements(dimension, entity)
            for kind, found, flat in zip(kinds, cells, members, strict=True):
                indices = np.searchsorted(tags, flat).reshape(len(found), -1).astype(np.int64)
                if len(groups) > 1:
                    indices = _once(indices)
                name = model.mesh.getElementProperties(kind)[0]
                blocks.append(Block(dimension, name, indices, groups))
    every = tuple((name, dimension) for (dimension, _), name in sorted(names.items()))
    return RawMesh(np.ascontiguousarray(nodes), tuple(blocks), every)


def _once(cells: Ints) -> Ints:
    """Each cell once: format 2 repeats a cell for each group that it is in."""
    _, first = np.unique(cells, axis=0, return_index=True)
    return cells[np.sort(first)]


def _check_header(path: Path) -> None:
    """Refuse what gmsh would take for something else: it runs a text file as a script."""
    try:
        with path.open("rb") as stream:
            head = stream.read(65536)
    except OSError as error:
        fault = Fault(path, "", None, f"{error.strerror}; expected {EXPECTED}")
        raise InputError([fault]) from error
    # What else it begins with, gmsh would run as a script.
    start = head.find(b"$MeshFormat") if head.startswith((b"$MeshFormat", b"$Comments")) else -1
    words = head[start:].split()[1:2] if start >= 0 else []
    version = words[0].decode(errors="replace") if words else ""
    if not version:
        raise InputError([Fault(path, "", None, f"no $MeshFormat; expected {EXPECTED}")])
    if version.split(".")[0] not in ("2", "4"):
        raise InputError([Fault(path, "$MeshFormat", version, f"expected {EXPECTED}")])
