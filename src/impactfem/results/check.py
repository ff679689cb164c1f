"""What a check of a stage says, and whether it is met."""

from __future__ import annotations

from collections.abc import Iterable

from impactfem.log import LOGGER

Check = tuple[bool, str]
"""Whether it is met, and the sentence with its number."""


def log_checks(checks: Iterable[Check]) -> None:
    """Log checks, as warnings where one is not met."""
    for good, line in checks:
        if good:
            LOGGER.info("%s", line)
        else:
            LOGGER.warning("warning: %s", line)
