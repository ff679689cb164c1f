"""First periods of buildings before a run: those that are not of a building."""

from pathlib import Path

import numpy as np
import pytest

from impactfem.case import load_case
from impactfem.case.place import dotted
from impactfem.case.template import write_new_case
from impactfem.coupling.periods import (
    shear_period,
    stick_period,
    storey_stiffness,
    unusual_periods,
)

GEOMETRY = Path(__file__).parents[2] / "geometry"
COLUMNS = "column,storeys,x [m],y [m],width_x [m],width_y [m]\n"


@pytest.fixture
def template(tmp_path):
    return write_new_case(tmp_path / "new", ["structure"], minimal=True)[0]


def keys(path):
    return [dotted(place) for place, _ in unusual_periods(load_case(path))]


def test_the_template_and_the_shipped_cases(template):
    assert keys(template) == []
    for name in ("npp_pair", "two_frames", "frame", "row_of_three_3d", "row_with_cabinet"):
        assert keys(GEOMETRY / f"{name}.toml") == []


def test_one_column_under_three_floors(template):
    """Of the walls a post is left, and one column in the middle."""
    walls = template.parent / "new_walls.csv"
    header = walls.read_text().splitlines()[0]
    walls.write_text(f"{header}\npost,1-3,2,2,2.3,2,0.3\n")
    columns = template.parent / "new_columns.csv"
    columns.write_text(f"{COLUMNS}middle,1-3,10,6,0.32,0.32\n")
    beams = template.parent / "new_beams.csv"
    beams.write_text(beams.read_text().splitlines()[0] + "\nalong,1-3,0,6,20,6,0.3,0.25,-0.25\n")
    assert keys(template) == ["buildings[0].structure.mesh.columns"] * 2
    # Twelve of 0.5 m carry the floors.
    rows = "".join(f"c{k},1-3,{k},6,0.5,0.5\n" for k in range(1, 13))
    columns.write_text(COLUMNS + rows)
    assert keys(template) == []


@pytest.mark.parametrize("new", ["4,6,13.4,3.4,0.0001,0.175", "4e4,6e4,1e5,3e4,2e3,2e3"])
def test_a_stick_that_is_too_soft_or_too_stiff(template, edited, new):
    edited(template.parent / "new_floors.csv", ("4.0,6.0,13.4,3.4,0.187,0.175", new))
    # The stick of west is that of its 3D model.
    assert keys(template) == ["buildings[1].floors"]
    edited(template, ("rigid_above = ", 'stick = "own"\nrigid_above = '))
    assert keys(template) == ["buildings[0].floors", "buildings[1].floors"]


def test_against_closed_forms(template):
    """A uniform shear building of n storeys: f1 = sin(π / (4 n + 2)) √(k / m) / π."""
    building = load_case(template).buildings[0]
    k, m = 3.0e8, building.floors[0].mass
    uniform = building.model_copy(
        update={"floors": tuple(f.model_copy(update={"mass": m}) for f in building.floors)}
    )
    exact = np.pi / (np.sin(np.pi / 14.0) * np.sqrt(k / m))
    assert shear_period(uniform, np.full(3, k)) == pytest.approx(exact, rel=1e-12)
    # Columns and walls between rigid slabs, by hand: half of the stiffness, as the storeys crack.
    along_x, along_y = storey_stiffness(building)
    E, G, h = 30e9, 12.5e9, 3.5 - 0.25

    def section(depth, width):
        return 1.0 / (h**3 / (E * width * depth**3) + h / (G * 5 / 6 * depth * width))

    expected = 0.5 * (10 * section(0.32, 0.32) + 2 * section(3.0, 0.2) + 2 * section(0.2, 3.0))
    assert along_x[1:] == pytest.approx(expected, rel=1e-12)
    assert along_y[1:] == pytest.approx(expected, rel=1e-12)
    # The stick is that of the 3D model, whose slabs are not rigid.
    assert shear_period(building, along_y) < stick_period(building)
