"""What a check of a stage says, and whether it is met."""

from __future__ import annotations

from collections.abc import Iterable

from impactfem.log import LOGGER

Check = tuple[bool | None, str]
"""Whether it is met, and the sentence with its number and what is asked of it.

None for what is told: a number without a limit, which can neither be met nor missed."""


def log_checks(checks: Iterable[Check]) -> None:
    """Log checks, as warnings where one is not met; what is told is no warning."""
    for good, line in checks:
        if good is False:
            LOGGER.warning("warning: %s", line)
        else:
            LOGGER.info("%s", line)
