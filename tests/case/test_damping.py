"""The tables [[damping_cases]] and [[buildings.structure.damping]] of a case file."""

from __future__ import annotations

import json
import pickle
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from impactfem.case import DampingCase, load_case
from impactfem.case.damping import PartDamping
from impactfem.case.template import write_new_case
from impactfem.dynamics.damping import Rayleigh

from .faults import faults_of, refused
from .sections import FULL_ORDER, LIGHT, PART_DAMPING, TRANSIENT, WALL
from .texts import added

Write = Callable[..., Path]

HEAVY = """
[[damping_cases]]
name = "heavy_7-B"
ratio = "7 %"
frequencies = ["1 Hz", "20 Hz"]
restitution = "60 %"
"""
CALIBRATED = f'{LIGHT}restitution = "calibrated"\n'
BESIDE = "beside [[buildings.structure.damping]]"


def test_left_out(pair: Path) -> None:
    assert load_case(pair).damping_cases == ()


def test_without_a_structure(broken: Write) -> None:
    case = load_case(broken(more=LIGHT + HEAVY))
    assert case.damping_cases == (
        DampingCase(name="light", mass_coefficient=0.838, stiffness_coefficient=2.12e-4),
        DampingCase(name="heavy_7-B", ratio=0.07, frequencies=(1.0, 20.0), restitution=0.6),
    )
    light, heavy = case.damping_cases
    assert (light.rayleigh, light.restitution) == (Rayleigh(0.838, 2.12e-4), "calibrated")
    assert heavy.rayleigh == case.damping.rayleigh
    # The dampings that the buildings have are not touched.
    assert {building.damping for building in case.buildings} == {case.damping}
    assert pickle.loads(pickle.dumps(case)) == case
    dumped = json.loads(case.model_dump_json(include={"damping_cases"}))["damping_cases"]
    assert [one["restitution"] for one in dumped] == ["calibrated", 0.6]


def test_calibrated_with_the_impact(structured: Write, broken: Write) -> None:
    case = load_case(structured(more=WALL + CALIBRATED + HEAVY))
    assert [one.restitution for one in case.damping_cases] == ["calibrated", 0.6]
    for write in (structured, broken):
        assert faults_of(write(more=HEAVY + CALIBRATED)) == {
            "damping_cases[1].restitution": "calibrated expected a section [wall_impact] beside "
            "it: the impact that gives it"
        }


def test_each_name_once(broken: Write) -> None:
    assert faults_of(broken(more=LIGHT + HEAVY + LIGHT)) == {
        "damping_cases[2].name": "light duplicate name, the first is damping_cases[0].name"
    }


def test_one_table_in_place_of_several(broken: Write) -> None:
    one = LIGHT.replace("[[damping_cases]]", "[damping_cases]")
    assert set(faults_of(broken(more=one))) == {"damping_cases"}


def test_served_by_the_reduced_basis(structured: Write) -> None:
    path = structured(more=f"{TRANSIENT}serve_damping_cases = true\n")
    assert faults_of(path) == {
        "transient.serve_damping_cases": "True expected [[damping_cases]] beside it: the dampings "
        "to serve"
    }
    transient = load_case(added(path, LIGHT)).transient
    assert transient is not None and transient.serve_damping_cases


def test_dampings_of_parts(structured: Write) -> None:
    structure = load_case(structured(more=PART_DAMPING + FULL_ORDER)).structure
    assert structure is not None
    first, second = structure.damping
    assert first.parts == ("column_*", "floor_8")
    assert first.rayleigh.ratio(20.0) == pytest.approx(0.02)
    assert second.rayleigh == Rayleigh(0.2, 1e-3)
    without = load_case(structured(more=FULL_ORDER)).structure
    assert without is not None and without.damping == ()


@pytest.mark.parametrize("solver", ['solver = "reduced"', 'solver = "both"', ""])
def test_parts_only_in_full_order(structured: Write, solver: str) -> None:
    path = structured(more=f"{PART_DAMPING}{TRANSIENT}{solver}\n")
    refused(path, "transient.solver", f"expected 'full' {BESIDE}")


@pytest.mark.parametrize(("name", "text"), [("damping_cases", LIGHT), ("wall_impact", WALL)])
def test_parts_with_nothing_that_needs_the_basis(structured: Write, name: str, text: str) -> None:
    text += "restitution = 0.5\n" if name == "damping_cases" else ""
    refused(structured(more=PART_DAMPING + FULL_ORDER + text), name, f"expected none {BESIDE}")
    assert load_case(structured(more=FULL_ORDER + text)).structure is not None


def test_parts_without_devices(structured: Write) -> None:
    device = '[[devices]]\nname = "pump"\n'
    faults = faults_of(structured(more=PART_DAMPING + FULL_ORDER + device))
    assert "the study of devices uses the reduced basis" in faults["devices"]


def test_template(tmp_path: Path) -> None:
    text = write_new_case(tmp_path / "new")[0].read_text(encoding="utf-8")
    block = text[text.index("# [[buildings.structure.damping]]") :].split("\n\n")[0]
    read = tomllib.loads(block.replace("# ", "", 1).replace("\n# ", "\n"))
    (entry,) = read["buildings"]["structure"]["damping"]
    assert PartDamping.model_validate(entry).ratio == pytest.approx(0.02)
