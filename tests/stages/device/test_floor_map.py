"""The floor of a device at the frequencies of its modes."""

import numpy as np
import pytest
import xarray as xr

from impactfem.plot.words import read_words
from impactfem.stages.device import floor_map
from impactfem.stages.device.floor_map import device_map
from impactfem.stages.device.selection import anchor_of, shown_modes
from impactfem.stages.stores import open_store

from .device_store import WantedDevice, device_store


@pytest.fixture
def parts(transient_folder):
    """A device on a floor of the building with maps: device.nc, maps and building.nc."""
    folder = transient_folder()
    store = device_store(WantedDevice(devices=("pump",)))
    with open_store(folder / "transient_maps.nc") as maps, open_store(folder / "building.nc") as b:
        floor = int(maps["floor_triangle_floor"][-1])
        store["anchor_floor"][:] = floor
        return store, maps.load(), b.load()


def test_values_at_the_modes(parts, tmp_path, monkeypatch):
    """Where the largest value is, and a ratio of 4 everywhere."""
    store, maps, building = parts
    drawn = []
    scale = floor_map.colour_scale
    monkeypatch.setattr(floor_map, "colour_scale", lambda v: drawn.append(v) or scale(v))
    device_map(tmp_path / "map.png", store, maps, building, 64.0, "pump")
    f = shown_modes(store, "pump")["mode_frequency"].values
    count = len(drawn) // 2
    assert 0 < count <= min(len(f), 2)
    # The maps have (10 + y) f and a quarter of it without impact.
    for values, at in zip(drawn[:count], f, strict=False):
        assert values.max() == pytest.approx(16.0 * at, rel=1e-5)
        assert values.min() == pytest.approx(10.0 * at, rel=1e-5)
    assert all(values == pytest.approx(4.0) for values in drawn[count:])
    words = read_words(tmp_path / "map.png")
    assert f"floor {anchor_of(store, 'pump')[1]}" in words.caption


def test_modes_outside_the_maps_have_no_figure(parts):
    store, maps, _ = parts
    f = float(shown_modes(store, "pump")["mode_frequency"].max())
    above = xr.Dataset(coords={"frequency": np.array([2.0 * f, 3.0 * f])})
    assert not device_map.declared.when(store, above, "pump")
    assert device_map.declared.when(store, maps, "pump")
