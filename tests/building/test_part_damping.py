"""Which parts have a damping of their own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from impactfem.building.from_case import part_damping, part_faults, read_parts
from impactfem.building.parts import BuildingParts, PartDamping
from impactfem.case import Case, load_case
from impactfem.case.damping import PartDamping as Entry
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import InputError

GEOMETRY = Path(__file__).parents[2] / "geometry"
LIGHT = {"mass_coefficient": 0.2, "stiffness_coefficient": 1e-3}
HEAVY = {"mass_coefficient": 2.0, "stiffness_coefficient": 3e-3}


def case_of(*entries: dict[str, Any]) -> Case:
    case = load_case(GEOMETRY / "frame.toml")
    assert case.structure is not None
    damping = tuple(Entry(**entry) for entry in entries)
    structure = case.structure.model_copy(update={"damping": damping})
    return case.model_copy(update={"structure": structure})


def found(case: Case, parts: BuildingParts) -> PartDamping | None:
    assert case.structure is not None
    return part_damping(case.structure, parts.mesh)


def test_parts_by_patterns(house: BuildingParts) -> None:
    case = case_of({"parts": ("column_?", "floor_2*"), **LIGHT}, {"parts": ("beam_1",), **HEAVY})
    dampings = found(case, house)
    assert dampings is not None
    light, heavy = Rayleigh(0.2, 1e-3), Rayleigh(2.0, 3e-3)
    by_name = dict(
        zip(
            [part.group for part in (*house.mesh.shell_parts, *house.mesh.beam_parts)],
            (*dampings.shells, *dampings.beams),
            strict=True,
        )
    )
    assert by_name == {
        **dict.fromkeys(("column_1", "column_2", "floor_2", "floor_2_acroterion"), light),
        "beam_1": heavy,
        **dict.fromkeys(("floor_1", *(f"storey_{k}_{w}" for k in (1, 2) for w in WALLS))),
    }
    assert dampings.distinct == [light, heavy]
    assert found(case_of(), house) is None


WALLS = ("inner", "south")


def test_patterns_that_do_not_fit(house: BuildingParts) -> None:
    """All at once, with the parts that exist."""
    case = case_of({"parts": ("floor_*", "floor_3"), **LIGHT}, {"parts": ("roof", "*_2"), **HEAVY})
    assert case.structure is not None
    every = (*house.mesh.shell_parts, *house.mesh.beam_parts)
    caught = part_faults(case.structure, every, case.path)
    faults = {(fault.key, fault.value): fault.expected for fault in caught}
    assert set(faults) == {
        ("structure.damping[0].parts[1]", "floor_3"),
        ("structure.damping[1].parts[0]", "roof"),
        ("structure.damping[1].parts", "floor_2"),
    }
    names = "floor_1, floor_2, floor_2_acroterion, storey_1_inner"
    assert names in faults["structure.damping[1].parts[0]", "roof"]
    also = "also matched by structure.damping[0]; expected one entry for floor_2"
    assert faults["structure.damping[1].parts", "floor_2"] == also


def test_read_with_the_mesh() -> None:
    parts, _, _ = read_parts(case_of({"parts": ("storey_*",), **LIGHT}), GEOMETRY / "frame.msh")
    assert parts.dampings is not None and parts.dampings.distinct == [Rayleigh(0.2, 1e-3)]
    with pytest.raises(InputError, match="expected a pattern of the parts of the mesh: floor_1"):
        read_parts(case_of({"parts": ("walls",), **LIGHT}), GEOMETRY / "frame.msh")
