"""Records of a motion of the building, at nodes and along directions."""

import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.response import modal_histories, node_response
from impactfem.stages.design.point_spectra import BuildingMotion

from .conftest import basis_of

DAMPING = Rayleigh(0.5, 1e-4)
NODES = np.array([9, 4, 4])
ALONG = np.array([1, 1, 2])


def test_records_are_those_of_the_nodes(whole, some_loads):
    """Against the histories of the stage `transient`, which has all directions of a node."""
    loads = some_loads()
    known = node_response(whole, modal_histories(whole, loads, DAMPING), loads, NODES)
    wanted = known.acceleration[:, np.arange(3), ALONG].T
    motion = BuildingMotion.under(whole, loads, DAMPING)
    np.testing.assert_allclose(motion.records(NODES, ALONG), wanted, rtol=1e-9, atol=1e-9)
    rough = motion.records(NODES, ALONG, roughly=True)
    np.testing.assert_allclose(rough, wanted, atol=1e-5 * np.abs(wanted).max())


def test_a_load_that_the_basis_has_not(some_loads):
    with pytest.raises(KeyError, match="floor 1"):
        BuildingMotion.under(basis_of(("ground y", "floor 2")), some_loads(), DAMPING)


def test_some_nodes_keep_their_response(whole, some_loads):
    loads = some_loads()
    cut = whole.at(np.array([9, 4, 9]))
    assert cut.nodes.tolist() == [4, 9] and len(cut.vectors) == 2
    at, along = np.array([4, 9]), np.array([1, 1])
    one, two = (BuildingMotion.under(b, loads, DAMPING).records(at, along) for b in (whole, cut))
    np.testing.assert_array_equal(one, two)
    with pytest.raises(KeyError, match="not made for"):
        BuildingMotion.under(cut, loads, DAMPING).records(np.array([7]), np.array([1]))
