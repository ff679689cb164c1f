"""A case file whose keys can be changed from Python, without text editing.

case = impactfem.load("towers.toml")
case.set("contact_laws.floor.stiffness", "5 GN/m")
run = impactfem.run(case, out="runs/stiff")
"""

import os
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Self

from impactfem.case import Case
from impactfem.case.model import CaseFile
from impactfem.case.place import Place, read_key, value_at
from impactfem.case.source import Source, read_source
from impactfem.run.check import check
from impactfem.run.variants import Key, Variant, read_variants
from impactfem.system.errors import Fault, InputError
from impactfem.system.files import atomic


class EditableCase:
    """A case file with changed keys; the original file is not changed."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)  #: the case file
        self._source: Source = read_source(self.path, CaseFile)
        self._changes: dict[Place, tuple[Key, Any]] = {}

    def __repr__(self) -> str:
        changes = f", changed: {self.variant.title}" if self._changes else ""
        return f"<Case {str(self.path)!r}: {self._source.raw.get('title', '')!r}{changes}>"

    @property
    def variant(self) -> Variant:
        """The changes, as a variant of the case file."""
        changes = self._changes.values()
        return Variant(tuple(key for key, _ in changes), tuple(value for _, value in changes))

    def get(self, key: str) -> Any:
        """Return the value of a key as the file or the last `set` states it; None if absent.

        Raises:
            InputError: The text is no key.
        """
        place = read_key(key)
        if place is None:
            expected = "expected a key of the case file, for example 'damping.ratio'"
            raise InputError([Fault(self.path, key, None, expected)])
        if place in self._changes:
            return self._changes[place][1]
        return value_at(place, self._source.raw)

    def set(self, key: str, value: Any) -> Self:
        """Set a key to a value and return the case.

        Args:
            key: The key with dots and, in lists, numbers from 0: "contacts[0].gap".
            value: The value as in the case file: "1 cm", a number, a list or a table.

        Raises:
            InputError: The case file has no such key. The value is validated by `check` and `run`.
        """
        try:
            (variant,) = read_variants({key: [value]}, None, self._source)
        except InputError as error:
            faults = error.faults
            raise InputError([Fault(self.path, key, value, f.expected) for f in faults]) from None
        self._changes[variant.keys[0].place] = variant.keys[0], value
        return self

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Write a case file that extends the original by the changes, and return its path.

        Raises:
            ImpactfemError: The file cannot be written.
        """
        target = Path(path)
        target.parent.mkdir(parents=True, exist_ok=True)
        with atomic(target) as temporary:
            temporary.write_text(self.variant.case_text(self._source, target.parent), "utf-8")
        return target

    def written_for(self, folder: Path) -> Path:
        """Return the case file of a run in a folder: the original, or a written file if changed."""
        if not self._changes:
            return self.path
        return self.write(folder.with_name(f"{folder.name}.toml"))

    def check(self) -> Case:
        """Validate the case with its changes, and return its values in SI.

        Raises:
            InputError: With every fault of the case.
        """
        if not self._changes:
            return check(self.path)
        with TemporaryDirectory() as folder:
            path = self.write(Path(folder) / self.path.name)
            try:
                return check(path)
            except InputError as error:
                # The temporary file is nothing that a user knows.
                faults = (
                    replace(fault, file=self.path) if fault.file == path else fault
                    for fault in error.faults
                )
                raise InputError(faults) from None
