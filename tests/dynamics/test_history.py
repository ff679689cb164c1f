import numpy as np
import pytest

from impactfem.dynamics.history import Recorder, State
from impactfem.system.errors import SolutionError


@pytest.fixture
def recorder(petsc):
    def make(*arguments):
        return Recorder(petsc(np.eye(4)), *arguments, time_step=0.5)

    return make


def state(step, value):
    u = value + np.arange(4.0)
    return State(step, u, 10.0 * u, 100.0 * u, np.zeros(4), np.zeros(4))


def test_parts_and_history(recorder):
    recording = recorder([2, 0, 2], ("acceleration", "displacement"), 2)
    recording.put(state(5, 1.0), (1.0, 2.0, 3.0, 4.0))
    now = state(6, 2.0)
    recording.put(now, (5.0, 6.0, 7.0, 8.0))
    part = recording.reduce(now)
    assert (now.damped, now.input) == (10.0, 12.0)
    now.step = 7
    recording.put(now, (0.0, 0.0, 1.0, 1.0))
    recording.reduce(now)
    assert part.time.tolist() == [2.5, 3.0]
    assert part.motion["displacement"].tolist() == [[3.0, 1.0, 3.0], [4.0, 2.0, 4.0]]
    history = recording.history()
    assert history.time.tolist() == [2.5, 3.0, 3.5] and list(history.motion) == [
        "acceleration",
        "displacement",
    ]
    assert history.motion["acceleration"].tolist() == [[300, 100, 300], *[[400, 200, 400]] * 2]
    assert history.energy.kinetic.tolist() == [1.0, 5.0, 0.0]
    assert history.energy.elastic.tolist() == [2.0, 6.0, 0.0]
    assert history.energy.damped.tolist() == [3.0, 10.0, 11.0]
    assert history.energy.input.tolist() == [4.0, 12.0, 13.0]


def test_nothing_recorded(recorder):
    recording = recorder([], (), 3)
    now = state(0, 0.0)
    recording.put(now, (0.0, 0.0, 0.0, 0.0))
    assert recording.reduce(now).motion == {}


@pytest.mark.parametrize(
    ("probes", "record", "said"),
    [([4], ["velocity"], "row 4"), ([-1], ["velocity"], "row -1"), ([0], ["speed"], "speed")],
)
def test_what_cannot_be_recorded(recorder, probes, record, said):
    with pytest.raises(SolutionError, match=f"cannot record {said}"):
        recorder(probes, record, 10)


def test_numbers_that_are_none(recorder):
    recording = recorder([0], ("velocity",), 3)
    now = state(9, np.nan)
    recording.put(now, (0.0, 0.0, 0.0, 0.0))
    with pytest.raises(SolutionError, match="not finite before step 9"):
        recording.reduce(now)
