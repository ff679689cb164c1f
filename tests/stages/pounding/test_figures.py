"""The figures of cases of many kinds: all are drawn, none warns, each is a picture."""

from contextlib import nullcontext

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from PIL import Image

from impactfem.case import load_case
from impactfem.coupling.force_history import write_forces
from impactfem.plot import style
from impactfem.plot.style import (
    BUILDINGS,
    DOTS,
    floor_colours,
    floor_looks,
    letter,
    ordered_looks,
    sheet,
)
from impactfem.plot.words import read_words
from impactfem.stages.drawing import Figures
from impactfem.stages.pounding import figures, model_figures
from impactfem.stages.pounding.compute import run_sticks
from impactfem.stages.pounding.elevation import elevation_figure
from impactfem.stages.pounding.figures import PoundingData
from impactfem.stages.pounding.stage import POUNDING
from impactfem.stages.pounding.store import write_motion, write_sticks
from impactfem.stages.stores import by_line, open_store

from ..figure_file import assert_drawn, draw_all

FREE = ["case", "damping", "elevation", "pounding_spectra", "response", "stick_model"]
ALL = sorted([*FREE, "contact_pairs", "impact_forces"])
FASTER = (('duration = "3 s"', 'duration = "1.6 s"'), ('["0.5 s", "2.5 s"]', '["0.4 s", "1.4 s"]'))
FAR = """[[buildings]]
name = "far"
material = "concrete"
floors = "small_floors.csv"
axis = ["10 m", "30.04 m"]
rigid_below = "0.40 m"
rigid_above = "0.10 m"

"""
FAR_CONTACT = """[[contacts]]
a = { building = "east", floor = [1, 2, 3], offset = ["0 m", "6 m", "0 m"] }
b = { building = "far", floor = [1, 2, 3], offset = ["0 m", "-6 m", "0 m"] }
normal = [0, 1, 0]
gap = "2 cm"
law = "floor"

"""
STOREY_CONTACT = """[[contacts]]
a = { building = "west", floor = 2, offset = ["0 m", "6 m", "0 m"] }
b = { building = "east", storey = 3, relative_height = 0.5, offset = ["0 m", "-6 m", "0 m"] }
normal = [0, 1, 0]
gap = "2 cm"
law = "floor"

"""
GRID = 'frequencies = { minimum = "0.5 Hz", maximum = "50 Hz", per_decade = 10 }'


def without(text, begin, end):
    start = text.index(begin)
    return text[:start] + text[text.index(end, start) :]


def free(text):
    return without(text, "[[contacts]]\n", "# A floor that meets")


def alone(text):
    return without(free(text), '[[buildings]]\nname = "east"', "# Fit stiffness")


def before(mark, addition):
    return lambda text: text.replace(mark, addition + mark)


def changed(*changes):
    def change(text):
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        return text

    return change


def direction(name):
    return changed(
        ('direction = "y"\ntype = "synthetic"', f'direction = "{name}"\ntype = "synthetic"')
    )


def row_of_three(text):
    text = before("# Fit stiffness", FAR)(text)
    return before("# A floor that meets", FAR_CONTACT)(text)


def floor_on_storey(text):
    """A pair that is not level."""
    text = changed(("title = ", 'allow = ["depth"]\ntitle = '))(text)
    return before("# A floor that meets", STOREY_CONTACT)(text)


WALL = ('b = { building = "east", fl', 'wall = "pit" # fl')


def one_floor_along_x(text):
    return changed(("[1, 2, 3]", "1"), ("small_floors", "one_floor"))(direction("x")(text))


CASES = {
    "without contacts": (free, FREE),
    "one building": (alone, FREE),
    "three buildings": (row_of_three, ALL),
    "vertical": (direction("z"), ALL),
    "floor on storey": (floor_on_storey, ALL),
    "a rigid wall, one frequency": (changed(WALL, (GRID, 'frequencies = ["5 Hz"]')), ALL),
    "one floor, along x": (one_floor_along_x, ALL),
}


STORES = {"case_figure": ("motion", "pounding", "forces"), "contact_figure": ("pounding", "forces")}


