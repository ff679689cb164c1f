"""The tables [[damping_cases]] and [[buildings.structure.damping]] of a case file."""

import json
import tomllib

import pytest

from impactfem.case import load_case
from impactfem.case.damping import PartDamping, RayleighCase
from impactfem.case.template import write_new_case
from impactfem.dynamics.damping import Caughey, ModeRatios, RatioTable, Rayleigh

from .faults import faults_of, refused
from .sections import FULL_ORDER, LIGHT, PART_DAMPING, PUMP, TRANSIENT, WALL
from .texts import added

HEAVY = """
[[damping_cases]]
name = "heavy_7-B"
ratio = "7 %"
frequencies = ["1 Hz", "20 Hz"]
restitution = "60 %"
"""
CALIBRATED = f'{LIGHT}restitution = "calibrated"\n'
BESIDE = "beside [[buildings.structure.damping]]"


def test_without_a_structure(broken):
    case = load_case(broken(more=LIGHT + HEAVY))
    assert case.damping_cases == (
        RayleighCase(name="light", mass_coefficient=0.838, stiffness_coefficient=2.12e-4),
        RayleighCase(name="heavy_7-B", ratio=0.07, frequencies=(1.0, 20.0), restitution=0.6),
    )
    light, heavy = case.damping_cases
    assert (light.rayleigh, light.restitution) == (Rayleigh(0.838, 2.12e-4), "calibrated")
    assert heavy.rayleigh == case.damping.rayleigh
    # The dampings that the buildings have are not touched.
    assert {building.damping for building in case.buildings} == {case.damping}
    dumped = json.loads(case.model_dump_json(include={"damping_cases"}))["damping_cases"]
    assert [one["restitution"] for one in dumped] == ["calibrated", 0.6]


def test_calibrated_with_the_impact(structured, broken):
    case = load_case(structured(more=WALL + CALIBRATED + HEAVY))
    assert [one.restitution for one in case.damping_cases] == ["calibrated", 0.6]
    for write in (structured, broken):
        path = write(more=HEAVY + CALIBRATED)
        refused(path, "damping_cases[1].restitution", "missing_section [wall_impact]")


def test_served_by_the_reduced_basis(structured):
    path = structured(more=f"{TRANSIENT}serve_damping_cases = true\n")
    refused(path, "transient.serve_damping_cases", "missing_section [[damping_cases]]")
    transient = load_case(added(path, LIGHT)).transient
    assert transient is not None and transient.serve_damping_cases


def test_dampings_of_parts(structured):
    structure = load_case(structured(more=PART_DAMPING + FULL_ORDER)).structure
    first, second = structure.damping
    assert first.parts == ("column_*", "floor_8")
    assert first.rayleigh.ratio(20.0) == pytest.approx(0.02)
    assert second.rayleigh == Rayleigh(0.2, 1e-3)
    without = load_case(structured(more=FULL_ORDER)).structure
    assert without is not None and without.damping == ()


@pytest.mark.parametrize("solver", ['solver = "reduced"', 'solver = "both"', ""])
def test_parts_only_in_full_order(structured, solver):
    path = structured(more=f"{PART_DAMPING}{TRANSIENT}{solver}\n")
    refused(path, "transient.solver", "no_reduced_basis 'full'")


@pytest.mark.parametrize(
    ("name", "text"), [("damping_cases", LIGHT), ("wall_impact", WALL), ("devices", PUMP)]
)
def test_parts_with_nothing_that_needs_the_basis(structured, name, text):
    text += "restitution = 0.5\n" if name == "damping_cases" else ""
    refused(structured(more=PART_DAMPING + FULL_ORDER + text), name, "no_reduced_basis")
    assert load_case(structured(more=FULL_ORDER + text)).structure is not None


def test_template(tmp_path):
    text = write_new_case(tmp_path / "new")[0].read_text(encoding="utf-8")
    block = text[text.index("# [[buildings.structure.damping]]") :].split("\n\n")[0]
    read = tomllib.loads(block.replace("# ", "", 1).replace("\n# ", "\n"))
    (entry,) = read["buildings"]["structure"]["damping"]
    assert PartDamping.model_validate(entry).ratio == pytest.approx(0.02)


RAYLEIGH_TEXT = 'ratio = "7 %"\nfrequencies = ["1 Hz", "20 Hz"]'


