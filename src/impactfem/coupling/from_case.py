"""From the case file's buildings and contacts to sticks, pairs, calibration, ground and loads."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from functools import lru_cache

import numpy as np
from scipy.integrate import trapezoid

from impactfem.case import Building, Case
from impactfem.case.calibration import Calibration as CalibrationCase
from impactfem.case.contacts import Contact
from impactfem.case.floors import Floor as FloorRow
from impactfem.case.motions import read_force_table
from impactfem.coupling.ground import Ground, History
from impactfem.coupling.laws import LAWS, Law, effective_mass
from impactfem.coupling.pounding import End, Load, Pair, System
from impactfem.sticks.calibration import (
    Bounds,
    Calibration,
    Parameters,
    Target,
    assess,
    calibrate,
    family_modes,
)
from impactfem.sticks.condensed import ModelStick
from impactfem.sticks.element import Section, StoreySprings
from impactfem.sticks.stick import Floor, Stick, build_stick, on_floor_matrices
from impactfem.system.errors import Fault, InputError
from impactfem.system.log import LOGGER

RIGID = 1e6
"""Stiffness of storeys given by springs, whose floors stay level, over their lateral stiffness:
along z, and about x and y for the radius of gyration. These frequencies are a thousand times those
of the storeys."""
COARSE = 0.01
"""Part of an impulse that samples may miss without a warning."""


def given_parameters(building: Building) -> Parameters:
    """Return the values of the case file and its floor table, before any calibration."""
    return Parameters(
        factor=building.stiffness_factor,
        heights=np.array([floor.storey_height for floor in building.floors]),
        below=building.rigid_below,
        above=building.rigid_above,
    )


def stick_of(
    building: Building,
    parameters: Parameters | None = None,
    storey_points: tuple[tuple[int, float], ...] = (),
) -> Stick:
    """Return the stick of a building, by the values of the case file or by calibrated ones.

    Storey points are points inside storeys, see `build_stick`.
    """
    values = parameters or given_parameters(building)
    along = period_factors(building)
    floors = []
    for row, height in zip(building.floors, values.heights, strict=True):
        section = storey_of(building, row, values.factor * row.storey_stiffness_factor, along)
        inertia, ends = (row.Jx, row.Jy, row.Jz), (values.below, values.above)
        floors.append(Floor(row.floor, row.mass, inertia, float(height), section, *ends))
    return _built(building, floors, storey_points)


def stick_on_model(
    building: Building, model: ModelStick, storey_points: tuple[tuple[int, float], ...] = ()
) -> Stick:
    """Return the stick of a building with the stiffness and the masses of its 3D model.

    Storey points are points inside storeys, see `build_stick`.
    """
    ends = building.rigid_below, building.rigid_above
    floors = [
        Floor(row.floor, float(mass), tuple(J.tolist()), row.storey_height, section, *ends)
        for row, mass, J, section in zip(
            building.floors, model.mass, model.inertia, model.sections, strict=True
        )
    ]
    return on_floor_matrices(_built(building, floors, storey_points), model.K, model.M)


def _built(
    building: Building, floors: Sequence[Floor], storey_points: tuple[tuple[int, float], ...]
) -> Stick:
    return build_stick(
        building.name,
        floors,
        damping=building.damping.law,
        axis=building.axis,
        base=building.base,
        soil=None if building.soil is None else building.soil.law,
        storey_points=storey_points,
    )


def storey_of(
    building: Building, row: FloorRow, factor: float, along: tuple[float, float]
) -> Section | StoreySprings:
    """Return the section, or the springs, of the storey below a floor.

    Args:
        building: The building.
        row: The floor.
        factor: Factor on all stiffnesses [-].
        along: Further factors on the lateral stiffness along x and y; torsion has their mean [-].
    """
    x, y = along
    twist = 0.5 * (x + y)
    if row.kx is not None and row.ky is not None and row.kt is not None:
        kx, ky = factor * x * row.kx, factor * y * row.ky
        return StoreySprings(
            kx=kx,
            ky=ky,
            kz=RIGID * max(kx, ky),
            krx=RIGID * ky * row.Jx / row.mass,
            kry=RIGID * kx * row.Jy / row.mass,
            kt=factor * twist * row.kt,
        )
    young, moment = building.material.young_modulus, building.second_moment_factor
    shear = young / (2.0 * (1.0 + building.material.poisson_ratio))
    given = row.section
    areas = {"A": given["A"], "Avx": x * given["Avx"], "Avy": y * given["Avy"]}
    moments = {"Ix": y * moment, "Iy": x * moment, "Iz": twist}
    moments = {key: part * given[key] for key, part in moments.items()}
    return Section(E=factor * young, G=factor * shear, **areas, **moments)


@lru_cache(maxsize=64)
def period_factors(building: Building) -> tuple[float, float]:
    """Return the factors on the stiffness along x and y that give the periods of a building.

    A stick moves along x without moving along y, so that the factor along each is (T₀/T)², with
    the period T₀ without it.
    """
    if building.periods is None:
        return 1.0, 1.0
    stick = stick_of(building.model_copy(update={"periods": None}))
    x, y = (
        1.0 if period is None else (family_modes(stick, axis)[0][0] * period) ** -2.0
        for axis, period in (("x", building.periods.x), ("y", building.periods.y))
    )
    return x, y


def calibration_of(case: Case) -> Calibration | None:
    """Fit the sticks to the targets of the case, or compare the given values with them."""
    return None if case.calibration is None else _calibrated(case.calibration, case.buildings)


@lru_cache(maxsize=4)
def _calibrated(given: CalibrationCase, every: tuple[Building, ...]) -> Calibration:
    # Kept: most stages of a run need the sticks, and a fit takes two seconds.
    buildings = {building.name: building for building in every}
    targets = [
        Target(**{field.name: getattr(row, field.name) for field in fields(Target)})
        for row in given.targets
    ]
    first = buildings[targets[0].building]
    start = given_parameters(first)

    def make(name: str, parameters: Parameters) -> Stick:
        return stick_of(buildings[name], parameters)

    if given.mode == "given":
        return assess(make, targets, start, direction=given.direction)
    bounds = Bounds(
        factor=given.stiffness_factor,
        height_min=np.array([row.storey_height_min for row in first.floors]),
        height_max=np.array([row.storey_height_max for row in first.floors]),
        height=given.height,
        rigid_depth=given.rigid_depth,
    )
    return calibrate(
        make,
        targets,
        bounds,
        direction=given.direction,
        start=start,
        starts=given.starts,
        seed=given.seed,
    )


def law_between(
    case: Case, contact: Contact, sticks: Mapping[str, Stick], ends: Iterable[End]
) -> Law:
    """Return the law of a contact between points of sticks, with their effective mass."""
    normal = np.array(contact.normal)
    masses = (sticks[e.building].point_mass(e.master, e.offset, normal) for e in ends)
    entry = case.contact_laws[contact.law]
    return LAWS[entry.type].of_case(contact.law, entry, effective_mass(*masses))


def system_of(case: Case, calibration: Calibration | None) -> System:
    """Return the sticks of all buildings and the pairs between them.

    The values of a calibration go to the buildings that its targets name; the others keep those of
    the case file.
    """
    calibrated = {target.building for target in calibration.targets} if calibration else set()
    points: dict[str, list[tuple[int, float]]] = {}
    for contact in case.contacts:
        for point, _ in contact.ends:
            if point.storey is not None and point.relative_height is not None:
                points.setdefault(point.building, []).append((point.storey, point.relative_height))
    sticks = {}
    for building in case.buildings:
        name, own_points = building.name, tuple(points.get(building.name, ()))
        if name in case.sticks_on_models:
            if name not in case.model_sticks:
                raise ValueError(f"the stick of {name} is that of its 3D model, which has to run")
            sticks[name] = stick_on_model(building, case.model_sticks[name], own_points)
        else:
            fitted = calibration.parameters if calibration and name in calibrated else None
            sticks[name] = stick_of(building, fitted, own_points)
    pairs = []
    for contact in case.contacts:
        normal, ends = np.array(contact.normal), list[End]()
        for point, _ in contact.ends:
            stick = sticks[point.building]
            if point.floor is not None:
                end = End.of_floor(stick, point.floor, point.offset)
            else:
                storey, height = int(point.storey or 0), float(point.relative_height or 0.0)
                master = stick.storey_points[storey, height]
                end = End(stick.name, master, point.offset, storey, height)
            ends.append(end)
        # The law of the line is that of its middle: the masses are those of a central impact.
        along = contact.along * np.array(contact.tangent)
        middles = [replace(end, offset=tuple((end.offset - along).tolist())) for end in ends]
        law = law_between(case, contact, sticks, middles).part(contact.share)
        a, b = ends[0], ends[1] if len(ends) > 1 else None
        pair = Pair(contact.name, a, b, normal, contact.gap, law, contact.bearing_area)
        pairs.append(replace(pair, line=contact.line))
    return System(tuple(sticks.values()), tuple(pairs))


def ground_of(
    case: Case, histories: Sequence[History], time_step: float, n_t: int | None = None
) -> Ground:
    """Return the ground under the buildings of a case at n_t times of a step [s].

    Left out, they are those of [pounding]: up to its duration, or until the longest motion has
    reached its end under all buildings.
    """
    if n_t is None:
        longest = max(dt * (samples.size - 1) for _, dt, samples in histories)
        # Rounded, so that a step printed with four digits still gives the intended number of steps.
        n_t = round(case.computed_time(longest) / time_step) + 1
    return Ground.under(histories, time_step, n_t, case.delays)


def loads_of(case: Case, system: System, time_step: float, n_t: int) -> list[Load]:
    """Return the loads of a case, on the mass centres of the floors, at n_t times of a step [s].

    A warning is logged if samples at the time step miss a part of an impulse.

    Raises:
        InputError: A table of forces is not usable any more.
    """
    time = time_step * np.arange(n_t)
    found = []
    for loads in case.loads:
        faults: list[Fault] = []
        table = read_force_table(loads.file, faults)
        if table is None:
            raise InputError(faults)
        direction = np.array(loads.direction)
        for (building, floor), force in zip(table.floors, table.at(time).T, strict=True):
            found.append(Load(End.of_floor(system.stick(building), floor), direction, force))
        fine = np.union1d(time, table.time[table.time <= time[-1]])
        exact, sampled = (trapezoid(table.at(at), at, axis=0) for at in (fine, time))
        size = trapezoid(np.abs(table.at(fine)), fine, axis=0)
        off = float(np.max(np.abs(sampled - exact) / np.maximum(size, 1e-300), initial=0.0))
        if off > COARSE:
            LOGGER.warning(
                "warning: %s: at pounding.time_step an impulse is %.2g %% off; expected a smaller "
                "step",
                loads.file.name,
                100.0 * off,
            )
    return found
