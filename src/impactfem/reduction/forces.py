"""Impact forces that fit the building: whose they are, long enough, and each on a side of it."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from impactfem.building.mesh import BuildingMesh, outward_normal
from impactfem.case import Building3D
from impactfem.case.base import nearest
from impactfem.case.facade import ALIGNED, words_of
from impactfem.case.motions import read_force_table
from impactfem.coupling.force_history import ForceHistory, PairEnds
from impactfem.coupling.given_forces import given_forces, wrong_signs
from impactfem.reduction.edge_force import EdgeForce, Shares
from impactfem.reduction.sides import Impulses, PairEnd, Sides
from impactfem.system.errors import Fault, InputError
from impactfem.system.log import LOGGER

LOAD = "load"
"""How the columns of loads are named, before their number."""


Ends = dict[int, tuple[PairEnd, PairEnd]]


def checked_forces(
    history: ForceHistory,
    path: Path,
    building: Building3D,
    mesh: BuildingMesh,
    duration: float,
    inputs: str = "",
    impulses: Impulses | None = None,
) -> tuple[ForceHistory, list[Shares]]:
    """The impact forces on a building with a 3D model, after every check that can be made.

    The pairs are those of the case. In a case without contacts they are those of the file, which
    says then what they are between. A file of this program that was made from anything else than
    `inputs`, the hash of what this run's sticks depend on, is used with a warning; it is empty
    where not known. The impulses are those of the impact on the wall, for spread `calibrated`.

    Gives the history of the pairs that touch the building, and what a positive force of each does
    to it: it pushes a side of a floor inwards.

    Raises:
        InputError: With every fault of the forces, over the duration that is to be computed [s].
    """
    ends, faults = pair_ends(history, path, building, duration)
    mine = {j: end for j, pair in ends.items() for end in pair if end.building == building.name}
    sides = Sides(building, mesh, impulses)
    shares = []
    for j, end in mine.items():
        found = sides.shares(path, history.pairs[j], end)
        if isinstance(found, Fault):
            faults.append(found)
        else:
            shares.append(found)
    if faults:
        raise InputError(faults)
    # The pairs of forces that were made from another case are those of this one.
    if inputs and history.inputs:
        other = history.inputs != inputs
    else:
        other = history.case_hash not in ("", building.case.content_hash())
    if other:
        LOGGER.warning("warning: %s was made from another case, or by another version", path)
    return history.of(list(mine)), shares


def pair_ends(
    history: ForceHistory, path: Path, building: Building3D, duration: float
) -> tuple[Ends, list[Fault]]:
    """Both ends of the pairs, by their index; what is wrong with these or with the length.

    As the contacts of the case say, or the file, in a case without contacts; whatever the mesh is.
    """
    contacts = {contact.name: contact for contact in building.case.contacts}
    ends: Ends = {}
    faults: list[Fault] = []
    unknown = [name for name in history.pairs if name not in contacts]
    of_lines = [name for name in unknown if name.rpartition(" at ")[0] in contacts]
    if contacts and history.ends.hat_a is not None and building.case.pounding_in_3d:
        # Points along which 3D models touch: several of each pair of the case.
        owner = building.name if building.contacts else ""
        depths = {name: contact.depth for name, contact in contacts.items()}
        ends, faults = _ends_by_file(history, path, owner, depths)
    elif of_lines and history.ends.hat_a is None:
        expected = (
            "expected forces.nc of that run, which says where the points along which 3D models "
            "touch are; a CSV does not"
        )
        faults.append(Fault(path, "pair", of_lines[0], expected))
    elif contacts:
        for j, name in enumerate(history.pairs):
            if name not in contacts:
                expected = f"expected a pair of the case; {nearest(name, list(contacts))}"
                faults.append(Fault(path, "pair", name, expected))
                continue
            ends[j] = PairEnd.both(contacts[name])
            faults += _contradictions(history, path, j, ends[j])
        for contact in building.contacts:
            if contact.name not in history.pairs:
                expected = (
                    f"missing; expected a column with the forces of the pair {contact.name} of "
                    f"the case, which touches {building.name}"
                )
                faults.append(Fault(path, "pair", None, expected))
    elif history.pairs:
        ends, faults = _ends_by_file(history, path, building.name)
    faults += wrong_signs(history, path, building.case)
    # The last step of forces may be cut, as whole steps make no duration.
    step = float(history.time[-1]) / (len(history.time) - 1)
    if history.time[-1] < duration - step:
        expected = f"expected forces up to {duration:g} s, which is to be computed"
        faults.append(Fault(path, "time", f"up to {history.time[-1]:g} s", expected))
    return ends, faults


def with_floor_forces(
    building: Building3D, mesh: BuildingMesh, forces: ForceHistory, edges: list[Shares]
) -> tuple[ForceHistory, list[Shares]]:
    """Impact forces with those of the loads of the case on the building.

    To the impact forces and the patterns of each a column and its patterns are added for each load.

    Raises:
        InputError: A load is not at right angles to an edge, or on a floor without one.
    """
    outward = {floor: outward_normal(mesh, floor) for floor in mesh.edges}
    sides = Sides(building, mesh)
    names, columns, every = list(forces.pairs), [forces.force], list(edges)
    faults: list[Fault] = []
    for index, loads in enumerate(building.case.loads):
        table = read_force_table(loads.file, faults)
        if table is None:
            continue
        values, direction = table.at(forces.time), np.array(loads.direction)
        for k, (of, floor) in enumerate(table.floors):
            if of != building.name:
                continue
            along = float(direction @ outward[floor]) if floor in outward else 0.0
            if abs(along) < 1.0 - ALIGNED:
                there = words_of(outward[floor]) if floor in outward else "which has none"
                expected = (
                    f"expected a direction at right angles to the edge of floor {floor}, {there}: "
                    "forces act on the edges of slabs in the 3D model"
                )
                key = f"loads[{index}].direction"
                faults.append(Fault(building.case.path, key, words_of(direction), expected))
                continue
            names.append(f"{LOAD} {index}, floor {floor}")
            # A positive amplitude pushes the edge inwards.
            columns.append(-along * values[:, [k]])
            every.append(sides.loaded(floor))
    if faults:
        raise InputError(faults)
    joined = replace(forces, pairs=tuple(names), force=np.hstack(columns), ends=PairEnds())
    return (joined if len(every) > len(edges) else forces), every


def loaded_edges(building: Building3D, mesh: BuildingMesh) -> dict[int, Shares]:
    """The patterns of the loads of the case on the edges of a building, by floor."""
    sides, found = Sides(building, mesh), dict[int, Shares]()
    for loads in building.case.loads:
        table = read_force_table(loads.file, [])
        for of, floor in () if table is None else table.floors:
            if of == building.name and floor in mesh.edges:
                found[floor] = sides.loaded(floor)
    return found


def check_contacts(building: Building3D, mesh: BuildingMesh) -> tuple[EdgeForce, ...]:
    """The patterns of all forces that may act on a building, by floor.

    Of contacts, or of the pairs of the forces of another program, and of loads; of floors that
    [transient] names alone, and nothing strikes, uniform ones.

    Raises:
        InputError: With every fault: what the building cannot take, floors without an edge.
    """
    case, transient = building.case, building.transient
    sides, path = Sides(building, mesh), case.path
    faults: list[Fault] = []
    ends = [(one.name, end) for one in case.contacts for end in PairEnd.both(one)]
    if transient is not None and transient.forces is not None and not case.contacts:
        path = transient.forces
        history = given_forces(transient)
        found, faults = _ends_by_file(history, path, building.name) if history.pairs else ({}, [])
        ends += [(history.pairs[j], end) for j, pair in found.items() for end in pair]
    floors = None if transient is None else transient.floors
    named = None if isinstance(floors, dict) else floors  # that of this building is a tuple
    patterns: list[EdgeForce] = []
    for name, end in ends:
        if end.building != building.name:
            continue
        shares = sides.shares(path, name, end)
        if isinstance(shares, Fault):
            faults.append(shares)
        elif named is None or end.floor in named:
            patterns += [pattern for pattern, _ in shares]
    by_floor = loaded_edges(building, mesh)
    loaded = set(by_floor)
    if named is not None:
        loaded = (loaded & set(named)) | {k for k in named if k not in {p.floor for p in patterns}}
    if bare := ", ".join(str(k) for k in named or () if k not in mesh.edges and k in loaded):
        known = ", ".join(map(str, sorted(mesh.edges))) or "none"
        expected = f"floor {bare} has no edge (group edge_K) in the mesh, which has {known}"
        faults.append(Fault(case.path, "transient.floors", list(named or ()), expected))
    if faults:
        raise InputError(faults)
    for floor in sorted(loaded):
        patterns += [pattern for pattern, _ in by_floor.get(floor) or sides.loaded(floor)]
    return tuple(sorted(dict.fromkeys(patterns), key=lambda one: one.floor))


def _ends_by_file(
    history: ForceHistory,
    path: Path,
    building: str,
    depths: Mapping[str, float | None] | None = None,
) -> tuple[Ends, list[Fault]]:
    """Both ends of the pairs as the file says; what is wrong, as none on this building, if any.

    The depths of slabs [m] are those of line contacts, by their names in the case.
    """
    said = history.ends
    names = ("building_a", "building_b", "floor_a", "floor_b", "normal")
    if missing := ", ".join(name for name in names if getattr(said, name) is None):
        expected = "what each pair is between (NetCDF only): the case has no contacts to say it"
        return {}, [Fault(path, missing, None, expected)]
    ends: Ends = {}
    faults: list[Fault] = []
    for j, name in enumerate(history.pairs):
        pair = []
        for side, sign in (("a", 1.0), ("b", -1.0)):
            of_end: list[Any] = [
                None if (values := getattr(said, f"{what}_{side}")) is None else values[j]
                for what in ("building", "floor", "relative_height", "offset", "hat")
            ]
            owner, floor, height, offset, hat = of_end
            height = None if height is None or math.isnan(height) else float(height)
            offset = None if offset is None else tuple(offset.tolist())
            hat = None if hat is None or math.isnan(hat[0]) else tuple(hat.tolist())
            outward = sign * np.asarray(said.normal)[j]
            depth = (depths or {}).get(name.rpartition(" at ")[0])
            pair.append(PairEnd(owner, floor, height, outward, offset, hat, depth=depth))
        a, b = pair
        if a.building == b.building:
            expected = "another building than that of a, or none for a rigid wall"
            faults.append(Fault(path, f"pair {name}, building_b", b.building, expected))
        else:
            ends[j] = (a, b)
    touched = {end.building for both in ends.values() for end in both}
    if building and not faults and building not in touched:
        expected = f"expected a pair that touches {building}, the building of the 3D model"
        faults.append(Fault(path, "building_a, building_b", sorted(touched - {""}), expected))
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
                expected = f"expected {wanted}, as in the case"
                yield Fault(path, f"{pair}, {name}_{side}", said[j], expected)
        heights = getattr(history.ends, f"relative_height_{side}")
        height = math.nan if end.relative_height is None else end.relative_height
        if heights is not None and not np.isclose(heights[j], height, 0.0, 1e-9, equal_nan=True):
            found = "nan" if math.isnan(heights[j]) else float(heights[j])
            expected = f"expected a point of {end.place}, as in the case"
            yield Fault(path, f"{pair}, relative_height_{side}", found, expected)
        offset = getattr(history.ends, f"offset_{side}")
        place = end.offset or (0.0, 0.0, 0.0)
        if offset is not None and not np.allclose(offset[j], place, 0.0, 1e-6):
            expected = f"expected {words_of(place)} m, as in the case"
            yield Fault(path, f"{pair}, offset_{side}", words_of(offset[j]), expected)
    normal = history.ends.normal
    if normal is not None and np.abs(normal[j] - ends[0].outward).max() > ALIGNED:
        words = [words_of(n) for n in (ends[0].outward, normal[j])]
        yield Fault(path, f"{pair}, normal", words[1], f"expected {words[0]}, as in the case")
