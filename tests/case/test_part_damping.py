"""The tables [[buildings.structure.damping]] of a case file."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.case.damping import PartDamping
from impactfem.dynamics.damping import Rayleigh

from .faults import faults_of, refused
from .texts import added

Structured = Callable[..., Path]

TABLES = """
[[buildings.structure.damping]]
parts = ["column_*", "floor_8"]
ratio = "2 %"
frequencies = ["1 Hz", "20 Hz"]
[[buildings.structure.damping]]
parts = ["beam_*"]
mass_coefficient = "0.2 1/s"
stiffness_coefficient = "1 ms"
"""
FULL = '\n[transient]\nsolver = "full"\ntime_step = "1 ms"\n'
OTHERS = {
    "damping_cases": '[[damping_cases]]\nname = "light"\nratio = "1 %"\nfrequencies = ["1 Hz", '
    '"9 Hz"]\nrestitution = 0.5\n',
    "wall_impact": '[wall_impact]\ngap = "1 cm"\ndisplacement = "-2 cm"\nduration = "1 s"\n'
    'time_step = "1 ms"\n',
}


def test_read(structured: Structured) -> None:
    structure = load_case(added(structured(), TABLES + FULL)).structure
    assert structure is not None
    first, second = structure.damping
    assert first.parts == ("column_*", "floor_8")
    assert first.rayleigh.ratio(20.0) == pytest.approx(0.02)
    assert second.rayleigh == Rayleigh(0.2, 1e-3)
    without = load_case(added(structured(), FULL)).structure
    assert without is not None and without.damping == ()


@pytest.mark.parametrize("solver", ["reduced", "both", None])
def test_only_in_full_order(structured: Structured, solver: str | None) -> None:
    transient = "" if solver is None else FULL.replace('"full"', f'"{solver}"')
    refused(
        added(structured(), TABLES + transient),
        "transient.solver",
        "expected 'full' beside [[buildings.structure.damping]]",
    )


def test_default_solver(structured: Structured) -> None:
    text = FULL.replace('solver = "full"\n', "")
    assert "transient.solver" in faults_of(added(structured(), TABLES + text))


@pytest.mark.parametrize("name", list(OTHERS))
def test_nothing_that_needs_the_basis(structured: Structured, name: str) -> None:
    refused(
        added(structured(), TABLES + FULL + OTHERS[name]),
        name,
        "expected none beside [[buildings.structure.damping]]",
    )
    assert load_case(added(structured(), FULL + OTHERS[name])).structure is not None


def test_no_devices(structured: Structured) -> None:
    device = '[[devices]]\nname = "pump"\n'
    faults = faults_of(added(structured(), TABLES + FULL + device))
    assert "the study of devices uses the reduced basis" in faults["devices"]


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ('parts = ["beam_*"]', "parts = []", "buildings[1].structure.damping[1].parts"),
        ('parts = ["beam_*"]\n', "", "buildings[1].structure.damping[1].parts"),
        ('ratio = "2 %"', 'ratio = "120 %"', "buildings[1].structure.damping[0].ratio"),
        ('"1 ms"', '"1 m"', "buildings[1].structure.damping[1].stiffness_coefficient"),
        ('parts = ["beam_*"]', 'part = ["beam_*"]', "buildings[1].structure.damping[1].part"),
    ],
)
def test_refused(structured: Structured, old: str, new: str, key: str) -> None:
    assert old in TABLES
    assert key in faults_of(added(structured(), TABLES.replace(old, new) + FULL))


def test_template() -> None:
    text = files("impactfem.case").joinpath("templates/case.toml").read_text(encoding="utf-8")
    block = text[text.index("# [[buildings.structure.damping]]") :].split("\n\n")[0]
    (entry,) = tomllib.loads(block.replace("# ", "", 1).replace("\n# ", "\n"))["buildings"][
        "structure"
    ]["damping"]
    assert PartDamping.model_validate(entry).ratio == pytest.approx(0.02)
