"""The section [device_analysis] of a case file."""

from collections.abc import Callable
from pathlib import Path
from typing import get_args

import pytest

from impactfem.case import Case, DeviceAnalysis, load_case
from impactfem.case.devices import Combination
from impactfem.device import combination

from .faults import faults_of
from .texts import added, replaced

Structured = Callable[..., Path]
With = Callable[..., Path]

DEVICE = """
[transient]
time_step = "1 ms"

[[devices]]
name = "cabinet"
point = ["5 m", "1 m", "3.26 m"]
radius = "0.5 m"
modes = "pair_modes.csv"
damping = { ratio = "2 %", frequencies = ["5 Hz", "30 Hz"] }
"""
ANALYSIS = """
[device_analysis]
combination = ["abs", "dsc", "ten-percent"]
duration = "4 s"
rigid = { method = "gupta", f1 = "5 Hz", f2 = "30 Hz" }
missing_mass = false
directions = "100-40-40"
rotations = false
broadening = 0
time_step = "0.2 ms"
"""


@pytest.fixture
def analysed(structured: Structured) -> With:
    """A case with a device and the section, with texts of the section replaced."""

    def write(*edits: tuple[str, str], device: str = DEVICE) -> Path:
        path = structured()
        added(path, device + replaced(ANALYSIS, *edits))
        modes = "frequency [Hz],direction,effective_mass [kg]\n8,y,300\n"
        (path.parent / "pair_modes.csv").write_text(modes, encoding="utf-8")
        return path

    return write


def test_without_devices(analysed: With) -> None:
    assert faults_of(analysed(device="")) == {
        "device_analysis": "None expected [[devices]] beside it: the devices to analyse"
    }


def analysis_of(case: Case) -> DeviceAnalysis:
    assert case.device_analysis is not None
    return case.device_analysis


def test_analysis(analysed: With) -> None:
    found = analysis_of(load_case(analysed()))
    assert found.combination == ("abs", "dsc", "ten-percent")
    assert (found.duration, found.time_step, found.broadening) == (4.0, 0.2e-3, 0.0)
    assert (found.missing_mass, found.rotations, found.directions) == (False, False, "100-40-40")
    assert found.rigid is not None
    assert (found.rigid.method, found.rigid.f1, found.rigid.f2) == (("gupta",), 5.0, 30.0)
    found = analysis_of(load_case(analysed((', f1 = "5 Hz", f2 = "30 Hz"', ""))))
    assert found.rigid is not None
    assert (found.rigid.f1, found.rigid.f2) == (None, None)


@pytest.mark.parametrize(
    ("new", "expected"),
    [
        ('["none", "gupta", "lindley-yow"]', ("none", "gupta", "lindley-yow")),
        ('["gupta"]', ("gupta",)),
    ],
)
def test_rigid_methods_are_a_list_like_the_combinations(
    analysed: With, new: str, expected: tuple[str, ...]
) -> None:
    found = analysis_of(load_case(analysed(('"gupta"', new)))).rigid
    assert found is not None and found.method == expected


def test_combinations_are_those_of_the_analysis() -> None:
    assert get_args(Combination) == get_args(combination.Combination)


@pytest.mark.parametrize(
    ("old", "new", "key", "expected"),
    [
        ('"abs"', '"dsc"', "combination", "each combination once"),
        ('duration = "4 s"\n', "", "duration", "the duration of the strong motion"),
        ('"gupta"', '"lindley-yow"', "rigid.f1", "only with method 'gupta'"),
        ('"gupta"', '["lindley-yow", "none"]', "rigid.f1", "only with method 'gupta'"),
        ('"gupta"', '"stiff"', "rigid.method", "expected 'none' or 'gupta' or 'lindley-yow', or a"),
        ('"gupta"', '["gupta", "gupta"]', "rigid.method", "or a list of them, each once"),
        ('f2 = "30 Hz"', 'f2 = "5 Hz"', "rigid.f2", "above f1, 5 Hz"),
        ('"0.2 ms"', '"1.1 ms"', "time_step", "at most the time step of [transient], 0.001 s"),
    ],
)
def test_analysis_refused(analysed: With, old: str, new: str, key: str, expected: str) -> None:
    faults = faults_of(analysed((old, new)))
    assert f"device_analysis.{key}" in faults
    assert expected in faults[f"device_analysis.{key}"]
