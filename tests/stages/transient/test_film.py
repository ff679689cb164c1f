"""The film of the main impact: where buildings stand, how they move, and its files."""

import re
import subprocess

import imageio.v2 as imageio
import numpy as np
import pytest
import xarray as xr
from imageio_ffmpeg import get_ffmpeg_exe

from impactfem.stages.transient import film
from impactfem.system.errors import ImpactfemError
from impactfem.system.own_process import in_own_process

GAP, DEPTH = 0.02, 4.0
"""Gap of the pair, and distance of the façade of the neighbour from its axis [m]."""


_EMPTY = film.Moving(np.zeros((0, 3)), np.zeros((0, 3), dtype=int), np.zeros((1, 0, 3)))
_PLAN = [[0.0, 0.0, 4.0], [8.0, 0.0, 4.0], [8.0, 6.0, 4.0], [0.0, 6.0, 4.0]]
BOX = film.Actor(
    "box",
    film.Moving(np.array(_PLAN), np.array([[0, 1, 2, 3]]), np.zeros((1, 4, 3))),
    *(_EMPTY, _EMPTY, np.zeros((1, 4))),
)
"""A building of one slab of 8 m x 6 m."""


@pytest.fixture
def folder(transient_folder):
    """A run of building "one" with a neighbour "two" of one floor beyond its impact edge."""

    def write(**wanted):
        run = transient_folder(**wanted)
        with xr.open_dataset(run / "transient_maps.nc") as maps:
            size = np.ptp(maps["node_position"].values, axis=0)
            times = maps["frame"].values
        along = wanted.get("direction", "y")
        c = "xyz".index(along)
        normal, reach = np.zeros(3), np.zeros(3)
        normal[c], reach[c] = 1.0, size[c] / 2.0
        time = np.linspace(0.0, 1.0, 2001)
        u = 0.03 * np.sin(2.0 * np.pi * time)
        stations = [*((f"one.floor_{k}", "one", k) for k in (1, 2, 3)), ("two.floor_1", "two", 1)]
        names, buildings, floors = zip(*stations, strict=True)
        xr.Dataset(
            {
                "displacement": (("time", "station", "component"), _moved(u, [0, 0, 0, 1])),
                "acceleration": (("time", "station", "component"), _moved(u, [0, 0, 0, 9])),
                "building_axis": (("building", "plan"), [[50.0, 50.0], _axis(c, size[c])]),
                "building_base": ("building", [0.0, 0.0]),
            },
            {
                "time": time,
                "component": [along],
                "station": list(names),
                "station_building": ("station", list(buildings)),
                "station_floor": ("station", list(floors)),
                "elevation": ("station", [4.0, 8.0, 12.0, 4.0]),
                "rigid_below": ("station", [0.4, 0.4, 0.4, 0.4]),
                "rigid_above": ("station", [0.1, 0.1, 0.1, 0.1]),
                "building": ["one", "two"],
                "building_model": ("building", ["stick", "stick"]),
            },
            {"shown_direction": along},
        ).to_netcdf(run / "pounding.nc")
        force = np.where((time > 0.5) & (time < 0.512), 2e7, 0.0)
        xr.Dataset(
            {
                "building_a": ("pair", ["one"]),
                "building_b": ("pair", ["two"]),
                "floor_a": ("pair", [1]),
                "floor_b": ("pair", [1]),
                "normal": (("pair", "axis"), [normal]),
                "gap": ("pair", [GAP]),
                "relative_height_a": ("pair", [np.nan]),
                "relative_height_b": ("pair", [np.nan]),
                "offset_a": (("pair", "axis"), [reach]),
                "offset_b": (("pair", "axis"), [-DEPTH * normal]),
                "force": (("time", "pair"), force[:, None]),
            },
            {"time": time, "axis": list("xyz"), "pair": ["one.floor_1-two.floor_1"]},
        ).to_netcdf(run / "forces.nc")
        return run, times

    return write


def _moved(u, factors):
    return np.multiply.outer(u, factors)[..., None]


def _axis(c, size):
    """Axis of the neighbour in plan: beyond half the building, the gap and its own half [m]."""
    place = np.array([50.0, 50.0])
    place[c] += size / 2.0 + GAP + DEPTH
    return place


@pytest.fixture
def cast(folder, monkeypatch):
    """The buildings and contact points of the film, as they are handed to the drawing."""

    def seen(**wanted):
        run, _ = folder(**wanted)
        handed = []
        monkeypatch.setattr(film, "draw_frames", lambda shown: handed.append(shown) or [])
        monkeypatch.setattr(film, "_write_mp4", lambda *_: None)
        monkeypatch.setattr(film, "_write_gif", lambda *_: None)
        film.draw_film(run)
        return handed[0]

    return seen


