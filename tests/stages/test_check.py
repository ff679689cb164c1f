"""Checks in the log."""

import logging

import pytest

from impactfem.stages.check import limited, log_checks


@pytest.mark.parametrize(
    ("good", "logged"),
    [
        (True, ("DEBUG", "a number")),
        (None, ("DEBUG", "a number")),
        (False, ("WARNING", "warning: a number")),
    ],
)
def test_only_what_is_missed_is_a_warning(caplog, good, logged):
    with caplog.at_level(logging.DEBUG, "impactfem"):
        log_checks([(good, "a number")])
    assert [(record.levelname, record.getMessage()) for record in caplog.records] == [logged]


@pytest.mark.parametrize(
    ("arguments", "least", "wanted"),
    [
        (("q", 8.9e-16, 1e-9), False, (True, "q 8.9e-16 (limit 1e-9)")),
        (("q", 0.0, 1e-9), False, (True, "q 0 (limit 1e-9)")),
        (("q", 2e-9, 1e-9), False, (False, "q 2e-9 (limit 1e-9)")),
        (("q", 0.0037, 0.005, "%"), False, (True, "q 0.37 % (limit 0.5 %)")),
        (("q", 0.12, 0.5, "% of the gap"), False, (True, "q 12 % of the gap (limit 50 %)")),
        (("q", 7.0, 16.0), True, (False, "q 7 (at least 16)")),
        (("q", 1234.5, 2e3, "mm"), False, (True, "q 1234 mm (limit 2000 mm)")),
        # Just beyond its limit, it reads otherwise than the limit.
        (("q", 0.05004, 0.05, "%"), False, (False, "q 5.004 % (limit 5 %)")),
        (("q", 9.9999, 10.0), True, (False, "q 9.9999 (at least 10)")),
        # A value that is not known meets no limit.
        (("q", float("nan"), 1.0), False, (False, "q nan (limit 1)")),
        (("q", float("nan"), 1.0), True, (False, "q nan (at least 1)")),
    ],
)
def test_a_value_and_its_limit(arguments, least, wanted):
    assert limited(*arguments, least=least) == wanted
