"""Fixtures of sticks."""

from ...sticks.conftest import floors, row, run, section, shake, small_case, study  # noqa: F401
