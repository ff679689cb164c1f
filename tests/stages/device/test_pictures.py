"""Pictures of devices in 3D: which there are, how large they are, and the lines around them."""

import numpy as np
import pytest
from PIL import Image

from impactfem.stages.device.pictures import _cut, device_pictures, device_size

from .device_store import WantedDevice, device_folder, device_store
from .test_figures import one_floor


@pytest.mark.slow
def test_pictures_of_two_devices(tmp_path):
    folder = device_folder(tmp_path, devices=("pump", "fan"))
    assert device_pictures(folder) == []
    one_floor().to_netcdf(folder / "building.nc", engine="h5netcdf")
    drawn = device_pictures(folder)
    assert [path.name for path in drawn] == ["figure_23_model.png", "figure_23_model_fan.png"]
    for path in drawn:
        with Image.open(path) as picture:
            assert picture.width > 1000
            assert len(picture.convert("RGB").getcolors(maxcolors=10**7)) > 50


def test_size_of_a_device():
    def size(**wanted):
        return device_size(device_store(WantedDevice(**wanted)), "pump")

    assert size() == pytest.approx((0.5, 1.0))
    radius, height = size(cylinder=False)
    assert height == pytest.approx(0.46) and radius == pytest.approx(0.25 * 0.46)
    assert size(from_modes=True) == (0.25, 1.0)


def test_lines_end_at_the_square():
    point = np.array([1.0, 1.0, 5.0])
    lines = np.array(
        [
            [[0.0, 1.0], [2.0, 1.0]],  # across it
            [[0.8, 0.8], [1.2, 1.2]],  # inside
            [[0.0, 0.0], [2.0, 2.0]],  # from corner to corner
            [[3.0, 0.0], [3.0, 2.0]],  # beside it
            [[1.0, 1.2], [1.0, 9.0]],  # out of it
            [[0.0, 1.4], [0.6, 2.0]],  # past a corner of it
        ]
    )
    cut = _cut(lines, point, 0.5, 7.0)
    expected = [
        [[0.5, 1.0], [1.5, 1.0]],
        [[0.8, 0.8], [1.2, 1.2]],
        [[0.5, 0.5], [1.5, 1.5]],
        [[1.0, 1.2], [1.0, 1.5]],
    ]
    assert cut[..., :2] == pytest.approx(np.array(expected))
    assert np.all(cut[..., 2] == 7.0)
