"""The figures of the stage `transient`, from stores no solver made: all kinds, waves, fields."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes

from impactfem.case import load_case
from impactfem.case.transient import Transient
from impactfem.plot import style
from impactfem.plot.floor_field import SIGNED
from impactfem.stages.transient import curve_figures, floor_figures
from impactfem.stages.transient.curve_figures import (
    centre,
    centre_spectrum,
)
from impactfem.stages.transient.figures import TransientData
from impactfem.stages.transient.selection import at_floor, of_pounding, shown
from impactfem.stages.transient.stage import TRANSIENT
from impactfem.system.errors import ImpactfemError

from ..figure_file import assert_drawn, draw_all

PROBES = [
    "centre",
    "centre_spectrum",
    "across_spectra",
    "across",
    "edge_spectra",
    "edge",
]
IMPACTS = ["edge_impacts", "wave_map", "force_density"]
WAVES = ["wave_snapshots", "membrane_force"]
TRANSFER = ["transfer_functions"]
MAPS = ["top_floor_pfa", *(f"top_floor_psa-{f}hz" for f in (10, 33, 100))]

ALL = [*PROBES, *IMPACTS, *WAVES, *TRANSFER, *MAPS]
CASES = {
    "no impact": ({"loads": ()}, [*PROBES, *MAPS]),
    "full solver": ({"solver": "full", "maps": False}, [*PROBES, *IMPACTS]),
    "one floor, along x": ({"floors": (1,), "loads": (1,), "direction": "x"}, ALL),
    "two dampings, two frequencies, without frames": (
        {
            "floors": (2, 5),
            "loads": (5,),
            "dampings": (0.02, 0.05),
            "frequencies": 2,
            "frames": False,
        },
        ALL,
    ),
}


@pytest.fixture
def draw(monkeypatch):
    """Draw without pictures and film, which have tests of their own, and coarsely."""
    monkeypatch.setitem(style.SETTINGS, "figure.dpi", 40.0)
    return partial(draw_all, TRANSIENT.figures)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_a_building(transient_folder, draw, name):
    wanted, expected = CASES[name]
    folder = transient_folder(**wanted)
    drawn = draw(folder)
    assert [path.stem for path in drawn] == sorted(expected)
    assert sorted((folder / "figures").iterdir()) == drawn
    for path in drawn:
        assert_drawn(path, 500, 500)


def test_maps_that_are_asked_for(transient_folder, draw):
    folder = transient_folder(loads=())
    maps = Transient.model_construct(fields=("psa",), field_frequencies=(0.2, 2.5, 700.0))
    drawn = draw(folder, transient=maps)
    # 0.2 Hz and 700 Hz are outside of what was computed.
    assert [path.stem for path in drawn if path.stem not in PROBES] == ["top_floor_psa-2p5hz"]


def test_maps_are_at_the_modes_of_the_devices():
    """The pump of the paper's building has modes at 30.5 and 82.9 Hz (Table 6)."""
    case = load_case(Path(__file__).parents[3] / "geometry" / "npp_pair.toml")
    maps = xr.Dataset(coords={"frequency": [1.0, 200.0]})
    for devices, expected in (
        (case.devices, ["30p5hz", "82p9hz"]),
        ((), ["10hz", "33hz", "100hz"]),
    ):
        building = replace(case.in_time[0], devices=devices)
        default = building.transient.model_copy(update={"field_frequencies": None})
        data = TransientData(replace(building, transient=default), Path(), lambda _: maps)
        vars(data)["maps"] = maps
        assert data.frequency == expected


def test_a_folder_that_is_a_file(transient_folder, draw):
    folder = transient_folder(loads=(), maps=False)
    (folder / "figures").mkdir()
    (folder / "figures" / "centre.svg").mkdir()
    (folder / "figures" / "centre.svg" / "something").touch()
    with pytest.raises(ImpactfemError, match="cannot write"):
        draw(folder)


def test_the_band_is_drawn(stores, tmp_path, monkeypatch):
    """The spectrum has the store's band, and none for the full solver."""
    widths = []

    def kept(self, x, low, high, **options):
        widths.append(high - low)

    monkeypatch.setattr(Axes, "fill_between", kept)

    def draw_one(**wanted):
        store, sticks = stores(**wanted)
        centre_spectrum(shown(store), sticks).write(tmp_path / "one.svg")
        return at_floor(shown(store), "centre", 3)["psa"].values

    psa = draw_one()
    # Two half widths of 2 % each.
    assert len(widths) == 1 and widths[0] == pytest.approx(0.04 * psa)
    widths.clear()
    draw_one(solver="full")
    assert not widths


