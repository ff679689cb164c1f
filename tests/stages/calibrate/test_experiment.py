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


def test_a_floor_behind_the_wall_is_named():
    PAPER.check_start(np.array([-0.02, 0.01, 0.0]))  # it may start at the wall
    message = "floor 7 is displaced by 10.1 mm towards it, the gap is 10 mm, when floor 8 is displ"
    with pytest.raises(ImpactfemError, match=message):
        PAPER.check_start(np.array([-0.02, 0.0101, 0.0]))


def test_columns(history):
    found = history(np.zeros(4))
    assert found.column(8) == 0
    with pytest.raises(ImpactfemError, match="floor 7 is none of those that may hit the wall: 8"):
        found.column(7)