@pytest.fixture
def draw(new_case, tmp_path, monkeypatch):
    """Compute a case and draw its figures, as the stage does, coarsely; or some, or one alone."""
    monkeypatch.setitem(style.SETTINGS, "figure.dpi", 60.0)

    def run(change, one=None, only=None):
        path = new_case(tmp_path, *FASTER)
        floors = (tmp_path / "small_floors.csv").read_text(encoding="utf-8")
        (tmp_path / "one_floor.csv").write_text(floors[: floors.index("\n2,")], encoding="utf-8")
        path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")
        study = run_sticks(load_case(path), lambda _: nullcontext())
        write_motion(tmp_path / "motion.nc", study, "")
        write_sticks(tmp_path / "pounding.nc", study, "")
        write_forces(tmp_path / "forces.nc", study.response, "", "")
        if one is None:
            wanted = POUNDING.figures.declared
            some = tuple(f for f in wanted if f.each == "" and only in (None, f.name))
            return draw_all(Figures(PoundingData, some), tmp_path)
        stores = [
            xr.load_dataset(tmp_path / f"{name}.nc", engine="netcdf4") for name in STORES[one]
        ]
        return getattr(model_figures, one)(tmp_path / "one.svg", *stores)

    return run


@pytest.mark.parametrize("name", CASES)
def test_a_case(draw, tmp_path, name):
    change, expected = CASES[name]
    drawn = draw(change)
    assert sorted(path.stem for path in drawn) == expected
    assert sorted((tmp_path / "figures").iterdir()) == sorted(drawn)
    for path in drawn:
        assert_drawn(path, 0, 0)


def test_the_elevation_names_floors_and_accelerations(draw, tmp_path):
    """Of each building; one that is not hit has the same acceleration with and without impact."""
    draw(changed(), only="elevation")
    store = xr.load_dataset(tmp_path / "pounding.nc", engine="netcdf4")
    words = read_words(tmp_path / "figures" / "elevation.svg")
    for name in store["building"].values:
        own = store.isel(station=(store["station_building"] == name).values)
        largest = float(own["pfa"].sel(direction=store.attrs["shown_direction"]).max())
        assert f"{name} with {own.sizes['station']} floors" in words.seen
        assert f"{largest:.3g} m/s²" in words.seen
    text = (tmp_path / "figures" / "elevation.svg").read_text(encoding="utf-8")
    assert f"{store.sizes['impact']}×" in text and "MN" in text and "gap 20 mm" in text


def test_devices_are_marked_in_the_elevation(draw, tmp_path):
    """Those of one place have one text; a device of another building is on that building."""
    draw(changed(), only="")
    sticks, forces = (open_store(tmp_path / name) for name in ("pounding.nc", "forces.nc"))
    names = [str(name) for name in xr.load_dataset(tmp_path / "pounding.nc")["building"].values]
    place, other = (0.0, 0.0, 3.5), (0.0, 0.0, 7.0)
    equipment = [(names[0], "pump", place), (names[0], "fan", place), (names[1], "tank", other)]
    with sticks as one, forces as pairs:
        elevation_figure(tmp_path / "one.svg", one, by_line(pairs), equipment)
    text = (tmp_path / "one.svg").read_text(encoding="utf-8")
    assert "pump, fan" in text and "tank" in text
    assert "required" in text and "devices" in read_words(tmp_path / "one.svg").caption


@pytest.mark.parametrize(("name", "shown"), [("wall", True), ("along x", False)])
def test_the_elevation_holds_its_rigid_wall(draw, tmp_path, name, shown):
    """Names outside of the axes are not drawn; without a wall there is no such name."""
    draw(changed(WALL) if shown else direction("x"), only="elevation")
    text = (tmp_path / "figures" / "elevation.svg").read_text(encoding="utf-8")
    assert ("rigid wall" in text, "gap 20 mm" in text) == (shown, True)


@pytest.mark.parametrize("hertz", [False, True])
def test_the_law_of_the_contact(draw, tmp_path, hertz):
    """A spring and a dashpot are the picture of one law alone."""
    linear = 'type = "kelvin-voigt"\nstiffness = "1.2e10 N/m" '
    other = 'type = "hunt-crossley"\nstiffness = "3e11 N/m^1.5" #'
    draw(changed((linear, other)) if hertz else changed(), "contact_figure")
    words = read_words(tmp_path / "one.svg")
    assert ("hunt-crossley" in words.caption) == hertz


