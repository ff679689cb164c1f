from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from impactfem.building.from_case import (
    beam_section,
    column_section,
    geometry_of,
    part_faults,
    read_parts,
    sections_of,
)
from impactfem.building.generate import generate
from impactfem.building.geometry import Beam, Column, MeshSize, Wall
from impactfem.building.mesh import areas
from impactfem.building.mesh_report import MeshReport
from impactfem.building.read_mesh import read_mesh
from impactfem.building.section import BeamSection, ShellSection
from impactfem.case import load_case
from impactfem.case.buildings import BeamGroup, FileMesh, PartMaterial, ShellGroup
from impactfem.case.damping import PartDamping as Entry
from impactfem.case.sections import rolled_section
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import InputError
from one_building import building_of

GEOMETRY = Path(__file__).parents[2] / "geometry"
FRAME = GEOMETRY / "frame.msh"
PAIR = GEOMETRY / "npp_pair.toml"
SHELLS = (
    ShellGroup(groups="floor_*", thickness=0.25),
    ShellGroup(groups="storey_[12]_west", thickness=0.2),
)
BEAMS = (
    BeamGroup(groups="beam_*", width=0.3, depth=0.5, offset=-0.125),
    BeamGroup(groups="column_*", width=0.4, depth=0.6),
)


@pytest.fixture(scope="module")
def pair():
    return load_case(PAIR)


@pytest.fixture
def structure(pair, frame_file):
    """The structure of the case with a mesh from a file, its groups as given."""

    def made(shells=SHELLS, beams=BEAMS):
        mesh = FileMesh(type="file", file=str(frame_file), shells=shells, beams=beams)
        return pair.structure.model_copy(update={"mesh": mesh})

    return made


def test_the_geometry_of_the_paper_s_building(pair, structure):
    geometry = geometry_of(building_of(pair))
    assert (geometry.length, geometry.width) == (46.2, 15.6)
    assert len(geometry.floors) == 8
    assert geometry.levels[0] == 0.0
    # The mass centre of floor 8, and the top of the parapet (section 2 of the paper).
    assert geometry.levels[-1] == pytest.approx(30.30)
    assert geometry.levels[-1] + geometry.parapet.height == pytest.approx(30.93)
    assert geometry.impact_edge == "y+"
    assert geometry.size == MeshSize.uniform(1.0)
    assert Wall("gable_west", tuple(range(2, 9)), (0, 0), (0, 15.6), 0.6) in geometry.walls
    transverse = BeamSection.beam(0.75, 0.85, -0.575)
    rows = [beam for beam in geometry.beams if beam.section == transverse]
    assert len(rows) == 7
    assert rows[3] == Beam("transverse_4", tuple(range(1, 9)), (23.1, 0), (23.1, 15.6), transverse)
    column = BeamSection.column(0.8, 1.2)
    assert [c.section for c in geometry.columns] == [column] * 7
    assert geometry.columns[3] == Column("row_4", tuple(range(2, 9)), (23.1, 7.8), column)
    assert len({bay.name for bay in geometry.bays}) == 10  # the indices of Table 1
    mesh = pair.structure.mesh.model_copy(update={"floor_size": 0.4, "column_size": 2.0})
    finer = pair.model_copy(update={"structure": pair.structure.model_copy(update={"mesh": mesh})})
    assert geometry_of(building_of(finer)).size == MeshSize(
        floor=0.4, storey=1.0, beam=1.0, column=2.0
    )
    with pytest.raises(ValueError, match="is not generated"):
        geometry_of(replace(building_of(pair), structure=structure()))


@pytest.mark.parametrize(
    ("name", "elements", "dofs"),
    [
        ("npp_pair.toml", 0, 250_000),
        pytest.param("npp_pair_fine.toml", 113_000, 1_300_000, marks=pytest.mark.slow),
    ],
)
def test_the_mesh_of_the_paper_s_building(name, elements, dofs, tmp_path):
    case = load_case(PAIR.with_name(name))
    geometry = geometry_of(building_of(case))
    path = tmp_path / "building.msh"
    generate(geometry, path)
    mesh = read_mesh(path)
    report = MeshReport.of(mesh, sections_of(case.structure, mesh))
    assert report.elements >= elements
    assert 6 * report.nodes >= dofs
    assert report.quality_mean > 0.95
    assert not report.warnings
    slabs = 8 * 46.2 * 15.6 + 2 * (46.2 + 15.6) * 0.63
    walls = sum(
        np.hypot(wall.end[0] - wall.start[0], wall.end[1] - wall.start[1])
        * (geometry.levels[k] - geometry.levels[k - 1])
        for wall in geometry.walls
        for k in wall.storeys
    ) - sum(bay.width * bay.height for bay in geometry.bays)
    for family, area in (("floor", slabs), ("storey", walls)):
        own = areas(mesh.nodes, mesh.triangles[mesh.triangles_of(family)])
        assert own.sum() == pytest.approx(area, rel=1e-9)
    ends = mesh.nodes[mesh.lines[:, :2]]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert length[mesh.lines_of("beam")].sum() == pytest.approx(8 * (7 * 15.6 + 5 * 46.2))
    height = geometry.levels[8] - geometry.levels[1]
    assert length[mesh.lines_of("column")].sum() == pytest.approx(7 * height)


