"""Sections of beams and columns: rolled ones by name, and those of [sections]."""

import math

import pytest

from impactfem.case import load_case
from impactfem.case.sections import rolled_section, rolled_sections
from impactfem.coupling.periods import storey_stiffness

from .faults import by_file

BEAMS, COLUMNS = "pair_beams.csv", "pair_columns.csv"
BOX = """
[sections.box]
A = "120 cm2"
Iy = "6500 cm4"
Iz = "6500 cm4"
J = "9700 cm4"
Avy = "50 cm2"
"""
MIXED_BEAMS = """\
beam,floors,x1 [m],y1 [m],x2 [m],y2 [m],section,width [m],depth [m],angle [deg]
row_1,1-8,5.775,0,5.775,15.6,IPE 400,,,
along,1-8,0,7.8,46.2,7.8,,0.2,0.28,90
"""
MIXED_COLUMNS = """\
column,storeys,x [m],y [m],section,angle [deg]
row_1,2-8,5.775,7.8,HE 300 B,90
row_2,2-8,15.775,7.8,box,
"""
FILES = {BEAMS: MIXED_BEAMS, COLUMNS: MIXED_COLUMNS}


def test_names_of_rolled_sections():
    assert len(rolled_sections()) == 18 + 72 + 180 + 46 + 289
    for names in (("HEB 300", "HE 300 B", "heb300", "HE300-B"), ("W14x90", "W14X90", "w 14 × 90")):
        assert len({rolled_section(name) for name in names}) == 1
    assert rolled_section("UB 457x191x67") == rolled_section("457 x 191 x 67 UB")
    w14 = rolled_section("W14x90")
    assert (w14.A, w14.Iy, w14.J) == pytest.approx(
        (26.5 * 0.0254**2, 999 * 0.0254**4, 4.06 * 0.0254**4)
    )


def test_sections_in_tables(structured):
    case = load_case(structured(more=BOX, files=FILES))
    mesh = case.structure.mesh
    row, along = mesh.beams
    assert (row.section, row.width, row.angle) == (rolled_section("IPE 400"), None, 0.0)
    assert (along.section, along.depth, along.angle) == (None, 0.28, pytest.approx(math.pi / 2))
    steel, box = mesh.columns
    assert (steel.section, steel.angle) == (rolled_section("HEB 300"), pytest.approx(math.pi / 2))
    assert box.section == case.sections["box"]
    assert (box.section.A, box.section.Avz) == (pytest.approx(0.012), None)


def test_a_turned_column_is_stiff_across(structured):
    """Storey stiffness of one column: 12 E I/h³ of the strong axis along its web."""
    stiffness = []
    for angle in (0, 90):
        table = f"column,storeys,x [m],y [m],section,angle [deg]\np,1-8,5.775,7.8,W14x90,{angle}\n"
        wall = "wall,storeys,x1 [m],y1 [m],x2 [m],y2 [m],thickness [m]\n"
        files = {COLUMNS: table, "pair_walls.csv": f"{wall}w,1-8,0,0,1,0,0.3\n"}
        bays = ((None, 'bays = "pair_bays.csv"\n', ""),)
        case = load_case(structured(*bays, files=files))
        without = case.structure.mesh.model_copy(update={"walls": ()})
        structure = case.structure.model_copy(update={"mesh": without})
        building = next(b for b in case.buildings if b.structure is not None)
        stiffness.append(storey_stiffness(building.model_copy(update={"structure": structure})))
    (x, y), (turned_x, turned_y) = stiffness
    assert turned_x == pytest.approx(y)
    assert turned_y == pytest.approx(x)
    assert (x > y).all()


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("IPE 400", "IPE 410", f"{BEAMS}: line 2, column section"),
        (",box,", ",boks,", f"{COLUMNS}: line 3, column section"),
        ("IPE 400,,", "IPE 400,0.2,", f"{BEAMS}: line 2"),
        (",0.2,0.28,", ",0.2,,", f"{BEAMS}: line 3"),
    ],
)
def test_refused(structured, old, new, place):
    files = {name: text.replace(old, new) for name, text in FILES.items()}
    assert set(by_file(structured(more=BOX, files=files))) == {place}


def test_walls_by_storeys(structured):
    more = '\n[[buildings.structure.mesh.thicknesses]]\nwalls = "s*"\nstoreys = [2, 3]\n'
    mesh = load_case(structured(more=f'{more}thickness = "30 cm"\n')).structure.mesh
    south, north, _ = mesh.walls
    assert [mesh.wall_thickness(south, k) for k in (1, 2, 3)] == [0.6, 0.3, 0.3]
    assert mesh.wall_thickness(north, 3) == 0.6
    wrong = more.replace('"s*"', '"none_*"') + 'thickness = "30 cm"\n'
    assert set(by_file(structured(more=wrong))) == {
        "pair.toml: buildings[1].structure.mesh.thicknesses"
    }
