"""The report: its assumptions, and the publication that it is compared with."""

import fnmatch
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, StrictBool, ValidationError, ValidationInfo

from impactfem.case.base import Section, nearest, once, refuse
from impactfem.case.explain import explain
from impactfem.case.leaf import File, Prose, Text
from impactfem.case.quantity import Weight
from impactfem.case.reading import Reading, TableFile, reading_of
from impactfem.case.source import read_source
from impactfem.case.table import Table, read_table
from impactfem.case.unit import UnitError, to_si
from impactfem.records.file import read_number
from impactfem.system.errors import Fault, InputError
from impactfem.system.files import LARGEST_TOML

Relation = Literal["=", ">", "<"]
Kind = Literal["result", "input", "fitted", "scaled", "selected", "derived"]
STAGE_OF = {
    "motion": "pounding",
    "sticks": "pounding",
    "pounding": "pounding",
    "frs": "pounding",
    "soil": "pounding",
    "building": "building",
    "reduce": "reduce",
    "calibration": "calibrate",
    "transient": "transient",
    "device": "device",
    "design": "design",
    "ensemble": "ensemble",
    "ensemble3d": "design",
}
"""The stage that makes a result, by the first word of its name."""


class PublishedRow(Section):
    """One row of the table of published values, in the units of the publication."""

    name: Text
    """Name of the result, as in summary.json."""
    value: Text
    """The published value; '> 110' or '< 110' where an inequality is published, which then holds or
    does not, whatever the tolerance."""
    unit: Text
    """Unit of the value; '-' when it has none."""
    source: Text
    """Place of publication: table, figure or section."""


class Published(Section):
    """A published value in SI, with its SI unit and where it is published.

    Args:
        value: The value, or the bound of an inequality.
        relation: Relation of the published result to the number: "=", or ">" or "<" the bound.
        unit: SI unit.
        source: Where it is published.
        kind: How our result relates to it: a result, or (`GivenValues`) no test of ours.
    """

    value: float
    relation: Relation = "="
    unit: str
    source: str
    kind: Kind = "result"


def read_published(path: Path, faults: list[Fault]) -> dict[str, Published] | None:
    """Read a table of published values, in SI by name; None when there are faults."""
    values: dict[str, Published] = {}

    def in_si(table: Table[PublishedRow]) -> Iterator[Fault]:
        for line, row in table:
            relation: Relation = "="
            if row.value[0] in "<>":
                relation = "<" if row.value[0] == "<" else ">"
            number = read_number(row.value if relation == "=" else row.value[1:])
            if number is None:
                expected = "expected a finite number (its unit is in the column 'unit'), or '> 110'"
                yield table.fault(line, "value", row.value, expected)
                continue
            try:
                value, unit = to_si(number, row.unit)
            except UnitError as error:
                expected = f"{error}; expected a unit, or '-'"
                yield table.fault(line, "unit", row.unit, expected)
                continue
            values[row.name] = Published(
                value=value, relation=relation, unit=unit, source=row.source
            )

    return None if read_table(path, PublishedRow, faults, in_si, once=("name",)) is None else values


REFERENCE = "a reference of the report (TOML)"


class ReferenceValue(Section):
    """A result with a published value and a tolerance."""

    name: Text
    """Name of the result, as in summary.json and in 'published'."""
    tolerance: Weight
    """Largest difference that counts as reproduced; not for inequalities."""
    reason: Prose | None = None
    """Reason for a larger difference."""


class ReferenceItem(Section):
    """An equation, figure or table of a publication, with its place in the run."""

    kind: Literal["equation", "figure", "table"]
    """Title of the item."""
    number: Text
    """Its number in the publication."""
    title: Text
    """Content of the item."""
    shows: tuple[Text, ...] = ()
    """Files of the run that show this item, relative to its folder; * for any letters."""
    tells: Prose | None = None
    """Comment on the result: differences and reasons."""
    given: StrictBool = False
    """All its values are inputs of the case."""
    values: tuple[ReferenceValue, ...] = ()
    """Results compared."""


class GivenValues(Section):
    """Published values that are inputs or calibrated: they never count as reproduced."""

    kind: Literal["input", "fitted", "scaled", "selected", "derived"]
    """'input': an input, or a formula of inputs; 'fitted': a parameter was fitted to it; 'scaled':
    the result was scaled to it; 'selected': chosen from several results by closeness; 'derived':
    not printed, but derived from printed values."""
    names: tuple[Text, ...] = Field(min_length=1)
    """Names of the table of published values; * for any letters."""
    reason: Prose
    """Explanation of the kind."""


class Assumption(Section):
    """An assumption and its reason."""

    name: Text | None = None
    """Name of the entry, for files that extend this one."""
    text: Prose
    """The assumption."""
    reason: Prose
    """Reason, and known effect on the results."""


