"""Reading a case file with all files it names; every fault of all of them is reported at once."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from impactfem.case.buildings import Building, BuildingEntry
from impactfem.case.calibration import Calibration, CalibrationEntry
from impactfem.case.contacts import expand
from impactfem.case.damping_cases import damping_case_faults
from impactfem.case.design_spectrum import TableSpectrum
from impactfem.case.device_analysis import DeviceAnalysis
from impactfem.case.devices import DeviceSetup
from impactfem.case.ensemble import Ensemble, ensemble_faults
from impactfem.case.explain import explain
from impactfem.case.file_mesh import FileMesh
from impactfem.case.generated_mesh import GeneratedMesh, GeneratedMeshEntry
from impactfem.case.loads import read_force_table
from impactfem.case.model import Case, CaseFile
from impactfem.case.motions import DIRECTIONS, Motion, RecordMotion, RestMotion, SyntheticMotion
from impactfem.case.named_files import NamedFiles, tables_of
from impactfem.case.pair_distance import distance_faults
from impactfem.case.part_damping import part_damping_faults
from impactfem.case.placed_devices import (
    DeviceTables,
    analysis_faults,
    device_faults,
    lacks_of_devices,
    resolve_analysis,
    resolve_device,
)
from impactfem.case.published import Published
from impactfem.case.report import Report
from impactfem.case.source import Source, read_source
from impactfem.case.struck_edge import struck_edge_faults
from impactfem.case.structure import Mesh, PartMaterial, Structure, StructureEntry
from impactfem.case.transient import Transient, transient_faults
from impactfem.case.wall_impact import (
    WallImpactSetup,
    calibrated_contact_faults,
    lacks_wall_impact,
    resolve_wall_impact,
    wall_impact_faults,
)
from impactfem.system.errors import Fault, InputError


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


def read_case(path: str | Path) -> tuple[Case | None, list[Fault], set[str]]:
    """Read a case as far as it can be read, so that further checks can tell its other faults.

    Args:
        path: As in `load_case`.

    Returns:
        The case, without the sections that cannot be read, or None where all need one of these;
        the faults; the names of the sections that are left out.

    Raises:
        InputError: A file is no case file at all.
    """
    source = read_source(Path(path), CaseFile)
    files = NamedFiles(source)
    case_file, faults = _validated(source.raw, source, files)
    left_out = {fault.key.partition(".")[0].partition("[")[0] for fault in faults}
    faults.extend(_duplicates(source))
    if not (source.raw.get("motions") or source.raw.get("loads")):
        expected = "missing; expected [[motions]], [[loads]] or both: what moves the buildings"
        faults.append(source.fault(("motions",), None, expected))
    faults.extend(_lacks_structure(source))
    faults.extend(lacks_wall_impact(source))
    faults.extend(damping_case_faults(source))
    faults.extend(part_damping_faults(source))
    faults.extend(lacks_of_devices(source))
    faults.extend(struck_edge_faults(source, files.known))
    faults.extend(files.faults)
    left_out |= files.sections_at_fault
    if not source.raw.get("motions") and ("loads" in left_out or not source.raw.get("loads")):
        left_out.add("motions")  # nothing that can be read moves the buildings
    rest = case_file
    if left_out:
        content = _without(source.raw, left_out)
        rest = None if content is None else _validated(content, source, files)[0]
    # These go on where a table is missing.
    case_file = case_file or rest
    if case_file is not None:
        faults.extend(_spectrum_faults(source, case_file, files))
        faults.extend(_wall_faults(source, case_file, files))
        faults.extend(_device_faults(source, case_file, files))
        if "structure" not in left_out:
            faults.extend(_storey_faults(source, case_file, files))
    if rest is None:
        return None, faults, left_out
    case_file = rest
    if any(fault.key.startswith("wall_impact") for fault in faults):
        left_out.add("wall_impact")
        case_file = case_file.model_copy(update={"wall_impact": None})
    case = _resolve(source, case_file, files)
    if case.ensemble is not None and "transient" in left_out:
        alone = case.ensemble.model_copy(update={"structure_motions": 0})
        case = case.model_copy(update={"ensemble": alone})
    if case.ensemble is not None:
        faults.extend(ensemble_faults(source, case.ensemble, case.motions, case.transient))
    if case.transient is not None and case.structure is not None:
        studied = case.building(case.structure.building)
        levels = (studied.base, *studied.elevations)
        computed = None if "pounding" in left_out else _computed_duration(case)
        faults.extend(
            transient_faults(source, case.transient, case.structure.mesh, levels, computed)
        )
    if "structure" not in left_out:
        faults.extend(_loop_faults(source, case))
    if not left_out & {"structure", "transient"}:
        faults.extend(_load_faults(source, case))
    faults.extend(distance_faults(source, case_file.contacts, case))
    return case, faults, left_out


def _validated(
    raw: dict[str, Any], source: Source, files: NamedFiles
) -> tuple[CaseFile | None, list[Fault]]:
    """The model of a content, or its faults."""
    try:
        return CaseFile.model_validate(raw, context=files.known), []
    except ValidationError as error:
        return None, explain(error, source, CaseFile)


# What takes the place of a section that is at fault and that every case has.
_PLACEHOLDERS: dict[str, Any] = {
    "title": "case",
    "pounding": {"time_step": "1 us"},
    "spectra": {"damping": ["5 %"], "frequencies": ["1 Hz"]},
}
_NEEDED = {"materials", "damping", "buildings", "motions"}
# Sections that are of no use without another one.
_NEED_OTHERS = {
    "structure": ("wall_impact", "transient", "devices", "device_analysis", "calibration"),
    "transient": ("devices", "device_analysis"),
    "contact_laws": ("contacts",),
    "wall_impact": (),
}


def _without(raw: dict[str, Any], sections: set[str]) -> dict[str, Any] | None:
    """The content of a case file without some sections and those that need them.

    Args:
        raw: The content.
        sections: Names of the sections; those that are left out for want of them are added.

    Returns:
        The rest; None where every case needs one of the sections.
    """
    for name in list(sections):
        sections.update(_NEED_OTHERS.get(name, ()))
    if sections & _NEEDED:
        return None
    rest = {name: section for name, section in raw.items() if name not in sections}
    return rest | {name: _PLACEHOLDERS[name] for name in sections & _PLACEHOLDERS.keys()}


def _duplicates(source: Source) -> Iterator[Fault]:
    """Names and directions that only one table may have, from the file as it stands."""
    groups = (
        *(("buildings", "name"), ("motions", "direction")),
        *(("damping_cases", "name"), ("devices", "name")),
    )
    for group, key in groups:
        seen: dict[str, int] = {}
        tables = dict(tables_of(source.raw, group))
        for index, entry in tables.items():
            value = entry.get(key)
            if not isinstance(value, str):
                continue
            # Files are named by these names: on some systems X and x are one file.
            first = seen.setdefault(value.lower(), index)
            if first != index:
                alike = value == tables[first].get(key)
                of_case = "" if alike else ", upper and lower case alike"
                expected = f"duplicate {key}{of_case}, the first is {group}[{first}].{key}"
                yield source.fault((group, index, key), value, expected)


def _lacks_structure(source: Source) -> Iterator[Fault]:
    """What the 3D model does without that model, from the file as it stands."""
    for section in ("wall_impact", "transient"):
        if section in source.raw and "structure" not in source.raw:
            expected = "expected a section [structure] beside it: the 3D model that moves"
            yield source.fault((section,), None, expected)


def _load_faults(source: Source, case: Case) -> Iterator[Fault]:
    """Loads at an angle to the edges of a generated building, which take its 3D model's forces."""
    if case.structure is None or case.transient is None:
        return
    mesh, name = case.structure.mesh, case.structure.building
    for index, loads in enumerate(case.loads):
        table = read_force_table(loads.file, [])
        if table is None or not isinstance(mesh, GeneratedMesh):
            continue
        across = abs(loads.direction["xyz".index(mesh.impact_edge[0])])
        if across < 1.0 - 1e-6 and any(building == name for building, _ in table.floors):
            expected = (
                f"expected a direction along {mesh.impact_edge[0]}, at right angles to the impact "
                f"edge of {name}: forces act on the edges of slabs in its 3D model"
            )
            yield source.fault(("loads", index, "direction"), list(loads.direction), expected)


