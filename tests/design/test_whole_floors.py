"""Reading `transient_maps.nc`: the largest of all vertices of each floor."""

import numpy as np
import pytest
import xarray as xr

from impactfem.design.floor_points import floor_points
from impactfem.design.whole_floors import read_whole_floors
from impactfem.errors import ImpactfemError
from impactfem.files import write_netcdf

pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")

FLOORS, _ = floor_points(("centre_1", "centre_2"), np.array([[0, 0, 3.0], [0, 0, 6.0]]))


@pytest.fixture
def store():
    height = np.array([3.0, 6.0, 3.0, 6.5])
    psa = np.random.default_rng(0).random((4, 3, 5)).astype(np.float32)
    return xr.Dataset(
        {
            "psa": (("node", "component", "frequency"), psa),
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
    assert (found.damping, found.points_per_cycle) == (0.05, 2.0)


def test_without_fields(tmp_path):
    assert read_whole_floors(tmp_path / "transient_maps.nc", FLOORS) is None


def test_another_store(store, tmp_path):
    write_netcdf(tmp_path / "transient_maps.nc", store.drop_vars("psa"))
    with pytest.raises(ImpactfemError, match="cannot read fields over the floors from"):
        read_whole_floors(tmp_path / "transient_maps.nc", FLOORS)
