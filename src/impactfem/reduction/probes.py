"""Where the response is looked at: points of the building, as nodes of its mesh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from impactfem.building.mesh import BuildingMesh, Mark, Part, parse_group, place, side_lengths
from impactfem.case import Case
from impactfem.case.transient import OUTSIDE
from impactfem.case.transient import Probe as CaseProbe
from impactfem.system.errors import Fault, InputError, SolutionError

Array = NDArray[np.float64]

LINE_POINTS = 9
"""Points of the line across a floor (figure 14 of the paper)."""


@dataclass(frozen=True)
class Probe:
    """A node whose motion is recorded."""

    name: str  #: Its name.
    node: int  #: The node.
    distance: float = 0.0  #: From where it was requested to the node [m].
    #: "centre" of a floor, middle of its impact "edge", on the "line" across it, or "point".
    kind: str = "point"
    floor: int = 0  #: Number of that floor; 0 for a point.


def case_probes(
    mesh: BuildingMesh, asked: Sequence[CaseProbe], across: int | None = None
) -> list[Probe]:
    """The probes that are always there, and those that the case asks for.

    Args:
        mesh: The mesh.
        asked: Probes of the case.
        across: Number of the floor with the line; the top floor when None.

    Raises:
        SolutionError: A probe is outside the building, or the mesh has no such group.
    """
    probes = standard_probes(mesh, across)
    farthest = _farthest(mesh)
    for one in asked:
        probes += _asked(mesh, one, farthest)
    return probes


def checked_probes(case: Case, mesh: BuildingMesh) -> list[Probe]:
    """The probes of a case: those that are always there, and its own.

    Args:
        case: A case with a section for the response in time.
        mesh: The mesh of its building.

    Raises:
        InputError: One fault for each probe that is outside the building, or whose group the mesh
            has not.
    """
    probes, faults = standard_probes(mesh, case.wave_floor), []
    farthest = _farthest(mesh)
    for index, one in case.numbered_probes:
        try:
            probes += _asked(mesh, one, farthest)
        except SolutionError as error:
            faults.append(Fault(case.path, f"transient.probes[{index}]", None, str(error)))
    if faults:
        raise InputError(faults)
    return probes


def _farthest(mesh: BuildingMesh) -> float:
    return max(OUTSIDE, 0.5 * float(side_lengths(mesh.nodes, mesh.triangles).mean()))


def _asked(mesh: BuildingMesh, one: CaseProbe, farthest: float) -> list[Probe]:
    """The probes of one table of the case."""
    if one.group is not None:
        nodes = _group(mesh, one.group)
        return [Probe(one.numbered(k), int(n)) for k, n in enumerate(nodes, start=1)]
    return [nearest_node(mesh, name, np.array(p), farthest) for name, p in one.points]


def _group(mesh: BuildingMesh, group: str) -> NDArray[np.int64]:
    """The free nodes of a physical group, ascending."""
    named = parse_group(group)
    if isinstance(named, Mark) and named.kind == "centre" and named.level in mesh.centres:
        return np.array([mesh.centres[named.level]])
    if isinstance(named, Mark) and named.kind == "edge" and named.level in mesh.edges:
        return np.unique(mesh.edges[named.level])
    if isinstance(named, Part):
        for parts, cells, part in (
            (mesh.shell_parts, mesh.triangles, mesh.triangle_part),
            (mesh.beam_parts, mesh.lines, mesh.line_part),
        ):
            chosen = [k for k, one in enumerate(parts) if one == named]
            if chosen:
                nodes = np.unique(cells[part == chosen[0]])
                return np.setdiff1d(nodes, mesh.base)
    raise SolutionError(f"the probe's group {group} has no free nodes in this mesh")


def nearest_node(mesh: BuildingMesh, name: str, point: Array, farthest: float) -> Probe:
    """The probe nearest to a point.

    Args:
        mesh: The mesh.
        name: Name of the probe.
        point: Coordinates [m].
        farthest: Largest distance that is taken for the point itself [m].

    Raises:
        SolutionError: The point is outside the building; names the nearest node.
    """
    distance, node = cKDTree(mesh.nodes).query(np.asarray(point))
    if distance > farthest:
        raise SolutionError(
            f"the probe {name} at {place(np.asarray(point))} is outside the building: the nearest "
            f"node, at {place(mesh.nodes[node])}, is {distance:.3g} m away"
        )
    return Probe(name, int(node), float(distance))


def standard_probes(mesh: BuildingMesh, across: int | None = None) -> list[Probe]:
    """The points that are always there.

    The mass centre of each floor, the middle of its impact edge, and on one floor a line from the
    middle of the impact edge to the opposite edge, at right angles to it (figure 14).

    Args:
        mesh: The mesh.
        across: Number of the floor with the line; the top floor when None.
    """
    probes = [Probe(f"centre_{k}", mesh.centres[k], 0.0, "centre", k) for k in mesh.floors]
    probes += [
        Probe(f"edge_{k}", _middle_of_edge(mesh, k), 0.0, "edge", k) for k in sorted(mesh.edges)
    ]
    return [*probes, *_line(mesh, mesh.floors[-1] if across is None else across)]


def _middle_of_edge(mesh: BuildingMesh, floor: int) -> int:
    nodes = np.unique(mesh.edges[floor])
    where = mesh.nodes[nodes]
    middle = 0.5 * (where.min(axis=0) + where.max(axis=0))
    return int(nodes[np.argmin(np.linalg.norm(where - middle, axis=1))])


def _line(mesh: BuildingMesh, floor: int) -> list[Probe]:
    """Nodes of the floor's slab nearest to the points of the line; numbered from the edge."""
    nodes = np.unique(mesh.triangles[mesh.triangles_of("floor", floor)])
    start = mesh.nodes[_middle_of_edge(mesh, floor)]
    level = np.abs(mesh.nodes[nodes, 2] - start[2]) < 1e-6 * max(1.0, abs(start[2]))
    nodes = nodes[level]
    where = mesh.nodes[nodes]
    edge = np.ptp(mesh.nodes[np.unique(mesh.edges[floor])], axis=0)
    across = 1 - int(np.argmax(edge[:2]))
    low, high = where[:, across].min(), where[:, across].max()
    far = high if abs(start[across] - low) < abs(start[across] - high) else low
    tree = cKDTree(where)
    probes = []
    for number, share in enumerate(np.linspace(0.0, 1.0, LINE_POINTS), start=1):
        point = start.copy()
        point[across] += share * (far - start[across])
        distance, found = tree.query(point)
        probes.append(Probe(f"line_{number}", int(nodes[found]), float(distance), "line", floor))
    return probes