def _computed_duration(case: Case) -> float | None:
    """Time that is computed of the sticks [s]; None when a record has to be read to know it."""
    if case.pounding.duration is not None:
        return case.pounding.duration
    lasting = [None if isinstance(m, RecordMotion) else m.duration for m in case.motions]
    known = [duration for duration in lasting if duration is not None]
    return max(known, default=None) if len(known) == len(lasting) else None


def _resolve(source: Source, case_file: CaseFile, files: NamedFiles) -> Case:
    folder = source.path.parent
    return Case(
        path=source.path,
        title=case_file.title,
        materials=case_file.materials,
        damping=case_file.damping,
        damping_cases=case_file.damping_cases,
        buildings=tuple(_building(entry, case_file, files) for entry in case_file.buildings),
        calibration=_calibration(case_file.calibration, files),
        structure=_structure(case_file.structure, case_file, files, folder),
        wall_impact=_wall_impact(case_file, files),
        transient=_transient(case_file.transient, folder),
        devices=_devices(case_file, files),
        device_analysis=_device_analysis(case_file),
        motions=_motions(case_file, files, folder),
        loads=tuple(
            loads.model_copy(update={"file": folder / loads.file}) for loads in case_file.loads
        ),
        contact_laws=case_file.contact_laws,
        contacts=expand(case_file.contacts),
        pounding=case_file.pounding,
        spectra=case_file.spectra,
        ensemble=_ensemble(case_file.ensemble, folder),
        report=_report(case_file, files),
        published=_published(files),
        digest=_digest(source, files.contents),
    )


