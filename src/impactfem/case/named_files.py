"""The files that a case names: their bytes for the hash, their tables for the models."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from impactfem.case.bays import Bay, read_bays
from impactfem.case.design_spectrum import SpectrumTable, read_spectrum
from impactfem.case.device_matrices import DeviceMatrices, NamedMatrix, read_matrix
from impactfem.case.device_modes import DeviceMode, read_device_modes
from impactfem.case.floors import Floor, read_floors
from impactfem.case.given_spectra import GivenSpectra, read_given_spectra
from impactfem.case.known import Known
from impactfem.case.leaf import PositiveLength
from impactfem.case.loads import ForceTable, floor_faults, read_force_table
from impactfem.case.members import Beam, Column, MemberRow, Site, Wall, read_members
from impactfem.case.place import Place
from impactfem.case.published import Published, read_published
from impactfem.case.report import REFERENCE, Reference, read_reference
from impactfem.case.source import Source
from impactfem.case.table import Table
from impactfem.case.targets import Target, read_targets
from impactfem.system.errors import Fault
from impactfem.system.text_file import read_bytes

_LENGTH: TypeAdapter[float] = TypeAdapter(PositiveLength)


@dataclass
class NamedFiles:
    """The files a case names, read before the models are made.

    Args:
        source: The case file, whose content may have any faults.
        faults: Of the files.
        sections_at_fault: Names of the sections with such files.
    """

    source: Source
    faults: list[Fault] = field(default_factory=list)
    contents: dict[Path, bytes] = field(default_factory=dict)
    floors: dict[Path, tuple[Floor, ...]] = field(default_factory=dict)
    targets: dict[Path, tuple[Target, ...]] = field(default_factory=dict)
    force_tables: dict[Path, ForceTable] = field(default_factory=dict)
    spectra: dict[Path, SpectrumTable] = field(default_factory=dict)
    published: dict[str, Published] = field(default_factory=dict)
    reference: Reference | None = None
    walls: tuple[Wall, ...] = ()
    bays: tuple[Bay, ...] = ()
    beams: tuple[Beam, ...] = ()
    columns: tuple[Column, ...] = ()
    device_modes: dict[Path, tuple[DeviceMode, ...]] = field(default_factory=dict)
    given_spectra: dict[Path, GivenSpectra] = field(default_factory=dict)
    device_matrices: dict[tuple[Path, Path], DeviceMatrices] = field(default_factory=dict)
    floors_read: set[Path] = field(default_factory=set)
    device_files_read: set[Path] = field(default_factory=set)
    sections_at_fault: set[str] = field(default_factory=set)
    known: Known = field(init=False)

    def __post_init__(self) -> None:
        raw = self.source.raw
        buildings = tables_of(raw, "buildings")
        names = _building_names(raw)
        self.known = Known(
            groups={
                "materials": _keys(raw, "materials"),
                "contact_laws": _keys(raw, "contact_laws"),
                "buildings": names,
            },
            floors=self.floors,
            floors_of={name: Path(file) for name, file in _texts(raw, "floors").items()},
            targets=self.targets,
            material_of=_texts(raw, "material"),
            without_density=_without_density(raw),
        )
        with self._section("buildings"):
            for index, entry in buildings:
                self._read_floors(("buildings", index, "floors"), entry.get("floors"))
        calibration = raw.get("calibration")
        if isinstance(calibration, dict):
            place = ("calibration", "targets")
            with self._section("calibration"):
                self._read_targets(place, calibration.get("targets"), names)
        structure = raw.get("structure")
        if isinstance(structure, dict) and isinstance(structure.get("mesh"), dict):
            with self._section("structure"):
                self._read_structure(structure.get("building"), structure["mesh"])
        transient = raw.get("transient")
        if isinstance(transient, dict):
            what = "a force history (NetCDF or CSV)"
            with self._section("transient"):
                self._open(("transient", "forces"), transient.get("forces"), what)
        with self._section("devices"):
            for index, entry in tables_of(raw, "devices"):
                self._read_device_modes(("devices", index, "modes"), entry.get("modes"))
                self._read_given_spectra(("devices", index, "spectra"), entry.get("spectra"))
                self._read_matrices(("devices", index, "matrices"), entry.get("matrices"))
        with self._section("motions"):
            for index, entry in tables_of(raw, "motions"):
                self._open(("motions", index, "file"), entry.get("file"), "a record")
                self._read_spectrum(("motions", index, "spectrum", "file"), entry.get("spectrum"))
        with self._section("loads"):
            for index, entry in tables_of(raw, "loads"):
                self._read_forces(("loads", index, "file"), entry.get("file"))
        published: Mapping[str, Published] | None = None
        file = self._open(("published",), raw.get("published"), "a table (CSV)")
        if file is not None:
            published = read_published(self._path(file), self.faults)
            self.published = dict(published or {})
        report = raw.get("report")
        if isinstance(report, dict):
            file = self._open(("report", "reference"), report.get("reference"), REFERENCE)
            if file is not None:
                self.reference = read_reference(self._path(file), self.faults, published)

    @contextmanager
    def _section(self, name: str) -> Iterator[None]:
        """Files of a section of the case are read in the block; whether one is at fault is kept."""
        before = len(self.faults)
        yield
        if len(self.faults) > before:
            self.sections_at_fault.add(name)

    def _path(self, file: Path) -> Path:
        """A file relative to the working folder."""
        return self.source.path.parent / file

    def _open(self, place: Place, value: Any, what: str) -> Path | None:
        """Read the bytes of a file for the hash; None when it cannot be read."""
        if not isinstance(value, str) or not value.strip() or "\0" in value:
            return None  # a fault of the case file's own, found by its model
        file = Path(value)
        if file not in self.contents:
            content = read_bytes(self._path(file), what)
            if isinstance(content, Fault):
                self.faults.append(self.source.fault(place, value, content.expected))
                return None
            self.contents[file] = content
        return file

    def _read_floors(self, place: Place, value: Any) -> None:
        file = self._open(place, value, "a floor table (CSV)")
        if file is not None and file not in self.floors_read:
            self.floors_read.add(file)  # buildings share a table: its faults are told once
            _keep(self.floors, file, read_floors(self._path(file), self.faults))

    def _read_forces(self, place: Place, value: Any) -> None:
        file = self._open(place, value, "a table of forces (CSV)")
        if file is None or file in self.force_tables:
            return
        table = read_force_table(self._path(file), self.faults)
        names = self.known.names("buildings")
        if table is None or names is None:
            return
        self.force_tables[file] = table
        floors = {}
        for name in names:
            known = self.known.building_floors(name)
            floors[name] = None if known is None else tuple(floor.floor for floor in known)
        self.faults.extend(floor_faults(self._path(file), table, floors))

    def _read_targets(self, place: Place, value: Any, names: tuple[str, ...] | None) -> None:
        file = self._open(place, value, "a target table (CSV)")
        if file is not None:
            _keep(self.targets, file, read_targets(self._path(file), names, self.faults))

    def _read_device_modes(self, place: Place, value: Any) -> None:
        file = self._open(place, value, "a table of modes (CSV)")
        if file is not None and file not in self.device_files_read:
            self.device_files_read.add(file)  # devices share a table as well
            _keep(self.device_modes, file, read_device_modes(self._path(file), self.faults))

    def _read_given_spectra(self, place: Place, value: Any) -> None:
        file = self._open(place, value, "a table of floor spectra (CSV)")
        if file is not None and file not in self.device_files_read:
            self.device_files_read.add(file)
            table = read_given_spectra(self._path(file), self.faults)
            if table is not None:
                self.given_spectra[file] = table

    def _read_matrices(self, place: Place, entry: Any) -> None:
        if not isinstance(entry, dict):
            return
        found: list[tuple[Path, NamedMatrix]] = []
        for key in ("mass", "stiffness"):
            file = self._open((*place, key), entry.get(key), "a matrix (CSV)")
            matrix = None if file is None else read_matrix(self._path(file), self.faults)
            if file is not None and matrix is not None:
                found.append((file, matrix))
        if len(found) < 2:
            return
        (mass, M), (stiffness, K) = found
        if M.names != K.names:
            expected = f"expected the same names in the same order as in the header of {mass}"
            self.faults.append(self.source.fault((*place, "stiffness"), str(stiffness), expected))
            return
        matrices = DeviceMatrices(names=M.names, mass=M.rows, stiffness=K.rows)
        self.device_matrices[mass, stiffness] = matrices

    def _read_spectrum(self, place: Place, entry: Any) -> None:
        if not isinstance(entry, dict) or entry.get("type") != "table":
            return
        file = self._open(place, entry.get("file"), "a table of a design spectrum (CSV)")
        table = None if file is None else read_spectrum(self._path(file), self.faults)
        if file is not None and table is not None:
            self.spectra[file] = table

    def _read_structure(self, building: Any, mesh: dict[str, Any]) -> None:
        if mesh.get("type") == "file":
            self._open(("structure", "mesh", "file"), mesh.get("file"), "a mesh of gmsh (.msh)")
        if mesh.get("type") != "generated":
            return
        floors = self.known.building_floors(building) if isinstance(building, str) else None
        site = Site(
            length=self._length(mesh.get("length")),
            width=self._length(mesh.get("width")),
            heights=None if floors is None else {f.floor: f.storey_height for f in floors},
        )
        walls = self._read_members(mesh, "walls", Wall, site)
        self.walls = walls.rows if walls is not None else ()
        for_bays = self._open(("structure", "mesh", "bays"), mesh.get("bays"), "a bay table (CSV)")
        if for_bays is not None:
            bays = read_bays(self._path(for_bays), walls, site, self.faults)
            self.bays = bays.rows if bays is not None else ()
        beams = self._read_members(mesh, "beams", Beam, site)
        self.beams = beams.rows if beams is not None else ()
        columns = self._read_members(mesh, "columns", Column, site)
        self.columns = columns.rows if columns is not None else ()

    def _read_members(
        self, mesh: dict[str, Any], key: str, model: type[MemberRow], site: Site
    ) -> Table[MemberRow] | None:
        what = f"a {model.kind} table (CSV)"
        file = self._open(("structure", "mesh", key), mesh.get(key), what)
        if file is None:
            return None
        return read_members(self._path(file), model, site, self.faults)

    def _length(self, value: Any) -> float | None:
        """A length of the case file; None when it is at fault, which its model tells."""
        try:
            return _LENGTH.validate_python(value, context=self.known)
        except ValidationError:
            return None


def tables_of(raw: dict[str, Any], key: str) -> list[tuple[int, dict[str, Any]]]:
    """The tables of an array of tables with their index, as far as they are tables."""
    entries = raw.get(key)
    if not isinstance(entries, list):
        return []
    return [(index, entry) for index, entry in enumerate(entries) if isinstance(entry, dict)]


def _keep(rows: dict[Path, Any], file: Path, table: Table[Any] | None) -> None:
    if table is not None:
        rows[file] = table.rows


def _keys(raw: dict[str, Any], key: str) -> tuple[str, ...] | None:
    """The names of the tables of a table; none when it is left out, None when it is broken."""
    entries = raw.get(key, {})
    if not isinstance(entries, dict):
        return None
    return tuple(name for name, entry in entries.items() if isinstance(entry, dict))


def _building_names(raw: dict[str, Any]) -> tuple[str, ...] | None:
    """The names of the buildings; None when one has none, so that any reference may be to it."""
    names = [entry.get("name") for _, entry in tables_of(raw, "buildings")]
    if not names or not all(isinstance(name, str) for name in names):
        return None
    return tuple(dict.fromkeys(str(name) for name in names))


def _texts(raw: dict[str, Any], key: str) -> dict[str, str]:
    """What the buildings say under a key, by their name, as far as both are texts."""
    return {
        entry["name"]: entry[key]
        for _, entry in tables_of(raw, "buildings")
        if isinstance(entry.get("name"), str) and isinstance(entry.get(key), str)
    }


def _without_density(raw: dict[str, Any]) -> frozenset[str]:
    """Names of the materials that say no density."""
    entries = raw.get("materials")
    if not isinstance(entries, dict):
        return frozenset()
    return frozenset(
        name
        for name, entry in entries.items()
        if isinstance(entry, dict) and "density" not in entry
    )
