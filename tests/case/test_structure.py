"""The section [buildings.structure] of a case file, and its tables."""

from pathlib import Path
from types import SimpleNamespace
from typing import Annotated

import pytest
from pydantic import TypeAdapter

from impactfem.case import FileMesh, load_case
from impactfem.case.buildings import GeneratedMesh, structure_files
from impactfem.case.leaf import Levels
from impactfem.case.members import Wall, read_members
from impactfem.case.reading import Reading

from .faults import by_file as faults_of
from .faults import refused
from .sections import FROM_FILE, PARTS, STRUCTURE
from .test_refused_models import ALONG, COLUMN, GABLE, SOUTH, WINDOW

WALLS, BAYS = "pair_walls.csv", "pair_bays.csv"
BEAMS, COLUMNS = "pair_beams.csv", "pair_columns.csv"


def test_generated(structured):
    case = load_case(structured())
    structure = case.structure
    assert structure.building == "B1"
    assert structure.material == case.materials["concrete"]
    assert structure.storey_stiffness_factor == 0.13
    assert (structure.calibration.frequency, structure.calibration.direction) == (1.8, "y")
    assert (structure.floor_masses, structure.modes, structure.drilling) == (True, 20, 1.0)
    mesh = structure.mesh
    assert isinstance(mesh, GeneratedMesh)
    assert (mesh.length, mesh.width, mesh.slab_thickness, mesh.size) == (46.2, 15.6, 0.3, 0.9)
    assert mesh.floor_size is None
    assert (mesh.parapet.height, mesh.impact_edge) == (0.63, "y+")
    south, north, gable = mesh.walls
    assert (south.name, south.thickness, south.length) == ("south", 0.6, 46.2)
    assert north.storeys == (1, 3, 4, 5, 6, 7, 8)
    assert gable.ends == ((0.0, 0.0), (0.0, 15.6))
    assert [bay.bay for bay in mesh.bays] == ["6", "6", "1"]
    assert mesh.bays[0].top == mesh.bays[1].sill == 2.7
    assert (mesh.beams[0].beam, mesh.beams[0].offset) == ("row_1", -0.575)
    assert mesh.columns[0].storeys == (2, 3, 4, 5, 6, 7, 8)
    assert structure_files(structure) == ()


def test_only_walls_are_needed(structured):
    path = structured(
        (None, 'bays = "pair_bays.csv"\nbeams = "pair_beams.csv"\ncolumns = "pair_columns.csv"\n',
         ""),
        (None, 'parapet = { height = "63 cm", thickness = "30 cm" }\n', ""),
        (None, 'calibration = { frequency = "1.80 Hz", direction = "y" }\n', ""),
        (None, "storey_stiffness_factor = 0.13\n", ""),
    )  # fmt: skip
    structure = load_case(path).structure
    assert isinstance(structure.mesh, GeneratedMesh)
    assert structure.mesh.bays == structure.mesh.beams == structure.mesh.columns == ()
    assert structure.mesh.parapet is None
    assert structure.calibration is None
    assert structure.storey_stiffness_factor == 1.0


def test_own_material(structured):
    other = '[materials.other]\nyoung_modulus = "20 GPa"\npoisson_ratio = 0.2\n\n[damping]'
    names = ((None, "factor = 0.13\n", 'factor = 0.13\nmaterial = "other"\n'),)
    path = structured(
        (None, "[damping]", other.replace("\n\n", '\ndensity = "2 t/m3"\n\n')), *names
    )
    structure = load_case(path).structure
    assert structure.material.density == 2000.0
    path = structured((None, "[damping]", other), *names)
    refused(path, "buildings[1].structure.material", "no_density [materials.other]")


def test_material_of_the_building_without_density(structured):
    refused(
        structured((None, 'density = "2400 kg/m3"', "")),
        "pair.toml: buildings[1].structure.material",
        "no_density [materials.concrete]",
    )