def _building(entry: BuildingEntry, case_file: CaseFile, files: NamedFiles) -> Building:
    shared = {name: getattr(entry, name) for name in BuildingEntry.model_fields}
    return Building(
        **shared
        | {
            "material": case_file.materials[entry.material],
            "floors": files.floors[entry.floors],
            "damping": entry.damping or case_file.damping,
        }
    )


def _calibration(entry: CalibrationEntry | None, files: NamedFiles) -> Calibration | None:
    if entry is None:
        return None
    shared = {name: getattr(entry, name) for name in CalibrationEntry.model_fields}
    return Calibration(**shared | {"targets": files.targets[entry.targets]})


def _structure(
    entry: StructureEntry | None, case_file: CaseFile, files: NamedFiles, folder: Path
) -> Structure | None:
    if entry is None:
        return None
    materials = {building.name: building.material for building in case_file.buildings}
    shared = {name: getattr(entry, name) for name in StructureEntry.model_fields}
    return Structure(
        **shared
        | {
            "material": case_file.materials[entry.material or materials[entry.building]],
            "materials": tuple(
                PartMaterial(parts=own.parts, material=case_file.materials[own.material])
                for own in entry.materials
            ),
            "mesh": _mesh(entry.mesh, files, folder),
        }
    )


def _mesh(entry: GeneratedMeshEntry | FileMesh, files: NamedFiles, folder: Path) -> Mesh:
    if isinstance(entry, FileMesh):
        return entry.model_copy(update={"file": folder / entry.file})
    shared = {name: getattr(entry, name) for name in GeneratedMeshEntry.model_fields}
    tables = {name: getattr(files, name) for name in ("walls", "bays", "beams", "columns")}
    return GeneratedMesh(**shared | tables)


def _wall_impact(case_file: CaseFile, files: NamedFiles) -> WallImpactSetup | None:
    entry, structure = case_file.wall_impact, case_file.structure
    if entry is None or structure is None:
        return None
    return resolve_wall_impact(entry, _floor_numbers(files, structure))


def _floor_numbers(files: NamedFiles, structure: StructureEntry) -> list[int]:
    floors = files.known.building_floors(structure.building)
    return [floor.floor for floor in floors or ()]


def _transient(transient: Transient | None, folder: Path) -> Transient | None:
    if transient is None or transient.forces is None:
        return transient
    return transient.model_copy(update={"forces": folder / transient.forces})


def _devices(case_file: CaseFile, files: NamedFiles) -> tuple[DeviceSetup, ...]:
    structure = case_file.structure
    if structure is None:
        return ()
    levels, tables = _levels(case_file, files), _device_tables(files)
    return tuple(
        resolve_device(entry, tables, levels, structure.building) for entry in case_file.devices
    )


def _device_tables(files: NamedFiles) -> DeviceTables:
    return DeviceTables(files.device_modes, files.given_spectra, files.device_matrices)


def _device_analysis(case_file: CaseFile) -> DeviceAnalysis | None:
    if not case_file.devices or case_file.transient is None:
        return None
    return resolve_analysis(case_file.device_analysis, case_file.transient.time_step)


def _levels(case_file: CaseFile, files: NamedFiles) -> dict[int, float]:
    """Elevation of each floor [m] of the building of [structure]; none when they are not known."""
    for entry in case_file.buildings:
        named = case_file.structure is not None and entry.name == case_file.structure.building
        if named and entry.floors in files.floors:
            building = _building(entry, case_file, files)
            numbers = [floor.floor for floor in building.floors]
            return dict(zip(numbers, building.elevations, strict=True))
    return {}


def _motions(case_file: CaseFile, files: NamedFiles, folder: Path) -> tuple[Motion, ...]:
    """The motions; with loads alone ground at rest, along the direction of the first of them."""
    if case_file.motions:
        return tuple(_motion(motion, folder) for motion in case_file.motions)
    first, *_ = case_file.loads
    lasts = max(float(files.force_tables[loads.file].time[-1]) for loads in case_file.loads)
    along = [abs(component) for component in first.direction]
    rest = RestMotion(
        direction=DIRECTIONS[along.index(max(along))],
        type="rest",
        duration=case_file.pounding.duration or lasts,
        time_step=case_file.pounding.time_step,
    )
    return (rest,)


