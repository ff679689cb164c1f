"""Motions through a building of two modes: each alone, and all with those that fail named."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.response import modal_histories, node_response
from impactfem.spectra import response_spectra
from impactfem.spectra.statistics import STATISTICS, over_members
from impactfem.stages.design import carrier as one_motion
from impactfem.stages.design.carrier import carry, point_records
from impactfem.stages.design.members import stacked
from impactfem.stages.ensemble.compute import worked_off
from impactfem.system.errors import SolutionError
from impactfem.system.files import read_archive

from .conftest import points

DAMPING = Rayleigh(0.5, 1e-4)
FORCE = np.array([1e5, 2e5])


def records(basis, loads, table, *kind):
    modal = modal_histories(basis, loads, DAMPING).acceleration
    return point_records(basis, loads, modal, table, *kind)


def spectra_of(carrier, loads, node, component):
    """Spectra of a node along a direction, and its peak acceleration."""
    record = records(carrier.basis, loads, points(node=[node], component=[component]))
    found = response_spectra(
        record, 1e-3, carrier.spectra.frequency_values, [0.02, 0.05], points_per_cycle=20.0
    )
    return found.psa[:, 0], np.abs(record).max()


def test_records_are_those_of_the_nodes(whole, some_loads):
    """Against the histories of the stage `transient`, which has all directions of a node."""
    loads, table = some_loads(), points(node=[9, 4, 4], component=[1, 1, 2])
    known = node_response(whole, modal_histories(whole, loads, DAMPING), loads, table["node"])
    wanted = known.acceleration[:, np.arange(3), table["component"]].T
    np.testing.assert_allclose(records(whole, loads, table), wanted, rtol=1e-9, atol=1e-9)
    rough = records(whole, loads, table, np.float32)
    np.testing.assert_allclose(rough, wanted, atol=1e-5 * np.abs(wanted).max())


def test_some_nodes_keep_their_response(whole, some_loads):
    loads, table = some_loads(), points(node=[4, 9], component=[1, 1])
    cut = whole.at(np.array([9, 4, 9]))
    assert cut.nodes.tolist() == [4, 9] and len(cut.vectors) == 2
    np.testing.assert_array_equal(records(whole, loads, table), records(cut, loads, table))
    with pytest.raises(KeyError, match="not made for"):
        records(cut, loads, points(node=[7], component=[1]))


def test_spectra_of_every_point_and_direction(carrier, some_loads):
    """A floor has one probe here, at its mass centre, which is its envelope."""
    found = carry(carrier, some_loads(), FORCE)
    psa, peak = spectra_of(carrier, some_loads(), 4, 2)
    assert found["member_psa"].shape == (2, 2, 3, 12) and found["member_zpa"].shape == (2, 3)
    np.testing.assert_allclose(found["member_psa"][:, 1, 2], psa, rtol=1e-9)
    assert found["member_zpa"][1, 2] == pytest.approx(peak)
    np.testing.assert_array_equal(found["member_centre_peak"], found["member_psa"].max(axis=-1))
    # Not above the frequency that the model is meant for.
    lower = carry(replace(carrier, highest=5.0), some_loads(), FORCE)["member_centre_peak"]
    np.testing.assert_array_equal(lower, found["member_psa"][..., :6].max(axis=-1))
    assert not found["member_vertices"].any()
    assert found["member_basis_error"] == 1e-3 and "member_device_force" not in found


def test_vertices_that_govern(carrier, searching, some_loads):
    """The lower floor gets the envelope of its probe, node 9, and of node 7 where it governs."""
    found, alone = (carry(one, some_loads(), FORCE) for one in (searching, carrier))
    psa, probes = found["member_psa"], alone["member_psa"]
    for component in (1, 2):
        at_vertex, _ = spectra_of(carrier, some_loads(), 7, component)
        wanted = np.maximum(probes[:, 0, component], at_vertex)
        np.testing.assert_allclose(psa[:, 0, component], wanted, rtol=0.02)
        assert np.all(psa[:, 0, component] <= wanted * (1.0 + 1e-9))
    assert np.any(psa[:, 0] > 1.2 * probes[:, 0])
    # Nothing is looked at on the upper floor, nor along x; the mass centre stays.
    np.testing.assert_allclose(psa[:, 1], probes[:, 1], rtol=1e-12)
    np.testing.assert_allclose(psa[:, :, 0], probes[:, :, 0], rtol=1e-12)
    np.testing.assert_allclose(found["member_centre_peak"], alone["member_centre_peak"], rtol=1e-12)
    counts = found["member_vertices"]
    assert counts[0, 1:].min() >= 1 and counts[1].max() == counts[0, 0] == 0


@pytest.fixture
def carried(carrier, tmp_path):
    """Carry motions; gives results, failures, files and keys."""

    def run(loads):
        files = {name: tmp_path / f"{name}.npz" for name in loads}
        keys = {name: f"key {name}" for name in loads}
        done = []
        waiting = {name: (one, FORCE) for name, one in loads.items()}
        with ThreadPoolExecutor(2) as pool:
            work = partial(one_motion.carry, carrier)
            found, failed = worked_off(work, waiting, files, keys, pool, done.append, " in 3D")
        assert done == list(range(1, len(loads) + 1))
        return found, failed, files, keys

    return run


def test_stored_and_gone_on_with(carried, some_loads):
    """Of the stored ones and new ones together, though only the stored ones have their key."""
    found, failed, files, keys = carried({"a": some_loads(), "b": some_loads(scale=0.5)})
    assert not failed
    again = read_archive(files["b"], keys["b"])
    every = stacked(["b", "a"], {"b": again, "a": found["a"]}, {})
    # In one order in all processes, so that one run writes the store that another does.
    assert list(every) == list(found["a"])
    for part, values in every.items():
        np.testing.assert_array_equal(values, [found[name][part] for name in "ba"])
    np.testing.assert_array_equal(again["member_impact_force"], FORCE)


def test_one_that_fails_is_named(carried, some_loads, monkeypatch):
    bad = some_loads(scale=0.0)

    def fails(carrier, loads, force):
        if not loads.force.any():
            raise SolutionError("the response is not finite")
        return carry(carrier, loads, force)

    monkeypatch.setattr(one_motion, "carry", fails)
    found, failed, files, _ = carried({"good": some_loads(), "bad": bad})
    assert list(found) == ["good"] and failed == {"bad": "the response is not finite"}
    assert files["good"].is_file() and not files["bad"].exists()
    with pytest.raises(SolutionError, match=r"two.*bad: the response"):
        stacked(["good"], found, failed)


def test_identical_members_have_no_spread(carried, some_loads):
    found, *_ = carried({name: some_loads() for name in "abc"})
    psa = stacked(list("abc"), found, {})["member_psa"]
    assert psa.shape[0] == 3
    for name in STATISTICS:
        np.testing.assert_allclose(over_members(psa, name), found["a"]["member_psa"], rtol=1e-12)
    other, *_ = carried({"d": some_loads(scale=2.0)})
    spread = np.stack([*psa, other["d"]["member_psa"]])
    assert np.all(over_members(spread, "mean") > 1.2 * found["a"]["member_psa"])