def test_mesh_from_a_file(written, monkeypatch):
    path = written(FROM_FILE)
    monkeypatch.chdir(path.parent.parent)
    case = load_case(Path(path.parent.name) / path.name)
    mesh = case.structure.mesh
    assert isinstance(mesh, FileMesh)
    assert structure_files(case.structure) == (mesh.file,)
    assert mesh.file == Path(path.parent.name) / "pair.msh"  # relative to the working folder
    assert [entry.groups for entry in mesh.shells] == ["floor_*", "storey_*"]
    (column,) = mesh.beams
    assert (column.width, column.depth, column.offset) == (0.4, 0.5, 0.0)


def test_walls_and_bays_as_built(structured):
    """A facade half a wall inside, gables that end on it, wider bays about their middles."""
    path = structured(
        (None, 'size = "0.9 m"', 'size = "0.9 m"\nwall_setback = ["0 m", "0.3 m"]\n'
         'openings = [{ walls = "*", storeys = [2, 5], width = 0.5 }]\n'
         'slabs = [{ floors = [2, 8], thickness = "90 cm" }]'),
    )  # fmt: skip
    mesh = load_case(path).structure.mesh
    (south, north, gable), bays = mesh.built
    at = (south.y1, south.y2, north.y1, gable.y1, gable.y2)
    assert at == pytest.approx((0.3, 0.3, 15.3, 0.3, 15.3))
    assert (south.x1, south.x2, gable.x1) == (0.0, 46.2, 0.0)
    # Bays stay where they are: those of the gable are counted from its beginning.
    assert [bay.centre for bay in bays] == pytest.approx([10.0, 10.0, 1.7])
    assert [bay.width for bay in bays] == pytest.approx([1.0, 1.65, 1.65])
    assert [mesh.slab(k) for k in (1, 2, 8)] == [0.3, 0.9, 0.9]


def test_floors_with_a_gap(structured):
    path = structured(("pair_floors.csv", "\n8,", "\n9,"), (None, "7, 8]", "7, 9]"))
    faults = faults_of(path)
    expected = "expected a building with floors from 1 without a gap, found 1, 2, 3, 4, 5, 6, 7, 9"
    assert faults.pop("pair.toml: buildings[1].structure") == expected
    # Its tables name storey 8.
    assert {key.split(":")[0] for key in faults} == {WALLS, BEAMS, COLUMNS}


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        (BAYS, WINDOW, "1,gable,2,0.5,0,1,2.62"),  # at the corner, from floor to floor
        (BAYS, WINDOW, f"{WINDOW}\n1,gable,2,5.3,2.05,3.3,0.57"),  # equal ones that touch
        (BAYS, "6,south,5,10,2.7,3.3", "6,south,6,10,2.7,3.3"),  # another storey
        (WALLS, GABLE, "gable,2,0,0.3,46.2,0.3,60\n"),  # beside another, no bay in reach
        (WALLS, GABLE, f"{GABLE}\nmore,2,0,15.6,46.2,15.6,60"),  # where north is not
        (WALLS, GABLE, f"{GABLE}\nmore,1-8,46.2,0,46.2,15.6,60\ntwo,1-8,5,0,9,15.6,60"),
        (BEAMS, ALONG, "along,1-8,0,0,5.775,0"),  # end to end with the other, on a wall
        (COLUMNS, COLUMN, f"{COLUMN}\nrow_2,1{COLUMN[9:]}"),  # one above the other
    ],
)
def test_accepted(structured, file, old, new):
    assert load_case(structured((file, old, new))).structure is not None


