"""The figures of the stage `transient` for buildings of many kinds, from stores no solver made."""

import pytest
import xarray as xr
from matplotlib.axes import Axes
from PIL import Image

from impactfem.plot import style
from impactfem.stages.transient import figures as transient_figures
from impactfem.stages.transient.curve_figures import centre_spectrum
from impactfem.stages.transient.selection import at_floor, shown
from impactfem.system.errors import ImpactfemError

PROBES = [
    "figure_12_centre",
    "figure_13_centre_spectrum",
    "figure_15_across_spectra",
    "figure_16_across",
    "figure_19_edge_spectra",
    "figure_20_edge",
]
IMPACTS = ["figure_11_impact_forces", "figure_17_map", "figure_21_force_spectra"]
WAVES = ["figure_17_snapshots", "figure_18_membrane"]
TRANSFER = ["figure_22_transfer"]
MAPS = ["building_map_pfa", *(f"building_map_psa_{f}hz" for f in (10, 75, 85))]

ALL = [*PROBES, *IMPACTS, *WAVES, *TRANSFER, *MAPS]
CASES = {
    "no impact": ({"loads": ()}, [*PROBES, *MAPS]),
    "full solver": ({"solver": "full", "maps": False}, [*PROBES, *IMPACTS]),
    "along x": ({"direction": "x"}, ALL),
    "one floor": ({"floors": (1,), "loads": (1,)}, ALL),
    "other numbers, two dampings, two frequencies": (
        {"floors": (2, 5), "loads": (5,), "dampings": (0.02, 0.05), "frequencies": 2},
        ALL,
    ),
}


@pytest.fixture
def draw(monkeypatch):
    """Draw without pictures and film, which have tests of their own, and coarsely."""
    monkeypatch.setattr(transient_figures, "transient_pictures", lambda folder: [])
    monkeypatch.setattr(transient_figures, "wave_animation", lambda folder: [])
    monkeypatch.setitem(style.SETTINGS, "savefig.dpi", 40.0)
    return transient_figures.transient_figures


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_a_building(transient_folder, draw, name):
    wanted, expected = CASES[name]
    folder = transient_folder(**wanted)
    drawn = draw(folder)
    assert [path.stem for path in drawn] == sorted(expected)
    assert sorted((folder / "figures").iterdir()) == drawn
    for path in drawn:
        with Image.open(path) as picture:
            assert 200 <= picture.width <= 500 and 100 <= picture.height <= 500
            assert len(picture.convert("RGB").getcolors(maxcolors=10**6)) > 50


def test_maps_that_are_asked_for(transient_folder, draw):
    folder = transient_folder(loads=())
    drawn = draw(folder, fields=("psa",), field_frequencies=(0.2, 2.5, 700.0))
    # 0.2 Hz and 700 Hz are outside of what was computed.
    assert [path.stem for path in drawn if path.stem not in PROBES] == ["building_map_psa_2p5hz"]


def test_with_pictures(transient_folder, monkeypatch):
    folder = transient_folder(loads=(), maps=False)
    pictures = [folder / "figures" / "figure_14_probes.png"]
    monkeypatch.setattr(transient_figures, "transient_pictures", lambda _: pictures)
    monkeypatch.setattr(transient_figures, "probe_figures", lambda response, sticks: [])
    assert transient_figures.transient_figures(folder) == pictures


def test_a_folder_that_is_a_file(transient_folder, draw):
    folder = transient_folder(loads=(), maps=False)
    (folder / "figures").mkdir()
    (folder / "figures" / "figure_12_centre.png").mkdir()
    (folder / "figures" / "figure_12_centre.png" / "something").touch()
    with pytest.raises(ImpactfemError, match="cannot write"):
        draw(folder)


def test_the_band_is_drawn(transient_folder, monkeypatch):
    """Figure 13 has the store's band, and none for the full solver."""
    widths = []

    def kept(self, x, low, high, **options):
        widths.append(high - low)

    monkeypatch.setattr(Axes, "fill_between", kept)

    def draw_one(**wanted):
        folder = transient_folder(maps=False, **wanted)
        with (
            xr.open_dataset(folder / "transient.nc", engine="h5netcdf") as store,
            xr.open_dataset(folder / "pounding.nc", engine="h5netcdf") as sticks,
        ):
            response = shown(store)
            centre_spectrum(response, sticks).write_png(folder)
            return at_floor(response, "centre", 3)["psa"].values

    psa = draw_one()
    # Two half widths of 2 % each.
    assert len(widths) == 1 and widths[0] == pytest.approx(0.04 * psa)
    widths.clear()
    draw_one(solver="full")
    assert not widths
