"""Fixtures of sticks."""

import numpy as np
import pytest

from impactfem.sticks.calibration import Calibration, Parameters, Target

from ...sticks.conftest import floors, row, run, section, shake, small_case, study  # noqa: F401

CALIBRATION = Calibration(
    Parameters(0.4, np.array([3.5, 3.4, 3.6]), 0.3, 0.2),
    (Target("west", 1, 2.0, 500e3), Target("east", 2, 8.0, None)),
    np.array([2.1, 7.0]),
    np.array([4e5, 1e5]),
)


@pytest.fixture(scope="session")
def no_contacts(study, run):  # noqa: F811
    """The small case with nothing that could touch."""
    return run(study.case.model_copy(update={"contacts": ()}))
