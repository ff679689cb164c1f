"""Loads shared out among bases give what one basis with all of them gives."""

import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.response import modal_histories, node_response
from impactfem.stages.design.bases import at_nodes, lacking, modal_shares, records_of, shares

DAMPING = Rayleigh(0.5, 1e-4)
NODES = np.array([9, 4, 4])
ALONG = np.array([1, 1, 2])


def recorded(bases, loads, nodes=NODES):
    return records_of(modal_shares(bases, loads, DAMPING), nodes, ALONG[: len(nodes)])


def test_parts_add_up(whole, parted, some_loads):
    loads = some_loads()
    one, two = recorded([whole], loads), recorded(parted, loads)
    scale = np.abs(one).max()
    assert one.shape == (3, 1001)
    np.testing.assert_allclose(two, one, atol=1e-12 * scale)
    # Without the share of the second basis something is missing.
    alone = recorded([parted[0]], some_loads((2,)))
    assert np.abs(alone - one).max() > 1e-2 * scale


def test_records_are_those_of_the_nodes(whole, some_loads):
    """Against the histories of the stage `transient`, which has all directions of a node."""
    loads = some_loads()
    known = node_response(whole, modal_histories(whole, loads, DAMPING), loads, NODES)
    wanted = known.acceleration[:, np.arange(3), ALONG].T
    np.testing.assert_allclose(recorded([whole], loads), wanted, rtol=1e-9, atol=1e-9)
    rough = records_of(modal_shares([whole], loads, DAMPING), NODES, ALONG, roughly=True)
    np.testing.assert_allclose(rough, wanted, atol=1e-5 * np.abs(wanted).max())


def test_the_ground_is_added_once(parted, some_loads):
    loads = some_loads()
    first, second = shares(parted, loads)
    assert first.names == ("ground y", "floor 2") and second.names == ("floor 1",)
    np.testing.assert_array_equal(first.ground, loads.ground)
    assert not second.ground.any()


def test_each_load_goes_to_the_first_basis_that_has_it(whole, parted, some_loads):
    first, second = shares([whole, parted[1]], some_loads())
    assert first.names == whole.loads and second.names == ()


def test_a_load_that_no_basis_has(parted, some_loads):
    with pytest.raises(KeyError, match="floor 1"):
        shares(parted[:1], some_loads())
    with pytest.raises(KeyError, match="ground y"):
        shares(parted[1:], some_loads((1,)))


def test_lacking(parted, whole, some_loads):
    loads = [some_loads((2,)), some_loads((1,))]
    directions, edges = lacking(parted[0], loads)
    assert directions == [] and [edge.name for edge in edges] == ["floor 1"]
    assert lacking(whole, loads) == ([], [])
    directions, edges = lacking(None, loads)
    assert directions == [1] and [edge.floor for edge in edges] == [1, 2]


def test_at_nodes_keeps_the_response(whole, some_loads):
    loads = some_loads()
    cut = at_nodes(whole, np.array([9, 4, 9]))
    assert cut.nodes.tolist() == [4, 9] and len(cut.vectors) == 2
    at = np.array([4, 9])
    one, two = (recorded([b], loads, at) for b in (whole, cut))
    np.testing.assert_array_equal(one, two)
    with pytest.raises(KeyError, match="not made for"):
        recorded([cut], loads, np.array([7]))