class Reference(Section):
    """A publication that a case reproduces, item by item."""

    extends: File | None = None
    """Another file of this kind that this one extends; state only the differences, as in
    `[items."figure 1"]`, `[items."table 2".values."building.frequency.1"]`, `[given.fitted]` or
    `[assumptions.NAME]`."""
    title: Text
    """The publication."""
    assumptions: tuple[Assumption, ...] = ()
    """Missing data of the publication, and the values adopted."""
    given: tuple[GivenValues, ...] = ()
    """Published values that are inputs or calibrated (no independent check); all others are
    results."""
    items: tuple[ReferenceItem, ...]
    """Its equations, figures and tables."""

    def kind(self, name: str) -> Kind:
        """Relation of our result to the published value of the same name."""
        for one in self.given:
            if any(fnmatch.fnmatchcase(name, pattern) for pattern in one.names):
                return one.kind
        return "result"


PUBLISHED_FILE = TableFile("a table (CSV)", read_published)


def _read_reference(path: Path, faults: list[Fault], info: ValidationInfo) -> Reference | None:
    """Read the places of a publication, which may name the published values of the case."""
    reading, before = reading_of(info), len(faults)
    try:
        source = read_source(path, Reference, REFERENCE)
        if {"buildings", "pounding"} & source.raw.keys():
            expected = "this is a case; expected a reference: a title and [[items]], its figures"
            raise refuse(expected, kind="not_a_reference")
        reference = Reference.model_validate(source.raw, context=Reading(source))
    except InputError as error:
        faults.extend(error.faults)
        return None
    except ValidationError as error:
        faults.extend(explain(error.errors(), source, Reference))
        return None
    # Those that it extends are part of the case as well.
    folder = os.path.relpath(path.parent, reading.source.path.parent)
    for name in filter(None, source.texts):
        reading.open(os.path.normpath(Path(folder, name)), REFERENCE, LARGEST_TOML)
    seen: set[tuple[str, str]] = set()
    for index, item in enumerate(reference.items):
        if (item.kind, item.number) in seen:
            expected = f"each {item.kind} once"
            faults.append(source.fault(("items", index, "number"), item.number, expected))
        seen.add((item.kind, item.number))
    name = reading.value("published")
    if name is not None:
        published = reading.table(name, PUBLISHED_FILE.what, read_published)
        if published is not None:
            known = list(published)
            for i, item in enumerate(reference.items):
                for k, value in enumerate(item.values):
                    if value.name not in known:
                        expected = f"no published value; {nearest(value.name, known)}"
                        place = ("items", i, "values", k, "name")
                        faults.append(source.fault(place, value.name, expected))
            first: dict[str, int] = {}  # which one of [[given]] says the kind of a value
            for i, given in enumerate(reference.given):
                for k, pattern in enumerate(given.names):
                    found = fnmatch.filter(known, pattern)
                    wrong = [] if found else [f"no published value; {nearest(pattern, known)}"]
                    wrong += [
                        f"expected {one} in one of them, it is in given[{first[one]}] as well"
                        for one in found
                        if first.setdefault(one, i) != i
                    ]
                    at = ("given", i, "names", k)
                    faults += [source.fault(at, pattern, expected) for expected in wrong]
    return reference if len(faults) == before else None


REFERENCE_FILE = TableFile(REFERENCE, _read_reference, sited=True)


ALL_FIGURES = "all"


class Report(Section):
    """The report that a run ends in: one page that shows all results with their checks."""

    author: Text | None = None
    """Author of the study, for the signature block; default a blank line."""
    checker: Text | None = None
    """Checker of the study, likewise."""
    revision: Text | None = None
    """Revision of the study, as 'B, 2 March 2026', likewise."""
    figures: tuple[Text, ...] = ()
    """Figures in addition to the default ones and those that the reference shows, by the names of
    their files; ["all"] for all."""
    reference: Annotated[Reference, REFERENCE_FILE] | None = None
    """Equations, figures and tables of a publication, with tolerances (TOML), for comparison in the
    report."""
    assumptions: tuple[Assumption, ...] = ()
    """Assumptions of the case, in addition to those of the method."""

    _figures_once = once("figures", "figure")

    @property
    def shown_files(self) -> tuple[str, ...]:
        """Files that the items of the reference show; * for any letters."""
        items = () if self.reference is None else self.reference.items
        return tuple(name for item in items for name in item.shows)

    def requests(self, name: str, file: str) -> bool:
        """Return whether a figure is requested by its name, or shown by the reference."""
        if name in self.figures or ALL_FIGURES in self.figures:
            return True
        return any(fnmatch.fnmatchcase(f"figures/{file}", pattern) for pattern in self.shown_files)
