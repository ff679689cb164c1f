"""A variant of a case: a small case file that extends it, and the folder of its run."""

from __future__ import annotations

import hashlib
import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from impactfem.case.model import CaseFile
from impactfem.case.overlay import overlay_text
from impactfem.case.place import dotted
from impactfem.case.source import Source
from impactfem.run.axis import COMMAND_LINE, MOST, Axis, words
from impactfem.run.loop import check
from impactfem.run.stages import asked_stages
from impactfem.system.errors import Fault, ImpactfemError, InputError
from impactfem.system.files import atomic

CASES = "cases"
RUNS = "runs"
_LONGEST = 120  # letters of a name, with room for endings


@dataclass(frozen=True)
class Variant:
    """A variant of a case.

    Args:
        axes: The axes of the sweep.
        values: Its value on each axis, as in a case file.
    """

    axes: tuple[Axis, ...]
    values: tuple[Any, ...]

    @property
    def title(self) -> str:
        """What it is, in words."""
        pairs = zip(self.axes, self.values, strict=True)
        return ", ".join(f"{axis.key} = {words(value)}" for axis, value in pairs)

    @property
    def name(self) -> str:
        """Its name for files; it depends on its own values only."""
        pairs = zip(self.axes, self.values, strict=True)
        name = ",".join(f"{_plain(axis.key)}={_plain(words(value))}" for axis, value in pairs)
        if len(name) <= _LONGEST:
            return name
        digest = hashlib.sha256(self.title.encode()).hexdigest()[:8]
        return f"{name[: _LONGEST - 9]}-{digest}"

    def case_text(self, source: Source, folder: Path) -> str:
        """Its case file.

        Args:
            source: The case that it extends.
            folder: Where its case file will be.
        """
        changes = {axis.place: v for axis, v in zip(self.axes, self.values, strict=True)}
        title = self.title.replace("\n", " ")
        return f"# A variant: {title}\n{overlay_text(source, changes, folder, CaseFile)}"

    def case_file(self, folder: Path) -> Path:
        """Its case file in the folder of a sweep."""
        return folder / CASES / f"{self.name}.toml"

    def run_folder(self, folder: Path) -> Path:
        """The folder of its run in that of a sweep."""
        return folder / RUNS / self.name


def variants_of(axes: Sequence[Axis], *, zipped: bool) -> list[Variant]:
    """The variants of some axes, the last axis running fastest.

    Args:
        axes: The axes.
        zipped: Whether the axes run together, value by value; else each value of one meets each
            value of the others.

    Raises:
        InputError: Axes that run together differ in their number of values, there are too many
            variants, or two have one name.
    """
    lengths = [len(axis.values) for axis in axes]
    if zipped and len(set(lengths)) > 1:
        found = ", ".join(f"{axis.key} has {len(axis.values)}" for axis in axes)
        expected = f"expected the same number of values for each key; {found}"
        raise InputError([Fault(COMMAND_LINE, "--zip", None, expected)])
    if not zipped and math.prod(lengths) > MOST:
        expected = f"expected at most {MOST} variants, found {math.prod(lengths)}"
        raise InputError([Fault(COMMAND_LINE, "--set", None, expected)])
    lists = [axis.values for axis in axes]
    rows = zip(*lists, strict=True) if zipped else itertools.product(*lists)
    variants = [Variant(tuple(axes), tuple(row)) for row in rows]
    first: dict[str, Variant] = {}
    for variant in variants:
        other = first.setdefault(variant.name, variant)
        if other is not variant:
            expected = f"expected values that differ in letters and digits, as in {other.title}"
            raise InputError([Fault(COMMAND_LINE, "--set", variant.title, expected)])
    return variants


def check_variants(variants: Sequence[Variant], source: Source, stage: str | None) -> None:
    """Read every variant with all that it names; nothing is computed or left behind.

    Args:
        variants: The variants.
        source: The case that they extend, which has no fault itself.
        stage: The last stage to run.

    Raises:
        InputError: With the faults of all variants, each value of a key once.
    """
    faults: dict[str, Fault] = {}
    with TemporaryDirectory() as folder:
        for variant in variants:
            path = Path(folder) / "case.toml"
            path.write_text(variant.case_text(source, path.parent), encoding="utf-8")
            try:
                asked_stages(check(path), stage)
            except InputError as error:
                for fault in error.faults:
                    told = _told(fault, variant, path)
                    faults.setdefault(str(told), told)
            except ImpactfemError as error:
                told = Fault(COMMAND_LINE, f"--set {variant.title}", None, str(error))
                faults.setdefault(str(told), told)
    if faults:
        raise InputError(faults.values())


def write_case(variant: Variant, source: Source, folder: Path) -> None:
    """Write the case file of a variant into the folder of a sweep.

    Raises:
        ImpactfemError: It cannot be written.
    """
    path = variant.case_file(folder)
    try:
        path.parent.mkdir(exist_ok=True)
    except OSError as error:
        raise ImpactfemError(f"cannot write {path.parent}: {error.strerror or error}") from error
    with atomic(path) as temporary:
        temporary.write_text(variant.case_text(source, path.parent), encoding="utf-8")


def _told(fault: Fault, variant: Variant, path: Path) -> Fault:
    """A fault of a variant, as one of the value that makes it."""
    if fault.file != path:
        return fault
    for axis, value in zip(variant.axes, variant.values, strict=True):
        if fault.key == dotted(axis.place):
            return Fault(COMMAND_LINE, f"--set {axis.key}", value, fault.expected)
    told = str(fault).removeprefix(f"{path}: ")
    return Fault(COMMAND_LINE, f"--set {variant.title}", None, told)


def _plain(text: str) -> str:
    """A text of letters, digits and a few signs, for the name of a file."""
    short = re.sub(r"\s+|[\[\]\"']", "", text.replace("%", "pct"))
    return re.sub(r"[^\w.+-]+", "_", short)