def test_sections_of_a_file(structure, frame):
    sections = sections_of(structure(), frame)
    found = dict(zip((part.group for part in frame.shell_parts), sections.shells, strict=True))
    assert found["floor_2"] == ShellSection(0.25)
    assert found["storey_1_west"] == ShellSection(0.2)
    found = dict(zip((part.group for part in frame.beam_parts), sections.beams, strict=True))
    assert found["beam_1_south"] == BeamSection.beam(0.3, 0.5, -0.125)
    assert found["column_2_north_east"] == BeamSection.column(0.4, 0.6)


def test_turned_sections():
    """The web of a section lies along n2: upright in beams, along x in columns."""
    hea = rolled_section("HEA 200")
    upright = beam_section(hea, (None, None), 0.0, (-1.0, 0.0, 0.0), -0.1)
    assert (upright.I1, upright.I2, upright.k2) == (hea.Iy, hea.Iz, hea.Avz / hea.A)
    assert (upright.reference, upright.offset) == ((0.0, 0.0, 1.0), (0.0, 0.0, -0.1))
    flat = beam_section(hea, (None, None), np.pi / 2, (-1.0, 0.0, 0.0), 0.0)
    assert flat.reference == pytest.approx((0.0, -1.0, 0.0))
    A_x, A_y, I_x, I_y = column_section(hea, (None, None), 0.0).in_plan()
    assert (I_x, I_y) == (hea.Iz, hea.Iy)
    assert (A_x, A_y) == pytest.approx((hea.Avz * 6 / 5, hea.Avy * 6 / 5))
    turned = column_section(hea, (None, None), np.pi / 3)
    assert turned.reference == pytest.approx((0.5, np.sqrt(0.75), 0.0))
    assert turned.in_plan()[2:] == pytest.approx(
        (0.75 * hea.Iy + 0.25 * hea.Iz, 0.25 * hea.Iy + 0.75 * hea.Iz)
    )
    rectangle = column_section(None, (0.4, 0.6), np.pi / 2)
    assert rectangle.in_plan() == pytest.approx(
        (0.24, 0.24, 0.6 * 0.4**3 / 12.0, 0.4 * 0.6**3 / 12.0)
    )


@pytest.mark.parametrize(
    ("groups", "expected"),
    [
        (
            {"beams": BEAMS[:1]},
            [
                "column_1_north_east, column_1_south_east, column_2_north_east, "
                "column_2_south_east: no pattern matches them of structure.mesh.beams in the case"
            ],
        ),
        (
            {"shells": (*SHELLS, ShellGroup(groups="floor_2*", thickness=0.3))},
            [
                "floor_2: matched by 'floor_*', 'floor_2*'; expected one of structure.mesh.shells "
                "in the case"
            ],
        ),
        (
            {"shells": (*SHELLS, ShellGroup(groups="storey_3*", thickness=0.3))},
            [
                ": no group for structure.mesh.shells with the pattern 'storey_3*'; the mesh has "
                "floor_1, floor_2, storey_1_west, storey_2_west"
            ],
        ),
        (
            {"beams": (BEAMS[0], BEAMS[1].model_copy(update={"offset": 0.1}))},
            [
                f"column_{k}_{where}: an offset; expected none for columns"
                for k in (1, 2)
                for where in ("north_east", "south_east")
            ],
        ),
    ],
)
def test_groups_that_do_not_fit(structure, frame, groups, expected):
    with pytest.raises(InputError) as caught:
        sections_of(structure(**groups), frame)
    assert all(Path(fault.file).name == "frame.msh" for fault in caught.value.faults)
    assert [f"{fault.key}: {fault.expected}" for fault in caught.value.faults] == expected


