"""One member through a building of two modes."""

import numpy as np
import pytest

from impactfem.design.bases import superposed
from impactfem.design.member import carry
from impactfem.spectra import response_spectra


def test_spectra_of_every_point_and_direction(carrier, member):
    found = carry(carrier, member())
    record = superposed(carrier.bases, member().loads, carrier.damping, np.array([4])).acceleration
    wanted = response_spectra(
        record[:, 0, 2], 1e-3, carrier.spectra.frequency_values, [0.05], points_per_cycle=20.0
    )
    assert found["psa"].shape == (2, 2, 3, 12) and found["pfa"].shape == (2, 3)
    np.testing.assert_allclose(found["psa"][1, 1, 2], wanted.psa[0, 0], rtol=1e-9)
    assert found["pfa"][1, 2] == pytest.approx(np.abs(record[:, 0, 2]).max())
    assert found["basis_error"] == 1e-3 and found["impact_force"].tolist() == [1e5, 2e5]
    assert found["device_force"].shape == (0, 6)


def test_twice_the_loads_twice_the_spectra(carrier, member):
    one, two = (carry(carrier, member(scale=scale))["psa"] for scale in (1.0, 2.0))
    np.testing.assert_allclose(two, 2.0 * one, rtol=1e-9)


def test_an_impact_more(carrier, member):
    one, two = (carry(carrier, member(floors=floors)) for floors in ((2,), (1, 2)))
    assert np.abs(one["psa"] / two["psa"] - 1.0).max() > 1e-3
