"""The context of a validation: the rest of a case file, and the files that it names."""

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationInfo
from pydantic_core import PydanticCustomError

from impactfem.case.base import REPORTED, UNREADABLE
from impactfem.case.leaf import FileName
from impactfem.case.place import SEARCHED, Place, value_at
from impactfem.case.source import Source
from impactfem.case.table import Table
from impactfem.system.errors import Fault
from impactfem.system.files import LARGEST, read_bytes


@dataclass
class Reading:
    """The context of a validation.

    Names are taken from the file as it stands, so that a reference to a table that has a fault of
    its own is no second fault.
    """

    #: The case file, whose content may have any faults.
    source: Source = field(default_factory=lambda: Source(Path()))
    faults: list[Fault] = field(default_factory=list)  #: what is wrong in the files that it names
    #: Their bytes, by their name in the case file.
    contents: dict[str, bytes] = field(default_factory=dict)
    #: Values of the sections that are validated already, without invalid parts.
    values: dict[str, Any] = field(default_factory=dict)
    #: Valid tables of the arrays of tables, by their index in the file.
    entries: dict[str, dict[int, Any]] = field(default_factory=dict)
    #: Names of the sections with a fault, and of those that are of no use without them.
    left_out: set[str] = field(default_factory=set)
    #: Name of the building whose 3D model is being read; "" outside of them.
    building: str = ""
    _tables: dict[tuple[Path, str, str], Any] = field(default_factory=dict)

    def fault(self, place: Place, expected: str, kind: str) -> Fault:
        """A fault of a key in the file that says it, with its value unless it holds tables."""
        value = self.value(*place)
        listed = value if isinstance(value, list) else [value]
        shown = listed and not any(isinstance(one, dict) for one in listed)
        return self.source.fault(place, value if shown else None, expected, kind)

    def original(self, place: Place) -> Place:
        """A place among the tables that are valid, as a place of the file.

        That of a pair of [contact_search] is a key of this section.
        """
        if place[:2] == ("contacts", SEARCHED):
            return ("contact_search", *place[2:])
        if len(place) > 1 and isinstance(place[1], int) and place[0] in self.entries:
            return (place[0], list(self.entries[str(place[0])])[place[1]], *place[2:])
        return place

    def value(self, *place: int | str) -> Any:
        """Return the value at a place of the file; None without one."""
        return value_at(place, self.source.raw)

    @property
    def three_d(self) -> dict[str, Place]:
        """The places of the 3D models, by the names of their buildings."""
        return {
            str(entry.get("name")): ("buildings", index, "structure")
            for index, entry in self.tables("buildings")
            if "structure" in entry
        }

    @contextmanager
    def model_of(self, building: str) -> Iterator[None]:
        """Name the building of the 3D model that is read in the block."""
        before, self.building = self.building, building
        try:
            yield
        finally:
            self.building = before

    def tables(self, key: str) -> list[tuple[int, dict[str, Any]]]:
        """The tables of an array of tables with their index, without entries that are no tables."""
        entries = self.source.raw.get(key)
        if not isinstance(entries, list):
            return []
        return [(index, entry) for index, entry in enumerate(entries) if isinstance(entry, dict)]

    def names(self, group: str) -> tuple[str, ...] | None:
        """The names of the tables of a section; None where one is not known, so that any may be.

        Two with one name are another fault: one of them should have a different name.
        """
        entries = self.source.raw.get(group, {})
        if isinstance(entries, dict) and group != "buildings":
            return tuple(name for name, entry in entries.items() if isinstance(entry, dict))
        names = [entry.get("name") for _, entry in self.tables(group)]
        if not names or not all(isinstance(name, str) for name in names):
            return None
        known = tuple(map(str, names))
        return known if len({name.lower() for name in known}) == len(known) else None

    def path(self, name: str) -> Path:
        """A file relative to the working folder, by its name in the case file."""
        return self.source.path.parent / name

    def fetch(self, name: str, what: str, largest: float) -> str:
        """Read the bytes of a file once, and return its fault in words, or ""."""
        content = self.contents.get(name) or read_bytes(self.path(name), what, largest)
        if isinstance(content, Fault):
            return content.expected
        self.contents[name] = content
        return ""

    def open(self, name: str, what: str, largest: float, deferred: bool = False) -> Path:
        """Read the bytes of a file, and give it relative to the working folder; or refuse it.

        One that is larger [byte] is not read. A `deferred` one is refused where it is used.
        """
        wrong = self.fetch(name, what, largest)
        if wrong and not deferred:
            raise PydanticCustomError(UNREADABLE, "{expected}", {"expected": wrong})
        return self.path(name)

    def table(self, name: Any, what: str, read: Callable[..., Any], *further: Any) -> Any:
        """Read the content of a file once; its faults are added to those of the reading.

        A file is read once for each `what`. `read` takes its path, a list for faults, and what is
        further given. Of a `Table` the rows are given; None where it
        has faults.
        """
        if not isinstance(name, str) or not name.strip() or self.fetch(name, what, LARGEST):
            return None
        path = self.path(name)
        # Of a 3D model: what stands in the table has to fit its own building.
        key = (path, what, self.building)
        if key not in self._tables:
            faults: list[Fault] = []
            found = read(path, faults, *further)
            self.faults += [fault for fault in faults if fault not in self.faults]
            self._tables[key] = found.rows if isinstance(found, Table) else found
        return self._tables[key]

    @property
    def inputs(self) -> list[tuple[str, bytes]]:
        """The case texts and the files that they name: their names there, and what is in them."""
        texts = [(name, text.encode()) for name, text in self.source.texts.items()]
        return [*texts, *sorted(self.contents.items())]

    @property
    def digest(self) -> str:
        """Hash of the case texts and their files; where the folder lies does not enter."""
        sha = hashlib.sha256()
        for name, content in self.inputs:
            # Lengths keep the border between two files: moving bytes across it changes the hash.
            sha.update(f"{len(name.encode())} {name} {len(content)} ".encode())
            sha.update(content)
        return sha.hexdigest()


def reading_of(info: ValidationInfo) -> Reading:
    """The context of the validation of a case file."""
    if not isinstance(info.context, Reading):
        raise TypeError("a case file is validated with what is known of it")
    return info.context


@dataclass(frozen=True)
class TableFile(FileName):
    """The name of a file in a case file, held as what is in the file."""

    #: Reads it: its path and a list for faults, and where `sited` the information of the
    #: validation, lead to what is in it, or None.
    read: Callable[..., Any] = lambda path, faults: None
    sited: bool = False  #: as said
    as_path: bool = False  #: whether the field holds the file itself, which is checked alone

    def check(self, value: Any, info: ValidationInfo) -> Any:
        """Read the file; a model made from Python has what is in it already."""
        if info.context is None and not self.as_path:
            return value
        path = super().check(value, info)
        if info.context is None:
            return path
        further = (info,) if self.sited else ()
        found = info.context.table(value, self.what, self.read, *further)
        if found is None:
            raise PydanticCustomError(REPORTED, "the file has faults")
        return path if self.as_path else found
