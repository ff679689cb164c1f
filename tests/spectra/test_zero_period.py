import numpy as np
import pytest

from impactfem.spectra import rigid_frequency
from impactfem.system.errors import ImpactfemError

F = [1.0, 2.0, 5.0, 10.0, 50.0]


def test_first_frequency_from_which_on_it_stays():
    spectra = [[1.0, 9.0, 4.0, 2.05, 2.0], [2.0, 2.0, 2.2, 2.0, 2.0], [2.0] * 5]
    found = rigid_frequency(F, spectra, [2.0, 2.0, 2.0])
    np.testing.assert_array_equal(found, [10.0, 10.0, 1.0])
    # Another tolerance, another frequency.
    np.testing.assert_array_equal(rigid_frequency(F, spectra, [2.0] * 3, 0.2), [10.0, 1.0, 1.0])
    np.testing.assert_array_equal(rigid_frequency(F, spectra, [2.0] * 3, 0.01)[:1], [50.0])


def test_list_that_ends_too_early():
    assert np.isnan(rigid_frequency(F, [1.0, 2.0, 3.0, 4.0, 5.0], 2.0))


def test_floor_at_rest_is_rigid():
    assert rigid_frequency(F, np.zeros(5), 0.0) == 1.0


def test_refused():
    with pytest.raises(ImpactfemError, match="tolerance"):
        rigid_frequency(F, np.ones(5), 1.0, 0.0)
    with pytest.raises(ImpactfemError, match="zero-period accelerations of shape"):
        rigid_frequency(F, np.ones((2, 5)), [1.0, 1.0, 1.0])
