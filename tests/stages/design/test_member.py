"""One member through a building of two modes."""

import numpy as np
import pytest

from impactfem.spectra import response_spectra
from impactfem.stages.design.member import carry
from impactfem.stages.design.point_spectra import BuildingMotion


def test_spectra_of_every_point_and_direction(carrier, member):
    found = carry(carrier, member())
    motion = BuildingMotion.under(carrier.basis, member().loads, carrier.damping)
    record = motion.records(np.array([4]), np.array([2]))[0]
    wanted = response_spectra(
        record, 1e-3, carrier.spectra.frequency_values, [0.05], points_per_cycle=20.0
    )
    assert found["psa"].shape == (2, 2, 3, 12) and found["pfa"].shape == (2, 3)
    np.testing.assert_allclose(found["psa"][1, 1, 2], wanted.psa[0, 0], rtol=1e-9)
    assert found["pfa"][1, 2] == pytest.approx(np.abs(record).max())
    # A floor has one probe here, which is its envelope.
    np.testing.assert_array_equal(found["floor_psa"], found["psa"])
    np.testing.assert_array_equal(found["floor_pfa"], found["pfa"])
    assert not found["vertices"].any()
    assert found["basis_error"] == 1e-3 and found["impact_force"].tolist() == [1e5, 2e5]
    assert found["device_force"].shape == (0, 6)


def test_twice_the_loads_twice_the_spectra(carrier, member):
    one, two = (carry(carrier, member(scale=scale))["psa"] for scale in (1.0, 2.0))
    np.testing.assert_allclose(two, 2.0 * one, rtol=1e-9)


def test_an_impact_more(carrier, member):
    one, two = (carry(carrier, member(floors=floors)) for floors in ((2,), (1, 2)))
    assert np.abs(one["psa"] / two["psa"] - 1.0).max() > 1e-3


def test_vertices_that_govern(carrier, searching, member):
    """The lower floor gets the envelope of its probe, node 9, and of node 7 where it governs."""
    found, alone = carry(searching, member()), carry(carrier, member())
    motion = BuildingMotion.under(carrier.basis, member().loads, carrier.damping)
    for component in (1, 2):
        record = motion.records(np.array([7]), np.array([component]))
        one = response_spectra(
            record, 1e-3, carrier.spectra.frequency_values, [0.02, 0.05], points_per_cycle=20.0
        )
        wanted = np.maximum(alone["psa"][:, 0, component], one.psa[:, 0])
        np.testing.assert_allclose(found["floor_psa"][:, 0, component], wanted, rtol=0.02)
        assert np.all(found["floor_psa"][:, 0, component] <= wanted * (1.0 + 1e-9))
    assert np.any(found["floor_psa"][:, 0] > 1.2 * alone["floor_psa"][:, 0])
    # Nothing is looked at on the upper floor, nor along x.
    np.testing.assert_allclose(found["floor_psa"][:, 1], alone["floor_psa"][:, 1], rtol=1e-12)
    np.testing.assert_allclose(found["floor_psa"][:, :, 0], alone["floor_psa"][:, :, 0], rtol=1e-12)
    np.testing.assert_allclose(found["psa"], alone["psa"], rtol=1e-12)
    counts = found["vertices"]
    assert counts[0, 1:].min() >= 1 and counts[1].max() == counts[0, 0] == 0
