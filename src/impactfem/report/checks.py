"""The checks of a run: counts by severity, and tables."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from impactfem.stages.check import digits, severity_counts

Checks = Sequence[Mapping[str, Any]]
"""Entries of `checks.json`."""
SEVERITIES = {
    "invalid": "do not use the results that the check names",
    "limited": "use the results within the limit that the check states",
}
"""What a failed check means, by its severity."""


@dataclass(frozen=True)
class Count:
    """How many checks of a run failed by severity, and passed."""

    invalid: int
    limited: int
    passed: int
    information: int  #: items without a limit

    @property
    def failed(self) -> int:
        """Number of failed checks."""
        return self.invalid + self.limited

    @property
    def words(self) -> str:
        """The counts in words."""
        if not self.failed:
            return f"all {self.passed} passed"
        return f"{self.invalid} invalid, {self.limited} limited"


def count(checks: Checks) -> Count:
    """Count the checks of a run."""
    return Count(**severity_counts(checks))


def failures(checks: Checks) -> Checks:
    """Return the failed checks, those that make results invalid first."""
    order = list(SEVERITIES)
    failed = (one for one in checks if one["passed"] is False)
    return sorted(failed, key=lambda one: order.index(one["severity"]))


@dataclass(frozen=True)
class Row:
    """A check as a row of a table."""

    id: str
    state: str  #: "invalid", "limited", "passed" or "information"
    quantity: str
    value: str
    allowed: str
    place: str
    more: str  #: detail; of a failed check also consequence and remedy


def rows(checks: Checks) -> list[Row]:
    """Return the rows of checks; only a failed check has its consequence and remedy."""
    made = []
    for one in checks:
        failed = one["passed"] is False
        state = one["severity"] if failed else "passed" if one["passed"] else "information"
        texts = [one["detail"]]
        texts += [one["consequence"], one["remedy"]] if failed else []
        more = ". ".join(text.removesuffix(".") for text in texts if text)
        value = "" if one["value"] is None else f"{digits(one['value'])} {one['unit']}".strip(" -")
        if one["value"] is None and one["passed"] is False:
            value = "not computed"
        made.append(
            Row(one["id"], state, one["quantity"], value, _allowed(one), one["place"], more)
        )
    return made


def _allowed(check: Mapping[str, Any]) -> str:
    low, high = check["lower"], check["upper"]
    if check["passed"] is None or (low is None and high is None):
        return ""
    if low is not None and high is not None:
        return f"{digits(low)} to {digits(high)}"
    return f"≤ {digits(high)}" if low is None else f"≥ {digits(low)}"
