"""Verdicts: a demand of a run, the capacity that it is compared with, and their ratio.

Each stage lists its verdicts; a run writes all of them into ``verdicts.json``. A demand without a
capacity names the key of the case that gives one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from impactfem.system.scalar import Scalar


@dataclass(frozen=True)
class Verdict:
    """A demand with impacts, and the capacity that it must not exceed."""

    id: str  #: stage and name of the quantity, ``device.anchor_tension``
    quantity: str  #: the compared quantity, a noun phrase
    unit: str  #: SI unit of demand and capacity, "-" without one
    place: str  #: building, floor, device or contact pair
    demand: float | None  #: with impacts; None where it could not be computed
    capacity: float | None = None  #: None where the case gives none
    key: str = ""  #: key of the case that gives the capacity
    demand_without_impact: float | None = None  #: None where it was not computed
    frequency: float | None = None  #: of a spectral ordinate [Hz]
    band: tuple[float, float] | None = None  #: frequencies that are compared [Hz]
    detail: str = ""  #: governing bolt, time and direction, or the rule; without a full stop

    @property
    def ratio(self) -> float | None:
        """Demand over capacity [-]; None without one of them."""
        if self.demand is None or self.capacity is None:
            return None
        if self.capacity <= 0.0:
            return math.inf if self.demand > 0.0 else 0.0
        return self.demand / self.capacity

    @property
    def passed(self) -> bool | None:
        """Whether the demand is at most the capacity; None without one of them."""
        return None if self.ratio is None else bool(self.ratio <= 1.0)

    def row(self, stage: str) -> dict[str, Any]:
        """Return the verdict of a stage as an entry of ``verdicts.json``, in SI."""
        ratio = self.ratio
        return {
            "stage": stage,
            **asdict(self),
            "ratio": ratio if ratio is not None and math.isfinite(ratio) else None,
            "passed": self.passed,
        }


def verdict_scalars(verdicts: Sequence[Verdict]) -> list[Scalar]:
    """Return number and largest ratio of the verdicts by given capacities; none without one."""
    given = [one for one in verdicts if one.key and one.ratio is not None]
    if not given:
        return []
    worst = max(given, key=lambda one: one.ratio or 0.0)
    exceeded = sum(one.passed is False for one in given)
    note = f"{worst.quantity}, {worst.place}"
    return [
        Scalar("verdicts.exceeded", float(exceeded), "-", f"of {len(given)} verdicts"),
        Scalar("verdicts.largest_ratio", worst.ratio, "-", note),
    ]


def pair_words(pair: str) -> str:
    """Return a contact pair in words: floor 3 of west and floor 3 of east.

    Further pairs of the same floors have a number: west.floor_3-east.floor_3#2 is pair 2.
    """
    both, _, number = pair.partition("#")
    sides = (side.partition(".") for side in both.split("-"))
    words = (f"{place.replace('_', ' ')} of {name}" if place else name for name, _, place in sides)
    return " and ".join(words) + (f" (pair {number})" if number else "")
