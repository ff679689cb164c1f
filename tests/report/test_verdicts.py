"""Verdicts in the report and on the console."""

import pytest

from impactfem.report.verdicts import given, verdict_summary, verdicts_table
from impactfem.stages.verdict import Verdict


def rows(*verdicts):
    return [one.row("device") for one in verdicts]


SHEAR = Verdict("device.shear", "shear of a bolt", "N", "pump", 27.5e3, 94e3, "devices[0].anchors")
ZPA = Verdict("device.zpa", "ZPA", "m/s2", "pump", 150.0, 60.0, "zpa_limit", 6.8, frequency=100.0)
DRIFT = Verdict("pounding.drift", "drift", "-", "west", 0.002, None, "limits.storey_drift")
NO_GAP = Verdict("pounding.gap", "gap", "m", "a pair", 0.01, 0.0)


def test_the_largest_ratio_comes_first_and_rows_without_capacity_last():
    table = verdicts_table(rows(DRIFT, SHEAR, ZPA, NO_GAP))
    assert [row[0].split(" at ")[0] for row in table.rows] == [
        "gap",
        "ZPA",
        "shear of a bolt",
        "drift",
    ]
    zpa, shear, drift = table.rows[1:]
    assert zpa[1:] == ["150 m/s²", "6.8 m/s²", "60 m/s²", "2.5", "exceeded", "pump"]
    assert shear[1:6] == ["27.5 kN", "", "94 kN", "0.293", "passed"]
    assert drift[3] == drift[4] == "" and "limits.storey_drift" in drift[5]
    assert verdicts_table([]) is None


def test_verdicts_of_given_capacities_alone_count():
    assert given(rows(NO_GAP, DRIFT)) == [] and verdict_summary(rows(NO_GAP, DRIFT)) is None
    value, text = verdict_summary(rows(SHEAR, ZPA, DRIFT, NO_GAP))
    assert "1 of 2" in value and "2.5" in text
    assert "1" in verdict_summary(rows(SHEAR))[0] and "0.293" in verdict_summary(rows(SHEAR))[1]
    # A gap that is too small is named, one that is wide enough is not.
    assert "not counted: gap" in text and "gap" not in verdict_summary(rows(SHEAR))[1]


@pytest.mark.parametrize(("capacity", "word"), [(27.5e3, "passed"), (27.4e3, "exceeded")])
def test_words_of_a_verdict(capacity, word):
    one = Verdict("device.shear", "shear", "N", "pump", 27.5e3, capacity, "key")
    assert verdicts_table(rows(one)).rows[0][5] == word


def test_a_demand_that_was_not_computed_is_no_missing_capacity():
    one = Verdict("device.bolts", "interaction", "-", "pump", None, 1.0, "devices[0].anchors")
    assert "devices" not in verdicts_table(rows(one)).rows[0][-1]
