"""A run beside a publication: every equation, figure and table, and how near ours comes."""

from __future__ import annotations

import fnmatch
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

REPRODUCED, DIFFERS, UNPUBLISHED, ABSENT, SHOWN = (
    "reproduced",
    "differs",
    "no number published",
    "not computed",
    "shown",
)


@dataclass(frozen=True)
class Compared:
    """One result beside its published value.

    Args:
        name: Name of the result.
        ours: Ours, SI; None when it was not computed, or the stage ran and has none.
        published: The published one, SI.
        unit: Their SI unit.
        difference: (ours − published) / |published|; None without one of them, or when it is zero.
        tolerance: Largest |difference| that counts as reproduced.
        status: `REPRODUCED`, `DIFFERS` or `ABSENT`.
        reason: Why it differs; "" when it does not.
    """

    name: str
    ours: float | None
    published: float | None
    unit: str
    difference: float | None
    tolerance: float
    status: str
    reason: str


@dataclass(frozen=True)
class Place:
    """An equation, figure or table of the publication with ours.

    Args:
        kind: What it is.
        number: Its number.
        title: What it shows.
        tells: What is to be said of ours.
        shows: Files of the run that show ours, relative to its folder.
        lacking: Patterns of files that were asked for and that no stage of the run wrote.
        compared: The results with a published value.
        status: The worst of its results; for a place without one, whether ours is shown.
    """

    kind: str
    number: str
    title: str
    tells: str
    shows: Sequence[str]
    lacking: Sequence[str]
    compared: Sequence[Compared] = field(default=())
    status: str = UNPUBLISHED

    @property
    def name(self) -> str:
        """Kind and number."""
        return f"{self.kind} {self.number}"


def places(
    reference: Mapping[str, Any], summary: Sequence[Mapping[str, Any]], written: Sequence[str]
) -> list[Place]:
    """Put a run beside a publication.

    Args:
        reference: The publication, as a case has it.
        summary: The scalar results with their published values.
        written: Files of the run, relative to its folder.
    """
    results = {entry["name"]: entry for entry in summary}
    return [_place(item, results, written) for item in reference["items"]]


def count(found: Sequence[Place], kind: str) -> Counter[str]:
    """How many places of a kind have each status."""
    return Counter(place.status for place in found if place.kind == kind)


def _place(
    item: Mapping[str, Any], results: Mapping[str, Mapping[str, Any]], written: Sequence[str]
) -> Place:
    shows: list[str] = []
    lacking: list[str] = []
    for pattern in item["shows"]:
        found = fnmatch.filter(written, pattern)
        shows += found
        lacking += [] if found else [pattern]
    compared = [_compared(value, results) for value in item["values"]]
    states = {one.status for one in compared}
    if DIFFERS in states:
        status = DIFFERS
    elif REPRODUCED in states:
        status = REPRODUCED
    elif ABSENT in states or (lacking and not shows):
        status = ABSENT
    else:
        status = SHOWN if item["kind"] == "equation" else UNPUBLISHED
    return Place(
        kind=item["kind"],
        number=item["number"],
        title=item["title"],
        tells=item["tells"] or "",
        shows=shows,
        lacking=lacking,
        compared=compared,
        status=status,
    )


def _compared(value: Mapping[str, Any], results: Mapping[str, Mapping[str, Any]]) -> Compared:
    entry = results.get(value["name"], {"value": None, "paper": None, "unit": ""})
    ours, published = entry["value"], entry["paper"]
    difference = None
    if published is None or value["name"] not in results:
        status = ABSENT
    elif ours is None:
        # The stage ran and has no such result, as a second impact that does not happen.
        status = DIFFERS
    elif published == 0.0:
        status = REPRODUCED if ours == 0.0 else DIFFERS
    else:
        difference = (ours - published) / abs(published)
        status = REPRODUCED if abs(difference) <= value["tolerance"] else DIFFERS
    return Compared(
        name=value["name"],
        ours=ours,
        published=published,
        unit=entry["unit"],
        difference=difference,
        tolerance=value["tolerance"],
        status=status,
        reason=(value["reason"] or "no reason is given") if status == DIFFERS else "",
    )
