"""Variants of a case: keys with their values, and a small case file for each choice."""

import csv
import hashlib
import itertools
import json
import math
import os
import re
import tomllib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import tomli_w

from impactfem.case.model import CONDITIONS, CaseFile
from impactfem.case.place import Place, dotted, key_fault, read_key, value_at
from impactfem.case.quantity import QUANTITY
from impactfem.case.source import EXTENDS, Source, file_names
from impactfem.case.unit import UnitError, to_si
from impactfem.run.check import check
from impactfem.run.stages import asked_stages
from impactfem.system.errors import Fault, ImpactfemError, InputError, file_errors, printable
from impactfem.system.files import LARGEST_TOML, atomic, read_text

Settings = Mapping[str, Sequence[Any]] | Sequence[str]
"""The values by key, or texts `KEY=VALUE,VALUE`."""

COMMAND_LINE = "command line"
CASES, RUNS = "cases", "runs"
MOST = 10_000  # variants of a sweep: more is a slip of the pen
_LONGEST = 120  # letters of a name, with room for endings


@dataclass(frozen=True)
class Key:
    """A changed key: its text, and its place in the case."""

    name: str
    place: Place


@dataclass(frozen=True)
class Variant:
    """A variant of a case: its changed keys and their values as in a case file."""

    keys: tuple[Key, ...]
    values: tuple[Any, ...]
    #: Whether its case allows every condition of the key `allow`: one of a range, as in a fit.
    lenient: bool = False

    @property
    def title(self) -> str:
        """Its keys and values in words."""
        return ", ".join(f"{key} = {value}" for key, value in self._words())

    @property
    def name(self) -> str:
        """Its name for files, of letters, digits and a few signs; it depends on its values only."""
        parts = []
        for pair in self._words():
            short = [re.sub(r"\s+|[\[\]\"']", "", text.replace("%", "pct")) for text in pair]
            parts.append("=".join(re.sub(r"[^\w.+-]+", "_", text) for text in short))
        name = ",".join(parts)
        if len(name) <= _LONGEST:
            return name
        digest = hashlib.sha256(self.title.encode()).hexdigest()[:8]
        return f"{name[: _LONGEST - 9]}-{digest}"

    def _words(self) -> list[tuple[str, str]]:
        return [(k.name, words(value)) for k, value in zip(self.keys, self.values, strict=True)]

    def case_file(self, folder: Path) -> Path:
        """Its case file in the folder of a sweep."""
        return folder / CASES / f"{self.name}.toml"

    def run_folder(self, folder: Path) -> Path:
        """The folder of its run in that of a sweep."""
        return folder / RUNS / self.name

    def case_text(self, source: Source, folder: Path) -> str:
        """Its case file, which extends the case `source` by what differs.

        A file that extends another one replaces a list as a whole: a change within a list writes
        all of it. Names of files become relative to the `folder` of the new file, which need not
        exist yet.
        """
        raw, origin = deepcopy(source.raw), source.path.parent.resolve()
        target = folder.resolve()
        for key, value in zip(self.keys, self.values, strict=True):
            table: Any = raw
            for end, part in enumerate(key.place[:-1], start=1):
                # A section that the case leaves to its defaults, see `key_fault`.
                if isinstance(table, dict) and isinstance(part, str):
                    table.setdefault(part, {})
                table = value_at(key.place[:end], raw)
            table[key.place[-1]] = deepcopy(value)
        for place, name in list(file_names(raw, (), raw, CaseFile)):
            if not Path(name).is_absolute():
                value_at(place[:-1], raw)[place[-1]] = os.path.relpath(origin / name, target)
        extended = os.path.relpath(origin / source.path.name, target)
        changed: dict[str, Any] = {EXTENDS: extended}
        for key in self.keys:
            *tables, last = itertools.takewhile(lambda part: isinstance(part, str), key.place)
            table = changed
            for part in tables:
                table = table.setdefault(str(part), {})
            table[str(last)] = value_at((*tables, last), raw)
        if self.lenient:
            changed["allow"] = list(CONDITIONS)
        return f"# A variant: {printable(self.title)}\n{tomli_w.dumps(changed)}"


def words(value: Any) -> str:
    """Return a value as on the command line."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def in_si(value: Any) -> tuple[float | str, str]:
    """Return a value in SI with its unit; a value that is no quantity as words, with unit ""."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value), "-"
    match = QUANTITY.fullmatch(value) if isinstance(value, str) else None
    try:
        return (words(value), "") if match is None else to_si(float(match[1]), match[2])
    except UnitError:
        return words(value), ""


def read_variants(settings: Settings, table: Path | None, source: Source) -> list[Variant]:
    """Return the variants of settings, each value of a key with each of the others, or of a table.

    A table (CSV) has the keys in its first line and a variant in each further line; lines that
    begin with # are comments.

    Raises:
        InputError: With every fault of keys and values; without variants, or more than `MOST`.
    """
    faults: list[Fault] = []
    if table is not None:
        names, rows = _read_table(table, faults)
        where: Path | str = table
    else:
        pairs = _pairs(settings)
        names, where = [name for name, _ in pairs], COMMAND_LINE
        lists = [_values(f"--set {name}", given, faults) for name, given in pairs]
        count = math.prod(map(len, lists))
        if count > MOST:
            faults.append(Fault(COMMAND_LINE, "--set", None, f"expected at most {MOST} variants"))
        rows = list(itertools.product(*lists)) if lists and count <= MOST else []
    keys: list[Key] = []
    for name in names:
        label = f"--set {name}".strip() if table is None else name
        key = _key(name, source, keys)
        if isinstance(key, str):
            faults.append(Fault(where, label, None, key))
        else:
            keys.append(key)
    if not rows and not faults:
        expected = "expected a key with its values, for example --set 'damping.ratio=3 %,5 %'"
        faults.append(Fault(where, "" if table else "--set", None, expected))
    if faults:
        raise InputError(faults)
    variants = [Variant(tuple(keys), tuple(row)) for row in rows]
    first: dict[str, Variant] = {}
    for variant in variants:
        if (other := first.setdefault(variant.name, variant)) is not variant:
            expected = f"expected variants that differ in letters and digits, as in {other.title}"
            raise InputError([Fault(where, "", variant.title, expected)])
    return variants


