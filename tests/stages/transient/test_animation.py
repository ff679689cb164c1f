"""The film of the wave: its frames, its encoding, and the cases without one."""

import re
import subprocess

import imageio.v2 as imageio
import numpy as np
import pytest
import xarray as xr
from imageio_ffmpeg import get_ffmpeg_exe
from matplotlib.tri import Triangulation

from impactfem.stages.transient.animation import LASTS, Sampler, _frames, wave_animation
from impactfem.stages.transient.selection import shown
from impactfem.system.errors import ImpactfemError


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
def test_a_film(transient_folder, direction):
    folder = transient_folder(direction=direction, floors=(2, 5), loads=(5,))
    (path,) = wave_animation(folder)
    assert path == folder / "figures" / "wave_floor_5.mp4"
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
    said = []
    folder = transient_folder()
    with (
        xr.open_dataset(folder / "transient.nc", engine="h5netcdf") as store,
        xr.open_dataset(folder / "transient_maps.nc", engine="h5netcdf") as maps,
    ):
        from impactfem.stages.transient import animation

        title = animation._title

        def kept(response, time):
            said.append(title(response, time))
            return said[-1]

        monkeypatch.setattr(animation, "_title", kept)
        frames = _frames(shown(store), maps.isel(frame=[0, 16]))
        first, second = next(frames), next(frames)
    assert first.dtype == np.uint8 and first.shape[2] == 3 and (first != second).any()
    assert said[-2].endswith("floor 3: t = 0.4900 s, 10.0 ms before the impact began; force 0.0 MN")
    assert said[-1].endswith("t = 0.5060 s, 6.0 ms after the impact began; force 20.0 MN")


@pytest.mark.parametrize(
    "wanted",
    [{"maps": False}, {"solver": "full", "maps": False}, {"loads": ()}, {"frames": False}],
    ids=["no maps", "full solver", "no impact", "maps without frames"],
)
def test_no_film(transient_folder, wanted):
    folder = transient_folder(**wanted)
    assert wave_animation(folder) == []
    assert not (folder / "figures").exists()


def test_no_encoder(transient_folder, monkeypatch):
    def none(*arguments, **options):
        raise RuntimeError("No ffmpeg exe could be found")

    monkeypatch.setattr(imageio, "get_writer", none)
    folder = transient_folder()
    with pytest.raises(ImpactfemError, match=r"cannot write .*wave_floor_3\.mp4: No ffmpeg exe"):
        wave_animation(folder)
    assert list((folder / "figures").iterdir()) == []


def test_values_at_points():
    """Linear functions are met exactly, in whichever triangle; there is nothing outside."""
    mesh = Triangulation([0.0, 4.0, 4.0, 0.0], [0.0, 0.0, 2.0, 2.0], [[0, 1, 2], [0, 2, 3]])
    points = np.array([[[0.5, 0.2], [3.9, 1.0]], [[1.0, 1.9], [5.0, 1.0]]])
    found = Sampler(mesh, points)(3.0 + 2.0 * mesh.x - 7.0 * mesh.y)
    expected = 3.0 + 2.0 * points[..., 0] - 7.0 * points[..., 1]
    assert found[0] == pytest.approx(expected[0]) and found[1, 0] == pytest.approx(expected[1, 0])
    assert np.isnan(found[1, 1])
