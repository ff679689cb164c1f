"""Reading a case file with all files it names; every fault of all of them is reported at once."""

from __future__ import annotations

import hashlib
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from impactfem.case.base import Known
from impactfem.case.buildings import Building, BuildingEntry
from impactfem.case.calibration import Calibration, CalibrationEntry
from impactfem.case.contacts import expand
from impactfem.case.design_spectrum import SpectrumTable, TableSpectrum, read_spectrum
from impactfem.case.ensemble import Ensemble, ensemble_faults
from impactfem.case.explain import explain
from impactfem.case.floors import Floor, read_floors
from impactfem.case.model import Case, CaseFile
from impactfem.case.motions import Motion, RecordMotion
from impactfem.case.published import Published, read_published
from impactfem.case.table import Table
from impactfem.case.targets import Target, read_targets
from impactfem.case.text import read_bytes, read_text
from impactfem.errors import Fault, InputError

_WHAT = "a case file (TOML); 'impactfem new NAME' writes one to start from"


def load_case(path: str | Path) -> Case:
    """Read a case file, its tables and its records.

    Args:
        path: The case file (TOML). Files it names are relative to its folder.

    Returns:
        The case: SI values, names resolved, tables read, contacts one for each pair of points.

    Raises:
        InputError: With every fault of the case file and of the files it names.
    """
    path = Path(path)
    text = read_text(path, _WHAT)
    if isinstance(text, Fault):
        raise InputError([text])
    raw = _parse(path, text)
    files = _Files(path, raw)
    faults: list[Fault] = []
    case_file: CaseFile | None = None
    try:
        case_file = CaseFile.model_validate(raw, context=files.known)
    except ValidationError as error:
        faults.extend(explain(error, path, raw, CaseFile))
    faults.extend(_duplicates(path, raw))
    faults.extend(files.faults)
    if case_file is not None:
        faults.extend(_spectrum_faults(path, case_file, files))
    if faults or case_file is None:
        raise InputError(faults)
    case = _resolve(path, text, case_file, files)
    if case.ensemble is not None:
        faults.extend(ensemble_faults(path, case.ensemble, case.motions))
    if faults:
        raise InputError(faults)
    return case


def _parse(path: Path, text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"\(at line (\d+), column (\d+)\)", str(error))
        reason = re.sub(r"\s*\(at .*\)$", "", str(error))
        key = f"line {place[1]}, column {place[2]}" if place else "the end of the file"
        line = text.splitlines()[int(place[1]) - 1].strip() if place else None
        raise InputError([Fault(path, key, line, f"not valid TOML: {reason}")]) from error
    except (ValueError, RecursionError) as error:
        reason = "tables nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise InputError([Fault(path, "", None, f"not valid TOML: {reason}")]) from error


@dataclass
class _Files:
    """The files a case names, read before the models are made.

    Args:
        path: The case file.
        raw: Its content as parsed, which may have any faults.
    """

    path: Path
    raw: dict[str, Any]
    faults: list[Fault] = field(default_factory=list)
    contents: dict[Path, bytes] = field(default_factory=dict)
    floors: dict[Path, tuple[Floor, ...]] = field(default_factory=dict)
    targets: dict[Path, tuple[Target, ...]] = field(default_factory=dict)
    spectra: dict[Path, SpectrumTable] = field(default_factory=dict)
    published: dict[str, Published] = field(default_factory=dict)
    floors_read: set[Path] = field(default_factory=set)
    known: Known = field(init=False)

    def __post_init__(self) -> None:
        buildings = _tables(self.raw, "buildings")
        names = _building_names(self.raw)
        self.known = Known(
            groups={
                "materials": _keys(self.raw, "materials"),
                "contact_laws": _keys(self.raw, "contact_laws"),
                "buildings": names,
            },
            floors=self.floors,
            floors_of={
                entry["name"]: Path(entry["floors"])
                for _, entry in buildings
                if isinstance(entry.get("name"), str) and isinstance(entry.get("floors"), str)
            },
            targets=self.targets,
        )
        for index, entry in buildings:
            self._read_floors(f"buildings[{index}].floors", entry.get("floors"))
        calibration = self.raw.get("calibration")
        if isinstance(calibration, dict):
            self._read_targets("calibration.targets", calibration.get("targets"), names)
        for index, entry in _tables(self.raw, "motions"):
            self._open(f"motions[{index}].file", entry.get("file"), "a record")
            self._read_spectrum(f"motions[{index}].spectrum.file", entry.get("spectrum"))
        file = self._open("published", self.raw.get("published"), "a table (CSV)")
        if file is not None:
            self.published = read_published(self.path.parent / file, self.faults) or {}

    def _open(self, key: str, value: Any, what: str) -> Path | None:
        """Read the bytes of a file for the hash; None when it cannot be read."""
        if not isinstance(value, str) or not value.strip() or "\0" in value:
            return None  # a fault of the case file's own, found by its model
        file = Path(value)
        if file not in self.contents:
            content = read_bytes(self.path.parent / file, what)
            if isinstance(content, Fault):
                self.faults.append(Fault(self.path, key, value, content.expected))
                return None
            self.contents[file] = content
        return file

    def _read_floors(self, key: str, value: Any) -> None:
        file = self._open(key, value, "a floor table (CSV)")
        if file is not None and file not in self.floors_read:
            self.floors_read.add(file)  # buildings share a table: its faults are told once
            _keep(self.floors, file, read_floors(self.path.parent / file, self.faults))

    def _read_targets(self, key: str, value: Any, names: tuple[str, ...] | None) -> None:
        file = self._open(key, value, "a target table (CSV)")
        if file is not None:
            _keep(self.targets, file, read_targets(self.path.parent / file, names, self.faults))

    def _read_spectrum(self, key: str, entry: Any) -> None:
        if not isinstance(entry, dict) or entry.get("type") != "table":
            return
        file = self._open(key, entry.get("file"), "a table of a design spectrum (CSV)")
        table = None if file is None else read_spectrum(self.path.parent / file, self.faults)
        if file is not None and table is not None:
            self.spectra[file] = table


