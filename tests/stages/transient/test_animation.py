"""Both buildings of the main impact: where their floors are drawn, and what is not."""

from contextlib import ExitStack

import numpy as np
import pytest
import xarray as xr

from impactfem.stages.transient import animation
from impactfem.stages.transient.animation import _pair, both_figures, line_ends

HATS = [[3.0, 4.0, 4.0], [0.0, 0.0, 1.0]]


@pytest.fixture
def pair(transient_folder, tmp_path, monkeypatch):
    """A run of building "one" and, below and 2 cm away, the same building once more."""

    def write(normal=(0.0, -1.0, 0.0), line="one-two", gap=0.02, apart=None):
        run = transient_folder()
        second = run / "two"
        second.mkdir()
        for name in ("transient.nc", "transient_maps.nc", "building.nc"):
            store = xr.load_dataset(run / name, engine="netcdf4")
            store.attrs["building"] = "two"
            store.to_netcdf(second / name, engine="netcdf4")
        ends = {"impact": [line, "other"]}
        stores = {
            "pounding.nc": xr.Dataset(
                {
                    "impact_peak_force": ("impact", [2e6, 1e6]),
                    "impact_pair": ("impact", ends["impact"]),
                    "building_axis": (("building", "plan"), [[10.0, 20.0], [10.0, 7.0]]),
                },
                {"building": ["one", "two"]},
            ),
            "forces.nc": xr.Dataset(
                {
                    "line": ("pair", ["one-two"] * 2),
                    "building_a": ("pair", ["one"] * 2),
                    "building_b": ("pair", ["two"] * 2),
                    "normal": (("pair", "axis"), [normal] * 2),
                    "gap": ("pair", [gap] * 2),
                    "hat_a": (("pair", "corner"), HATS),
                    "hat_b": (("pair", "corner"), HATS),
                    "offset_a": (("pair", "axis"), [[2.0, -4.0, 0.0], [-1.0, -4.0, 0.0]]),
                    "offset_b": (("pair", "axis"), [[2.0, 8.98, 0.0], [-1.0, 8.98, 0.0]]),
                }
            ),
        }
        if apart is not None:
            moved = np.multiply.outer([[0.0, 0.0], apart], [1.0, -2.0, 0.0])
            ground = xr.DataArray(moved, {"time": [0.0, 1.0]}, ("building", "time", "axis"))
            stores["pounding.nc"]["ground_apart"] = ground
        for name, store in stores.items():
            store.to_netcdf(run / name, engine="netcdf4")
        return second

    return write


def test_where_floors_are(pair):
    """The middle of a hat at axis and offset of its point; the side at its distance."""
    with ExitStack() as stores:
        floors, _, normal, gap = _pair(pair(), stores)
        places = []
        for one in floors:
            edge = line_ends(one.response)[0]
            corner = one.maps["wave_node_position"].values[:, 0].min()
            places.append((one.shift[0] + corner + np.mean(HATS[0]), one.shift[1] + edge[1]))
    assert places == [pytest.approx((12.0, 16.0)), pytest.approx((12.0, 15.98))]
    assert (tuple(normal), gap) == ((0.0, -1.0), 0.02)


def test_ground_that_waves_move_apart(pair):
    """Each building moves with the ground under it: of the second by the way from the first."""
    with ExitStack() as stores:
        floors, moved, _, _ = _pair(pair(apart=(0.0, 0.03)), stores)
        at = floors[1].maps["snapshot"].values
        own = [one.maps["wave_displacement"].values[..., :2] for one in floors]
    np.testing.assert_array_equal(moved[0], own[0])
    way = 0.03 * at[:, None, None] * [1.0, -2.0]
    np.testing.assert_allclose(moved[1] - own[1], np.broadcast_to(way, own[1].shape), atol=1e-9)
    assert at.min() > 0.0


@pytest.mark.parametrize(
    "change", [{"normal": (0.6, -0.8, 0.0)}, {"line": "other"}, {"gap": 0.0}], ids=str
)
def test_what_is_not_drawn(pair, change):
    folder = pair(**change)
    assert both_figures(folder) == [] and not (folder / "figures").exists()
    assert both_figures(folder.parent) == []  # the first building


def test_files(pair):
    """The gap is drawn wider."""
    folder = pair()
    (path,) = both_figures(folder)
    assert path.name == animation.PICTURE and path.is_file()
