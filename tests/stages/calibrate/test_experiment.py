from dataclasses import replace

import numpy as np
import pytest

from impactfem.stages.calibrate.experiment import WallExperiment
from impactfem.system.errors import ImpactfemError

PAPER = WallExperiment((6, 7, 8), 8, -0.02, 0.01, 1.3, 0.34e-3, "y+")


def test_times_of_the_paper():
    assert PAPER.n_t == 3825
    assert (PAPER.n_t - 1) * PAPER.time_step == pytest.approx(1.3, abs=0.17e-3)


@pytest.mark.parametrize(
    ("side", "normal"),
    [("x-", (-1, 0, 0)), ("x+", (1, 0, 0)), ("y-", (0, -1, 0)), ("y+", (0, 1, 0))],
)
def test_normal_points_to_the_wall(side, normal):
    assert np.array_equal(replace(PAPER, side=side).normal, normal)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"floors": ()}, r"needs floors that may hit it, each named once, got \(\)"),
        ({"floors": (7, 8, 7)}, r"each named once, got \(7, 8, 7\)"),
        ({"side": "z+"}, "on side x-, x\\+, y- or y\\+, got 'z\\+'"),
        ({"gap": -0.001}, "gap to the wall must not be negative, got -0.001 m"),
        ({"gap": float("nan")}, "gap to the wall must not be negative, got nan m"),
        ({"time_step": 0.0}, "time step above 0 and below its duration, got 0 s and 1.3 s"),
        ({"time_step": 2.0}, "got 2 s and 1.3 s"),
        ({"displacement": float("inf")}, "displacement of floor 8 must be a number, got inf"),
        (
            {"displacement": 0.012},
            "starts inside the building: floor 8 is displaced by 12 mm towards it, the gap is 10",
        ),
    ],
)
def test_what_is_no_experiment_is_refused(changes, message):
    with pytest.raises(ImpactfemError, match=message):
        replace(PAPER, **changes)


def test_a_floor_may_start_at_the_wall():
    assert replace(PAPER, displacement=0.01).displacement == PAPER.gap
    PAPER.check_start(np.array([-0.02, 0.01, 0.0]))


def test_a_floor_behind_the_wall_is_named():
    message = "floor 7 is displaced by 10.1 mm towards it, the gap is 10 mm, when floor 8 is displ"
    with pytest.raises(ImpactfemError, match=message):
        PAPER.check_start(np.array([-0.02, 0.0101, 0.0]))


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
