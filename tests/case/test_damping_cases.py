"""The tables [[damping_cases]] of a case file."""

import json
import pickle
from collections.abc import Callable
from pathlib import Path

import pytest

from impactfem.case import DampingCase, load_case
from impactfem.dynamics.damping import Rayleigh

from .faults import faults_of, refused
from .texts import added

Broken = Callable[..., Path]
Structured = Callable[..., Path]

LIGHT = """
[[damping_cases]]
name = "light"
mass_coefficient = "0.838 1/s"
stiffness_coefficient = "0.212 ms"
"""
HEAVY = """
[[damping_cases]]
name = "heavy_7-B"
ratio = "7 %"
frequencies = ["1 Hz", "20 Hz"]
restitution = "60 %"
"""
CALIBRATED = f'{LIGHT}restitution = "calibrated"\n'
WALL = """
[wall_impact]
gap = "1 cm"
displacement = "-2 cm"
duration = "1.3 s"
time_step = "0.34 ms"
"""
SERVING = """
[transient]
time_step = "1 ms"
serve_damping_cases = true
"""


@pytest.fixture
def with_cases(broken: Broken) -> Callable[[str], Path]:
    """The case without a 3D model, with some text at its end."""
    return lambda text: added(broken(), text)


def test_left_out(pair: Path) -> None:
    assert load_case(pair).damping_cases == ()


def test_without_a_structure(with_cases: Callable[[str], Path]) -> None:
    case = load_case(with_cases(LIGHT + HEAVY))
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


def test_calibrated_with_the_impact(structured: Structured) -> None:
    case = load_case(added(structured(), WALL + CALIBRATED + HEAVY))
    assert [one.restitution for one in case.damping_cases] == ["calibrated", 0.6]


def test_calibrated_without_the_impact(
    with_cases: Callable[[str], Path], structured: Structured
) -> None:
    for path in (with_cases(HEAVY + CALIBRATED), added(structured(), HEAVY + CALIBRATED)):
        assert faults_of(path) == {
            "damping_cases[1].restitution": "calibrated expected a section [wall_impact] beside "
            "it: the impact that gives it"
        }


@pytest.mark.parametrize(
    ("old", "new", "key", "expected"),
    [
        ('"light"', '"own"', "name", "own expected another name"),
        ('"light"', '"light"\nfloors = 2', "floors", "unknown key"),
        ('"light"', '"light"\nratio = 0.1\nfrequencies = ["1 Hz", "2 Hz"]', "mass_coefficient",
         "not both"),
        ('mass_coefficient = "0.838 1/s"\n', "", "stiffness_coefficient", "together"),
    ],
)  # fmt: skip
def test_refused(
    with_cases: Callable[[str], Path], old: str, new: str, key: str, expected: str
) -> None:
    assert old in LIGHT
    refused(with_cases(LIGHT.replace(old, new)), f"damping_cases[0].{key}", expected)


def test_each_name_once(with_cases: Callable[[str], Path]) -> None:
    assert faults_of(with_cases(LIGHT + HEAVY + LIGHT)) == {
        "damping_cases[2].name": "light duplicate name, the first is damping_cases[0].name"
    }


def test_one_table_in_place_of_several(with_cases: Callable[[str], Path]) -> None:
    faults = faults_of(with_cases(LIGHT.replace("[[damping_cases]]", "[damping_cases]")))
    assert set(faults) == {"damping_cases"}


def test_served_by_the_reduced_basis(structured: Structured) -> None:
    path = added(structured(), SERVING)
    assert faults_of(path) == {
        "transient.serve_damping_cases": "True expected [[damping_cases]] beside it: the dampings "
        "to serve"
    }
    transient = load_case(added(path, LIGHT)).transient
    assert transient is not None and transient.serve_damping_cases
