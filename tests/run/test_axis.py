"""The axes of a sweep as they are written on a command line."""

from pathlib import Path

import numpy as np
import pytest

from impactfem.case.source import Source
from impactfem.run.axis import Axis, in_si, read_axes

SOURCE = Source(
    Path("case.toml"),
    {
        "title": "A case",
        "damping": {"ratio": "5 %", "frequencies": ["1 Hz", "20 Hz"]},
        "buildings": [{"name": "A"}, {"name": "B"}],
        "transient": {"solver": "reduced"},
        "wall_impact": {"displaced_floor": 8},
    },
)


def values(text: str, key: str = "title") -> tuple[object, ...]:
    (axis,), faults = read_axes([f"{key}={text}"], SOURCE)
    assert not faults
    return axis.values


def faults(*texts: str) -> list[str]:
    return [str(fault) for fault in read_axes(texts, SOURCE)[1]]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("3 %, 5 %", ("3 %", "5 %")),
        ("1,2.5,-3e2", (1, 2.5, -300.0)),
        ("reduced,full", ("reduced", "full")),
        ("true,false", (True, False)),
        ("'a, b',\"c\"", ("a, b", "c")),
        ("[8],[7, 8],[]", ([8], [7, 8], [])),
        ("{ a = 1, b = 2 }", ({"a": 1, "b": 2},)),
        ("25 cm:35 cm:3", ("25 cm", "30 cm", "35 cm")),
        ("25:35 cm:3", ("25 cm", "30 cm", "35 cm")),
        ("0.1:0.3:3", (0.1, 0.2, 0.3)),
        ("6:8:3", (6, 7, 8)),
        ("6:7:3", (6.0, 6.5, 7.0)),
        ("5 %:1 %:3", ("5 %", "3 %", "1 %")),
        ("1e10 N/m:1e12 N/m:3:log", ("10000000000 N/m", "100000000000 N/m", "1e+12 N/m")),
        ("1:2:2,5", (1, 2, 5)),
        ("'1:2:3'", ("1:2:3",)),
        ("2020-01-01", ("2020-01-01",)),
    ],
)
def test_values(text: str, expected: tuple[object, ...]) -> None:
    found = values(text)
    assert found == expected
    assert [type(one) for one in found] == [type(one) for one in expected]


def test_ranges_are_even_or_in_equal_ratios() -> None:
    even = np.diff(np.array(values("0.3:7:11"), dtype=np.float64))
    assert np.allclose(even, 0.67, rtol=1e-11)
    ratios = np.array(values("0.3:7:11:log"), dtype=np.float64)
    assert np.allclose(ratios[1:] / ratios[:-1], (7 / 0.3) ** 0.1, rtol=1e-11)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "one value or more"),
        ("1,,2", "a value between two commas"),
        ("1,", "a value between two commas"),
        ("1,2,1", "each value once"),
        ("1:2", "a range start:stop:count"),
        ("1:2:3:4", "a range start:stop:count"),
        ("1:2:3:log:5", "a range start:stop:count"),
        ("a:b:3", "a range start:stop:count"),
        ("1:2:2.5", "a range start:stop:count"),
        ("1:2:1", "2 to 10000 values"),
        ("1:2:10001", "2 to 10000 values"),
        ("1:1:3", "two different finite numbers"),
        ("1:1e999:3", "two different finite numbers"),
        ("1 m:2 cm:3", "one unit for both ends"),
        ("-1:1:3:log", "above zero"),
        ("0:1:3:log", "above zero"),
    ],
)
def test_values_with_a_fault(text: str, expected: str) -> None:
    (fault,) = faults(f"title={text}")
    assert fault.startswith("command line: --set title") and expected in fault


def test_all_faults_of_all_keys() -> None:
    found = faults("damping.rato=1", "x y=2", "", "buildings[9].name=C,C", "title=1:2", "extends=a")
    assert len(found) == 7
    assert "did you mean 'ratio'" in found[0] and "an index below 2" in found[3]
    assert "each value once" in found[4] and "start:stop" in found[5]
    assert all("a key of the case file" in found[k] for k in (1, 2, 6))


def test_keys_that_hold_one_another() -> None:
    for texts in (("damping=1", "damping.ratio=2"), ("damping.ratio=1", "damping.ratio=2")):
        (fault,) = faults(*texts)
        assert "do not hold one another" in fault
    assert not faults("damping.ratio=1", "damping.frequencies=2", "buildings[0].name=A")


def test_nothing_is_swept() -> None:
    assert "one key or more" in faults()[0]


def test_values_from_python() -> None:
    settings = {"damping.ratio": ["3 %", 0.05], "transient.solver": "reduced,full"}
    axes, none = read_axes(settings, SOURCE)
    assert not none
    assert [axis.values for axis in axes] == [("3 %", 0.05), ("reduced", "full")]


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("25 cm", (0.25, "m")),
        ("5 %", (0.05, "-")),
        ("2.5", (2.5, "-")),
        (3, (3.0, "-")),
        (True, ("true", "")),
        ("full", ("full", "")),
        ("5 parrots", ("5 parrots", "")),
        ([7, 8], ("[7, 8]", "")),
    ],
)
def test_in_si(value: object, expected: tuple[object, str]) -> None:
    assert in_si(value) == expected


def test_one_unit_for_an_axis() -> None:
    lengths = Axis("a", ("a",), ("25 cm", "1 m"))
    assert lengths.unit == "m" and lengths.cell("25 cm") == 0.25
    mixed = Axis("a", ("a",), ("25 cm", "calibrated"))
    assert mixed.unit == "" and mixed.cell("25 cm") == "25 cm"
