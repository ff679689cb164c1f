"""Pictures in 3D fill their frame and see the building from the right side; the film of a wave."""

import re
import subprocess

import imageio.v2 as imageio
import numpy as np
import pytest
import xarray as xr
from imageio_ffmpeg import get_ffmpeg_exe
from matplotlib.colors import LogNorm
from PIL import Image

from impactfem.plot.scene import impact_view, screen_axes
from impactfem.stages.transient import animation
from impactfem.stages.transient.animation import LASTS, Filmed, write_film
from impactfem.stages.transient.pictures import (
    AMPLIFICATION,
    PEAKS,
    PROBES,
    colour_scale,
    draw_pictures,
)
from impactfem.stages.transient.selection import shown
from impactfem.system.errors import ImpactfemError
from impactfem.system.own_process import in_own_process


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
@pytest.mark.parametrize("direction", ["x", "y"])
def test_a_building(transient_folder, direction):
    folder = transient_folder(direction=direction)
    drawn = in_own_process(draw_pictures, folder)
    assert [path.name for path in drawn] == [PROBES, PEAKS, AMPLIFICATION]
    for path in drawn:
        with Image.open(path) as picture:
            assert picture.width > 900 and picture.height > 300
            assert len(picture.convert("RGB").getcolors(maxcolors=10**7)) > 50
        assert max(inked(path)) > 0.6


@pytest.mark.slow
def test_without_fields(transient_folder):
    folder = transient_folder(maps=False)
    assert [path.name for path in in_own_process(draw_pictures, folder)] == [PROBES]


def test_a_store_that_is_missing(transient_folder):
    folder = transient_folder(maps=False)
    (folder / "building.nc").unlink()
    with pytest.raises(ImpactfemError, match=r"building\.nc"):
        in_own_process(draw_pictures, folder)


def test_floors_that_are_far_above_the_others_take_the_logarithm():
    hit, others = np.array([60.0, 128.0]), np.array([2.7, 6.0, np.nan])
    scale = colour_scale(np.concatenate([hit, others]))
    assert isinstance(scale, LogNorm)
    assert np.asarray(scale([2.7, 128.0])) == pytest.approx([0.0, 1.0])
    # Of the floors that are not hit, a fifth of the colours and not a fortieth.
    assert np.ptp(scale([2.7, 6.0])) > 0.2
    assert bool(scale(others).mask[2])


@pytest.mark.parametrize("values", [[0.0, 128.0], [20.0, 128.0], [5.0, 5.0], [np.nan]])
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


def filmed(folder, **some):
    """The floor of the waves in the stores of a run."""
    names = ("transient.nc", "transient_maps.nc")
    store, maps = (xr.load_dataset(folder / name, engine="netcdf4") for name in names)
    return [Filmed(shown(store), maps.isel(some))]


def played(path):
    """What ffmpeg says of a film, and its frames, shape (n, height, width, 3)."""
    command = [get_ffmpeg_exe(), "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    about = done.stderr.decode()
    width, height = (int(x) for x in re.search(r"Video:.* (\d+)x(\d+)[ ,]", about).groups())
    pixels = np.frombuffer(done.stdout, dtype=np.uint8)
    return about, pixels.reshape(-1, height, width, 3).astype(np.float32)


@pytest.mark.slow
@pytest.mark.parametrize("direction", ["x", "y"])
def test_a_film(transient_folder, tmp_path, direction):
    path = tmp_path / "wave_floor_5.mp4"
    write_film(path, filmed(transient_folder(direction=direction, floors=(2, 5), loads=(5,))))
    assert 5_000 < path.stat().st_size < 2_000_000
    assert path.read_bytes()[4:8] == b"ftyp"
    about, pictures = played(path)
    # What all browsers play: even sizes, H.264 with colours by twos.
    assert re.search(r"Video: h264.*yuv420p", about)
    lasts = re.search(r"Duration: 00:00:([0-9.]+)", about)
    assert float(lasts[1]) == pytest.approx(LASTS, abs=0.2)
    assert len(pictures) == 53
    assert pictures.shape[1] % 2 == 0 and pictures.shape[2] % 2 == 0
    # It rests, moves, and rests again.
    moved = [np.abs(picture - pictures[0]).mean() for picture in pictures]
    assert moved[16] > 5.0 * max(moved[5], 0.1) and moved[-1] < 0.5 * moved[16]


def test_frames_say_when(transient_folder, monkeypatch):
    said, title = [], animation._title

    def kept(*given):
        said.append(title(*given))
        return said[-1]

    monkeypatch.setattr(animation, "_title", kept)
    frames = animation._frames(filmed(transient_folder(), frame=[0, 16]))
    first, second = next(frames), next(frames)
    assert first.dtype == np.uint8 and first.shape[2] == 3 and (first != second).any()
    assert said[-2].endswith("floor 3: t = 0.4900 s, 10.0 ms before the impact began; force 0.0 MN")
    assert said[-1].endswith("t = 0.5060 s, 6.0 ms after the impact began; force 20.0 MN")


def test_no_encoder(transient_folder, monkeypatch):
    def none(*arguments, **options):
        raise RuntimeError("No ffmpeg exe could be found")

    monkeypatch.setattr(imageio, "get_writer", none)
    path = transient_folder() / "figures" / "film.mp4"
    with pytest.raises(ImpactfemError, match=r"cannot write .*film\.mp4: No ffmpeg exe"):
        write_film(path, filmed(path.parents[1]))
    assert list(path.parent.iterdir()) == []
