"""Fixtures of sticks and of small matrices."""

from ..dynamics.conftest import chain, membrane, petsc  # noqa: F401
from ..sticks.conftest import floors, row, run, section, shake, small_case, study  # noqa: F401