@pytest.mark.parametrize("direction", ["x", "y"])
def test_the_gap_has_the_factor_of_the_displacements(cast, direction):
    """So that façades touch in the film when the gap is closed."""
    shown = cast(direction=direction)
    (one, two), factor = shown.actors, shown.factor
    c = "xyz".index(direction)
    edge, face = one.floors.points[:, c].max(), two.floors.points[:, c].min()
    assert factor > 1.0 and face - edge == pytest.approx(factor * GAP, rel=1e-5)
    # The contact point is on the façade, at the height of the floor.
    assert shown.touches[0].place[[c, 2]] == pytest.approx([edge, 4.0], rel=1e-5)
    # Both façades are opposite to each other.
    across = 1 - c
    middles = [b.floors.points[:, across].mean() for b in (one, two)]
    assert middles[0] == pytest.approx(middles[1], abs=0.01)


def test_displacements_and_forces_are_those_of_the_stores(cast):
    shown = cast()
    _, two = shown.actors
    u = 0.03 * np.sin(2.0 * np.pi * shown.times)
    np.testing.assert_allclose(two.floors.displacement[:, 0, 1], u, atol=1e-4)
    np.testing.assert_allclose(two.acceleration[:, 0], 9.0 * u, atol=1e-3)
    force = shown.touches[0].force
    assert force.max() == 2e7 and force[0] == 0.0


def test_a_contact_between_two_frames_is_in_the_later_one(folder):
    run, _ = folder()
    store = xr.load_dataset(run / "forces.nc")
    store["force"][:] = 0.0
    store["force"][1003, 0] = 5e6
    pairs = film._pairs_of(store, "one")
    with xr.open_dataset(run / "pounding.nc") as pounding:
        (touch,) = film._touches(pairs, pounding, "one", store.time.values[990:1020:5])
    assert touch.force.tolist() == [0.0, 0.0, 0.0, 5e6, 0.0, 0.0]


def test_the_contact_of_a_storey_is_between_its_floors(folder):
    run, times = folder()
    store = xr.load_dataset(run / "forces.nc")
    store["floor_a"][:], store["relative_height_a"][:] = 2, 0.25
    with xr.open_dataset(run / "pounding.nc") as pounding:
        (touch,) = film._touches(film._pairs_of(store, "one"), pounding, "one", times)
    # Between 4.1 and 7.6 m, the rigid ends of storey 2.
    assert touch.place[2] == pytest.approx(4.1 + 0.25 * 3.5 + float(store.offset_a[0, 2]))


def test_walls_move_linearly_between_floors():
    """Their lower end rests on the ground; a parapet moves as the top floor."""
    nodes = np.array([[0.0, 0.0, 3.0], [4.0, 0.0, 3.0], [0.0, 0.0, 6.0], [4.0, 0.0, 6.0]])
    u = np.array([[[1.0, 0.0, 0.0]] * 2 + [[3.0, 0.0, 0.5]] * 2])
    points = np.array([[0.0, 0.0, z] for z in (0.0, 1.5, 3.0, 4.5, 6.0, 7.0)])
    moved = film._between_floors(points, nodes, u)
    assert moved[0, :, 0] == pytest.approx([0.0, 0.5, 1.0, 2.0, 3.0, 3.0])
    assert moved[0, :, 2] == pytest.approx([0.0, 0.0, 0.0, 0.25, 0.5, 0.5])


def test_a_rigid_wall_is_a_plate_at_the_gap(folder):
    run, _ = folder()
    forces = xr.load_dataset(run / "forces.nc")
    assert film._plates(forces, BOX, 10.0) == []
    forces["building_b"][:] = ""
    (plate,) = film._plates(forces, BOX, 10.0)
    assert plate[:, 1] == pytest.approx([6.0 + 10.0 * GAP] * 4)
    assert np.ptp(plate, axis=0)[0] == pytest.approx(8.0)


def test_nothing_is_drawn_without_impact(folder):
    run, _ = folder(loads=())
    assert film.draw_film(run) == []


@pytest.mark.slow
def test_files(folder):
    """An mp4 that all browsers play and a GIF; the picture changes with time."""
    run, times = folder()
    mp4, gif = in_own_process(film.draw_film, run)
    assert (mp4.name, gif.name) == ("main_impact.mp4", "main_impact.gif")
    command = [get_ffmpeg_exe(), "-i", mp4, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    about = done.stderr.decode()
    assert re.search(r"Video: h264.*yuv420p", about)
    lasts = re.search(r"Duration: 00:00:([0-9.]+)", about)
    assert float(lasts[1]) == pytest.approx(film.LASTS, abs=0.3)
    pictures = imageio.mimread(gif)
    assert len(pictures) == len(times) and pictures[0].shape[:2] == (480, 640)
    buildings = slice(90, 400)  # rows without texts
    first, last = (np.asarray(pictures[k][buildings, :, :3], dtype=float) for k in (0, -1))
    assert np.abs(first - last).mean() > 0.1


def test_no_encoder(tmp_path, monkeypatch):
    def none(*arguments, **options):
        raise RuntimeError("No ffmpeg exe could be found")

    monkeypatch.setattr(imageio, "mimwrite", none)
    path = tmp_path / "film.mp4"
    with pytest.raises(ImpactfemError, match=r"No ffmpeg exe"):
        film._write_mp4(path, [np.zeros((4, 4, 3), dtype=np.uint8)])
    assert not path.exists()