def test_3d_models_are_no_sticks(draw, tmp_path, monkeypatch):
    """Slabs in the figure of the contact, no modes of sticks."""
    draw(changed(), "contact_figure")
    store = xr.load_dataset(tmp_path / "pounding.nc", engine="netcdf4")
    laws = ["unilateral"] * store.sizes["pair"]
    sticks = store.assign_coords(pair_law=("pair", laws))
    store = sticks.assign_coords(building_model=("building", ["structure"] * 2))
    drawn = list[str]()
    for name in ("_draw_slabs", "_draw_stick"):
        monkeypatch.setattr(model_figures, name, lambda *_, name=name: drawn.append(name))
    forces = xr.load_dataset(tmp_path / "forces.nc", engine="netcdf4")
    model_figures.contact_figure(tmp_path / "one.svg", store, forces)
    assert drawn == ["_draw_slabs"] * store.sizes["building"]
    words = read_words(tmp_path / "one.svg")
    assert "no dashpot" in words.caption and "spring" not in words.seen
    assert "sticks" not in figures.damping(store).caption
    assert (
        "sticks"
        in figures.damping(store.assign(building_model=("building", ["stick"] * 2))).caption
    )


@pytest.mark.parametrize("gap", ["2 cm", "2 mm"])
def test_pairs_that_touch(draw, gap):
    """At a gap of 2 cm the top floors alone touch, at 2 mm others as well."""
    case = changed(('"2 cm"', f'"{gap}"'), ("title = ", 'allow = "gap"\ntitle = '))
    (path,) = draw(case, only="impact_forces")
    words = read_words(path)
    several = ", 1 curve;" not in words.seen.partition(".")[0]
    assert several == (gap == "2 mm") == ("touch (a)" in words.caption)


@pytest.mark.parametrize("count", [figures.MOST + 1, figures.MOST + 4])
def test_the_pairs_with_the_largest_forces_are_drawn(count):
    pairs = [f"west.floor_{k}-east.floor_{k}" for k in range(1, count + 1)]
    force = np.zeros((2, count))
    force[1] = 1e6 * np.arange(1, count + 1)
    forces = xr.Dataset(
        {"force": (("time", "pair"), force), "floor_a": ("pair", range(1, count + 1))},
        {"time": [0.0, 1.0], "pair": pairs},
    )
    sticks = xr.Dataset({"impact_pair": ("impact", np.array([], dtype=str))})
    curves = figures.impact_forces(sticks, forces, {}).panels[0].curves
    largest = [float(curve.y.max()) for curve in curves]
    assert largest == list(range(count, count - figures.MOST - 1, -1))


def test_buildings_are_as_wide_as_their_points_say(draw, monkeypatch):
    """A tower of 10 m beside a wing of 12 m, 2 cm apart."""
    drawn = []
    monkeypatch.setattr(
        model_figures, "Rectangle", lambda at, width, *_, **__: drawn.append((at[0], width))
    )
    monkeypatch.setattr(Axes, "add_patch", lambda *_: None)
    draw(changed(('"18.02 m"', '"17.02 m"'), ('"-6 m"', '"-5 m"')), "case_figure")
    # Left side and width of each.
    assert np.array(drawn) == pytest.approx(np.array([(0.0, 12.0), (12.02, 10.0)]))


def test_of_the_finished_run(finished):
    names = {path.name for path in (finished.folder / "figures").iterdir()}
    assert names >= {"case.svg", "elevation.svg", "impact_forces.svg", "pounding_spectra.svg"}


def test_floors_have_colours_of_their_own():
    for count in (1, 2, 8, 40):
        assert len({tuple(colour) for colour in floor_colours(count)}) == count
    assert len(set(BUILDINGS)) == 4


def test_neighbours_are_told_apart_without_colour():
    for count in (1, 2, 8, 13):
        looks = floor_looks(count)
        assert looks == ordered_looks(count)[::-1]
        assert len({(tuple(look["color"]), look["ls"]) for look in looks}) == count
        # The top floor's line is solid, and no two of four neighbours have the same dashes.
        dashes = [look["ls"] for look in looks[::-1]]
        assert dashes[0] == "-"
        assert all(len(set(dashes[k : k + 4])) == len(dashes[k : k + 4]) for k in range(count))


def test_a_picture(tmp_path):
    path = tmp_path / "a.png"
    with sheet(path, (2, 2), (6.0, 4.0), "Figure 1") as (_, axes):
        letter(axes)
        assert [panel.get_title("left") for panel in axes] == ["(a)", "(b)", "(c)", "(d)"]
        assert not path.exists()
    with Image.open(path) as drawn:
        assert drawn.size == (1200, 800) and drawn.info["dpi"] == pytest.approx(
            (DOTS, DOTS), rel=1e-3
        )


def test_an_error_leaves_no_picture(tmp_path):
    with pytest.raises(ZeroDivisionError), sheet(tmp_path / "a.png", (1, 1), (3, 3), "") as _:
        raise ZeroDivisionError
    assert not list(tmp_path.iterdir())
