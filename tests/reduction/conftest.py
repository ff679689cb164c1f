"""Fixtures of small matrices and of a frame."""

from ..dynamics.conftest import chain, membrane, petsc  # noqa: F401
from ..stages.transient.conftest import basis, csc, frame, full_runs, loads, spectra  # noqa: F401
