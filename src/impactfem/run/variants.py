"""Variants of a case: keys with their values, and a small case file for each choice."""

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

import numpy as np
import tomli_w

from impactfem.case.model import CaseFile
from impactfem.case.place import Place, dotted, key_fault, read_key, value_at
from impactfem.case.quantity import NUMBER, QUANTITY
from impactfem.case.source import EXTENDS, Source, file_names
from impactfem.case.unit import UnitError, to_si
from impactfem.run.check import check
from impactfem.run.stages import asked_stages
from impactfem.system.errors import Fault, ImpactfemError, InputError, file_errors, printable
from impactfem.system.files import atomic

Settings = Mapping[str, str | Sequence[Any]] | Sequence[str]
"""Texts `KEY=VALUES`; or by key a text of values, or a list of them."""

COMMAND_LINE = "command line"
CASES, RUNS = "cases", "runs"
MOST = 10_000  # values of a key and variants of a sweep: more is a slip of the pen
_LONGEST = 120  # letters of a name, with room for endings
_END = rf"\s*({NUMBER})\s*([^:]*?)\s*"
_RANGE = re.compile(rf"{_END}:{_END}:\s*(\d+)\s*(:\s*log\s*)?", re.DOTALL)


@dataclass(frozen=True)
class Axis:
    """A key that is swept, its place in the case, and its values as in a case file."""

    key: str
    place: Place
    values: tuple[Any, ...]

    @property
    def unit(self) -> str:
        """SI unit of the values; "-" for numbers; "" when they are words."""
        units = {unit for _, unit in map(in_si, self.values)}
        return units.pop() if len(units) == 1 else ""

    def cell(self, value: Any) -> float | str:
        """A value for a table: in SI where all values of the axis have one unit, else as words."""
        return in_si(value)[0] if self.unit else words(value)


@dataclass(frozen=True)
class Variant:
    """A variant of a case: a value of each axis of the sweep."""

    axes: tuple[Axis, ...]
    values: tuple[Any, ...]

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
        pairs = zip(self.axes, self.values, strict=True)
        return [(axis.key, words(value)) for axis, value in pairs]

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
        for axis, value in zip(self.axes, self.values, strict=True):
            value_at(axis.place[:-1], raw)[axis.place[-1]] = deepcopy(value)
        for place, name in list(file_names(raw, (), raw, CaseFile)):
            if not Path(name).is_absolute():
                value_at(place[:-1], raw)[place[-1]] = os.path.relpath(origin / name, target)
        extended = os.path.relpath(origin / source.path.name, target)
        changed: dict[str, Any] = {EXTENDS: extended}
        for axis in self.axes:
            *tables, last = itertools.takewhile(lambda part: isinstance(part, str), axis.place)
            table = changed
            for part in tables:
                table = table.setdefault(str(part), {})
            table[str(last)] = value_at((*tables, last), raw)
        return f"# A variant: {printable(self.title)}\n{tomli_w.dumps(changed)}"


def words(value: Any) -> str:
    """A value as on the command line."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def in_si(value: Any) -> tuple[float | str, str]:
    """A value in SI with its unit; a value that is no quantity as words, with the unit ""."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value), "-"
    match = QUANTITY.fullmatch(value) if isinstance(value, str) else None
    try:
        return (words(value), "") if match is None else to_si(float(match[1]), match[2])
    except UnitError:
        return words(value), ""


