from dataclasses import replace

import numpy as np
import pytest

from impactfem.device.rigid_response import Gupta, LindleyYow
from impactfem.device.spectrum import AnchorSpectrum
from impactfem.system.errors import ImpactfemError

SPECTRUM = AnchorSpectrum(
    "y",
    np.array([1.0, 4.0, 8.0, 33.0, 60.0]),
    np.array([0.02, 0.05]),
    np.array([[2.0, 16.0, 16.0, 4.0, 4.0], [1.0, 8.0, 8.0, 4.0, 4.0]]),
    4.0,
)
XI = np.full(5, 0.02)
F = np.array([1.0, 5.0, 12.0, 33.0, 50.0])
S = SPECTRUM.at(F, XI)[0]


def test_gupta_from_the_spectrum():
    # Largest pseudo-velocity at 4 Hz: f1 = 16 / (16 / 4); rigid from 33 Hz on.
    f1, f2 = Gupta().corners(SPECTRUM, 0.02)
    assert (f1, f2) == pytest.approx((4.0, 70.0 / 3.0))
    found = Gupta().fraction(SPECTRUM, F, XI, S)
    assert found[[0, 3, 4]].tolist() == [0.0, 1.0, 1.0]
    assert found[2] == pytest.approx(np.log(12.0 / 4.0) / np.log(70.0 / 12.0))
    assert 0.0 < found[1] < found[2]


def test_gupta_with_given_frequencies():
    found = Gupta(10.0, 20.0).fraction(SPECTRUM, F, XI, S)
    assert found == pytest.approx([0.0, 0.0, np.log(1.2) / np.log(2.0), 1.0, 1.0])
    with pytest.raises(ImpactfemError, match="expected 0 < f1 < f2"):
        Gupta(20.0, 10.0)
    with pytest.raises(ImpactfemError, match="expected 0 < f1 < f2"):
        Gupta(0.0, 10.0)
    with pytest.raises(ImpactfemError, match="expected both frequencies to be given"):
        Gupta(f1=40.0).corners(SPECTRUM, 0.02)
    with pytest.raises(ImpactfemError, match="before it comes down"):
        Gupta().corners(replace(SPECTRUM, zpa=1.0), 0.02)


def test_lindley_and_yow():
    found = LindleyYow().fraction(SPECTRUM, F, XI, S)
    assert found[[3, 4]] == pytest.approx([1.0, 1.0])
    assert found[2] == pytest.approx(4.0 / S[2])
    assert found[1] == pytest.approx(0.25)
    # Below the amplified range nothing is rigid, although S falls below ZPA.
    assert found[0] == 0.0


def test_a_spectrum_without_ordinates():
    none = replace(SPECTRUM, psa=0.0 * SPECTRUM.psa, zpa=0.0)
    assert np.isfinite(LindleyYow().fraction(none, F, XI, 0.0 * S)).all()
