import numpy as np
import pytest

from impactfem.motion import Accelerogram, pair_correlation
from impactfem.system.errors import ImpactfemError

NOISE = np.random.default_rng(6).standard_normal((2, 4000))
FIRST, SECOND = (Accelerogram(0.005, a) for a in NOISE)


def test_independent_components():
    result = pair_correlation(FIRST, SECOND)
    assert abs(result.coefficient) < 0.05
    assert result.accepted


def test_a_motion_and_itself():
    assert pair_correlation(FIRST, FIRST).coefficient == pytest.approx(1.0)
    assert pair_correlation(FIRST, FIRST.scaled(-3.0)).coefficient == pytest.approx(-1.0)
    assert not pair_correlation(FIRST, FIRST).accepted


@pytest.mark.parametrize(("share", "limit", "accepted"), [(0.2, 0.16, False), (0.2, 0.3, True)])
def test_a_known_share(share, limit, accepted):
    orthogonal = NOISE[1] - NOISE[1].mean()
    own = NOISE[0] - NOISE[0].mean()
    orthogonal -= own * (orthogonal @ own) / (own @ own)
    orthogonal *= np.sqrt((own @ own) / (orthogonal @ orthogonal))
    mixed = share * own + np.sqrt(1.0 - share**2) * orthogonal
    result = pair_correlation(FIRST, Accelerogram(0.005, mixed + 7.0), limit)
    assert result.coefficient == pytest.approx(share)  # an offset does not matter
    assert result.accepted is accepted


def test_the_shorter_one_rests_after_its_end():
    short = Accelerogram(0.005, NOISE[0][:2000])
    continued = Accelerogram(0.005, np.pad(NOISE[0][:2000], (0, 2000)))
    assert pair_correlation(short, FIRST) == pair_correlation(continued, FIRST)


def test_refused():
    with pytest.raises(ImpactfemError, match=r"steps of 0.005 s and 0.01 s cannot be correlated"):
        pair_correlation(FIRST, Accelerogram(0.01, NOISE[1]))
    with pytest.raises(ImpactfemError, match="does not change has no correlation"):
        pair_correlation(FIRST, Accelerogram(0.005, np.ones(4000)))
