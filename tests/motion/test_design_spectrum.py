import numpy as np
import pytest

from impactfem.motion import DesignSpectrum
from impactfem.system.errors import ImpactfemError

SPECTRUM = DesignSpectrum(2.3, (0.05, 0.25, 2.5))


@pytest.mark.parametrize(
    ("period", "ordinate"),
    [
        (0.025, 2.3 * 1.75),  # halfway up: 1 + 0.5 (2.5 - 1)
        (0.05, 5.75),
        (0.1, 5.75),
        (0.25, 5.75),
        (0.5, 2.875),
        (2.5, 0.575),
        (5.0, 0.14375),  # 5.75 · 0.25 · 2.5 / 25
    ],
)
def test_ordinates_by_hand(period, ordinate):
    assert SPECTRUM.pseudo_acceleration(1 / period) == pytest.approx(ordinate, rel=1e-12)


def test_zero_period():
    assert SPECTRUM.pseudo_acceleration(np.inf) == 2.3


@pytest.mark.parametrize(
    ("damping", "eta"), [(0.05, 1.0), (0.02, np.sqrt(10 / 7)), (0.1, np.sqrt(10 / 15)), (0.6, 0.55)]
)
def test_damping_correction(damping, eta):
    spectrum = DesignSpectrum(2.3, (0.05, 0.25, 2.5), damping=damping)
    assert spectrum.damping_correction == pytest.approx(eta)
    assert spectrum.pseudo_acceleration(5.0) == pytest.approx(5.75 * eta)
    assert spectrum.pseudo_acceleration(np.inf) == 2.3  # no correction at zero period


def test_displacement_is_constant_beyond_the_last_corner():
    low = SPECTRUM.displacement([0.4, 0.3, 0.1, 0.01])
    assert low == pytest.approx(low[0])
    assert low[0] == pytest.approx(0.575 * (2.5 / (2 * np.pi)) ** 2)
    assert SPECTRUM.displacement([0.8])[0] < low[0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, (0.05, 0.25, 2.5)), "ground acceleration must be positive"),
        ((2.3, (0.25, 0.05, 2.5)), "T_B <= T_C"),
        ((2.3, (0.0, 0.25, 2.5)), "T_B <= T_C"),
        ((2.3, (0.05, 0.25, 2.5), 0.5), "amplification must be at least 1"),
        ((2.3, (0.05, 0.25, 2.5), 2.5, 5.0), "damping must be"),
    ],
)
def test_bad_spectra_are_refused(arguments, message):
    with pytest.raises(ImpactfemError, match=message):
        DesignSpectrum(*arguments)


def test_frequency_zero_is_refused():
    with pytest.raises(ImpactfemError, match="must be positive"):
        SPECTRUM.pseudo_acceleration([1.0, 0.0])
