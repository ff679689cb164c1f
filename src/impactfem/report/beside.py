"""A run beside a publication: every equation, figure and table, and how near ours comes."""

from __future__ import annotations

import fnmatch
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

REPRODUCED, DIFFERS, GIVEN, UNPUBLISHED, ABSENT, SHOWN = (
    "reproduced",
    "differs",
    "given or fitted",
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
        relation: What the publication says: "=", or ">" or "<" its value, which holds or does not,
            whatever the tolerance.
        kind: What ours is: "result", or "input", "fitted", "scaled", "selected" or "derived", which
            counts as `GIVEN` where it comes near.
        status: `REPRODUCED`, `GIVEN`, `DIFFERS` or `ABSENT`.
        reason: Why it differs; "" when it does not.
    """

    name: str
    ours: float | None
    published: float | None
    unit: str
    difference: float | None
    tolerance: float
    relation: str
    kind: str
    status: str
    reason: str

    @property
    def distance(self) -> float:
        """|log| of ours over the published value: how far apart they are; inf without a ratio."""
        if not self.ours or not self.published or self.ours * self.published < 0.0:
            return math.inf
        return abs(math.log(self.ours / self.published))


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
        status: The worst of its results; what is given or fitted makes no place reproduced; for a
            place without a value, whether ours is shown.
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


def count_values(found: Sequence[Place]) -> Counter[str]:
    """How many compared values have each status, each once."""
    return Counter({one.name: one.status for place in found for one in place.compared}.values())


def farthest(found: Sequence[Place]) -> list[Compared]:
    """The results that differ, each once, those that are farthest from the published ones first."""
    differing = {
        one.name: one
        for place in found
        for one in place.compared
        if one.status == DIFFERS and one.kind == "result"
    }
    return sorted(differing.values(), key=lambda one: -one.distance)


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
    elif GIVEN in states or item.get("given"):
        status = GIVEN
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
    # Runs of before 0.2 have neither.
    relation, kind = entry.get("relation") or "=", entry.get("kind") or "result"
    difference = None
    near = REPRODUCED if kind == "result" else GIVEN
    if published is None or value["name"] not in results:
        status = ABSENT
    elif ours is None:
        # The stage ran and has no such result, as a second impact that does not happen.
        status = DIFFERS
    else:
        difference = (ours - published) / abs(published) if published != 0.0 else None
        if relation != "=":
            good = ours > published if relation == ">" else ours < published
        else:
            good = ours == 0.0 if difference is None else abs(difference) <= value["tolerance"]
        status = near if good else DIFFERS
    return Compared(
        name=value["name"],
        ours=ours,
        published=published,
        unit=entry["unit"],
        difference=difference,
        tolerance=value["tolerance"],
        relation=relation,
        kind=kind,
        status=status,
        reason=(value["reason"] or "no reason is given") if status == DIFFERS else "",
    )
