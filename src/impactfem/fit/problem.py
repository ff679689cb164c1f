"""A fit as a problem of least squares: the case at values of its keys, and the data."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass, fields, replace
from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from impactfem.building.floor_properties import UNITS
from impactfem.building.mesh import BuildingMesh, side_lengths
from impactfem.case import Case
from impactfem.case.base import nearest
from impactfem.case.explain import expectation
from impactfem.case.load import read_case
from impactfem.case.model import CONDITIONS, CaseFile
from impactfem.case.place import Place, field_at, key_fault, read_key, value_at
from impactfem.case.report import STAGE_OF
from impactfem.case.source import EXTENDS, Source, read_source
from impactfem.fit.fit_file import (
    FitFile,
    FloorTarget,
    Given,
    ModesTarget,
    ScalarTarget,
    SpectrumTarget,
    measured_shape,
    read_fit,
    written,
)
from impactfem.fit.misfit import Misfit
from impactfem.run.check import check, mesh_of
from impactfem.run.stages import asked_stages
from impactfem.run.variants import COMMAND_LINE, Key, Variant, check_variants, in_si
from impactfem.stages.building.store import OUTPUTS as OF_BUILDING
from impactfem.stages.building.store import SCALARS
from impactfem.stages.building.targets import SHOWN_BENDING, from_structure
from impactfem.stages.inputs import program_key
from impactfem.stages.pounding.scalars import DEMANDS, MAIN_IMPACT
from impactfem.stages.pounding.store import MOTION_OUTPUTS, OUTPUTS
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import Fault, InputError
from impactfem.system.scalar import of_building

STICK_MODES = re.compile(r"sticks\.[^.]+\.(frequency\.\d+|effective_mass\.\d+|mass)")
MESH_KEYS = ("size", "floor_size", "storey_size", "beam_size", "column_size", "file")
"""Keys of a mesh that `coarse` may change: sizes of elements, and the file of a coarser mesh."""
MOST_MODES = 6
"""Modes of a stick among the results."""


@dataclass(frozen=True)
class Datum:
    """A known number."""

    name: str  #: the result, or what it is of
    value: float  #: in SI
    unit: str  #: SI unit
    deviation: float = 0.0  #: standard deviation in SI, where it is no part
    part: float = 0.0  #: standard deviation as a part of the model's value; 0 for one in SI
    group: str = ""  #: the shape or the spectrum that it belongs to; "" for none


@dataclass(frozen=True, eq=False)
class Problem:
    """The keys of a case that are fitted, and the data."""

    path: Path  #: the file of the fit
    fit: FitFile  #: its content
    said: Source  #: its content as written
    source: Source  #: the case
    free: tuple[Key, ...]  #: the free keys in the case
    first: tuple[float, ...]  #: their values at the first start, in SI
    fixed: tuple[tuple[Key, Any], ...]  #: further keys, each with the one value that it has here
    data: tuple[Datum, ...]  #: the known numbers
    #: The models of the data: "sticks", "floors" of the mesh, its "modes", or a "run" of stages.
    level: str
    stages: tuple[str, ...]  #: the last stages of that run
    digest: str  #: hash of case, targets and program

    @property
    def keys(self) -> list[str]:
        """The free keys."""
        return list(self.fit.free)

    @property
    def start(self) -> Array:
        """The first start on the scale of the fit, shape (n,)."""
        keys = self.fit.free.values()
        return np.array([key.scaled(value) for key, value in zip(keys, self.first, strict=True)])

    @property
    def misfit(self) -> Misfit:
        """The data with their deviations."""
        columns = ([getattr(datum, f.name) for datum in self.data] for f in fields(Misfit))
        return Misfit(*map(np.array, columns))

    @property
    def priors(self) -> list[tuple[int, float, float]]:
        """Of the keys with a prior: number, mean and standard deviation on the scale of the fit."""
        every = enumerate(key.scaled_prior for key in self.fit.free.values())
        return [(k, *one) for k, one in every if one is not None]

    def prior_errors(self, u: Array) -> Array:
        """(place − mean)/deviation of each prior at places on the scale of the fit."""
        return np.array([(u[k] - mean) / width for k, mean, width in self.priors])

    def of_floors(self, building: str) -> bool:
        """Whether a target is of floors of the 3D model of a building."""
        return any(isinstance(t, FloorTarget) and t.building == building for t in self.fit.targets)

    def measured(self, building: str) -> ModesTarget | None:
        """The measured modes of a building."""
        every = (t for t in self.fit.targets if isinstance(t, ModesTarget))
        return next((target for target in every if target.building == building), None)

    def values(self, u: Array) -> Array:
        """The keys in SI at places on the scale of the fit, shape (n,)."""
        free = self.fit.free.values()
        return np.array([key.value(float(one)) for key, one in zip(free, u, strict=True)])

    def variant(self, u: Array) -> Variant:
        """Return the case at these places by its changed keys."""
        units = (key.bounds[0].unit for key in self.fit.free.values())
        values = [_for_case(v, unit) for v, unit in zip(self.values(u), units, strict=True)]
        keys = (*self.free, *(key for key, _ in self.fixed))
        return Variant(keys, (*values, *(value for _, value in self.fixed)))

    def tried(self, u: Array) -> Variant:
        """The same, which may have the conditions that a case must allow."""
        return replace(self.variant(u), lenient=True)

    def case(self, u: Array) -> Case:
        """Read the case at these places from memory.

        Raises:
            InputError: It has faults, which no bound has.
        """
        variant, raw = self.variant(u), deepcopy(self.source.raw)
        raw["allow"] = list(CONDITIONS)  # conditions are of the case, not of what is tried
        for key, value in zip(variant.keys, variant.values, strict=True):
            value_at(key.place[:-1], raw)[key.place[-1]] = value
        case, faults, _ = read_case(replace(self.source, raw=raw))
        if faults or case is None:
            raise InputError(faults)
        return case

    def ends(self, u: Array, k: int) -> tuple[Array, Array]:
        """Places a step of a key to either side, not beyond its bounds, shape (n,) each."""
        step = self.fit.free[self.keys[k]].step
        low, high = u.copy(), u.copy()
        low[k], high[k] = max(u[k] - step, 0.0), min(u[k] + step, 1.0)
        return low, high

    @property
    def scale(self) -> str:
        """Hash of the scale that slopes are of, 0 to 1 between the bounds, and of their steps."""
        free = self.fit.free.values()
        every = [(*(end.value for end in one.bounds), one.scale, one.step) for one in free]
        return hashlib.sha256(repr(every).encode()).hexdigest()

    def key(self, u: Array) -> str:
        """Hash of all that the values of an evaluation at these places depend on."""
        variant = self.variant(u)
        given = {key.name: v for key, v in zip(variant.keys, variant.values, strict=True)}
        return hashlib.sha256(f"{self.digest} {json.dumps(given)}".encode()).hexdigest()


def _for_case(value: float, unit: str) -> Any:
    """Return a value as in a case file, of twelve digits so that its text is short."""
    return float(f"{value:.12g}") if unit == "-" else f"{value:.12g} {unit}"


def read_problem(
    path: Path, fit_path: Path, *, mesh: bool = False
) -> tuple[Problem, Problem | None]:
    """Read a case and the file of a fit; nothing is computed.

    Args:
        path: The case file.
        fit_path: The file of the fit (TOML).
        mesh: Whether the meshes of buildings with measured modes are read, or made, too, which
            takes some seconds, so that sensors beside them are refused.

    Returns:
        The problem, and the same with the keys of `coarse`, None without.

    Raises:
        InputError: With every fault of both files, and of the two together as far as those of one
            do not hide them.
    """
    faults, case = list[Fault](), None
    try:
        case = check(path)
    except InputError as error:
        faults += error.faults
    fit, said = read_fit(fit_path, faults)
    if case is None:
        raise InputError(faults)
    source = read_source(path, CaseFile)
    places = _places(said, source, fit_path, faults)
    if fit is None:
        raise InputError(faults)
    first = _first_values(fit, said, source, case, places, faults)
    free = [Key(key, places["free", key]) for key in first]
    fixed = _coarse_keys(fit, said, places, faults)
    faults += _overlaps(free, [key for key, _ in fixed], fit_path)
    if any(isinstance(target, SpectrumTarget) for target in fit.targets):
        for (table, key), place in places.items():
            if place[:2] == ("spectra", "damping"):
                expected = "expected another key: the targets' spectra are of dampings of the case"
                faults.append(Fault(fit_path, f'{table}."{key}"', None, expected))
    for k, target in enumerate(fit.targets):
        for key, value, expected in _wrong(target, case):
            if value is None and key:
                value = value_at(("targets", k, key[1:]), said.raw)
            faults.append(Fault(fit_path, f"targets[{k}]{key}", value, expected))
    if mesh:
        _check_sensors(fit, fit_path, case, faults)
    level, stages = _needed(fit, case) if not faults else ("", ())
    if faults:
        raise InputError(faults)
    data = tuple(one for target in fit.targets for one in _data(target, case))
    inputs = f"{case.digest} {fit.model_dump_json(include={'targets'})} {program_key()}"
    problem = Problem(
        path=fit_path,
        fit=fit,
        said=said,
        source=source,
        free=tuple(free),
        first=tuple(first.values()),
        fixed=(),
        data=data,
        level=level,
        stages=stages,
        digest=hashlib.sha256(inputs.encode()).hexdigest(),
    )
    rough = replace(problem, fixed=tuple(fixed)) if fixed else None
    _check_corners(problem, rough)
    return problem, rough


Places = dict[tuple[str, str], Place]
"""Places in the case of the keys of a fit, by their table, "free" or "coarse", and name."""


def _places(said: Source, source: Source, path: Path, faults: list[Fault]) -> Places:
    """Return the places of all keys of a fit that are keys of the case."""
    places: Places = {}
    for table in ("free", "coarse"):
        keys = said.raw.get(table)
        for key in keys if isinstance(keys, dict) else ():
            place = _place(key, source, path, f'{table}."{key}"', faults)
            if place is not None:
                places[table, key] = place
    return places


def _first_values(
    fit: FitFile, said: Source, source: Source, case: Case, places: Places, faults: list[Fault]
) -> dict[str, float]:
    """Return the value at the first start of each free key without a fault [SI]."""
    first: dict[str, float] = {}
    for key, entry in fit.free.items():
        if ("free", key) not in places:
            continue
        place = places["free", key]
        low, high = entry.bounds
        own = value_at(place, source.raw)
        value, unit = (math.nan, low.unit) if own is None else in_si(own)
        field = field_at(CaseFile, place, source.raw)[1]
        if own is None and field is not None and isinstance(field.default, int | float):
            value = float(field.default)
        phrase = "" if field is None else expectation(field.annotation, field.metadata)
        has, wrong = f"the case has {key} = {own!r}", ""
        at: Place = ("free", key)
        if not isinstance(value, int | float):
            wrong = f"{has}; expected the key of a number"
        elif phrase.startswith("a whole number"):
            wrong = f"{has}; expected the key of a number that need not be whole"
        elif (instead := _overridden(place, case)) is not None:
            wrong = f"{instead} in every evaluation; expected another key, or a case without that"
        elif unit != low.unit:
            at, wrong = (*at, "bounds"), f"{has}; expected bounds of its unit"
        elif entry.start is None and not low.value <= float(value) <= high.value:
            has = "the case has no such key" if own is None else has
            at, wrong = (*at, "bounds"), f"{has}; expected bounds around its value, or a start"
        if wrong:
            faults.append(written(said, at, wrong))
        else:
            start = float(value) if entry.start is None else entry.start.value
            # As the case has it: of twelve digits.
            first[key] = float(in_si(_for_case(start, low.unit))[0])
    return first


def _coarse_keys(
    fit: FitFile, said: Source, places: Places, faults: list[Fault]
) -> list[tuple[Key, Any]]:
    """Return the keys of `coarse` with their values."""
    fixed = []
    for name, value in fit.coarse.items():
        if ("coarse", name) not in places:
            continue
        place = places["coarse", name]
        fixed.append((Key(name, place), value))
        is_mesh = place[2:4] == ("structure", "mesh")
        if place[2:] != ("structure", "modes") and not (is_mesh and place[-1] in MESH_KEYS):
            expected = (
                "expected a key of the mesh or of the number of modes, as "
                f'"buildings[0].structure.mesh.size"; known: {", ".join(MESH_KEYS)}, modes. '
                "Other keys change the building or its load"
            )
            faults.append(written(said, ("coarse", name), expected))
    return fixed


def _overlaps(free: list[Key], coarse: list[Key], path: Path) -> Iterator[Fault]:
    """Yield the faults of keys that hold one another."""
    every = [*(("free", key) for key in free), *(("coarse", key) for key in coarse)]
    for (table, key), (other_table, other) in combinations(every, 2):
        if all(a == b for a, b in zip(key.place, other.place, strict=False)):
            expected = f'expected keys that do not hold one another; {table}."{key.name}" is one'
            yield Fault(path, f'{other_table}."{other.name}"', None, expected)


def _check_sensors(fit: FitFile, path: Path, case: Case, faults: list[Fault]) -> None:
    """Refuse sensors of measured modes that are away from the mesh of their building."""
    measured = {t.building: t for t in fit.targets if isinstance(t, ModesTarget)}
    for name, building in case.modelled.items():
        target = measured.get(name)
        mesh = None if target is None else mesh_of(building, faults)
        if target is not None and mesh is not None:
            try:
                sensor_nodes(path, fit, target, mesh)
            except InputError as error:
                faults += error.faults


def sensor_nodes(path: Path, fit: FitFile, target: ModesTarget, mesh: BuildingMesh) -> Index:
    """Return the node nearest to each sensor of a target of the fit in a file, shape (n,).

    Raises:
        InputError: A sensor is farther from all of them than the size of an element.
    """
    distance, nodes = cKDTree(mesh.nodes).query(target.places)
    farthest = float(side_lengths(mesh.nodes, mesh.triangles).mean())
    if distance.max() > farthest:
        x, y, z = target.places[int(np.argmax(distance))]
        others = len(np.unique(target.places[distance > farthest], axis=0)) - 1
        expected = (
            f"the sensor at ({x:g}, {y:g}, {z:g}) m is {distance.max():.3g} m from the nearest "
            f"node of {target.building}; expected at most {farthest:.3g} m, the size of an element"
        )
        expected += f"; so it is of {others} more" if others else ""
        where = f"targets[{fit.targets.index(target)}].shapes"
        raise InputError([Fault(path, where, None, expected)])
    return np.asarray(nodes)


def _overridden(place: Place, case: Case) -> str | None:
    """Name the calibration of the case that replaces the value of a key; None without one."""
    if place[0] != "buildings" or len(place) < 3:
        return None
    name, setup = case.buildings[int(place[1])].name, case.calibration
    if place[2:] == ("structure", "storey_stiffness_factor"):
        fits = [one.building for one in case.structures if one.calibration is not None]
        return f"the calibration of the 3D model of {name} fits it" if name in fits else None
    named = [] if setup is None else [target.building for target in setup.targets]
    if place[2] not in ("stiffness_factor", "rigid_below", "rigid_above") or name not in named:
        return None
    if setup is not None and setup.mode == "fit":
        return "[calibration] fits it"
    return None if name == named[0] else f"[calibration] gives {name} the values of {named[0]}"


def _place(key: str, source: Source, path: Path, where: str, faults: list[Fault]) -> Place | None:
    """Return the place of a key in the case; None, and a fault, for an invalid key."""
    place = read_key(key)
    if place is None or place == (EXTENDS,):
        wrong: str | None = "expected a key of the case, for example 'damping.ratio'"
    else:
        wrong = key_fault(place, source.raw, CaseFile)
    if wrong is not None:
        faults.append(Fault(path, where, None, wrong))
        return None
    return place


def _wrong(target: Any, case: Case) -> list[tuple[str, Any, str]]:
    """Return the faults of a target: its key, its value and what is expected."""
    if isinstance(target, ScalarTarget):
        word = target.result.partition(".")[0]
        if word not in STAGE_OF:
            hint = nearest(word, list(STAGE_OF))
            return [(".result", target.result, f"expected the name of a result; {hint}")]
        faults = _lacking(case, STAGE_OF[word], ".result", target.result)
        return faults or _of_stick(target, case) or _of_run(target, case)
    names = [building.name for building in case.buildings]
    if target.building not in names:
        return [
            (".building", target.building, f"unknown building; {nearest(target.building, names)}")
        ]
    models = [one.building for one in case.structures]
    if isinstance(target, ModesTarget):
        computed = {one.building: one.modes for one in case.structures}
        most = computed.get(target.building, 6 * len(case.building(target.building).floors))
        if len(target.modes) > most:
            more = "; more by its key modes" * (target.building in models)
            model = "3D model" if more else "stick"
            expected = f"expected at most {most} modes, as the {model} of {target.building} has"
            return [(".modes", len(target.modes), f"{expected}{more}")]
    if isinstance(target, FloorTarget):
        if target.building not in models:
            return [(".building", target.building, "expected a building with a 3D model")]
        known = [floor.floor for floor in case.building(target.building).floors]
        absent = [k for k in target.floors if k not in known]
        if absent:
            return [(".floors", absent[0], f"expected floors of {target.building}, {known}")]
        if target.value is None and (target.deviation is None or target.deviation.unit != "%"):
            expected = "expected a percentage, as the value is that of the floor table"
            return [(".deviation", None, expected)]
        row = case.building(target.building).floors[0]
        if target.value is None and getattr(row, target.quantity) is None:
            expected = f"required: the floor table has no column {target.quantity}"
            return [(".value", None, expected)]
    return _of_spectrum(target, case) if isinstance(target, SpectrumTarget) else []


def _of_spectrum(target: SpectrumTarget, case: Case) -> list[tuple[str, Any, str]]:
    """Return the faults of a spectrum."""
    stage = "pounding" if target.probe is None else "transient"
    found, building = _lacking(case, stage, "", None), case.building(target.building)
    if target.damping not in case.spectra.damping:
        found.append((".damping", target.damping, f"expected one of {case.spectra.damping}"))
    f = case.spectra.frequency_values
    outside = [one.frequency for one in target.spectrum if not f[0] <= one.frequency <= f[-1]]
    if outside:
        expected = f"expected frequencies of [spectra], {f[0]:g} to {f[-1]:g} Hz"
        found.append((".spectrum", f"{outside[0]:g} Hz", expected))
    floors = [floor.floor for floor in building.floors]
    if target.floor is not None and target.floor not in floors:
        found.append((".floor", target.floor, f"expected a floor of {target.building}, {floors}"))
    if target.probe is None:
        # A straight stick moves where it is pushed; what soil or a 3D model couples, a run knows.
        along = [np.eye(3)["xyz".index(motion.direction)] for motion in case.motions]
        along += [np.array(one.direction) for one in case.loads]
        along += [np.array(contact.normal) for contact in case.contacts]
        coupled = case.pounding_in_3d or any(one.soil is not None for one in case.buildings)
        if not coupled and not any(one["xyz".index(target.direction)] for one in along):
            expected = "expected a direction of [[motions]], [[loads]] or a normal of [[contacts]]"
            found.append((".direction", target.direction, expected))
        return found
    modelled = case.modelled.get(target.building)
    if modelled is None:
        return [*found, (".building", target.building, "expected a building with a 3D model")]
    known = [f"{kind}_{k}" for kind in ("centre", "edge") for k in floors]
    known += [f"line_{k}" for k in range(1, 10)]
    probes = [probe for _, probe in modelled.numbered_probes]
    if target.probe not in known and not any(probe.claims(target.probe) for probe in probes):
        known += [name for probe in probes for name, _ in probe.points]
        hint = nearest(target.probe, known)
        found.append((".probe", target.probe, f"expected a probe of {target.building}; {hint}"))
    return found


def _of_stick(target: ScalarTarget, case: Case) -> list[tuple[str, Any, str]]:
    """Return the faults of a mode or the mass of a stick."""
    word, name, quantity, *_ = [*target.result.split("."), "", ""]
    if word != "sticks" or not quantity or name == "storey_height":
        return []
    names = [building.name for building in case.buildings]
    if name not in names:
        return [(".result", target.result, f"unknown building; {nearest(name, names)}")]
    if not STICK_MODES.fullmatch(target.result):
        known = ", ".join(f"sticks.{name}.{k}" for k in ("frequency.1", "effective_mass.1", "mass"))
        return [(".result", target.result, f"expected the name of a result, as {known}")]
    building, modes = case.building(name), MOST_MODES
    if building.soil is None and all(
        end.storey is None for one in case.contacts for end, _ in one.ends
    ):
        modes = min(modes, 2 * len(building.floors))  # a floor moves along and turns about an axis
    if quantity != "mass" and target.result.rpartition(".")[2] not in map(str, range(1, modes + 1)):
        return [(".result", target.result, f"expected a mode of {name} from 1 to {modes}")]
    unit = "Hz" if quantity == "frequency" else "kg"
    if target.value.unit != unit:
        return [(".value", None, f"expected a value in {unit}, the unit of the result")]
    return []


def _of_run(target: ScalarTarget, case: Case) -> list[tuple[str, Any, str]]:
    """Return the faults of a result that no run of this case has."""
    units, name = _units(case), target.result
    for first in ("building.", "pounding.main_impact_"):
        if name.startswith(first) and name not in units:
            known = [one for one in units if one.startswith(first)]
            alike = [one for one in known if one.rpartition(".")[0] == name.rpartition(".")[0]]
            numbered = alike and alike[0].endswith(".1")
            hint = f"there are {alike[0]} to {alike[-1]}" if numbered else nearest(name, known)
            return [(".result", name, f"expected the name of a result; {hint}")]
    floors = sorted({floor.floor for building in case.buildings for floor in building.floors})
    found = re.findall(r"\.floor_(\d{1,9})\b", name.removeprefix("device."))
    if any(int(k) not in floors for k in found):
        return [(".result", name, f"expected a floor of the case, {floors}")]
    unit = units.get(name, target.value.unit)
    if unit != target.value.unit:
        return [(".value", None, f"expected a value in {unit}, the unit of the result")]
    return []


def _units(case: Case) -> dict[str, str]:
    """SI units of results by their names, as far as they are known without a run."""
    motions = {name: one.unit for name, one in MOTION_OUTPUTS.items() if one.dims == "motion"}
    units = {f"motion.{name}": unit for name, unit in motions.items() if unit}
    for entry in f"{MAIN_IMPACT} {DEMANDS}".split():
        word, _, variable = entry.partition("=")
        units[f"pounding.{word}"] = OUTPUTS[variable].unit
    for modelled in case.modelled.values():
        counts = {"{bending}": SHOWN_BENDING}
        counts["{floor}"] = len(modelled.entry.floors)
        for pattern, variables in SCALARS.items():
            count = next((k for label, k in counts.items() if pattern.endswith(label)), 1)
            for variable, k in product(variables.split(), range(1, count + 1)):
                name = pattern.format(variable=variable, bending=k, floor=k)
                of = of_building(name, modelled.part)
                units[of] = OF_BUILDING[variable].unit.partition(",")[0] or "-"
    return units


def _lacking(case: Case, stage: str, key: str, value: Any) -> list[tuple[str, Any, str]]:
    """Return the fault of a target whose stage lacks its input in the case."""
    try:
        asked_stages(case, stage)
    except InputError as error:
        return [(key, value, f"{one.key}: {one.expected}") for one in error.faults]
    return []


def _data(target: Any, case: Case) -> list[Datum]:
    """Return the data of a target."""

    def datum(name: str, value: float, unit: str, deviation: Given | None, digits: float) -> Datum:
        part = deviation is not None and deviation.unit == "%"
        width = digits if deviation is None else deviation.value
        return Datum(name, value, unit, 0.0 if part else width, width if part else 0.0)

    if isinstance(target, ScalarTarget):
        given = target.value
        return [datum(target.result, given.value, given.unit, target.deviation, given.rounding)]
    if isinstance(target, FloorTarget):
        rows = {floor.floor: floor for floor in case.building(target.building).floors}
        found = []
        for floor in target.floors:
            name = f"{target.building}.floor_{floor}.{target.quantity}"
            of_table = getattr(rows[floor], target.quantity)
            value = float(of_table if target.value is None else target.value.value)
            rounding = 0.0 if target.value is None else target.value.rounding
            found.append(datum(name, value, UNITS[target.quantity], target.deviation, rounding))
        return found
    if isinstance(target, ModesTarget):
        found = []
        for one in target.modes:
            name, f = f"{target.building}.mode_{one.mode}", one.frequency
            found.append(datum(f"{name}.frequency", f, "Hz", target.frequency_deviation, 0.0))
            if one.damping is not None:
                given = target.damping_deviation
                found.append(datum(f"{name}.damping", one.damping, "-", given, 0.0))
            width = target.shape_deviation
            found += [
                Datum(f"{name}.sensor_{k}", float(a), "-", width, group=f"{name}.shape")
                for k, a in enumerate(measured_shape(target, one.mode), start=1)
            ]
        return found
    place = target.probe or f"floor_{target.floor}"
    name, part = f"{target.building}.{place}.psa_{target.direction}", target.deviation
    return [
        Datum(f"{name}.{one.frequency:g}_Hz", one.psa, "m/s2", part=part, group=name)
        for one in target.spectrum
    ]


def _needed(fit: FitFile, case: Case) -> tuple[str, tuple[str, ...]]:
    """Return the models that the data require, and the last stages of a run if they require one."""
    models = {one.building for one in case.structures}
    level, stages = "sticks", set()
    for target in fit.targets:
        if isinstance(target, SpectrumTarget):
            stages.add("pounding" if target.probe is None else "transient")
        elif isinstance(target, FloorTarget):
            level = "floors" if level == "sticks" else level
        elif isinstance(target, ModesTarget):
            level = "modes" if target.building in models else level
        elif target.result.startswith("building."):
            level = "modes"
        elif not STICK_MODES.fullmatch(target.result) or from_structure(case):
            stages.add(STAGE_OF[target.result.partition(".")[0]])
    if not stages:
        return level, ()
    if level != "sticks":
        stages.add("building")
    # A stage that another one needs is run with it.
    with_needs = {name: {one.name for one in asked_stages(case, name)} - {name} for name in stages}
    needed: set[str] = set().union(*with_needs.values())
    return "run", tuple(sorted(stages - needed))


def _check_corners(problem: Problem, rough: Problem | None) -> None:
    """Read the case at its start, at each bound alone, and at all of them together.

    Raises:
        InputError: With the faults, in the words of the file of the fit.
    """
    n, start = len(problem.free), problem.start
    faults: dict[str, Fault] = {}

    def read(variant: Variant, place: Place, when: str = "") -> None:
        try:
            check_variants([variant], problem.source, None)
        except InputError as error:
            for fault in error.faults:
                at, expected = _place_of(fault, problem), fault.expected
                if not at and fault.file != COMMAND_LINE:
                    # Of another value of the case, which was read in a folder that is gone now.
                    expected = str(replace(fault, file=Path(fault.file).name))
                if at == place[:2] or not at:
                    at = place
                elif at[0] == "free":
                    end: Place = (*at, "bounds" if when else "start")
                    at = at if value_at(end, problem.said.raw) is None else end
                found = written(problem.said, at, f"{when}{expected}")
                faults.setdefault(str(found), found)

    read(problem.variant(start), ("free",))
    for k, key in enumerate(problem.keys):
        for bound in (0, 1):
            u = start.copy()
            u[k] = bound
            read(problem.tried(u), ("free", key, "bounds", bound))
    if not faults:
        for bound, name in enumerate(("lower", "upper")):
            when = f"at all {name} bounds together: "
            read(problem.tried(np.full(n, float(bound))), ("free",), when)
    if rough is not None:
        read(rough.variant(start), ("coarse",))
    if faults:
        raise InputError(faults.values())


def _place_of(fault: Fault, problem: Problem) -> Place:
    """Where the file of the fit says a value that `check_variants` refuses; () for nowhere."""
    key = fault.key.removeprefix("--set ") if fault.file == COMMAND_LINE else ""
    tables = {"free": problem.fit.free, "coarse": problem.fit.coarse}
    return next(((name, key) for name, table in tables.items() if key in table), ())
