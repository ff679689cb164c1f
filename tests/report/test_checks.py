"""Checks in the report: counts by severity, and rows."""

import pytest

from impactfem.report.checks import count, failures, rows
from impactfem.stages.check import CRITERIA, Criterion

LIMITED = Criterion("tests.limited", "a ratio", "-", upper=1.0, consequence="A", remedy="B")
INVALID = Criterion("tests.invalid", "a residual", "%", upper=0.1, severity="invalid")
for criterion in (LIMITED, INVALID):
    del CRITERIA[criterion.id]


def entries(*checks):
    return [one.row("pounding") for one in checks]


CHECKS = entries(
    LIMITED.check(2.0, "floor 3", "its detail"),
    LIMITED.check(0.5),
    INVALID.check(0.25),
    LIMITED.check(detail="no limit"),
)


def test_counts_by_severity():
    found = count(CHECKS)
    assert (found.invalid, found.limited, found.passed, found.information) == (1, 1, 1, 1)
    assert found.failed == 2
    assert count(CHECKS[1:2]).failed == 0


def test_invalid_results_come_first():
    assert [one["severity"] for one in failures(CHECKS)] == ["invalid", "limited"]


@pytest.mark.parametrize(
    ("number", "state", "value", "allowed", "more"),
    [
        (0, "limited", "2", "≤ 1", "its detail. A. B"),
        (1, "passed", "0.5", "≤ 1", ""),
        (2, "invalid", "25 %", "≤ 10", ""),
        (3, "information", "", "", "no limit"),
    ],
)
def test_consequence_and_remedy_of_failed_checks_alone(number, state, value, allowed, more):
    row = rows(CHECKS)[number]
    assert (row.state, row.value, row.allowed, row.more) == (state, value, allowed, more)
