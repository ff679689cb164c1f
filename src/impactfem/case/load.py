"""Reading a case file with all files it names; every fault of all of them is reported at once.

Each section, and each table of an array or by name, is validated once, by itself. Rules between
sections are applied to those that are valid.
"""

import hashlib
import math
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from impactfem.case.analysis import Pounding, Spectra
from impactfem.case.base import Written
from impactfem.case.buildings import Structure
from impactfem.case.checks import CHECKS, FILE_CHECKS
from impactfem.case.contact_search import searched
from impactfem.case.contacts import expand
from impactfem.case.devices import STEPS, DeviceAnalysis
from impactfem.case.explain import explain, without_consequences
from impactfem.case.floors import UNKNOWN_DAMPING
from impactfem.case.levels import plan_of
from impactfem.case.model import Case, CaseFile
from impactfem.case.motions import DIRECTIONS, RestMotion, read_force_table
from impactfem.case.place import SEARCHED, Place, form_of
from impactfem.case.reading import Reading
from impactfem.case.source import Source, read_source
from impactfem.case.storeys import with_inertia, with_stiffness
from impactfem.system.errors import Fault, ImpactfemError, InputError

_PLACEHOLDERS: dict[str, Any] = {
    "title": "case",
    "materials": {},
    "damping": UNKNOWN_DAMPING,
    "pounding": Pounding(time_step=1e-6),
    "spectra": Spectra(damping=(0.05,), frequencies=(1.0,)),
}
"""Values of sections that every case has, where they have faults."""
_NEED_OTHERS = {
    "structure": ("wall_impact", "transient", "devices", "device_analysis", "calibration"),
    "transient": ("devices", "device_analysis"),
}
"""Sections without which others are of no use."""
_OPTIONAL = {"wall_impact", "transient", "devices", "calibration", "ensemble", "loads"}
_OPTIONAL |= {"wave_passage", "contact_search"}
"""Sections that are left out as a whole where further checks would look at what is at fault."""
_REFERENCE: Place = ("report", "reference")


def load_case(path: str | Path) -> Case:
    """Read a case file, those it extends, their tables and records.

    Args:
        path: The case file (TOML). Files are relative to the folder of the file that names them.

    Returns:
        The case: SI values, names resolved, tables read, contacts one for each pair of points.

    Raises:
        InputError: With every fault of the case file and of the files it names.
    """
    case, faults, _ = read_case(path)
    if faults or case is None:
        raise InputError(faults)
    return case


def read_case(path: str | Path | Source) -> tuple[Case | None, list[Fault], set[str]]:
    """Read the valid sections of a case, so that further checks can find its other faults.

    Args:
        path: The case file, or what it says, where that was read before.

    Returns:
        The case without what cannot be read, or None where no building can be; the faults; the
        names of the sections that have faults, and of those that are of no use without them.

    Raises:
        InputError: A file is no case file at all.
    """
    source = path if isinstance(path, Source) else read_source(Path(path), CaseFile)
    reading = Reading(source)
    errors = list(_validate(reading))
    faults = explain(errors, source, CaseFile)
    for item in errors:
        name = "structure" if item["loc"][2:3] == ("structure",) else str(item["loc"][0])
        reading.left_out |= {name, *_NEED_OTHERS.get(name, ())}
    for of_file in FILE_CHECKS:
        kind = of_file.__name__.strip("_")
        faults += [reading.fault(*finding, kind) for finding in of_file(reading)]
    case, left_out = _completed(reading), reading.left_out
    for check in CHECKS:
        kind = check.__name__.strip("_")
        faults += [reading.fault(*finding, kind) for finding in check(case, reading)]
    faults = without_consequences([*faults, *reading.faults])
    if not left_out:
        return case, faults, left_out
    # The case without what cannot be used; none where no building can be.
    structures = () if "structure" in left_out else case.structures
    update = {
        "structure": next(iter(structures), None),
        "further_structures": structures[1:],
        **{name: CaseFile.model_fields[name].default for name in left_out & _OPTIONAL},
    }
    if case.ensemble is not None and left_out & {"transient"} and not left_out & {"ensemble"}:
        update["ensemble"] = case.ensemble.model_copy(update={"structure_motions": 0})
    return case.model_copy(update=update) if case.buildings else None, faults, left_out


@cache
def section_adapter(name: str, *, item: bool = False) -> TypeAdapter[Any]:
    """The validator of a section, or of an item of an array of tables."""
    info = CaseFile.model_fields[name]
    kind: Any = Annotated[info.annotation, info]
    return TypeAdapter(get_args(form_of(info))[0] if item else kind)


def _attempt(
    adapter: TypeAdapter[Any], value: Any, place: Place, reading: Reading
) -> tuple[Any, list[ErrorDetails]]:
    """Validate what stands at a place: the value, None where it is not valid, and the errors."""
    try:
        return adapter.validate_python(value, context=reading), []
    except ValidationError as error:
        errors = error.errors(include_url=False)
        for item in errors:
            item["loc"] = (*place, *item["loc"])
        return None, errors


