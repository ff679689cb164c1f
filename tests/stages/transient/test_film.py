"""The film of the main impact: where buildings stand, how they move, and its files."""

import imageio.v2 as imageio
import numpy as np
import pytest
import xarray as xr

from impactfem.plot.figure import declared
from impactfem.stages.drawing import Figures
from impactfem.stages.transient import film
from impactfem.stages.transient.figures import TransientData

from ..figure_file import draw_all

GAP = 0.02


@pytest.fixture
def pair(transient_folder):
    """A run of building "one" and the same building once more, 2 cm away along a normal."""

    def write(normal=(0.0, -1.0, 0.0), other="two", **options):
        run = transient_folder(**options)
        second = run / "two"
        second.mkdir()
        for name in ("transient.nc", "transient_maps.nc", "building.nc"):
            store = xr.load_dataset(run / name, engine="netcdf4")
            store.attrs["building"] = "two"
            store.to_netcdf(second / name, engine="netcdf4")
        xr.Dataset().to_netcdf(run / "pounding.nc", engine="netcdf4")
        names = ["one", other] if other else ["two", ""]
        forces = {
            "building_a": ("pair", names[:1] * 2),
            "building_b": ("pair", names[1:] * 2),
            "normal": (("pair", "axis"), [normal] * 2),
            "gap": ("pair", [2.0 * GAP, GAP]),
        }
        xr.Dataset(forces).to_netcdf(run / "forces.nc", engine="netcdf4")
        return second

    return write


@pytest.mark.parametrize("normal", [(0.0, -1.0, 0.0), (0.6, 0.8, 0.0)])
def test_the_gap_has_the_factor_of_the_displacements(pair, normal):
    """Façades touch in the film when the smallest gap is closed, and stand opposite."""
    found = film.film_of(pair(normal))
    parts, times, factor = found.parts, found.times, found.factor
    second, first, moved = parts[0].points, parts[2].points, parts[0].displacement
    # The film is that of "two", which is on the side of b.
    assert (second @ normal).min() - (first @ normal).max() == pytest.approx(factor * GAP, rel=1e-5)
    assert factor > 1.0 and len(moved) == len(times) and times[0] < 0.0 < times[-1]
    across = np.array([-normal[1], normal[0], 0.0])
    assert np.median(first @ across) == pytest.approx(np.median(second @ across), abs=1e-6)


def test_walls_move_linearly_between_floors():
    """Their lower end rests on the ground; a parapet moves as the top floor."""
    nodes = np.array([[0.0, 0.0, 3.0], [4.0, 0.0, 3.0], [0.0, 0.0, 6.0], [4.0, 0.0, 6.0]])
    u = np.array([[[1.0, 0.0, 0.0]] * 2 + [[3.0, 0.0, 0.5]] * 2])
    points = np.array([[0.0, 0.0, z] for z in (0.0, 1.5, 3.0, 4.5, 6.0, 7.0)])
    moved = film.between_floors(points, nodes, u)
    assert moved[0, :, 0] == pytest.approx([0.0, 0.5, 1.0, 2.0, 3.0, 3.0])
    assert moved[0, :, 2] == pytest.approx([0.0, 0.0, 0.0, 0.25, 0.5, 0.5])


@pytest.mark.parametrize("options", [{"loads": ()}, {"other": ""}, {"other": "three"}], ids=str)
def test_nothing_is_drawn_without_an_impact_between_two_models(pair, options):
    folder = pair(**options)
    assert film.film_of(folder) is None and film.film_of(folder.parent) is None


@pytest.mark.slow
def test_files(pair):
    """The picture changes with time."""
    folder = pair()
    figures = Figures(TransientData, declared(film))
    gif, mp4 = sorted(draw_all(figures, folder, in_3d=True), key=lambda path: path.suffix)
    with xr.open_dataset(folder / "transient_maps.nc") as maps:
        count = maps.sizes["frame"]
    assert mp4.name == "main_impact.mp4" and imageio.get_reader(mp4).count_frames() == count
    pictures = imageio.mimread(gif)
    assert len(pictures) == count and pictures[0].shape[:2] == (480, 640)
    # Rows without texts.
    first, last = (np.asarray(pictures[k][90:400, :, :3], dtype=float) for k in (0, -1))
    assert np.abs(first - last).mean() > 0.1