@pytest.mark.parametrize(
    ("text", "law"),
    [
        ('type = "rayleigh"\n' + RAYLEIGH_TEXT, Rayleigh.through(0.07, 1.0, 20.0)),
        ('type = "constant"\nratio = 0.04', RatioTable.constant(0.04)),
        ("ratio = 0.04", RatioTable.constant(0.04)),
        (
            'type = "table"\npoints = [["500 mHz", "2 %"], ["500 Hz", 1.2]]',
            RatioTable((0.5, 500.0), (0.02, 1.2)),
        ),
        (
            'type = "caughey"\npoints = [["1 Hz", 0.07], ["4 Hz", 0.02], ["20 Hz", 0.07]]',
            Caughey((1.0, 4.0, 20.0), (0.07, 0.02, 0.07)),
        ),
        (
            'type = "modes"\nratios = ["1 %", 0]\n' + RAYLEIGH_TEXT,
            ModeRatios((0.01, 0.0), Rayleigh.through(0.07, 1.0, 20.0)),
        ),
    ],
)
def test_laws(broken, text, law):
    case = load_case(broken((None, RAYLEIGH_TEXT, text), more=LIGHT))
    assert case.damping.law == law and {one.damping.law for one in case.buildings} == {law}
    again = type(case.damping).model_validate_json(case.damping.model_dump_json(), strict=True)
    assert again.law == law


POINTS = 'points = [["1 Hz", "5 %"], ["500 Hz", "5 %"]]'


@pytest.mark.parametrize(
    ("text", "key", "kind"),
    [
        ('type = "hysteretic"', "type", "union_tag_invalid"),
        ('type = "constant"', "ratio", "missing"),
        ('type = "constant"\nratio = 0.05\nfrequencies = ["1 Hz", "2 Hz"]', "frequencies",
         "extra_forbidden 'rayleigh'"),
        (f'type = "constant"\nratio = 0.05\n{POINTS}', "points", "extra_forbidden 'table'"),
        ('type = "table"', "points", "missing"),
        ('type = "table"\npoints = []', "points", "too_short"),
        (f'type = "table"\nratio = 0.05\n{POINTS}', "ratio", "extra_forbidden 'constant'"),
        ('type = "table"\npoints = [["1 Hz"]]', "points[0]", "missing 20 Hz"),
        ('type = "table"\npoints = [["1 s", 0.1]]', "points[0][0]", "unit"),
        ('type = "table"\npoints = [["1 Hz", -0.1]]', "points[0][1]", "greater_than_equal 0"),
        ('type = "table"\npoints = [["9 Hz", 0.1], ["8 Hz", 0.1]]', "points", "in_order"),
        ('type = "table"\npoints = [["1 Hz", 0.1], ["5 Hz", 0.1]]', "points", "of_damping 500 Hz"),
        ('type = "caughey"\npoints = [["1 Hz", 0.1], ["5 Hz", 0.01]]', "points", "not_negative"),
        (f'type = "modes"\n{RAYLEIGH_TEXT}', "ratios", "missing"),
        ('type = "modes"\nratios = [0.01]', "stiffness_coefficient", "one_of_them"),
        (f'type = "modes"\nratios = [1.0]\n{RAYLEIGH_TEXT}', "ratios[0]", "less_than 1"),
        (f"{RAYLEIGH_TEXT}\nratios = [0.1]", "ratios", "extra_forbidden 'modes'"),
    ],
)  # fmt: skip
def test_laws_that_are_refused(broken, text, key, kind):
    refused(broken((None, RAYLEIGH_TEXT, text)), f"damping.{key}", kind)


def test_laws_of_parts_and_in_full_order(structured):
    constant = (None, RAYLEIGH_TEXT, 'type = "constant"\nratio = 0.05')
    refused(
        structured(constant, more=PART_DAMPING + FULL_ORDER),
        "damping.type",
        "of_damping 'rayleigh'",
    )
    part = PART_DAMPING.replace(
        "[[buildings.structure.damping]]", "[[buildings.structure.damping]]\ntype = 'constant'", 1
    )
    found = faults_of(structured(more=part + FULL_ORDER))
    (key,) = (key for key in found if key.endswith("type"))
    assert key == "buildings[1].structure.damping[0].type"
    # A 3D model without either takes any law.
    assert load_case(structured(constant, more=TRANSIENT)).damping.type == "constant"