def _keep(rows: dict[Path, Any], file: Path, table: Table[Any] | None) -> None:
    if table is not None:
        rows[file] = table.rows


def _tables(raw: dict[str, Any], key: str) -> list[tuple[int, dict[str, Any]]]:
    """The tables of an array of tables with their index, as far as they are tables."""
    entries = raw.get(key)
    if not isinstance(entries, list):
        return []
    return [(index, entry) for index, entry in enumerate(entries) if isinstance(entry, dict)]


def _keys(raw: dict[str, Any], key: str) -> tuple[str, ...] | None:
    """The names of the tables of a table; none when it is left out, None when it is broken."""
    entries = raw.get(key, {})
    if not isinstance(entries, dict):
        return None
    return tuple(name for name, entry in entries.items() if isinstance(entry, dict))


def _building_names(raw: dict[str, Any]) -> tuple[str, ...] | None:
    """The names of the buildings; None when one has none, so that any reference may be to it."""
    names = [entry.get("name") for _, entry in _tables(raw, "buildings")]
    if not names or not all(isinstance(name, str) for name in names):
        return None
    return tuple(dict.fromkeys(str(name) for name in names))


def _duplicates(path: Path, raw: dict[str, Any]) -> Iterator[Fault]:
    """Names and directions that only one table may have, from the file as it stands."""
    for group, key in (("buildings", "name"), ("motions", "direction")):
        seen: dict[str, int] = {}
        for index, entry in _tables(raw, group):
            value = entry.get(key)
            if not isinstance(value, str):
                continue
            first = seen.setdefault(value, index)
            if first != index:
                expected = f"duplicate {key}, the first is {group}[{first}].{key}"
                yield Fault(path, f"{group}[{index}].{key}", value, expected)


def _resolve(path: Path, text: str, case_file: CaseFile, files: _Files) -> Case:
    return Case(
        path=path,
        title=case_file.title,
        materials=case_file.materials,
        damping=case_file.damping,
        buildings=tuple(_building(entry, case_file, files) for entry in case_file.buildings),
        calibration=_calibration(case_file.calibration, files),
        motions=tuple(_motion(motion, path.parent) for motion in case_file.motions),
        contact_laws=case_file.contact_laws,
        contacts=expand(case_file.contacts),
        pounding=case_file.pounding,
        spectra=case_file.spectra,
        ensemble=_ensemble(case_file.ensemble, path.parent),
        published=files.published,
        digest=_digest(text, files.contents),
    )


def _building(entry: BuildingEntry, case_file: CaseFile, files: _Files) -> Building:
    shared = {name: getattr(entry, name) for name in BuildingEntry.model_fields}
    return Building(
        **shared
        | {
            "material": case_file.materials[entry.material],
            "floors": files.floors[entry.floors],
            "damping": entry.damping or case_file.damping,
        }
    )


def _calibration(entry: CalibrationEntry | None, files: _Files) -> Calibration | None:
    if entry is None:
        return None
    shared = {name: getattr(entry, name) for name in CalibrationEntry.model_fields}
    return Calibration(**shared | {"targets": files.targets[entry.targets]})


def _motion(motion: Motion, folder: Path) -> Motion:
    """The motion with the files it names relative to the working folder."""
    if isinstance(motion, RecordMotion):
        return motion.model_copy(update={"file": folder / motion.file})
    if isinstance(motion.spectrum, TableSpectrum):
        spectrum = motion.spectrum.model_copy(update={"file": folder / motion.spectrum.file})
        return motion.model_copy(update={"spectrum": spectrum})
    return motion


def _spectrum_faults(path: Path, case_file: CaseFile, files: _Files) -> Iterator[Fault]:
    """Motions whose damping the table of their design spectrum does not have."""
    for index, motion in enumerate(case_file.motions):
        if isinstance(motion, RecordMotion) or not isinstance(motion.spectrum, TableSpectrum):
            continue
        table = files.spectra.get(motion.spectrum.file)
        if table is not None and table.at(motion.damping) is None:
            expected = f"expected a damping of {motion.spectrum.file}: {table.dampings}"
            yield Fault(path, f"motions[{index}].damping", motion.damping, expected)


def _ensemble(ensemble: Ensemble | None, folder: Path) -> Ensemble | None:
    if ensemble is None or ensemble.records is None:
        return ensemble
    return ensemble.model_copy(update={"records": folder / ensemble.records})


def _digest(text: str, contents: dict[Path, bytes]) -> str:
    """Hash of the case text and its files; where the folder lies does not enter."""
    sha = hashlib.sha256()
    for name, content in [("", text.encode()), *((str(f), c) for f, c in contents.items())]:
        # Lengths keep the border between two files: moving bytes across it changes the hash.
        sha.update(f"{len(name.encode())} {name} {len(content)} ".encode())
        sha.update(content)
    return sha.hexdigest()
