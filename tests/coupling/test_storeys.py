"""Sticks from storey stiffness, periods, plans and modal tables, against closed forms."""

import functools
import re

import numpy as np
import pytest

from impactfem.case import load_case
from impactfem.case.template import write_new_case
from impactfem.coupling.from_case import stick_of
from impactfem.sticks.modes import modes
from impactfem.system.errors import InputError

TABLE = 'floors = "towers_floors.csv"'


FACTOR = re.compile(r"(?m)^stiffness_factor = 0.5.*\n")


@functools.cache
def template(path):
    """The text of a new case, before it is changed."""
    return path.read_text(encoding="utf-8")


@pytest.fixture
def case(tmp_path):
    """The template with a floor table, and keys, of its first building."""

    def make(table, *keys, files=None):
        path = tmp_path / "towers.toml"
        if not path.exists():
            write_new_case(path)
        text = FACTOR.sub("", template(path), 1)
        text = text.replace(TABLE, "\n".join(['floors = "own.csv"', *keys]), 1)
        text = text.replace("floor = [1, 2, 3]", "floor = [1]")
        path.write_text(text, encoding="utf-8")
        for name, content in ({"own.csv": table} | (files or {})).items():
            (tmp_path / name).write_text(content, encoding="utf-8")
        return load_case(path).buildings[0]

    return make


def by_stiffness(*storeys, height=3.5):
    """A floor table by mass [t] and stiffness along x and y [kN/mm]."""
    rows = [f"{k},{m},{kx},{ky},{height}" for k, (m, kx, ky) in enumerate(storeys, start=1)]
    return "\n".join(["floor,mass [t],kx [kN/mm],ky [kN/mm],storey_height [m]", *rows])


def frequencies(building, family):
    found = modes(stick_of(building))
    return found.frequency[found.of_family(family)][: len(building.floors)]


def off(building, family, exact):
    return np.abs(frequencies(building, family) / np.sort(exact) - 1.0).max()


def test_a_uniform_shear_building(case):
    """ω_j = 2 √(k/m) sin((2j − 1) π / (2 (2n + 1))); rigid zones do not change it."""
    n, k, m = 8, 246e6, 350e3
    j = np.arange(1, n + 1)
    exact = np.sqrt(k / m) * np.sin((2 * j - 1) * np.pi / (2 * (2 * n + 1))) / np.pi
    building = case(by_stiffness(*[(350, 246, 123)] * n))
    assert building.rigid_below > 0.0
    assert off(building, "x", exact) < 1e-10
    assert off(building, "y", exact / np.sqrt(2.0)) < 1e-10
    softer = building.floors[0].model_copy(update={"kx": 0.999 * k})
    changed = building.model_copy(update={"floors": (softer, *building.floors[1:])})
    assert off(changed, "x", exact) > 1e-5


def test_two_storeys(case):
    """Masses 2 m and m on 2 k and k: ω² = k/(2 m) and 2 k/m (Chopra, Dynamics, example 10.1)."""
    building = case(by_stiffness((200, 40, 40), (100, 20, 20)))
    exact = np.sqrt([20e6 / 200e3, 2.0 * 20e6 / 100e3]) / (2.0 * np.pi)
    assert off(building, "x", exact) < 1e-10


def test_three_storeys(case):
    """Masses 1, 1.5, 2 on 1, 2, 3 from the top: b³ − 5.5 b² + 7.5 b − 2 = 0, ω² = b k/m.

    Clough and Penzien, Dynamics of Structures, example E11-1.
    """
    building = case(by_stiffness((200, 300, 300), (150, 200, 200), (100, 100, 100)))
    b = np.sort(np.roots([1.0, -5.5, 7.5, -2.0]))
    assert off(building, "y", np.sqrt(b * 100e6 / 100e3) / (2.0 * np.pi)) < 1e-10


