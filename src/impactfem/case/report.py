"""The report: assumptions that belong to the case, and the publication that it stands beside."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field, ValidationError

from impactfem.case.base import Section
from impactfem.case.explain import explain
from impactfem.case.known import Known
from impactfem.case.leaf import File, Text, Weight
from impactfem.case.source import Source, parse
from impactfem.case.text import read_text
from impactfem.errors import Fault, InputError

REFERENCE = "what the study stands beside (TOML)"


class ReferenceValue(Section):
    """A result that has a published value, and how near it has to come."""

    name: Text = Field(description="Name of the result, as in summary.json and in 'published'.")
    tolerance: Weight = Field(
        description="Largest difference from the published value that counts as reproduced."
    )
    reason: Text | None = Field(default=None, description="Why it differs by more, if it does.")


class ReferenceItem(Section):
    """An equation, figure or table of a publication, with its place in the run."""

    kind: Literal["equation", "figure", "table"] = Field(description="What it is.")
    number: Text = Field(description="Its number in the publication.")
    title: Text = Field(description="What it shows.")
    shows: tuple[Text, ...] = Field(
        default=(),
        description="Files of the run that show ours, relative to its folder; * for any letters.",
    )
    tells: Text | None = Field(
        default=None, description="What is to be said of ours: where it differs and why."
    )
    values: tuple[ReferenceValue, ...] = Field(default=(), description="Results compared.")


class Assumption(Section):
    """Something that is assumed, and why."""

    text: Text = Field(description="What is assumed.")
    reason: Text = Field(description="Why, and what it does to the results as far as it is known.")


class Reference(Section):
    """A publication that a case reproduces, place by place."""

    title: Text = Field(description="The publication.")
    assumptions: tuple[Assumption, ...] = Field(
        default=(), description="What it leaves out, and what the case takes in its place."
    )
    items: tuple[ReferenceItem, ...] = Field(description="Its equations, figures and tables.")


class ReportEntry(Section):
    """The report that a run ends in: one page that shows all results with their checks."""

    reference: File | None = Field(
        default=None,
        description="Equations, figures and tables of a publication, with tolerances (TOML); the "
        "report puts the results beside them.",
    )
    assumptions: tuple[Assumption, ...] = Field(
        default=(), description="What the case assumes, beside what the method does."
    )


class Report(Section):
    """The report with its reference read."""

    reference: Reference | None = None
    assumptions: tuple[Assumption, ...] = ()


def read_reference(path: Path, faults: list[Fault]) -> Reference | None:
    """Read the places of a publication; what is wrong with them is appended to ``faults``.

    Args:
        path: A TOML file as ``Reference`` says.
        faults: Every fault of the file is appended here.

    Returns:
        The places, or None when there were faults.
    """
    text = read_text(path, REFERENCE)
    if isinstance(text, Fault):
        faults.append(text)
        return None
    try:
        source = Source(path, parse(path, text))
        reference = Reference.model_validate(source.raw, context=Known())
    except InputError as error:
        faults.extend(error.faults)
        return None
    except ValidationError as error:
        faults.extend(explain(error, source, Reference))
        return None
    seen: set[tuple[str, str]] = set()
    before = len(faults)
    for index, item in enumerate(reference.items):
        if (item.kind, item.number) in seen:
            expected = f"each {item.kind} once"
            faults.append(source.fault(("items", index, "number"), item.number, expected))
        seen.add((item.kind, item.number))
    return reference if len(faults) == before else None
