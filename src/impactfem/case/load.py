"""Reading a case file with all files it names; every fault of all of them is reported at once."""

import hashlib
from copy import deepcopy
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from impactfem.case.base import REPORTED, UNREADABLE
from impactfem.case.checks import CHECKS, FILE_CHECKS
from impactfem.case.devices import STEPS, DeviceAnalysis
from impactfem.case.explain import explain, places
from impactfem.case.model import Case, CaseFile
from impactfem.case.motions import DIRECTIONS, RestMotion, read_force_table
from impactfem.case.place import Place
from impactfem.case.reading import Reading
from impactfem.case.source import Source, read_source
from impactfem.system.errors import Fault, InputError

_PLACEHOLDERS: dict[str, Any] = {
    "title": "case",
    "materials": {},
    "damping": {"ratio": "5 %", "frequencies": ["1 Hz", "20 Hz"]},
    "pounding": {"time_step": "1 us"},
    "spectra": {"damping": ["5 %"], "frequencies": ["1 Hz"]},
}
"""What takes the place of a section that is at fault and that every case has."""
_NEED_OTHERS = {
    "structure": ("wall_impact", "transient", "devices", "device_analysis", "calibration"),
    "transient": ("devices", "device_analysis"),
}
"""Sections without which others are of no use."""
_OPTIONAL = {"wall_impact", "transient", "devices", "calibration", "ensemble", "loads"}
_OPTIONAL |= {"wave_passage"}
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
    """Read a case as far as it can be read, so that further checks can tell its other faults.

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
    faults: list[Fault] = []
    try:
        sections: CaseFile | None = CaseFile.model_validate(source.raw, context=reading)
    except ValidationError as error:
        faults = explain(error, source, CaseFile)
        sections = _rest(error, reading)
    for as_it_stands in FILE_CHECKS:
        kind = as_it_stands.__name__.strip("_")
        faults += [reading.fault(*finding, kind) for finding in as_it_stands(reading)]
    if sections is None:
        return None, [*faults, *reading.faults], reading.left_out
    case, left_out = _completed(sections, reading), reading.left_out
    reading.lenient = True
    for check in CHECKS:
        kind = check.__name__.strip("_")
        faults += [reading.fault(*finding, kind) for finding in check(case, reading)]
    faults += reading.faults
    if not left_out:
        return case, faults, left_out
    # The case without what cannot be used; none where no building can be.
    buildings = tuple(building for building in case.buildings if building.floors)
    names = {building.name for building in buildings}
    structures = [one for one in case.structures if one.building in names]
    if case.structure is not None and not structures:
        left_out |= {"structure", *_NEED_OTHERS["structure"]}
    if "structure" in left_out:
        structures = []
    update = {
        "buildings": buildings,
        "contacts": tuple(c for c in case.contacts if names.issuperset(c.buildings)),
        "structure": next(iter(structures), None),
        "further_structures": tuple(structures[1:]),
        **{name: CaseFile.model_fields[name].default for name in left_out & _OPTIONAL},
    }
    if case.ensemble is not None and left_out & {"transient"} and not left_out & {"ensemble"}:
        update["ensemble"] = case.ensemble.model_copy(update={"structure_motions": 0})
    return case.model_copy(update=update) if buildings else None, faults, left_out


def _rest(error: ValidationError, reading: Reading) -> CaseFile | None:
    """What is left of a case file without what is at fault; None where nothing can be checked."""
    # Of an array of tables, or of tables by name, those without faults are left. A file that cannot
    # be read counts as empty.
    raw: dict[str, Any] = deepcopy(reading.source.raw)
    reading.lenient = True
    strict = error
    while True:
        before = deepcopy(raw)
        found = places(error, raw)
        # A 3D model at fault hides nothing of another one that is free of faults.
        entries = raw["buildings"] if isinstance(raw.get("buildings"), list) else []
        modelled = (isinstance(one, dict) and "structure" in one for one in entries)
        models = {k for k, has_one in enumerate(modelled) if has_one}
        at_fault = {place[1] for place, _ in found if _of_structure(place)}
        if models - at_fault:
            for k in at_fault:
                raw["buildings"][k].pop("structure")
            found = [one for one in found if not _of_structure(one[0])]
        own: dict[str, list[Place]] = {}
        for place, kind in found:
            name = "structure" if _of_structure(place) else str(place[0])
            reading.left_out |= {name, *_NEED_OTHERS.get(name, ())}
            if kind in (REPORTED, UNREADABLE):
                continue
            if _of_structure(place):
                raw["buildings"][place[1]].pop("structure", None)
            else:
                own.setdefault(name, []).append(place)
        for name, at in own.items():
            section, inside = raw.get(name), {place[1] for place in at if len(place) > 1}
            # Single tables are taken out where each fault is in one of them, else all of it.
            single = all(len(place) > 1 for place in at)
            if isinstance(section, list) and single:
                kept = [k for k in range(len(section)) if k not in inside]
                raw[name] = [section[k] for k in kept]
                earlier = reading.kept.get(name, range(len(section)))
                reading.kept[name] = [earlier[k] for k in kept]
            elif name in ("materials", "contact_laws") and isinstance(section, dict) and single:
                raw[name] = {key: table for key, table in section.items() if key not in inside}
            else:
                raw.pop(name, None)
        for name, placeholder in _PLACEHOLDERS.items():
            raw.setdefault(name, placeholder)
        if not raw.get("buildings"):
            return None
        try:
            return CaseFile.model_validate(raw, context=reading)
        except ValidationError as further:
            if raw == before and error is not strict:
                return None  # what is at fault cannot be taken out
            error = further


def _of_structure(place: Place) -> bool:
    """Whether a place is in the 3D model of a building."""
    return place[0] == "buildings" and place[2:3] == ("structure",)


def _completed(sections: CaseFile, reading: Reading) -> Case:
    """The case of the sections of its file, with what follows from other sections."""
    values = {name: getattr(sections, name) for name in CaseFile.model_fields}
    structures = [one.structure for one in sections.buildings if one.structure]
    source = reading.source
    names_it = source.path if sections.report.reference is None else source.file_of(_REFERENCE)
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
    return case.model_copy(update=update)