def test_torsion_of_a_stiffness_spread_as_the_mass(case):
    """A building as stiff along x as along y turns as fast as it sways."""
    building = case(by_stiffness(*[(350, 246, 246)] * 4))
    assert frequencies(building, "rz") == pytest.approx(frequencies(building, "x"), rel=1e-10)
    twice = case(by_stiffness(*[(350, 246, 246)] * 4).replace("ky [kN/mm]", "ky [kN/mm]"))
    row = twice.floors[0].model_copy(update={"kt": 2.0 * twice.floors[0].kt})
    stiffer = twice.model_copy(update={"floors": (row, *twice.floors[1:])})
    assert frequencies(stiffer, "rz")[0] > 1.02 * frequencies(stiffer, "x")[0]


def test_inertia_of_a_plan(case):
    """A rectangle, M b²/12, and an L of two rectangles about its centroid (Steiner)."""
    (floor, *_) = case(by_stiffness((300, 100, 100))).floors
    b, d = 20.0, 12.0
    expected = np.array([d**2, b**2, b**2 + d**2]) * 300e3 / 12.0
    assert (floor.Jx, floor.Jy, floor.Jz) == pytest.approx(expected, rel=1e-12)
    corners = '[["0 m", "0 m"], ["10 m", "0 m"], ["10 m", "4 m"], ["4 m", "4 m"], ["4 m", "12 m"], \
["0 m", "12 m"]]'
    floors = f"plans = [{{ floors = 1, plan = {corners} }}]"
    (floor, *_) = case(by_stiffness((300, 100, 100)), floors).floors
    areas, places = np.array([40.0, 32.0]), np.array([[5.0, 2.0], [2.0, 8.0]])
    own = np.array([[4.0**2, 10.0**2], [8.0**2, 4.0**2]]) / 12.0
    away = places - areas @ places / areas.sum()
    x, y = areas @ (own + away[:, ::-1] ** 2)
    assert (floor.Jx, floor.Jy) == pytest.approx(300e3 / areas.sum() * np.array([x, y]), rel=1e-12)


@pytest.mark.parametrize("springs", [True, False])
def test_periods_scale_the_stiffness(case, springs):
    """Of springs and of sections; what is left out keeps its stiffness."""
    table = by_stiffness(*[(350, 246, 123)] * 3)
    if not springs:
        head = "floor,mass [t],Ix [m4],Iy [m4],Iz [m4],A [m2],Avx [m2],Avy [m2],storey_height [m]"
        table = "\n".join([head, *(f"{k},350,80,200,9,5,0.17,0.11,3.5" for k in (1, 2, 3))])
    plain, both = case(table), case(table, 'periods = { x = "0.9 s", y = "1.1 s" }')
    x = case(table, 'periods = { x = "0.9 s" }')
    for family, period in (("x", 0.9), ("y", 1.1)):
        before, after = frequencies(plain, family), frequencies(both, family)
        assert after[0] == pytest.approx(1.0 / period, rel=1e-8)
        assert after / before == pytest.approx(np.full(3, after[0] / before[0]), rel=1e-8)
    assert frequencies(x, "y") == pytest.approx(frequencies(plain, "y"), rel=1e-10)
    ratios = [(frequencies(both, f)[0] / frequencies(plain, f)[0]) ** 2 for f in ("x", "y", "rz")]
    assert ratios[2] == pytest.approx(0.5 * (ratios[0] + ratios[1]), rel=1e-8)


def test_periods_alone_give_a_straight_mode(case):
    table = "floor,mass [t],storey_height [m]\n1,300,4\n2,250,3.5\n3,200,3\n"
    building = case(table, 'periods = { x = "0.9 s", y = "1.1 s" }')
    found = modes(stick_of(building))
    first = found.of_family("x")[0]
    assert found.frequency[first] == pytest.approx(1.0 / 0.9, rel=1e-10)
    shape = found.shape[[0, 6, 12], first]
    assert shape / shape[2] == pytest.approx(np.array([4.0, 7.5, 10.5]) / 10.5, rel=1e-9)