@pytest.mark.parametrize("count", [3, 30])
def test_many_points_are_one_curve(stores, count):
    """A legend of 78 left no room for the curves."""
    store, sticks = stores()
    response = shown(store)
    other = response.isel(probe=[0] * count)
    other = other.assign_coords(
        probe=[f"own_{k}" for k in range(count)], probe_kind=("probe", ["point"] * count)
    )
    figure = centre_spectrum(xr.concat([response, other], "probe", data_vars="minimal"), sticks)
    labels = [curve.label for curve in figure.panels[-1].curves]
    before = sum(kind == "point" for kind in response["probe_kind"].values.tolist())
    assert any("largest of" in label for label in labels) is (count + before > 10)


def test_forces_inside_storeys_are_called_so(stores):
    """Legend and caption name what is struck."""
    store, _ = stores()
    names = [name.replace("floor", "storey") for name in store["edge"].values]
    response = shown(store.assign_coords(edge=names))
    figure = curve_figures.force_density(response)
    assert all(curve.label in names for curve in figure.panels[0].curves)
    assert "floor" not in figure.caption and names[-1] in figure.caption


@pytest.fixture
def drawn(transient_folder, monkeypatch):
    """Draw a figure; gives how its colours are requested."""
    asked = []

    def kept(name):
        draw = getattr(Axes, name)

        def method(self, *values, **options):
            asked.append(options)
            return draw(self, *values, **options)

        return method

    def make(name, *, maps=True, **wanted):
        folder = transient_folder(**wanted)
        for method in ("tripcolor", "pcolormesh"):
            monkeypatch.setattr(Axes, method, kept(method))
        monkeypatch.setitem(style.SETTINGS, "figure.dpi", 40.0)
        given = [shown(xr.load_dataset(folder / "transient.nc", engine="netcdf4"))]
        if maps:
            given.append(xr.load_dataset(folder / "transient_maps.nc", engine="netcdf4"))
        getattr(floor_figures, name)(folder / "one.png", *given)
        return asked

    return make


@pytest.mark.parametrize(
    ("name", "maps"), [("snapshots_figure", True), ("wave_map", False), ("membrane_figure", True)]
)
def test_zero_is_in_the_middle_of_the_colours(drawn, name, maps):
    asked = drawn(name, maps=maps, plates=True)
    # A scale of colours is drawn by pcolormesh as well, with limits of its own.
    own = [options for options in asked if "vmin" in options]
    assert own and all(options["cmap"] == SIGNED for options in own)
    assert all(options["vmin"] == -options["vmax"] < 0.0 for options in own)
    assert len({options["vmax"] for options in own}) == 1


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


@pytest.mark.parametrize(
    ("model", "words"), [("stick", "sticks"), ("structure", "pounding, steps of 0.5 ms")]
)
def test_what_pounded(stores, model, words):
    """Response and spectrum of the mass centre have it together with the 3D model."""
    store, pounding = stores(model=model)
    for figure in (centre, centre_spectrum):
        found = figure(shown(store), pounding)
        labels = [curve.label for curve in found.panels[0].curves]
        assert sum(label.startswith(words) for label in labels) == 1
        assert f"3D model and {words}" in found.caption


def test_displacements_are_relative_to_the_ground_under_the_building(stores):
    """Those of the 3D model are: what pounded is, too, where waves move its ground elsewhere."""
    store, pounding = stores()
    time, response = pounding["time"].values, shown(store)
    ground = np.zeros((1, len(time), 3))
    ground[0, :, 1] = 0.02 * time
    apart = pounding.assign_coords(axis=["x", "y", "z"]).assign(
        ground_apart=(("building", "time", "axis"), ground)
    )
    for name, way in (("displacement", 0.02 * time), ("acceleration", 0.0 * time)):
        off = of_pounding(pounding, name, response) - of_pounding(apart, name, response)
        np.testing.assert_allclose(off.values, way, atol=1e-12)
