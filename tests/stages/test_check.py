"""Checks in the log."""

import logging

import pytest

from impactfem.stages.check import log_checks


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