def _pairs(settings: Settings) -> list[tuple[str, Any]]:
    if isinstance(settings, Mapping):
        return list(settings.items())
    return [(key.strip(), text) for key, _, text in (one.partition("=") for one in settings)]


def _key(name: str, source: Source, others: Sequence[Key]) -> Key | str:
    """Return a key of the case; for another text what is expected."""
    place = read_key(name)
    if place is None or place == (EXTENDS,):
        return "expected a key of the case file, for example 'damping.ratio'"
    unknown = key_fault(place, source.raw, CaseFile)
    if unknown is not None:
        return unknown
    for other in others:
        if all(a == b for a, b in zip(place, other.place, strict=False)):
            return f"expected keys that do not hold one another; {other.name} varies as well"
    return Key(name, place)


def _values(label: str, given: Any, faults: list[Fault]) -> list[Any]:
    """Return the values of a key, those of a text as in a case file; report repeated values."""
    values = _split(given) if isinstance(given, str) else list(given)
    if "" in values or not values:
        faults.append(Fault(COMMAND_LINE, label, None, "expected values separated by commas"))
    written = [words(value) for value in values]
    repeated = {value for value in written if written.count(value) > 1}
    faults += [Fault(COMMAND_LINE, label, v, "expected each value once") for v in sorted(repeated)]
    return values


def _split(text: str) -> list[Any]:
    """Split a text at the commas outside quotes and brackets into values."""
    items: list[str] = []
    for piece in text.split(",") if text.strip() else ():
        bare = re.sub(r"\"[^\"]*\"|'[^']*'", "", items[-1]) if items else ""
        if {'"', "'"} & set(bare) or sum(map(bare.count, "[{")) > sum(map(bare.count, "]}")):
            items[-1] += f",{piece}"
        else:
            items.append(piece)
    return [_value(item.strip()) for item in items]


def _value(text: str) -> Any:
    """Return a value of a case file; a text without quotes is a word."""
    try:
        content = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text
    value = content.get("value") if list(content) == ["value"] else None
    return value if isinstance(value, bool | int | float | str | list | dict) else text


def _read_table(path: Path, faults: list[Fault]) -> tuple[list[str], list[tuple[Any, ...]]]:
    """Read keys and values from a table of variants."""
    text = read_text(path, "a table of variants (CSV)", LARGEST_TOML)
    if isinstance(text, Fault):
        faults.append(text)
        return [], []
    written = (line for line in text.splitlines() if not line.startswith("#"))
    names, *lines = list(csv.reader(written)) or [[]]
    rows = [[cell.strip() for cell in line] for line in lines if any(map(str.strip, line))]
    for number, row in enumerate(rows, 2):
        if len(row) != len(names) or "" in row:
            expected = f"expected a value for each of the {len(names)} keys"
            faults.append(Fault(path, f"variant {number - 1}", None, expected))
    if len(rows) > MOST:
        faults.append(Fault(path, "", len(rows), f"expected at most {MOST} variants"))
    return [name.strip() for name in names], [tuple(map(_value, row)) for row in rows]


def check_variants(variants: Sequence[Variant], source: Source, stage: str | None) -> None:
    """Read every variant with all files that it names; nothing is computed or left behind.

    Raises:
        InputError: With the faults of all variants, each value of a key once.
    """
    faults: dict[str, Fault] = {}
    with TemporaryDirectory() as folder:
        for variant in variants:
            path = Path(folder) / "case.toml"
            path.write_text(variant.case_text(source, path.parent), encoding="utf-8")
            settings = {
                dotted(key.place): (f"--set {key.name}", value)
                for key, value in zip(variant.keys, variant.values, strict=True)
            }
            whole = f"--set {variant.title}"
            found: list[Fault] = []
            try:
                asked_stages(check(path, conditions=not variant.lenient), stage)
            except InputError as error:
                for fault in error.faults:
                    if fault.file != path:
                        file = fault.file  # as /tmp/folder/../../home/user/floors.csv
                        if str(file).startswith(folder):
                            file = Path(file).resolve()
                        found.append(replace(fault, file=file))
                    elif fault.key in settings:  # the fault of the setting that makes the value
                        key, value = settings[fault.key]
                        found.append(Fault(COMMAND_LINE, key, value, fault.expected))
                    else:
                        text = str(fault).removeprefix(f"{path}: ")
                        found.append(Fault(COMMAND_LINE, whole, None, text))
            except ImpactfemError as error:
                found.append(Fault(COMMAND_LINE, whole, None, str(error)))
            for fault in found:
                faults.setdefault(str(fault), fault)
    if faults:
        raise InputError(faults.values())


def write_case(variant: Variant, source: Source, folder: Path) -> None:
    """Write the case file of a variant into the folder of a sweep; ImpactfemError if it cannot."""
    path = variant.case_file(folder)
    with file_errors():
        path.parent.mkdir(exist_ok=True)
    with atomic(path) as temporary:
        temporary.write_text(variant.case_text(source, path.parent), encoding="utf-8")
