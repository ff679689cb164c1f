"""Points of the floors: which probes are on them, and which vertices govern."""

import itertools
from functools import partial

import numpy as np
import pytest

from impactfem.stages.design import floors
from impactfem.stages.design.floors import (
    MISSED,
    counted,
    enveloped,
    fewest,
    probe_points,
    read_probes,
    read_whole_floors,
)
from impactfem.stages.stores import dataset
from impactfem.stages.transient.maps import MAP_OUTPUTS
from impactfem.stages.transient.store import OUTPUTS
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import write_netcdf

from .conftest import points

pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")

NAMES = ("centre_2", "centre_1", "edge_1", "roof", "corner")
KINDS = ("centre", "centre", "edge", "point", "point")
POSITION = np.array(
    [[2.0, 2.0, 6.0], [2.0, 2.0, 3.0], [2.0, 4.0, 3.0], [0.0, 0.0, 6.6], [0.0, 0.0, 5.97]]
)
ELEVATION = np.array([3.0, 6.0])


@pytest.fixture
def transient():
    rng = np.random.default_rng(0)
    values = {
        "psa": rng.random((2, 5, 3, 7)),
        "pfa": rng.random((5, 3)),
        "zpa": rng.random((5, 3)),
        "probe_node": [5, 2, 9, 1, 4],
        "probe_position": POSITION,
        "xyz": ["x", "y", "z"],
        "probe": NAMES,
        "probe_kind": KINDS,
        "probe_floor": [2, 1, 1, 0, 0],
        "damping": [0.02, 0.05],
        "frequency": np.geomspace(1.0, 10.0, 7),
    }
    return dataset(OUTPUTS, values, attributes={"building": "B", "maximum_frequency": 100.0})


def test_floors_from_the_lowest(transient, tmp_path):
    write_netcdf(tmp_path / "transient.nc", transient)
    found = read_probes(tmp_path / "transient.nc")
    assert found["station_floor"].values.tolist() == [1, 2]
    assert found["elevation"].values.tolist() == ELEVATION.tolist()
    assert found["centre"].values.tolist() == [1, 0] and found.attrs["building"] == "B"
    on = found["on_floor"].values.T
    assert [np.array(NAMES)[one].tolist() for one in on] == [
        ["centre_1", "edge_1"],
        ["centre_2", "corner"],
    ]
    table = probe_points(found)
    assert table["point"].tolist() == [1] * 3 + [2] * 3 + [0] * 3 + [4] * 3
    assert table["node"].tolist() == [2] * 3 + [9] * 3 + [5] * 3 + [4] * 3
    psa = found["psa"].values
    along = table["point"].to_numpy(), table["component"].to_numpy()
    envelope = enveloped(table, psa[:, along[0], along[1]], 2, axis=1)
    assert envelope.shape == (2, 2, 3, 7)
    np.testing.assert_array_equal(envelope[:, 0], np.maximum(psa[:, 1], psa[:, 2]))
    np.testing.assert_array_equal(envelope[:, 1], np.maximum(psa[:, 0], psa[:, 4]))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda store: store.drop_vars("psa"), r"holds no spectra of probes: .*psa"),
        (lambda store: store.drop_vars("probe_kind"), r"holds no spectra of probes: .*probe_kind"),
        (lambda store: store.isel(probe=slice(2, None)), "no probe at the mass centre"),
        (lambda store: store.isel(damping=0), r"cannot read spectra of probes from .*damping"),
        (None, "cannot read"),
    ],
)
def test_a_store_that_is_no_use(transient, tmp_path, change, words):
    if change is not None:
        write_netcdf(tmp_path / "transient.nc", change(transient))
    with pytest.raises(ImpactfemError, match=words):
        read_probes(tmp_path / "transient.nc")


def test_envelope_of_points():
    """Only where there are points, each along its own direction."""
    some = points(floor=[0, 1, 1], component=[2, 0, 0], node=[7, 4, 9])
    values = np.random.default_rng(0).random((2, 3, 5))
    found = enveloped(some, values, 2, axis=1)
    np.testing.assert_array_equal(found[:, 0, 2], values[:, 0])
    np.testing.assert_array_equal(found[:, 1, 0], values[:, 1:].max(axis=1))
    others = np.ones((2, 3), dtype=bool)
    others[[0, 1], [2, 0]] = False
    assert not found[:, others].any()
    assert counted(some, 2).tolist() == [[0, 0, 1], [2, 0, 0]]
    assert not enveloped(floors.NO_POINTS, np.zeros((0, 4)), 2).any()


CURVES = np.random.default_rng(4).random((9, 6))


@pytest.mark.parametrize("missed", [0.0, 0.05, 0.3])
def test_near_everywhere(missed):
    chosen = fewest(CURVES, missed=missed)
    assert np.all(CURVES[chosen].max(axis=0) >= (1.0 - missed) * CURVES.max(axis=0))
    # One less is not enough: each was taken for a place that nothing before came near to.
    assert np.any(CURVES[chosen[:-1]].max(axis=0) < (1.0 - missed) * CURVES.max(axis=0))


