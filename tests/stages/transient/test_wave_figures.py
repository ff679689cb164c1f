"""Figures of waves: values with a sign in colours with zero in their middle."""

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import rgb_to_hsv

from impactfem.plot import style
from impactfem.plot.floor_field import SIGNED, signed_limits
from impactfem.stages.transient import floor_figures
from impactfem.stages.transient.curve_figures import probe_figures
from impactfem.stages.transient.selection import forces_note, shown

NOTE = (
    " Before the main impact the samples of its force alternate about zero (figure 11), and move "
    "the floor."
)


@pytest.fixture
def drawn(transient_folder, monkeypatch):
    """Draw a figure; gives how its colours are asked for, and its caption."""
    asked, captions = [], []

    def kept(name):
        draw = getattr(Axes, name)

        def method(self, *values, **options):
            asked.append(options)
            return draw(self, *values, **options)

        return method

    def figure(path, panels, size, caption):
        captions.append(caption)
        return style.figure(path, panels, size, caption)

    def make(name, *, maps=True, **wanted):
        folder = transient_folder(**wanted)
        for method in ("tripcolor", "pcolormesh"):
            monkeypatch.setattr(Axes, method, kept(method))
        monkeypatch.setattr(floor_figures, "figure", figure)
        monkeypatch.setitem(style.SETTINGS, "savefig.dpi", 40.0)
        with (
            xr.open_dataset(folder / "transient.nc", engine="h5netcdf") as store,
            xr.open_dataset(folder / "transient_maps.nc", engine="h5netcdf") as fields,
        ):
            stores = (shown(store), fields) if maps else (shown(store),)
            getattr(floor_figures, name)(folder / "one.png", *stores)
        return asked, captions[0]

    return make


@pytest.mark.parametrize(
    ("name", "maps"), [("snapshots_figure", True), ("wave_map", False), ("membrane_figure", True)]
)
def test_zero_is_in_the_middle_of_the_colours(drawn, name, maps):
    asked, _ = drawn(name, maps=maps)
    # A scale of colours is drawn by pcolormesh as well, with limits of its own.
    own = [options for options in asked if "vmin" in options]
    assert own and all(options["cmap"] == SIGNED for options in own)
    assert all(options["vmin"] == -options["vmax"] < 0.0 for options in own)
    assert len({options["vmax"] for options in own}) == 1


@pytest.mark.parametrize(("name", "maps"), [("snapshots_figure", True), ("wave_map", False)])
def test_the_caption_says_why_the_floor_moves_before_it_is_hit(drawn, name, maps):
    assert drawn(name, maps=maps)[1].endswith(NOTE)


def test_speeds_beside_the_arrivals(drawn, monkeypatch):
    """The line of the slab with its masses lies on the peaks; the bare plate's does not."""
    lines = []
    plot = Axes.plot

    def kept(self, *values, **options):
        lines.append((values, options))
        return plot(self, *values, **options)

    monkeypatch.setattr(Axes, "plot", kept)
    drawn("wave_map", maps=False)
    peaks = next(v for v, options in lines if options.get("color") == "black" and v[2:] == ("o",))
    by_name = {options["label"]: v for v, options in lines if "label" in options}
    assert list(by_name) == [
        "slab with its masses, 2000 m/s",
        "shear waves, 1250 m/s",
        "bare plate, 3200 m/s",
    ]
    for name, near in (("slab with its masses, 2000 m/s", 0.1), ("bare plate, 3200 m/s", 1.0)):
        times, distances = by_name[name]
        away = np.abs(np.interp(peaks[1], distances, times) - peaks[0]).max()
        assert (away < 0.1) == (near == 0.1)


@pytest.mark.parametrize(("name", "maps"), [("snapshots_figure", True), ("wave_map", False)])
def test_the_caption_says_where_a_base_plate_is(drawn, name, maps):
    caption = drawn(name, maps=maps, plates=True)[1]
    where = "that of pump at x = 6 m, y = 3 m (d = 3 m), nodes within 0.8 m"
    assert f" Rigid base plates on the floor, where it is flat: {where}." in caption
    assert "tank" not in caption  # on another floor


def test_captions_of_spectra_say_it_too(transient_folder):
    folder = transient_folder(plates=True)
    with (
        xr.open_dataset(folder / "transient.nc", engine="h5netcdf") as store,
        xr.open_dataset(folder / "pounding.nc", engine="h5netcdf") as sticks,
    ):
        figures = list(probe_figures(shown(store), sticks))
    told = {one.name[:9] for one in figures if "that of pump at" in one.caption}
    assert told == {"figure_13", "figure_15", "figure_22"}


def test_without_an_impact_there_is_nothing_to_say(transient_folder):
    path = transient_folder(loads=(), maps=False) / "transient.nc"
    with xr.open_dataset(path, engine="h5netcdf") as store:
        assert forces_note(store) == ""


def test_colours_of_a_sign():
    low, zero, high = (np.array(mpl.colormaps[SIGNED](share)[:3]) for share in (0.0, 0.5, 1.0))
    assert zero.min() > 0.95
    # Blue and red: apart for eyes without one of the three kinds of cones.
    assert rgb_to_hsv(low)[0] == pytest.approx(0.6, abs=0.05)
    assert min(rgb_to_hsv(high)[0], 1.0 - rgb_to_hsv(high)[0]) < 0.06


@pytest.mark.parametrize("values", [(-128.0, 66.0), (-2.0, -1.0), (3.0,)])
def test_signed_limits(values):
    low, high = signed_limits(*values)
    assert low == -high and high == max(abs(value) for value in values)