def _validate(reading: Reading) -> Iterator[ErrorDetails]:
    """Validate each section, and keep in the reading what is valid; yield the errors."""
    raw, values = reading.source.raw, reading.values
    for name, info in CaseFile.model_fields.items():
        given, form = raw.get(name), get_origin(form_of(info))
        if info.is_required():
            values[name] = _PLACEHOLDERS.get(name, ())
        else:
            values[name] = info.get_default(call_default_factory=True)
        if name not in raw:
            if info.is_required():
                yield ErrorDetails(type="missing", loc=(name,), msg="", input=raw)
        elif isinstance(given, list) and given and form is tuple:
            reading.entries[name] = entries = {}
            for k, entry in enumerate(given):
                value, errors = _entry(name, k, entry, reading)
                yield from errors
                if value is not None:
                    entries[k] = value
            finish = [one.finish for one in info.metadata if isinstance(one, Written)] or [tuple]
            values[name] = finish[0](tuple(entries.values()))
        elif isinstance(given, dict) and form is dict:
            values[name] = {}
            for key, entry in given.items():
                value, errors = _attempt(section_adapter(name), {key: entry}, (name,), reading)
                yield from errors
                values[name] |= value or {}
        else:
            value, errors = _attempt(section_adapter(name), given, (name,), reading)
            yield from errors
            values[name] = values[name] if errors else value
    for key in raw.keys() - CaseFile.model_fields.keys():
        yield ErrorDetails(type="extra_forbidden", loc=(key,), msg="", input=raw[key])


def _entry(name: str, k: int, raw: Any, reading: Reading) -> tuple[Any, list[ErrorDetails]]:
    """Validate a table of an array; the 3D model of a building by itself."""
    if name != "buildings" or not isinstance(raw, dict):
        return _attempt(section_adapter(name, item=True), raw, (name, k), reading)
    outside = {key: value for key, value in raw.items() if key != "structure"}
    building, errors = _attempt(section_adapter(name, item=True), outside, (name, k), reading)
    if "structure" in raw:
        with reading.model_of(str(raw.get("name", ""))):
            place = (name, k, "structure")
            structure, further = _attempt(TypeAdapter(Structure), raw["structure"], place, reading)
        errors += further
        if building is not None:
            building = building.model_copy(update={"structure": structure})
    if building is None:
        return None, errors
    plans = [plan_of(building, index) for index in range(len(building.floors))]
    without = any(math.isnan(floor.Jx) for floor in building.floors)
    if errors and without and None in plans:  # the plan may be that of the mesh
        return None, errors
    key = "length"
    try:
        floors = with_inertia(building.floors, plans)
        key = "floors" if building.modal_table is None else "modal_table"
        # A stick of the 3D model needs no stiffness in the case; `_of_sticks` checks the others.
        given = building.periods, building.modal_table
        of_model = "structure" in raw and building.stick != "own"
        if not of_model or floors[0].has_stiffness or any(given):
            floors = with_stiffness(floors, *given)
    except ImpactfemError as error:
        place, inside = (name, k, key), {"inside": ()}
        lacking = ErrorDetails(type="storeys", loc=place, msg=str(error), input=None, ctx=inside)
        return None, [*errors, lacking]
    return building.model_copy(update={"floors": floors}), errors


def _completed(reading: Reading) -> Case:
    """The case of the sections that are valid, with what follows from other sections."""
    values = reading.values
    structures = [one.structure for one in values["buildings"] if one.structure]
    source = reading.source
    names_it = source.path if values["report"].reference is None else source.file_of(_REFERENCE)
    case = Case.model_construct(
        structure=next(iter(structures), None),
        further_structures=tuple(structures[1:]),
        path=source.path,
        digest=reading.digest,
        reference_of="" if names_it == source.path else names_it.name,
        changes=tuple(name for name in source.changes(names_it) if name != "title"),
        input_files={
            name or reading.source.path.name: hashlib.sha256(content).hexdigest()
            for name, content in reading.inputs
        },
        **values,
    )
    names = {building.name for building in case.buildings}
    update: dict[str, Any] = {
        "contacts": tuple(
            contact
            for contact in case.contacts
            if names.issuperset(contact.buildings) and contact.law in case.contact_laws
        )
    }
    if case.structure is None and reading.three_d:
        reading.left_out |= {"structure", *_NEED_OTHERS["structure"]}
    if not case.devices or case.transient is None:
        update["device_analysis"] = None
    else:
        analysis = case.device_analysis or DeviceAnalysis()
        step = analysis.time_step or case.transient.time_step / STEPS
        update["device_analysis"] = analysis.model_copy(update={"time_step": step})
    if not case.motions and case.loads:
        # Ground at rest as long as the loads last, along the direction of the first of them.
        tables = [read_force_table(loads.file, []) for loads in case.loads]
        ends = [float(table.time[-1]) for table in tables if table is not None]
        along = [abs(component) for component in case.loads[0].direction]
        rest = RestMotion.model_construct(
            direction=DIRECTIONS[along.index(max(along))],
            type="rest",
            duration=case.pounding.duration or max(ends, default=0.0),
            time_step=case.pounding.time_step,
        )
        update["motions"] = (rest,) if ends else ()
        if not ends:
            reading.left_out.add("motions")  # nothing that can be read moves the buildings
    if case.report.reference is not None:
        update["published"] = {
            name: value.model_copy(update={"kind": case.report.reference.kind(name)})
            for name, value in case.published.items()
        }
    case = case.model_copy(update=update)
    # Without the explicit pairs that are at fault their floors would be in no pair.
    if case.contact_search is None or len(case.buildings) < 2 or "contacts" in reading.left_out:
        return case
    found = expand(searched(case, case.contact_search), SEARCHED)
    return case.model_copy(update={"contacts": (*case.contacts, *found)})