def test_all_faults_of_all_tables_at_once(structured):
    path = structured(
        (None, 'gap = "1 cm"', 'gap = "-1 cm"'),
        (None, 'impact_edge = "y+"', 'impact_edge = "y"'),
        (WALLS, GABLE, "gable,2,0,0,0,15.7,60"),
        (BAYS, WINDOW, f"{WINDOW}\n2,gable,2,3,2.1,1,0.2"),
        (BEAMS, ALONG, "along,9,0,16,46.2,7.8"),
        (COLUMNS, COLUMN, "row_1,2-8,5.775,7.8,0.8,0"),
    )
    assert set(faults_of(path)) == {
        "pair.toml: contacts[0].gap",
        "pair.toml: buildings[1].structure.mesh.impact_edge",
        f"{WALLS}: line 4, column y2 [m]",
        f"{BAYS}: line 5, column centre [m]",
        f"{BEAMS}: line 3, column floors",
        f"{BEAMS}: line 3, column y1 [m]",
        f"{COLUMNS}: line 2, column width_y [m]",
    }


def test_what_needs_a_broken_part_is_not_checked(structured):
    path = structured(
        (None, 'length = "46.20 m"', 'length = "46.20"'),
        ("pair_floors.csv", "1787", "x"),
        (WALLS, SOUTH, "south,1-9,0,0,99,0,-60"),
        (BAYS, WINDOW, "1,nowhere,9,99,9,1,9"),
        (BEAMS, ALONG, "along,9,0,7.8,99,7.8"),
    )
    assert set(faults_of(path)) == {
        "pair.toml: buildings[1].structure.mesh.length",
        "pair_floors.csv: line 4, column mass [t]",
        f"{WALLS}: line 2, column thickness [cm]",
    }


def test_structure_that_is_no_table(structured):
    for junk in (
        "[buildings.structure]\nmesh = 1\n",
        "[[buildings.structure]]\n",
        "[buildings.structure.mesh]\ntype = 3\n",
    ):
        faults = faults_of(structured((None, STRUCTURE, junk)))
        assert faults
        assert all(key.startswith("pair.toml: buildings[1].structure") for key in faults)


def test_buildings_that_are_no_array(structured):
    """That none has a 3D model is no further fault."""
    path = structured().with_name("over.toml")
    transient = '[transient]\ntime_step = "1 ms"\n'
    path.write_text(f'extends = "pair.toml"\n[buildings]\nbase = "1 m"\n{transient}')
    assert list(faults_of(path)) == ["over.toml: buildings"]


def test_coinciding_walls_at_an_angle(tmp_path):
    header = "wall,storeys,x1 [m],y1 [m],x2 [m],y2 [m],thickness [m]\n"
    path = tmp_path / "walls.csv"
    first = "a,1,0,0,8,6,0.2\n"
    for second, twice in [
        ("b,1,4,3,12,9,0.2", True),
        ("b,1,12,9,4,3,0.2", True),  # from the other end
        ("b,2,4,3,12,9,0.2", False),  # in another storey
        ("b,1,8,6,12,9,0.2", False),  # end to end
        ("b,1,4,3.1,12,9.1,0.2", False),  # beside it
        ("b,1,4,3,12,8.9,0.2", False),  # at an angle
    ]:
        path.write_text(header + first + second)
        faults = []
        table = read_members(Wall, path, faults, SimpleNamespace(context=Reading(), data={}))
        assert (table is None) == twice == bool(faults), second


@pytest.mark.parametrize(
    ("text", "levels"),
    [("3", (3,)), ("2-4", (2, 3, 4)), (" 1 3  5-7 ", (1, 3, 5, 6, 7)), ("4-4", (4,))],
)
def test_levels(text, levels):
    adapter = TypeAdapter(Annotated[tuple[int, ...], Levels("storeys")])
    assert adapter.validate_python(text) == levels == adapter.validate_python(list(levels))


def test_materials_of_parts(structured):
    case = load_case(structured(more=PARTS))
    (own,) = case.structure.materials
    assert own.parts == ("storey_*", "column_1_*")
    assert own.material == case.materials["masonry"] and own.material.young_modulus == 5e9
    assert case.structure.material == case.materials["concrete"]
