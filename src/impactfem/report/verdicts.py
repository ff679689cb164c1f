"""Demands, capacities and verdicts of a run, for the report and the console."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from impactfem.report.facts import Facts, quantity, table

Rows = Sequence[Mapping[str, Any]]
"""Entries of `verdicts.json`."""


def verdicts_table(verdicts: Rows) -> Facts | None:
    """Return demands, capacities and verdicts, the largest ratio first; None without any."""
    known = sorted(verdicts, key=lambda one: one["passed"] is not False)
    known.sort(key=lambda one: -_ratio(one))

    def shown(value: float | None, unit: str) -> str:
        return "" if value is None else quantity(value, unit, digits=3).replace("m/s2", "m/s²")

    rows = []
    for one in known:
        at = f" up to {one['band'][1]:.3g} Hz" if one["band"] else ""
        at = at if one["frequency"] is None else f" at {one['frequency']:.3g} Hz"
        ratio = one["ratio"]
        word = {True: "passed", False: "exceeded"}.get(one["passed"], "not computed")
        if one["capacity"] is None:
            word = f"no capacity: {one['key']}"
        unit, detail = one["unit"], one["detail"]
        rows.append(
            (
                f"{one['quantity']}{at}",
                shown(one["demand"], unit),
                shown(one["demand_without_impact"], unit),
                shown(one["capacity"], unit),
                "" if ratio is None else f"{ratio:.3g}",
                word,
                f"{one['place']}; {detail}" if detail else one["place"],
            )
        )
    note = "The demand is that with impacts, in the resolved band."
    if any(one["capacity"] is None for one in known):
        note += " A row without a capacity names the key of the case that gives one."
    columns = (
        "quantity {}; demand {}; demand without impact {}; capacity {}; demand / capacity {}; "
        "verdict {}; place {}"
    )
    return table("Demand and capacity", columns, rows, note) if rows else None


def _ratio(verdict: Mapping[str, Any]) -> float:
    """The ratio of a verdict: infinite without a capacity left, −1 without a capacity."""
    if verdict["passed"] is None:
        return -1.0
    return math.inf if verdict["ratio"] is None else float(verdict["ratio"])


def given(verdicts: Rows) -> Rows:
    """Return the verdicts by capacities that the case gives."""
    return [one for one in verdicts if one["passed"] is not None and one["key"]]


def verdict_summary(verdicts: Rows) -> tuple[str, str] | None:
    """Return how many verdicts by given capacities are exceeded, and the largest ratio, in words.

    None where the case gives no capacity. A gap that is too small has no capacity in the case: the
    text names it.
    """
    known = given(verdicts)
    if not known:
        return None
    worst, count = max(known, key=_ratio), sum(not one["passed"] for one in known)
    value = f"{count} of {len(known)} exceeded" if count else f"{len(known)} of {len(known)} passed"
    text = f"largest ratio of demand to capacity {_ratio(worst):.3g}: {worst['quantity']}, "
    text += worst["place"]
    for one in verdicts:
        if one["passed"] is False and not one["key"]:
            text += f"; not counted: {one['quantity']}, exceeded"
    return value, text
