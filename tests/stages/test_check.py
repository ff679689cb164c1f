"""Checks as data: limits, sentence, row of checks.json, and the declarations of all stages."""

import logging
import math
import re
from pathlib import Path

import numpy as np
import pytest

from impactfem.run.stages import stage_names
from impactfem.stages.check import CRITERIA, Criterion, digits, log_checks

ROOT = Path(__file__).parents[2]


def made(**limits):
    """A criterion that is not registered."""
    criterion = Criterion("tests.criterion", "an error", "%", consequence="It matters", **limits)
    del CRITERIA["tests.criterion"]
    return criterion


@pytest.mark.parametrize(
    ("limits", "value", "passed"),
    [
        ({"upper": 0.05}, 0.05, True),
        ({"upper": 0.05}, 0.0501, False),
        ({"lower": 16.0}, 16.0, True),
        ({"lower": 16.0}, 15.9, False),
        ({"lower": 0.9, "upper": 1.1}, 0.9, True),
        ({"lower": 0.9, "upper": 1.1}, 1.2, False),
        ({"upper": 0.05}, math.nan, False),
        ({}, 0.05, None),
        ({"upper": 0.05}, None, None),
    ],
)
def test_passed(limits, value, passed):
    assert made(**limits).check(value).passed is passed


def test_limits_of_the_case_replace_those_of_the_criterion():
    check = made(upper=0.05).check(0.06, upper=0.07)
    assert (check.passed, check.upper) == (True, 0.07)


def test_the_sentence():
    """Quantity = value unit, place (limits); detail. Consequence of a failure alone."""
    criterion = made(upper=0.05)
    passed, failed = criterion.check(0.04, "floor 3", "more"), criterion.check(0.06, "floor 3")
    assert passed.text == "an error = 4 %, floor 3 (at most 5 %); more"
    assert failed.text == "an error = 6 %, floor 3 (at most 5 %). It matters"
    assert made().check(place="floor 3", detail="not known").text == "an error, floor 3: not known"


def test_a_value_just_beyond_its_limit_does_not_read_as_the_limit():
    assert "5.0001 %" in made(upper=0.05).check(0.050001).text


@pytest.mark.parametrize(
    ("value", "limits", "unit", "text"),
    [
        (8.9e-16, {"upper": 1e-9}, "", "= 8.9e-16 (at most 1e-9)"),
        (0.12, {"upper": 0.5}, "% of the gap", "= 12 % of the gap (at most 50 %)"),
        (7.0, {"lower": 16.0}, "", "= 7 (at least 16)"),
        (1234.5, {"upper": 2e3}, "mm", "= 1234 mm (at most 2000 mm)"),
        (9.9999, {"lower": 10.0}, "", "= 9.9999 (at least 10)"),
        (math.nan, {"upper": 1.0}, "", "= nan (at most 1)"),
        (1.2, {"lower": 0.9, "upper": 1.1}, "", "= 1.2 (allowed 0.9 to 1.1)"),
    ],
)
def test_values_and_limits_in_the_sentence(value, limits, unit, text):
    criterion = Criterion("tests.criterion", "q", unit, **limits)
    del CRITERIA["tests.criterion"]
    assert criterion.check(value).text == f"q {text}"


def test_only_what_fails_is_a_warning(caplog):
    checks = [made(**limits).check(1.0) for limits in ({"upper": 2.0}, {}, {"upper": 0.5})]
    with caplog.at_level(logging.DEBUG, "impactfem"):
        log_checks("B1/pounding", checks)
    assert [record.levelname for record in caplog.records] == ["DEBUG", "DEBUG", "WARNING"]
    starts = ["B1/pounding: ", "B1/pounding: ", "warning: B1/pounding: "]
    assert all(map(str.startswith, caplog.messages, starts))


def test_the_row_has_no_infinite_number():
    row = made(upper=0.05).check(np.nan, "floor 3").row("B1/pounding")
    assert (row["stage"], row["id"], row["place"]) == ("B1/pounding", "tests.criterion", "floor 3")
    assert (row["value"], row["lower"], row["upper"]) == (None, None, 5.0)
    assert (row["passed"], row["severity"]) == (False, "limited")
    assert made().check(1.0).row("pounding")["severity"] == "information"


def test_two_checks_with_one_id_are_refused():
    first = next(iter(CRITERIA.values()))
    with pytest.raises(ValueError, match=re.escape(first.id)):
        Criterion(first.id, "another quantity")


@pytest.mark.parametrize(
    ("value", "text"), [(15.71, "15.7"), (8.88e-16, "8.9e-16"), (123.4, "123"), (1e-3, "0.001")]
)
def test_digits(value, text):
    assert digits(value) == text


def ends(key):
    """Section and last name of a dotted key."""
    return key.split(".")[0], key.split(".")[-1]


def unknown_keys(text, known):
    """Dotted keys in a text that a case file does not have; files are no keys."""
    dotted = re.findall(r"\b[a-z_]+(?:\.[a-z_]+)+\b", text)
    return [key for key in dotted if ends(key)[1] not in ("csv", "log") and ends(key) not in known]


def test_every_limit_has_a_consequence_and_a_remedy_with_keys_that_exist():
    page = (ROOT / "docs" / "case-file.md").read_text("utf-8")
    known = {ends(key) for key in re.findall(r'id="([^"]+)"', page)}
    assert len(CRITERIA) > 50
    for criterion in CRITERIA.values():
        assert criterion.id.partition(".")[0] in stage_names()
        if math.isfinite(criterion.lower) or math.isfinite(criterion.upper):
            assert criterion.consequence and criterion.remedy, criterion.id
        assert unknown_keys(criterion.remedy, known) == [], criterion.id
    assert unknown_keys("Reduce pounding.no_such_key", known) == ["pounding.no_such_key"]