def exported(building):
    """Tables of modes and shapes as another program exports them, with further columns."""
    found = modes(stick_of(building))
    keep = [found.of_family(f)[k] for f in ("x", "y", "rz") for k in (0, 1)]
    share = found.effective_mass[[0, 1, 5]] / found.total[[0, 1, 5], None]
    head, shapes = ["mode,period [s],UX,UY,SumUX,RZ"], ["Story,floor,mode,UX,UY,RZ"]
    for number, k in enumerate(keep, start=1):
        x, y, rz = (f"{value:.12g}" for value in share[:, k])
        head.append(f"{number},{1.0 / found.frequency[k]:.12g},{x},{y},0.9,{rz}")
        for j, floor in enumerate(building.floors):
            moved = ",".join(f"{-3.0 * found.shape[6 * j + c, k]:.12g}" for c in (0, 1, 5))
            shapes.append(f"STORY{j},{floor.floor},{number},{moved}")
    return {"modes.csv": "\n".join(head), "shapes.csv": "\n".join(shapes)}


MODAL = 'modal_table = { modes = "modes.csv", shapes = "shapes.csv" }'
MASSES = "floor,mass [t],storey_height [m]\n1,300,4\n2,250,3.5\n3,200,3\n"


def test_a_modal_table_gives_the_storeys_back(case):
    given = case(by_stiffness((300, 246, 150), (250, 200, 120), (200, 150, 110)))
    files = exported(given)
    found = case(MASSES, MODAL, files=files)
    for key in ("kx", "ky", "kt"):
        of_given = [getattr(floor, key) for floor in given.floors]
        assert [getattr(floor, key) for floor in found.floors] == pytest.approx(of_given, rel=1e-8)
    for family in ("x", "y", "rz"):
        assert off(found, family, frequencies(given, family)) < 1e-8


@pytest.mark.parametrize(
    ("table", "edit", "expected"),
    [
        (MASSES.replace("300", "30000"), ("", ""), "by its shape and the floor table"),
        (MASSES, ("STORY2,3,1", "STORY2,4,1"), "no row of mode 1"),
        (MASSES + "4,200,3\n", ("", ""), "no row of mode 1"),
        (MASSES, ("UX,UY,RZ", "UX,RZ,UY"), "mode"),
    ],
)
def test_a_modal_table_of_another_building(case, table, edit, expected):
    files = exported(case(by_stiffness((300, 246, 150), (250, 200, 120), (200, 150, 110))))
    files["shapes.csv"] = files["shapes.csv"].replace(*edit) if edit[0] else files["shapes.csv"]
    with pytest.raises(InputError) as error:
        case(table, MODAL, files=files)
    (fault,) = error.value.faults
    assert (fault.key, fault.kind) == ("buildings[0].modal_table", "storeys")
    assert expected in fault.expected


@pytest.mark.parametrize(
    ("table", "keys", "key", "kind"),
    [
        (MASSES, (), "buildings[0].floors", "storeys"),
        (MASSES, ('periods = { x = "1 s" }',), "buildings[0].floors", "storeys"),
        (MASSES, ("periods = {}",), "buildings[0].periods.y", "one_or_both"),
        (by_stiffness((300, 9, 9)).replace("ky [kN/mm]", "kt [kN m/rad]"), (),
         "line 1", "missing_column"),
        (MASSES.replace("mass [t]", "mass [t],kt [kN m/rad]").replace(",300", ",300,1e6")
         .replace(",250", ",250,1e6").replace(",200", ",200,1e6"), (),
         "line 2, column kt [kN m/rad]", "one_stiffness"),
        (by_stiffness((300, 9, 9)), ('periods = { x = "1 s" }', "stiffness_factor = 0.5"),
         "buildings[0].stiffness_factor", "scaled_once"),
    ],
)  # fmt: skip
def test_what_is_missing_or_twice(case, table, keys, key, kind):
    with pytest.raises(InputError) as error:
        case(table, *keys)
    assert [(fault.key, fault.kind) for fault in error.value.faults] == [(key, kind)]


def test_inertia_without_a_plan(tmp_path):
    path = write_new_case(tmp_path / "towers")[0]
    text = FACTOR.sub("", template(path))
    lines = [one for one in text.splitlines() if not one.startswith(("length = ", "width = "))]
    path.write_text("\n".join(lines), encoding="utf-8")
    (tmp_path / "towers_floors.csv").write_text(by_stiffness(*[(350, 246, 123)] * 3))
    with pytest.raises(InputError) as error:
        load_case(path)
    keys = [fault.key for fault in error.value.faults]
    assert keys == ["buildings[0].length", "buildings[1].length"]
