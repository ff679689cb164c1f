"""Results of a run compared with those of a publication."""

import fnmatch
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

REPRODUCED, DIFFERS, GIVEN = "reproduced", "differs", "given or fitted"
UNPUBLISHED, ABSENT, SHOWN = "no number published", "not computed", "shown"
STATUSES = (REPRODUCED, DIFFERS, GIVEN, UNPUBLISHED, SHOWN, ABSENT)
KINDS = ("equation", "figure", "table")
FARTHEST = 8
"""Number of results that differ on the first page."""


@dataclass(frozen=True)
class Compared:
    """One result and its published value."""

    name: str  #: name of the result
    ours: float | None  #: ours, SI; None where it was not computed, or the stage ran and has none
    published: float | None  #: the published one, SI
    unit: str  #: their SI unit
    #: (ours − published) / |published|; None without one of them, or when it is zero.
    difference: float | None
    tolerance: float  #: largest |difference| that counts as reproduced
    #: What the publication says: "=", or ">" or "<" its value, which holds or does not, whatever
    #: the tolerance.
    relation: str
    #: What ours is: "result", or "input", "fitted", "scaled", "selected" or "derived", which counts
    #: as `GIVEN` where it comes near.
    kind: str
    status: str  #: `REPRODUCED`, `GIVEN`, `DIFFERS` or `ABSENT`
    reason: str  #: why it differs; "" when it does not

    @property
    def distance(self) -> float:
        """|log| of ours over the published value; inf without a ratio."""
        if not self.ours or not self.published or self.ours * self.published < 0.0:
            return math.inf
        return abs(math.log(self.ours / self.published))


@dataclass(frozen=True)
class Place:
    """An equation, figure or table of the publication with ours."""

    item: Mapping[str, Any]  #: its kind, number, title, and its description in the case
    shows: Sequence[str]  #: files of the run that show ours, relative to its folder
    lacking: Sequence[str]  #: patterns of files that no stage of the run wrote
    compared: Sequence[Compared]  #: the results with a published value

    @property
    def status(self) -> str:
        """The worst of its results, or of what is given; without values, whether ours is shown."""
        states = {one.status for one in self.compared}
        if self.item.get("given"):
            states.add(GIVEN)
        if self.lacking and not self.shows:
            states.add(ABSENT)
        ranked = (DIFFERS, REPRODUCED, GIVEN, ABSENT)
        otherwise = SHOWN if self.item["kind"] == "equation" else UNPUBLISHED
        return next((status for status in ranked if status in states), otherwise)

    @property
    def standing(self) -> str:
        """How many results are reproduced, where some are not; what is given is no result."""
        results = [one for one in self.compared if one.kind == "result"]
        near = sum(one.status == REPRODUCED for one in results)
        differs = self.status == DIFFERS and results
        return f"{near} of {len(results)} reproduced" if differs else ""


def places(
    reference: Mapping[str, Any], summary: Sequence[Mapping[str, Any]], written: Sequence[str]
) -> list[Place]:
    """Compare a run with a publication: its scalar results, and files relative to its folder."""
    results = {entry["name"]: entry for entry in summary}
    made = []
    for item in reference["items"]:
        files = {pattern: fnmatch.filter(written, pattern) for pattern in item["shows"]}
        shows = [name for names in files.values() for name in names]
        lacking = [pattern for pattern, names in files.items() if not names]
        compared = [_compared(value, results.get(value["name"])) for value in item["values"]]
        made.append(Place(item, shows, lacking, compared))
    return made


def count(found: Sequence[Place], kind: str) -> Counter[str]:
    """How many places of a kind have each status."""
    return Counter(place.status for place in found if place.item["kind"] == kind)


def compared_values(found: Sequence[Place]) -> list[Compared]:
    """The compared values, each once."""
    return list({one.name: one for place in found for one in place.compared}.values())


def farthest(found: Sequence[Place]) -> list[Compared]:
    """The results that differ, those that are farthest from the published ones first."""
    values = compared_values(found)
    differing = [one for one in values if one.status == DIFFERS and one.kind == "result"]
    return sorted(differing, key=lambda one: -one.distance)


def _compared(value: Mapping[str, Any], entry: Mapping[str, Any] | None) -> Compared:
    """A value of the publication with the entry of the summary, if there is one."""
    result = entry or {"value": None, "paper": None, "unit": ""}
    ours, published = result["value"], result["paper"]
    # Runs of before 0.2 have neither.
    relation, kind = result.get("relation") or "=", result.get("kind") or "result"
    difference = None
    if published is None:
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
        status = DIFFERS if not good else REPRODUCED if kind == "result" else GIVEN
    return Compared(
        name=value["name"],
        ours=ours,
        published=published,
        unit=result["unit"],
        difference=difference,
        tolerance=value["tolerance"],
        relation=relation,
        kind=kind,
        status=status,
        reason=(value["reason"] or "no reason is given") if status == DIFFERS else "",
    )