def read_axes(
    settings: Settings, source: Source, *, zipped: bool = False
) -> tuple[list[Axis], list[Fault]]:
    """The axes of the settings that are free of faults, and every fault.

    In a text of values they are separated by commas, and one may be a range. Where axes run
    together (`zipped`) one may have a value more than once.
    """
    if isinstance(settings, Mapping):
        pairs = list(settings.items())
    else:
        pairs = [(key.strip(), values) for key, _, values in (s.partition("=") for s in settings)]
    axes: list[Axis] = []
    faults: list[Fault] = []
    if not pairs:
        expected = "expected one key or more with its values, for example 'damping.ratio=3 %,5 %'"
        faults.append(Fault(COMMAND_LINE, "--set", None, expected))
    for key, given in pairs:
        place = read_key(key)
        wrong: list[tuple[Any, str]] = []  # the value at fault, if it is one, and what was expected
        values: list[Any] = []
        if place is None or place == (EXTENDS,):
            example = "a key of the case file, for example 'damping.ratio'"
            wrong.append((None, f"expected KEY=VALUES with {example}"))
        else:
            unknown = key_fault(place, source.raw, CaseFile)
            wrong += [] if unknown is None else [(None, unknown)]
            for other in axes:
                if all(a == b for a, b in zip(place, other.place, strict=False)):
                    hint = f"{other.key} is swept as well"
                    wrong.append((None, f"expected keys that do not hold one another; {hint}"))
            values = _values_of(given, wrong) if isinstance(given, str) else list(given)
            if not values and not wrong:
                wrong.append((None, "expected one value or more after '='"))
            written = [words(value) for value in values]
            repeated = dict.fromkeys(w for w in written if written.count(w) > 1 and not zipped)
            wrong += [(value, "expected each value once") for value in repeated]
            if not wrong:
                axes.append(Axis(key, place, tuple(values)))
        faults += [Fault(COMMAND_LINE, f"--set {key}".strip(), *one) for one in wrong]
    return axes, faults


def _values_of(text: str, wrong: list[tuple[Any, str]]) -> list[Any]:
    """The values of a text; what is wrong is added with what was expected."""
    items: list[str] = []  # between the commas that are in no quotes and no brackets
    for piece in text.split(",") if text.strip() else ():
        bare = re.sub(r"\"[^\"]*\"|'[^']*'", "", items[-1]) if items else ""
        if {'"', "'"} & set(bare) or sum(map(bare.count, "[{")) > sum(map(bare.count, "]}")):
            items[-1] += f",{piece}"
        else:
            items.append(piece)
    values: list[Any] = []
    for item in map(str.strip, items):
        try:
            content = tomllib.loads(f"value = {item}")
        except tomllib.TOMLDecodeError:
            content = {}
        value = content.get("value") if list(content) == ["value"] else None
        if not item:
            wrong.append((item, "expected a value between two commas"))
        elif isinstance(value, bool | int | float | str | list | dict):  # a date is a word
            values.append(value)
        elif ":" not in item:
            values.append(item)
        else:
            try:
                values += _range(item)
            except ValueError as error:
                wrong.append((item, str(error)))
    return values


def _range(text: str) -> list[Any]:
    """The values of a range, evenly spaced or in equal ratios, in the unit of its ends."""
    match = _RANGE.fullmatch(text)
    if match is None:
        forms = "start:stop:count or start:stop:count:log, for example '25 cm:35 cm:3'"
        raise ValueError(f"expected a range {forms}")
    first, unit, last, last_unit, number, log = match.groups()
    start, stop, count = float(first), float(last), int(number)
    if not 2 <= count <= MOST:
        raise ValueError(f"expected a range of 2 to {MOST} values")
    if unit and last_unit and unit != last_unit:
        raise ValueError("expected one unit for both ends of a range")
    if not (math.isfinite(start) and math.isfinite(stop)) or start == stop:
        raise ValueError("expected a range between two different finite numbers")
    if log and min(start, stop) <= 0.0:
        raise ValueError("expected a range above zero: its values have equal ratios")
    spaced = np.geomspace(start, stop, count) if log else np.linspace(start, stop, count)
    # Twelve digits: 0.1:0.3:3 is 0.1, 0.2, 0.3 and not 0.30000000000000004.
    rounded = [float(f"{value:.12g}") for value in spaced]
    if unit or last_unit:
        return [f"{value:.12g} {unit or last_unit}" for value in rounded]
    whole = not {".", "e", "E"} & set(first + last) and all(v.is_integer() for v in rounded)
    return [int(value) for value in rounded] if whole else list(rounded)


def variants_of(axes: Sequence[Axis], *, zipped: bool) -> list[Variant]:
    """The product of the axes, the last one running fastest, or `zipped` value by value.

    InputError where axes that run together differ in their number of values, there are too many
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
            if other.title == variant.title:
                expected = "expected each combination of values once"
            raise InputError([Fault(COMMAND_LINE, "--set", variant.title, expected)])
    return variants


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
                dotted(axis.place): (f"--set {axis.key}", value)
                for axis, value in zip(variant.axes, variant.values, strict=True)
            }
            whole = f"--set {variant.title}"
            found: list[Fault] = []
            try:
                asked_stages(check(path), stage)
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
