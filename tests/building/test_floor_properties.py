"""Inertias of floors and sections of storeys, by hand."""

from pathlib import Path

import numpy as np
import pytest

from impactfem.building.floor_properties import UNITS, floor_properties
from impactfem.building.from_case import geometry_of, read_parts
from impactfem.building.generate import generate
from impactfem.building.geometry import Bay, Column, Geometry, MeshSize, Wall
from impactfem.building.section import BeamSection, Material
from impactfem.case import load_case
from one_building import building_of


@pytest.fixture(scope="module")
def box(generated):
    """6 m by 4 m, two storeys of 3 m: two walls along x, one with a window, and a column."""
    geometry = Geometry(
        length=6.0,
        width=4.0,
        levels=(0.0, 3.0, 6.0),
        slab_thickness=0.2,
        walls=(
            Wall("south", (1, 2), (0.0, 0.0), (6.0, 0.0), 0.3),
            Wall("north", (1, 2), (0.0, 4.0), (6.0, 4.0), 0.3),
        ),
        bays=(Bay("window", "south", 2, 3.0, 1.7, 2.0, 1.0),),
        columns=(Column("a", (1, 2), (3.0, 2.0), BeamSection.column(0.4, 0.6)),),
        size=MeshSize.uniform(1.0),
    )
    concrete = Material(30e9, 0.2, 2500.0)
    return floor_properties(*generated(geometry, concrete, np.array([60e3, 40e3])))


def test_sections(box):
    """By the storey's weakest cut, through a window above half the height."""
    for k, wall in enumerate((6.0, 4.0)):  # net length of the south wall
        A = 0.3 * (6.0 + wall) + 0.24
        assert box["A"][k] == pytest.approx(A, rel=1e-6)
        assert box["Avx"][k] == pytest.approx(A, rel=1e-6)  # walls along x, and the column
        assert box["Avy"][k] == pytest.approx(0.24, rel=1e-6)
        y = (0.3 * 6.0 * 4.0 + 0.24 * 2.0) / A
        Ix = 0.3 * 6.0 * (4.0 - y) ** 2 + 0.3 * wall * y**2 + 0.24 * (2.0 - y) ** 2
        assert box["Ix"][k] == pytest.approx(Ix + 0.4 * 0.6**3 / 12.0, rel=1e-6)
    north, gap = 0.3 * 6.0**3 / 12.0, 0.3 * (6.0**3 - 2.0**3) / 12.0
    assert box["Iy"][1] == pytest.approx(north + gap + 0.6 * 0.4**3 / 12.0, rel=1e-6)


def test_masses_and_inertias(box):
    """Floor 1: slab, half of two storeys each, and what is added evenly up to 60 t."""
    assert box["mass"] == pytest.approx([60e3, 40e3])
    slab = 2500.0 * 6.0 * 4.0 * 0.2
    walls = 2500.0 * 0.3 * (6.0 * 3.0 * 2.0)  # of both, half above and half below
    window = 2500.0 * 0.3 * 2.0 * 0.8 / 3.0  # 2 m x 1 m, of which the middle is 0.8 m below floor 2
    column = 2500.0 * 0.24 * 3.0
    added = 60e3 - (slab + walls - window + column)
    Jx = (slab + added) * 4.0**2 / 12.0 + (walls - window) * 2.0**2
    Jy = (slab + added) * 6.0**2 / 12.0 + walls * 6.0**2 / 12.0 - window * 2.0**2 / 12.0
    ey = 2.0 * window / 60e3  # the wall without it is the heavier one
    assert box["ey"][0] == pytest.approx(ey, rel=1e-6) and abs(box["ex"][0]) < 1e-4
    assert box["Jx"][0] == pytest.approx(Jx - 60e3 * ey**2, rel=1e-6)
    assert box["Jy"][0] == pytest.approx(Jy, rel=1e-4)  # shares go by the middles of cells
    assert box["Jz"] == pytest.approx(box["Jx"] + box["Jy"])


def test_the_paper_s_building_read_again(tmp_path):
    """Within 5 % of Appendix A but for what docs/paper-building.md says why."""
    case = load_case(Path(__file__).parents[2] / "geometry" / "npp_pair_reread.toml")
    mesh = case.structure.mesh.model_copy(update={"size": 1.5})  # J_x of floor 3 is 4.95 % off
    structure, rows = case.structure.model_copy(update={"mesh": mesh}), case.buildings[0].floors
    file = tmp_path / "building.msh"
    generate(geometry_of(building_of(case.model_copy(update={"structure": structure}))), file)

    def beyond(**changes):
        own = structure.model_copy(update=changes)
        parts, masses = read_parts(building_of(case.model_copy(update={"structure": own})), file)
        found = floor_properties(parts, masses)
        off = {q: found[q] / np.array([getattr(row, q) for row in rows]) - 1.0 for q in UNITS}
        far = {q: (np.flatnonzero(abs(x) > 0.05) + 1).tolist() for q, x in off.items()}
        return {q: floors for q, floors in far.items() if floors}

    again = beyond()
    assert again == {"Jx": [7], "Jy": [6], "Avy": [1, 8], "Avx": [1, 8], "Iy": [3]}
    even = beyond(added_mass=())
    assert even["Jx"] == [2, 3, 4, 5, 6, 7] and even["Iy"] == again["Iy"]
