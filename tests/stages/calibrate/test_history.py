import numpy as np
import pytest

from impactfem.system.errors import ImpactfemError


def test_times_and_columns(history):
    found = history(np.zeros(4), dt=0.5)
    assert np.array_equal(found.time, [0.0, 0.5, 1.0, 1.5])
    assert found.column(8) == 0
    with pytest.raises(ImpactfemError, match="floor 7 is none of those that may hit the wall: 8"):
        found.column(7)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass": np.ones(2)}, r"mass must have one value for each of 1 floors, got \(2,\)"),
        ({"velocity": np.zeros((3, 1))}, r"velocity must have shape \(4, 1\), got \(3, 1\)"),
        ({"opening": np.zeros((4, 2))}, r"opening must have shape \(4, 1\), got \(4, 2\)"),
        (
            {"displacement": np.array([[0.0], [0.0], [np.nan], [0.0]])},
            "displacement of floor 8 is nan at t = 0.002 s",
        ),
        ({"opening": np.full((4, 1), np.inf)}, "opening of floor 8 is inf at t = 0 s"),
    ],
)
def test_what_is_no_history_is_refused(history, changes, message):
    with pytest.raises(ImpactfemError, match=message):
        history(np.zeros(4), **changes)
