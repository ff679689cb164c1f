"""Impact forces that fit the building: whose they are, long enough, and each on a floor's edge."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from impactfem.building.mesh import BuildingMesh, outward_normal
from impactfem.case import Case, Contact
from impactfem.case.base import nearest
from impactfem.case.contact_checks import (
    ALIGNED,
    StruckEdge,
    normal_fault,
    offset_fault,
    side_of,
    words_of,
)
from impactfem.case.contacts import Vector
from impactfem.case.motions import read_force_table
from impactfem.coupling.force_history import ForceHistory, PairEnds
from impactfem.reduction.loads import EdgeForce
from impactfem.system.errors import Fault, InputError
from impactfem.system.log import LOGGER

Array = NDArray[np.float64]

LOAD = "load"
"""How the columns of loads are named, before their number."""


@dataclass(frozen=True, eq=False)
class PairEnd:
    """One end of a pair."""

    building: str  #: Its building; empty for a rigid wall.
    floor: int  #: Number of the floor, or of the one above for a point inside a storey.
    relative_height: float | None  #: Height in the storey, 0 to 1; None for a point of a floor.
    outward: Array  #: Unit vector towards the other end, shape (3,).
    offset: Vector | None = None  #: From the stick's axis to it [m]; None where it is not known.

    @property
    def place(self) -> str:
        """The end in words."""
        if self.building == "":
            return "a rigid wall"
        if self.relative_height is None:
            return f"floor {self.floor} of {self.building}"
        return f"storey {self.floor} of {self.building} at {self.relative_height:g} of its height"


Ends = dict[int, tuple[PairEnd, PairEnd]]


def checked_forces(
    history: ForceHistory,
    path: Path,
    case: Case,
    mesh: BuildingMesh,
    duration: float,
    inputs: str = "",
) -> tuple[ForceHistory, list[EdgeForce]]:
    """The impact forces on the building of the 3D model, after every check that can be made.

    The pairs are those of the case. In a case without contacts they are those of the file, which
    says then what they are between. A file of this program that was made from anything else than
    `inputs`, the hash of what this run's sticks depend on, is used with a warning; it is empty
    where not known.

    Gives the history of the pairs that touch the building, and what a positive force of each does
    to it: it pushes the edge of a floor inwards.

    Raises:
        InputError: With every fault of the forces, over the duration that is to be computed [s].
        ValueError: The case has no structure.
    """
    ends, faults = pair_ends(history, path, case, duration)
    building = _three_d(case)
    mine = {j: end for j, pair in ends.items() for end in pair if end.building == building}
    edges = _struck_edges(mesh)
    for j, end in mine.items():
        faults += _end_faults(path, history.pairs[j], end, edges, case)
    if faults:
        raise InputError(faults)
    # The pairs of forces that were made from another case are those of this one.
    if inputs and history.inputs:
        other = history.inputs != inputs
    else:
        other = history.case_hash not in ("", case.content_hash())
    if other:
        LOGGER.warning("warning: %s was made from another case, or by another version", path)
    pushed = [_edge_force(end.floor, edges[end.floor].outward) for end in mine.values()]
    return history.of(list(mine)), pushed


def _three_d(case: Case) -> str:
    """The building of the 3D model."""
    if case.structure is None:
        raise ValueError("a case without a structure has no edges that forces could act on")
    return case.structure.building


def pair_ends(
    history: ForceHistory, path: Path, case: Case, duration: float
) -> tuple[Ends, list[Fault]]:
    """Both ends of the pairs, by their index; what is wrong with these or with the length.

    As the contacts of the case say, or the file, in a case without contacts; whatever the mesh is.
    """
    building = _three_d(case)
    contacts = {contact.name: contact for contact in case.contacts}
    ends: Ends = {}
    faults: list[Fault] = []
    if contacts:
        for j, name in enumerate(history.pairs):
            if name not in contacts:
                expected = f"expected a pair of the case; {nearest(name, list(contacts))}"
                faults.append(Fault(path, "pair", name, expected))
                continue
            ends[j] = _ends_of_contact(contacts[name])
            faults += _contradictions(history, path, j, ends[j])
        for name, contact in contacts.items():
            touches = building in (contact.a.building, contact.b.building)
            if touches and name not in history.pairs:
                expected = f"the forces of the pair {name} of the case, which touches {building}"
                faults.append(Fault(path, "pair", None, expected))
    elif history.pairs:
        ends, faults = _ends_by_file(history, path, building)
    # The last step of forces may be cut, as whole steps make no duration.
    step = float(history.time[-1]) / (len(history.time) - 1)
    if history.time[-1] < duration - step:
        expected = f"forces up to {duration:g} s, which is to be computed"
        faults.append(Fault(path, "time", f"up to {history.time[-1]:g} s", expected))
    return ends, faults


def with_floor_forces(
    case: Case, mesh: BuildingMesh, forces: ForceHistory, edges: list[EdgeForce]
) -> tuple[ForceHistory, list[EdgeForce]]:
    """Impact forces with those of the loads of the case on the building of the 3D model.

    Args:
        case: The case, with a structure.
        mesh: The mesh of its building.
        forces: The impact forces on the building.
        edges: What each does to it, in their order.

    Returns:
        Both with a column and an edge for each load on the building.

    Raises:
        InputError: A load is not at right angles to an edge, or on a floor without one.
        ValueError: The case has no structure.
    """
    three_d = _three_d(case)
    outward = {floor: outward_normal(mesh, floor) for floor in mesh.edges}
    names, columns, every = list(forces.pairs), [forces.force], list(edges)
    faults: list[Fault] = []
    for index, loads in enumerate(case.loads):
        table = read_force_table(loads.file, faults)
        if table is None:
            continue
        values, direction = table.at(forces.time), np.array(loads.direction)
        for k, (building, floor) in enumerate(table.floors):
            if building != three_d:
                continue
            along = float(direction @ outward[floor]) if floor in outward else 0.0
            if abs(along) < 1.0 - ALIGNED:
                there = words_of(outward[floor]) if floor in outward else "which has none"
                expected = (
                    f"expected a direction at right angles to the edge of floor {floor}, {there}: "
                    "forces act on the edges of slabs in the 3D model"
                )
                key = f"loads[{index}].direction"
                faults.append(Fault(case.path, key, words_of(direction), expected))
                continue
            names.append(f"{LOAD} {index}, floor {floor}")
            # A positive amplitude pushes the edge inwards.
            columns.append(-along * values[:, [k]])
            every.append(_edge_force(floor, outward[floor]))
    if faults:
        raise InputError(faults)
    joined = replace(forces, pairs=tuple(names), force=np.hstack(columns), ends=PairEnds())
    return (joined if len(every) > len(edges) else forces), every


def check_contacts(case: Case, mesh: BuildingMesh) -> None:
    """See that contacts, and floors that may be hit, have edges in the 3D building of a case.

    Raises:
        InputError: With every fault.
        ValueError: The case has no structure.
    """
    building = _three_d(case)
    edges = _struck_edges(mesh)
    faults = [
        fault
        for contact in case.contacts
        for end in _ends_of_contact(contact)
        if end.building == building
        for fault in _end_faults(case.path, contact.name, end, edges, case)
    ]
    named = () if case.transient is None else case.transient.floors or ()
    bare = [str(floor) for floor in named if floor not in edges]
    if bare:
        known = ", ".join(map(str, sorted(edges))) or "none"
        expected = (
            f"floor {', '.join(bare)} has no edge (group edge_K) in the mesh, which has {known}"
        )
        faults.append(Fault(case.path, "transient.floors", list(named), expected))
    if faults:
        raise InputError(faults)


def _struck_edges(mesh: BuildingMesh) -> dict[int, StruckEdge]:
    """The edges of a mesh that can be struck, by floor."""
    edges = {}
    for floor in mesh.edges:
        x, y, z = (float(component) for component in outward_normal(mesh, floor))
        slab = mesh.nodes[np.unique(mesh.triangles[mesh.triangles_of("floor", floor)]), :2]
        (x0, y0), (x1, y1) = slab.min(axis=0).tolist(), slab.max(axis=0).tolist()
        line = mesh.nodes[np.unique(mesh.edges[floor]), 0 if abs(y) > abs(x) else 1]
        words = f"the edge of floor {floor}, group edge_{floor}, faces {side_of((x, y, z))}"
        ends = (float(line.min()), float(line.max()))
        edges[floor] = StruckEdge((x, y, z), ends, (x0, y0), (x1, y1), words)
    return edges


def _edge_force(floor: int, outward: Iterable[float]) -> EdgeForce:
    # The edge's own normal, not the pair's: all pairs of a floor are one load then.
    x, y, z = (-component + 0.0 for component in outward)
    return EdgeForce(f"floor {floor}", floor, (x, y, z))


def _ends_of_contact(contact: Contact) -> tuple[PairEnd, PairEnd]:
    normal = np.array(contact.normal)
    a, b = (
        PairEnd(
            point.building,
            point.floor if point.floor is not None else int(point.storey or 0),
            point.relative_height,
            outward,
            point.offset,
        )
        for point, outward in ((contact.a, normal), (contact.b, -normal))
    )
    return a, b


def _ends_by_file(history: ForceHistory, path: Path, building: str) -> tuple[Ends, list[Fault]]:
    """Both ends of the pairs as the file says, in a case without contacts; what is wrong."""
    said = history.ends
    buildings, floors = (said.building_a, said.building_b), (said.floor_a, said.floor_b)
    if None in buildings or None in floors or said.normal is None:
        names = ("building_a", "building_b", "floor_a", "floor_b", "normal")
        missing = ", ".join(name for name in names if getattr(said, name) is None)
        expected = "what each pair is between (NetCDF only): the case has no contacts to say it"
        return {}, [Fault(path, missing, None, expected)]
    heights = (said.relative_height_a, said.relative_height_b)
    ends: Ends = {}
    faults: list[Fault] = []
    for j, name in enumerate(history.pairs):
        a, b = (
            PairEnd(
                names[j],
                numbers[j],
                None if height is None or math.isnan(height[j]) else float(height[j]),
                sign * said.normal[j],
            )
            for names, numbers, height, sign in zip(
                buildings, floors, heights, (1.0, -1.0), strict=True
            )
            if names is not None and numbers is not None
        )
        if a.building == b.building:
            expected = "another building than that of a, or none for a rigid wall"
            faults.append(Fault(path, f"pair {name}, building_b", b.building, expected))
        else:
            ends[j] = (a, b)
    if not faults and all(building not in (a.building, b.building) for a, b in ends.values()):
        found = sorted({end.building for pair in ends.values() for end in pair} - {""})
        expected = f"expected a pair that touches {building}, the building of the 3D model"
        faults.append(Fault(path, "building_a, building_b", found, expected))
    return ends, faults


def _contradictions(
    history: ForceHistory, path: Path, j: int, ends: tuple[PairEnd, PairEnd]
) -> Iterator[Fault]:
    """What the file says of a pair, and the case says otherwise."""
    pair = f"pair {history.pairs[j]}"
    for side, end in zip("ab", ends, strict=True):
        for name, wanted in (("building", end.building), ("floor", end.floor)):
            said = getattr(history.ends, f"{name}_{side}")
            if said is not None and said[j] != wanted:
                yield Fault(path, f"{pair}, {name}_{side}", said[j], f"{wanted}, as in the case")
        heights = getattr(history.ends, f"relative_height_{side}")
        height = math.nan if end.relative_height is None else end.relative_height
        if heights is not None and not np.isclose(heights[j], height, 0.0, 1e-9, equal_nan=True):
            found = "nan" if math.isnan(heights[j]) else float(heights[j])
            expected = f"expected a point of {end.place}, as in the case"
            yield Fault(path, f"{pair}, relative_height_{side}", found, expected)
    normal = history.ends.normal
    if normal is not None and np.abs(normal[j] - ends[0].outward).max() > ALIGNED:
        words = [words_of(n) for n in (ends[0].outward, normal[j])]
        yield Fault(path, f"{pair}, normal", words[1], f"{words[0]}, as in the case")


def _end_faults(
    path: Path, pair: str, end: PairEnd, edges: dict[int, StruckEdge], case: Case
) -> Iterator[Fault]:
    """Why a pair cannot act on the edge of a floor."""
    if end.relative_height is not None:
        expected = "expected a point of a floor: forces act on the edges of slabs in the 3D model"
        yield Fault(path, f"pair {pair}", end.place, expected)
        return
    if end.floor not in edges:
        known = ", ".join(map(str, sorted(edges))) or "none"
        expected = (
            f"expected a floor whose edge (group edge_{end.floor}) is in the mesh, which has "
            f"{known}"
        )
        yield Fault(path, f"pair {pair}", end.place, expected)
        return
    edge = edges[end.floor]
    x, y, z = (float(component) for component in end.outward)
    wrong = normal_fault((x, y, z), edge)
    if wrong is not None:
        key = f"pair {pair}, normal out of {end.building}"
        yield Fault(path, key, words_of((x, y, z)), wrong)
    if end.offset is not None and case.transient is not None:
        axis = case.building(end.building).axis
        aside = offset_fault(axis, end.offset, edge, case.transient.eccentricity)
        if aside is not None:
            yield Fault(path, f"pair {pair}, offset on {end.building}", end.offset, aside)