def _motion(motion: Motion, folder: Path) -> Motion:
    """The motion with the files it names relative to the working folder."""
    if isinstance(motion, RecordMotion):
        return motion.model_copy(update={"file": folder / motion.file})
    if isinstance(motion, SyntheticMotion) and isinstance(motion.spectrum, TableSpectrum):
        spectrum = motion.spectrum.model_copy(update={"file": folder / motion.spectrum.file})
        return motion.model_copy(update={"spectrum": spectrum})
    return motion


def _report(case_file: CaseFile, files: NamedFiles) -> Report:
    entry = case_file.report
    assumptions = () if entry is None else entry.assumptions
    return Report(reference=files.reference, assumptions=assumptions)


def _loop_faults(source: Source, case: Case) -> Iterator[Fault]:
    """A calibration on the 3D model's modes, without the 3D model of a building it names."""
    if case.calibration is None or not case.calibration.from_structure:
        return
    named = {target.building for target in case.calibration.targets}
    if case.structure is None:
        expected = "expected a section [structure], whose modes are the targets"
    elif case.structure.building not in named:
        expected = f"targets of the building of [structure], {case.structure.building}"
    else:
        return
    yield source.fault(("calibration", "from_structure"), True, expected)


def _spectrum_faults(source: Source, case_file: CaseFile, files: NamedFiles) -> Iterator[Fault]:
    """Motions whose damping the table of their design spectrum does not have."""
    for index, motion in enumerate(case_file.motions):
        if isinstance(motion, RecordMotion) or not isinstance(motion.spectrum, TableSpectrum):
            continue
        table = files.spectra.get(motion.spectrum.file)
        if table is not None and table.at(motion.damping) is None:
            expected = f"expected a damping of {motion.spectrum.file}: {table.dampings}"
            yield source.fault(("motions", index, "damping"), motion.damping, expected)


def _wall_faults(source: Source, case_file: CaseFile, files: NamedFiles) -> Iterator[Fault]:
    """What does not go together between the impact on a wall and the rest of the case."""
    entry, structure = case_file.wall_impact, case_file.structure
    if entry is None or structure is None:
        return
    known = _floor_numbers(files, structure)
    if known:
        yield from wall_impact_faults(source, entry, structure.building, known)
    yield from calibrated_contact_faults(
        source, case_file.contact_laws, case_file.contacts, structure.building
    )


def _device_faults(source: Source, case_file: CaseFile, files: NamedFiles) -> Iterator[Fault]:
    """What does not go together between the devices and the rest of the case."""
    if case_file.structure is not None:
        yield from device_faults(
            source,
            case_file.devices,
            _device_tables(files),
            case_file.structure,
            _levels(case_file, files),
            () if case_file.transient is None else case_file.transient.probes,
        )
    if case_file.transient is not None:
        step = case_file.transient.time_step
        yield from analysis_faults(source, case_file.device_analysis, step)


def _storey_faults(source: Source, case_file: CaseFile, files: NamedFiles) -> Iterator[Fault]:
    """Storeys of a generated building in which nothing stands."""
    structure = case_file.structure
    if structure is None or not isinstance(structure.mesh, GeneratedMeshEntry):
        return
    stood_in = {k for row in (*files.walls, *files.columns) for k in row.levels}
    bare = [str(k) for k in _floor_numbers(files, structure) if k not in stood_in]
    if bare:
        tables = [str(structure.mesh.walls), str(structure.mesh.columns or "")]
        expected = (
            f"no wall and no column stands in storey {', '.join(bare)}; expected one or more in "
            f"each storey, in {' or '.join(filter(None, tables))}"
        )
        yield source.fault(("structure", "mesh", "walls"), str(structure.mesh.walls), expected)


def _ensemble(ensemble: Ensemble | None, folder: Path) -> Ensemble | None:
    if ensemble is None or ensemble.records is None:
        return ensemble
    return ensemble.model_copy(update={"records": folder / ensemble.records})


def _digest(source: Source, contents: dict[Path, bytes]) -> str:
    """Hash of the case texts and their files; where the folder lies does not enter."""
    sha = hashlib.sha256()
    texts = [(name, text.encode()) for name, text in source.texts.items()]
    for name, content in [*texts, *((str(f), c) for f, c in contents.items())]:
        # Lengths keep the border between two files: moving bytes across it changes the hash.
        sha.update(f"{len(name.encode())} {name} {len(content)} ".encode())
        sha.update(content)
    return sha.hexdigest()


def _published(files: NamedFiles) -> dict[str, Published]:
    """The published values, with what the reference says that ours are beside them."""
    reference = files.reference
    if reference is None:
        return files.published
    return {
        name: value.model_copy(update={"kind": reference.kind(name)})
        for name, value in files.published.items()
    }