@pytest.mark.parametrize("missed", [0.05, 0.3])
def test_against_every_choice(missed):
    """By trial of all: no smaller set does, but for what a greedy choice may have more."""
    near = (1.0 - missed) * CURVES.max(axis=0)
    best = next(
        size
        for size in range(1, 10)
        if any(
            np.all(CURVES[list(some)].max(axis=0) >= near)
            for some in itertools.combinations(range(9), size)
        )
    )
    assert best <= len(fewest(CURVES, missed=missed)) <= best + 1


def test_no_more_than_needed_or_allowed():
    assert fewest(np.vstack([CURVES, CURVES.max(axis=0)])) == [9]
    assert fewest(np.zeros((3, 4))) == [] and fewest(np.zeros((0, 4))) == []
    chosen = fewest(CURVES, missed=0.0, most=2)
    assert len(chosen) == 2
    assert np.any(CURVES[chosen].max(axis=0) < CURVES.max(axis=0))


@pytest.fixture
def fields():
    height = np.array([3.0, 6.0, 3.0, 6.5])
    psa = np.random.default_rng(0).random((4, 3, 5)).astype(np.float32)
    values = {
        "psa": psa,
        "pfa": psa.max(axis=2).astype(float),
        "node_number": [8, 3, 5, 6],
        "node_position": np.stack([0 * height, 0 * height, height], axis=1),
        "frequency": np.geomspace(1.0, 10.0, 5),
    }
    return dataset(MAP_OUTPUTS, values, attributes={"damping": 0.05, "points_per_cycle": 2.0})


@pytest.fixture
def read(tmp_path):
    def make(store):
        write_netcdf(tmp_path / "transient_maps.nc", store)
        found = read_whole_floors(tmp_path / "transient_maps.nc", ELEVATION)
        assert found is not None
        return found

    return make


def at(table, floor, component):
    return table["node"][(table["floor"] == floor) & (table["component"] == component)].tolist()


def test_largest_of_each_floor(fields, read):
    found, psa = read(fields), fields["psa"].values
    assert found.vertices.tolist() == [2, 1]
    np.testing.assert_array_equal(found.whole_psa[0], np.maximum(psa[0], psa[2]))
    np.testing.assert_array_equal(found.whole_psa[1], psa[1])
    np.testing.assert_array_equal(found.whole_zpa[0], psa[[0, 2]].max(axis=(0, 2)))
    assert (found.damping, found.points_per_cycle) == (0.05, 2.0)


def test_vertices_that_govern(fields, read):
    """All of both vertices of the lower floor, where no one of them has the envelope."""
    found = read(fields)
    assert set(at(found.governing, 0, 1)) <= {8, 5} and at(found.governing, 1, 2) == [3]
    height = dict(zip(fields["node_number"].values, fields["node_position"].values, strict=True))
    for one in found.governing.itertuples():
        np.testing.assert_array_equal((one.x, one.y, one.z), height[one.node])
    for name in ("psa", "zpa"):
        reached, whole = (getattr(found, f"{kind}_{name}") for kind in ("reached", "whole"))
        assert np.all(reached >= (1.0 - MISSED) * whole)
    assert set(found.candidates["node"]) == {8, 5, 3} and 6 not in set(found.governing["node"])


def test_candidates(fields, read, monkeypatch):
    """The two largest at each place of three, and none where the floor moves as one."""
    fields["node_position"][:, 2] = [3.0, 3.0, 3.0, 6.0]
    fields["psa"][:] = 1.0
    fields["psa"][:3, 1, 2] = [1.0, 0.5, 0.2]
    fields["psa"][2, 2, 4] = 3.0
    fields["pfa"][:] = 1.0
    monkeypatch.setattr(floors, "LARGEST", 2)
    nodes = [set(at(read(fields).candidates, 0, c)) for c in range(3)]
    # Along x all are alike, and the one that was chosen stands for them.
    assert len(nodes[0]) == 1 and nodes[1] == {8, 3} and 5 in nodes[2] and len(nodes[2]) == 2


@pytest.mark.parametrize("most", [1, 24])
def test_a_floor_that_moves_at_many_places(fields, read, monkeypatch, most):
    """One vertex alone does not have what each of two has at its own frequency."""
    fields["psa"][:] = 0.1
    for place, frequency in ((0, 1), (2, 3)):
        fields["psa"][place, :, frequency] = 1.0
    monkeypatch.setattr(floors, "fewest", partial(fewest, most=most))
    found = read(fields)
    part = (found.reached_psa / found.whole_psa)[0].min()
    assert part == pytest.approx(0.1 if most == 1 else 1.0)


def test_a_direction_in_which_nothing_moves(fields, read):
    fields["psa"][:, 0], fields["pfa"][:, 0] = 1e-12, 1e-12
    found = read(fields)
    assert 0 not in set(found.governing["component"]) | set(found.candidates["component"])


def test_without_fields(fields, tmp_path):
    path = tmp_path / "transient_maps.nc"
    assert read_whole_floors(path, ELEVATION) is None
    for fault in (fields.drop_vars("psa"), fields.isel(component=0)):
        write_netcdf(path, fault)
        with pytest.raises(ImpactfemError, match="cannot read fields"):
            read_whole_floors(path, ELEVATION)