def test_beams_that_stand_and_columns_that_lie(structure, frame):
    swapped = {"beam": "column", "column": "beam"}
    parts = tuple(replace(part, family=swapped[part.family]) for part in frame.beam_parts)
    with pytest.raises(InputError) as caught:
        sections_of(structure(), replace(frame, beam_parts=parts))
    faults = {fault.key: fault.expected for fault in caught.value.faults}
    beam, column = faults["beam_1_north_east"], faults["column_2_east"]
    assert beam.startswith("at (6.000, 4.000, ") and column.startswith("at (6.000, ")
    assert beam.endswith("column_<k>")
    assert column.endswith("beam_<k>")


def with_materials(structure, *entries):
    """A structure with soft parts, by their patterns."""
    soft = structure.material.model_copy(update={"young_modulus": 3e9, "density": 1800.0})
    own = tuple(PartMaterial(parts=parts, material=soft) for parts in entries)
    return structure.model_copy(update={"materials": own})


LIGHT = {"mass_coefficient": 0.2, "stiffness_coefficient": 1e-3}
HEAVY = {"mass_coefficient": 2.0, "stiffness_coefficient": 3e-3}


def case_of(*entries):
    case = load_case(GEOMETRY / "frame.toml")
    damping = tuple(Entry(**entry) for entry in entries)
    structure = case.structure.model_copy(update={"damping": damping})
    return case.model_copy(update={"structure": structure})


def by_name(parts, values):
    groups = [part.group for part in (*parts.mesh.shell_parts, *parts.mesh.beam_parts)]
    return dict(zip(groups, (*values.shells, *values.beams), strict=True))


def test_materials_and_dampings_by_patterns():
    case = case_of({"parts": ("column_1_*", "floor_2*"), **LIGHT}, {"parts": ("beam_*",), **HEAVY})
    soft = with_materials(case.structure, ("storey_*", "column_2_*"))
    parts, _ = read_parts(building_of(case.model_copy(update={"structure": soft})), FRAME)
    materials, dampings = by_name(parts, parts.materials), by_name(parts, parts.dampings)
    for group, material in materials.items():
        other = group.startswith(("storey", "column_2"))
        assert (material.E, material.rho) == ((3e9, 1800.0) if other else (33e9, 2500.0)), group
    light, heavy = Rayleigh(0.2, 1e-3), Rayleigh(2.0, 3e-3)
    expected = {"column_1": light, "floor_2": light, "beam": heavy}
    for group, damping in dampings.items():
        own = [d for start, d in expected.items() if group.startswith(start)]
        assert damping == (own[0] if own else None), group
    assert parts.dampings is not None and parts.dampings.distinct == [light, heavy]
    plain, _ = read_parts(building_of(case_of()), FRAME)
    assert plain.dampings is None and len(set(plain.materials.shells)) == 1


def test_patterns_that_do_not_fit(house):
    """All at once, of materials and dampings, with the parts that exist."""
    case = case_of({"parts": ("floor_*", "floor_3"), **LIGHT}, {"parts": ("roof", "*_2"), **HEAVY})
    structure = with_materials(case.structure, ("floor_*", "roof"), ("floor_2",))
    every = (*house.mesh.shell_parts, *house.mesh.beam_parts)
    caught = part_faults(structure, every, case.path)
    faults = {(fault.key, fault.value): fault.expected for fault in caught}
    assert set(faults) == {
        ("buildings.F.structure.materials[0].parts[1]", "roof"),
        ("buildings.F.structure.materials[1].parts", "floor_2"),
        ("buildings.F.structure.damping[0].parts[1]", "floor_3"),
        ("buildings.F.structure.damping[1].parts[0]", "roof"),
        ("buildings.F.structure.damping[1].parts", "floor_2"),
    }
    names = sorted(part.group for part in every)
    words = f"expected a pattern of the parts of the mesh: {', '.join(names)}"
    assert words == faults["buildings.F.structure.damping[1].parts[0]", "roof"]
    # Of a mesh that is made and then read, parts have another order: each fault is the same.
    assert [*part_faults(structure, every[::-1], case.path)] == [
        *part_faults(structure, every, case.path)
    ]
    also = "also matched by buildings.F.structure.damping[0]; expected one entry for floor_2"
    assert faults["buildings.F.structure.damping[1].parts", "floor_2"] == also


def test_a_pattern_of_no_part_is_refused_with_the_mesh():
    with pytest.raises(InputError, match="mesh: beam_1_east,"):
        read_parts(building_of(case_of({"parts": ("walls",), **LIGHT})), FRAME)
