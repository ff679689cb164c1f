"""Nodes of the mesh whose motion is wanted: probes, points that envelopes cover, floors, waves."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from impactfem.building.mesh import BuildingMesh, Mark, Part, parse_group, place, side_lengths
from impactfem.case import Building3D
from impactfem.case.devices import chosen
from impactfem.case.transient import OUTSIDE
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import Fault, InputError

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


def checked_probes(building: Building3D, mesh: BuildingMesh) -> list[Probe]:
    """The probes of a building: those that are always there, and those of the case.

    InputError with a fault for each probe that is outside the building, or whose group the mesh
    has not.
    """
    probes, faults = standard_probes(mesh, building.wave_floor), []
    # What is nearer to a node than half a side of a triangle is taken for the node.
    farthest = max(OUTSIDE, 0.5 * float(side_lengths(mesh.nodes, mesh.triangles).mean()))
    tree = cKDTree(mesh.nodes)
    for index, one in building.numbered_probes:
        found, wrong, key = [], "", ".group"
        if one.group is not None:
            nodes = _free_nodes(mesh, one.group)
            found = [Probe(one.numbered(k), int(n)) for k, n in enumerate(nodes, start=1)]
            if not found:
                wrong = f"the probe's group {one.group} has no free nodes in this mesh"
        else:
            for name, point in one.points:
                distance, node = tree.query(point)
                found.append(Probe(name, int(node), float(distance)))
                if distance > farthest and not wrong:
                    ends = {one.point: ".point", one.start: ".from", one.end: ".to"}
                    key = ends.get(point, "")
                    wrong = (
                        f"the probe {name} at {place(np.array(point))} is outside the building: the"
                        f" nearest node, at {place(mesh.nodes[node])}, is {distance:.3g} m away"
                    )
        if wrong:
            faults.append(Fault(building.case.path, f"transient.probes[{index}]{key}", None, wrong))
        probes += found
    if faults:
        raise InputError(faults)
    return probes


def _free_nodes(mesh: BuildingMesh, group: str) -> Index:
    """The free nodes of a physical group, ascending; none where the mesh has no such group."""
    named = parse_group(group)
    if isinstance(named, Mark) and named.kind == "centre" and named.level in mesh.centres:
        return np.array([mesh.centres[named.level]])
    if isinstance(named, Mark) and named.kind == "edge" and named.level in mesh.edges:
        return np.unique(mesh.edges[named.level])
    for parts, cells, part in (
        (mesh.shell_parts, mesh.triangles, mesh.triangle_part),
        (mesh.beam_parts, mesh.lines, mesh.line_part),
    ):
        if isinstance(named, Part) and named in parts:
            return np.setdiff1d(np.unique(cells[part == parts.index(named)]), mesh.base)
    return np.zeros(0, dtype=np.int64)


def standard_probes(mesh: BuildingMesh, across: int | None = None) -> list[Probe]:
    """The points that are always there.

    The mass centre of each floor, the middle of its impact edge, and on one floor, the top one when
    None, a line from the middle of the impact edge to the opposite edge, at right angles to it
    (figure 14).
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
    across = 1 - mesh.edge_axis(floor)
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


@dataclass(frozen=True)
class CoveredPoints:
    """Points of the mesh."""

    names: tuple[str, ...]  #: Of the probes.
    nodes: tuple[int, ...]  #: Their nodes.
    #: Of each anchor of the devices, numbers of the points that it covers.
    of_anchor: tuple[tuple[int, ...], ...]


def covered_points(building: Building3D, mesh: BuildingMesh) -> CoveredPoints:
    """Find the points that the devices of a building ask for.

    InputError where the mesh has none of the probes of a name or a pattern, or a probe
    of the case is not in the mesh.
    """
    patterns = [
        (f"devices[{index}]", anchor.envelope)
        for index, device in building.numbered_devices
        for anchor in device.anchor_points
    ]
    if building.transient is None or not any(wanted for _, wanted in patterns):
        return CoveredPoints((), (), tuple(() for _ in patterns))
    probes = {one.name: one.node for one in checked_probes(building, mesh)}
    faults = [
        Fault(
            building.case.path, f"{key}.envelope", pattern, "expected a probe that is in the mesh"
        )
        for key, wanted in patterns
        for pattern in wanted
        if not chosen(list(probes), [pattern])
    ]
    if faults:
        raise InputError(faults)
    names = chosen(list(probes), [p for _, wanted in patterns for p in wanted])
    return CoveredPoints(
        names=tuple(names),
        nodes=tuple(probes[name] for name in names),
        of_anchor=tuple(
            tuple(names.index(name) for name in chosen(names, wanted)) for _, wanted in patterns
        ),
    )


@dataclass(frozen=True, eq=False)
class MotionGrid:
    """Triangles and lines with their own numbering of nodes."""

    nodes: Index  #: Their nodes in the mesh, ascending, shape (n,).
    points: Array  #: Coordinates, shape (n, 3) [m].
    #: Indices of `nodes`, shape (m, 3), or (m, 6) with the mid nodes 01, 12 and 20.
    triangles: Index
    lines: Index  #: Nodes of the lines, shape (l, 2), or (l, 3) with the mid node last.

    @property
    def cells(self) -> int:
        """Number of triangles and lines."""
        return len(self.triangles) + len(self.lines)


def motion_grid(mesh: BuildingMesh, which: str) -> MotionGrid:
    """Shells and beams of a mesh at their "vertices", or at "all" nodes."""
    corners, ends = (6, 3) if which == "all" else (3, 2)
    triangles, lines = mesh.triangles[:, :corners], mesh.lines[:, :ends]
    nodes: Index = np.union1d(triangles, lines)
    return MotionGrid(
        nodes=nodes,
        points=mesh.nodes[nodes],
        triangles=np.searchsorted(nodes, triangles),
        lines=np.searchsorted(nodes, lines),
    )


def floor_vertices(mesh: BuildingMesh) -> Index:
    """Vertices of all floors, parapet included, ascending."""
    return np.asarray(np.unique(mesh.triangles[mesh.triangles_of("floor"), :3]), dtype=np.int64)


def wave_slab(mesh: BuildingMesh, floor: int | None = None) -> tuple[Index, Index]:
    """Triangles of a floor's slab, and all of its nodes; of the top floor when None."""
    flat = mesh.slab(mesh.floors[-1] if floor is None else floor)
    return flat, np.unique(mesh.triangles[flat])


def recorded_nodes(mesh: BuildingMesh, probes: Index, floor: int | None = None) -> Index:
    """All nodes whose motion is recorded: probes, floors, and those of the waves on a floor."""
    every = np.concatenate([probes, floor_vertices(mesh), wave_slab(mesh, floor)[1]])
    return np.asarray(np.unique(every), dtype=np.int64)
