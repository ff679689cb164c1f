"""Pictures in 3D fill their frame and see the building from the right side; the film of a wave."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import LogNorm
from PIL import Image

from impactfem.plot.floor_field import colour_scale
from impactfem.plot.scene import impact_view, screen_axes
from impactfem.stages.transient.stage import TRANSIENT
from impactfem.system.errors import ImpactfemError

from ..figure_file import draw_all


def inked(path):
    """Share of the picture's width and height between its first and last pixel that is not white.

    Legend, axes and the scale of colours are outside of the middle, which alone is looked at.
    """
    with Image.open(path) as picture:
        dark = np.asarray(picture.convert("L")) < 250
    dark = dark[: int(0.8 * dark.shape[0]), : int(0.8 * dark.shape[1])]
    rows, columns = np.flatnonzero(dark.any(axis=1)), np.flatnonzero(dark.any(axis=0))
    return np.ptp(rows) / dark.shape[0], np.ptp(columns) / dark.shape[1]


@pytest.mark.slow
def test_a_building(transient_folder):
    folder = transient_folder(direction="x")
    drawn = draw_all(TRANSIENT.figures, folder, in_3d=True)
    assert [path.name for path in drawn] == [
        "floor_amplification.png",
        "floor_peaks.png",
        "probes.png",
    ]
    for path in drawn:
        with Image.open(path) as picture:
            assert picture.width > 900 and picture.height > 300
            assert len(picture.convert("RGB").getcolors(maxcolors=10**7)) > 50
        assert max(inked(path)) > 0.6


@pytest.mark.slow
def test_without_fields(transient_folder):
    folder = transient_folder(maps=False)
    drawn = draw_all(TRANSIENT.figures, folder, in_3d=True)
    assert [path.name for path in drawn] == ["probes.png"]


def test_a_store_that_is_missing(transient_folder):
    folder = transient_folder(maps=False)
    (folder / "building.nc").unlink()
    with pytest.raises(ImpactfemError, match=r"building\.nc"):
        draw_all(TRANSIENT.figures, folder, in_3d=True)


def test_floors_that_are_far_above_the_others_take_the_logarithm():
    hit, others = np.array([60.0, 160.0]), np.array([2.7, 6.0, np.nan])
    scale = colour_scale(np.concatenate([hit, others]))
    assert isinstance(scale, LogNorm)
    assert np.asarray(scale([2.7, 160.0])) == pytest.approx([0.0, 1.0])
    # Of the floors that are not hit, a fifth of the colours and not a fortieth.
    assert np.ptp(scale([2.7, 6.0])) > 0.19
    assert bool(scale(others).mask[2])


@pytest.mark.parametrize("values", [[0.0, 128.0], [2.7, 128.0], [5.0, 5.0], [np.nan]])
def test_others_take_a_straight_scale(values):
    scale = colour_scale(np.array(values))
    assert not isinstance(scale, LogNorm)
    middle = 0.5 * (scale.vmin + scale.vmax)
    if scale.vmin < scale.vmax:
        assert scale(middle) == pytest.approx(0.5)


def test_the_impact_edge_is_seen(transient_folder):
    for direction, along in (("x", 0), ("y", 1)):
        path = transient_folder(direction=direction) / "building.nc"
        store = xr.load_dataset(path, engine="netcdf4")
        view, none = impact_view(store), impact_view(store.isel(edge=slice(0)))
        assert view[along] == pytest.approx(1.0) and view[2] > 0.0
        assert none[along] < 0.0


def test_axes_of_the_screen():
    right, up = screen_axes(np.array([0.0, -2.0, 0.0]))
    assert right == pytest.approx([1.0, 0.0, 0.0]) and up == pytest.approx([0.0, 0.0, 1.0])
    view = np.array([-0.3, -1.0, 0.8])
    right, up = screen_axes(view)
    assert [right @ up, right @ view, up @ view] == pytest.approx([0.0, 0.0, 0.0])
    assert right[0] > 0.0 and right[2] == pytest.approx(0.0) and up[2] > 0.0
