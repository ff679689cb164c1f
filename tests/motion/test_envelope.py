import numpy as np
import pytest

from impactfem.motion.envelope import Envelope
from impactfem.system.errors import ImpactfemError


def test_values_by_hand():
    e = Envelope(20.0, (2.0, 5.0), end_level=0.01)
    level = e.at(np.array([0.0, 1.0, 2.0, 3.5, 5.0, 12.5, 19.5, 20.0]))
    assert level[:5].tolist() == [0.0, 0.25, 1.0, 1.0, 1.0]
    assert level[5] == pytest.approx(0.1)  # halfway through a decay to 0.01
    assert level[6] == pytest.approx(0.01 ** (14.5 / 15) * 0.5)  # half of the last twentieth
    assert level[7] == 0.0


def test_strong_phase_may_fill_the_motion():
    level = Envelope(10.0, (0.0, 10.0)).at(np.array([0.0, 5.0, 9.4, 10.0]))
    assert level.tolist() == [1.0, 1.0, 1.0, 0.0]


@pytest.mark.parametrize("phase", [(-1.0, 5.0), (5.0, 5.0), (6.0, 5.0), (2.0, 21.0)])
def test_a_strong_phase_outside_is_refused(phase):
    with pytest.raises(ImpactfemError, match="strong phase must lie inside"):
        Envelope(20.0, phase)


@pytest.mark.parametrize("level", [0.0, 1.0])
def test_end_levels_out_of_range_are_refused(level):
    with pytest.raises(ImpactfemError, match="end level"):
        Envelope(20.0, (2.0, 5.0), end_level=level)
