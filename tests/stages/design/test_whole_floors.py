"""Reading `transient_maps.nc`: the largest of all vertices of each floor."""

from functools import partial

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.design import whole_floors
from impactfem.stages.design.fewest import MISSED, fewest
from impactfem.stages.design.floor_points import floor_points
from impactfem.stages.design.whole_floors import read_whole_floors
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import write_netcdf

pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")

FLOORS, _ = floor_points(
    ("centre_1", "centre_2"), np.array([[0, 0, 3.0], [0, 0, 6.0]]), {1: 0, 2: 1}
)


@pytest.fixture
def store():
    height = np.array([3.0, 6.0, 3.0, 6.5])
    psa = np.random.default_rng(0).random((4, 3, 5)).astype(np.float32)
    return xr.Dataset(
        {
            "psa": (("node", "component", "frequency"), psa),
            "pfa": (("node", "component"), psa.max(axis=2).astype(float)),
            "node_number": ("node", np.array([8, 3, 5, 6])),
            "node_position": (("node", "xyz"), np.stack([0 * height, 0 * height, height], axis=1)),
        },
        coords={"frequency": np.geomspace(1.0, 10.0, 5)},
        attrs={"damping": 0.05, "points_per_cycle": 2.0},
    )


def test_largest_of_each_floor(store, tmp_path):
    write_netcdf(tmp_path / "transient_maps.nc", store)
    found = read_whole_floors(tmp_path / "transient_maps.nc", FLOORS)
    assert found is not None and found.vertices.tolist() == [2, 1]
    psa = store["psa"].values
    np.testing.assert_array_equal(found.psa[0], np.maximum(psa[0], psa[2]))
    np.testing.assert_array_equal(found.psa[1], psa[1])
    np.testing.assert_array_equal(found.pfa[0], psa[[0, 2]].max(axis=(0, 2)))
    assert (found.damping, found.points_per_cycle) == (0.05, 2.0)


def test_vertices_that_govern(store, tmp_path):
    """All of both vertices of the lower floor, where no one of them has the envelope."""
    write_netcdf(tmp_path / "transient_maps.nc", store)
    found = read_whole_floors(tmp_path / "transient_maps.nc", FLOORS)
    assert found is not None
    assert set(found.governing.node[found.governing.at(0, 1)]) <= {8, 5}
    assert found.governing.node[found.governing.at(1, 2)].tolist() == [3]
    height = dict(zip(store["node_number"].values, store["node_position"].values, strict=True))
    for node, position in zip(found.governing.node, found.position, strict=True):
        np.testing.assert_array_equal(position, height[node])
    assert np.all(found.governing_psa >= (1.0 - MISSED) * found.psa)
    assert np.all(found.governing_pfa >= (1.0 - MISSED) * found.pfa)
    assert set(found.candidates.node) == {8, 5, 3} and 6 not in found.governing.node


def test_candidates(store, tmp_path, monkeypatch):
    """The two largest at each place of three, and none where the floor moves as one."""
    store["node_position"][:, 2] = [3.0, 3.0, 3.0, 6.0]
    store["psa"][:] = 1.0
    store["psa"][:3, 1, 2] = [1.0, 0.5, 0.2]
    store["psa"][2, 2, 4] = 3.0
    store["pfa"][:] = 1.0
    write_netcdf(tmp_path / "transient_maps.nc", store)
    monkeypatch.setattr(whole_floors, "LARGEST", 2)
    found = read_whole_floors(tmp_path / "transient_maps.nc", FLOORS)
    assert found is not None
    nodes = [set(found.candidates.node[found.candidates.at(0, c)].tolist()) for c in range(3)]
    # Along x all are alike, and the one that was chosen stands for them.
    assert len(nodes[0]) == 1 and nodes[1] == {8, 3} and 5 in nodes[2] and len(nodes[2]) == 2


@pytest.mark.parametrize("most", [1, 24])
def test_a_floor_that_moves_at_many_places(store, tmp_path, monkeypatch, most):
    """One vertex alone does not have what each of two has at its own frequency."""
    store["psa"][:] = 0.1
    for place, frequency in ((0, 1), (2, 3)):
        store["psa"][place, :, frequency] = 1.0
    write_netcdf(tmp_path / "transient_maps.nc", store)
    monkeypatch.setattr(whole_floors, "fewest", partial(fewest, most=most))
    found = read_whole_floors(tmp_path / "transient_maps.nc", FLOORS)
    assert found is not None
    part = (found.governing_psa[0] / found.psa[0]).min()
    assert part == pytest.approx(0.1 if most == 1 else 1.0)


def test_a_direction_in_which_nothing_moves(store, tmp_path):
    store["psa"][:, 0], store["pfa"][:, 0] = 1e-12, 1e-12
    write_netcdf(tmp_path / "transient_maps.nc", store)
    found = read_whole_floors(tmp_path / "transient_maps.nc", FLOORS)
    assert found is not None
    assert 0 not in found.governing.component and 0 not in found.candidates.component


def test_without_fields(tmp_path):
    assert read_whole_floors(tmp_path / "transient_maps.nc", FLOORS) is None


def test_another_store(store, tmp_path):
    write_netcdf(tmp_path / "transient_maps.nc", store.drop_vars("psa"))
    with pytest.raises(ImpactfemError, match="cannot read fields over the floors from"):
        read_whole_floors(tmp_path / "transient_maps.nc", FLOORS)
