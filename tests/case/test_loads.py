"""The tables [[loads]] of a case file, and their forces."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from impactfem.case import load_case
from impactfem.case.loads import early_ends, read_force_table
from impactfem.case.motions import RestMotion
from impactfem.system.errors import Fault

from .faults import faults_of
from .texts import added

Broken = Callable[..., Path]

LOADS = '\n[[loads]]\nfile = "blast.csv"\ndirection = [0, -2, 0]\n'
BLAST = "time [ms],B1.floor_8 [MN],B2.floor_1 [kN]\n0,0,0\n5,2.5,-40\n20,0,0\n"


def with_loads(path: Path, table: str = BLAST, loads: str = LOADS) -> Path:
    added(path, loads)
    (path.parent / "blast.csv").write_text(table, encoding="utf-8")
    return path


def without_motions(path: Path) -> Path:
    text = path.read_text(encoding="utf-8")
    start = text.index("[[motions]]")
    end = min(
        k for k in (text.find(s, start) for s in ("\n[contact_laws", "\n[pounding]")) if k > 0
    )
    path.write_text(text[:start] + text[end:], encoding="utf-8")
    return path


def test_read(broken: Broken) -> None:
    case = load_case(with_loads(broken()))
    (loads,) = case.loads
    assert loads.direction == (0.0, -1.0, 0.0)
    faults: list[Fault] = []
    table = read_force_table(loads.file, faults)
    assert table is not None and not faults
    assert table.floors == (("B1", 8), ("B2", 1))
    assert table.time.tolist() == pytest.approx([0.0, 5e-3, 20e-3])
    at = table.at(np.array([0.0, 2.5e-3, 20e-3, 21e-3]))
    assert at == pytest.approx(np.array([[0, 0], [1.25e6, -2e4], [0, 0], [0, 0]]))
    assert not isinstance(case.motions[0], RestMotion)
    assert load_case(broken()).loads == ()


def test_a_building_of_any_name(tmp_path: Path) -> None:
    path = tmp_path / "blast.csv"
    for name, faults in (("model_1", 0), ("_1", 2)):
        path.write_text(f"time [s],{name}.floor_1 [N]\n0,0\n1,2\n", encoding="utf-8")
        found: list[Fault] = []
        assert (read_force_table(path, found) is None) == bool(faults)
        assert len(found) == faults


def test_a_change_of_the_table_is_another_case(broken: Broken) -> None:
    path = with_loads(broken())
    before = load_case(path).content_hash()
    (path.parent / "blast.csv").write_text(BLAST.replace("2.5", "2.6"), encoding="utf-8")
    assert load_case(path).content_hash() != before


def test_loads_alone_leave_the_ground_at_rest(broken: Broken) -> None:
    case = load_case(without_motions(with_loads(broken())))
    (motion,) = case.motions
    assert isinstance(motion, RestMotion) and motion.direction == "y"
    assert case.shown_direction == "y"
    nothing = without_motions(broken())
    assert "[[motions]], [[loads]] or both" in faults_of(nothing)["motions"]
    text = nothing.read_text(encoding="utf-8")
    nothing.write_text("motions = []\n" + text, encoding="utf-8")
    assert "[[motions]], [[loads]] or both" in faults_of(nothing)["motions"]


@pytest.mark.parametrize(
    ("old", "new", "key", "expected"),
    [
        ("B1.floor_8", "B3.floor_8", "column B3.floor_8", "expected a building of the case"),
        ("B1.floor_8", "B1.floor_9", "column B1.floor_9", "B1 has no floor 9; its floors are 1"),
        ("B1.floor_8 [MN]", "B1.floor_8", "line 1, column B1.floor_8", "no unit"),
        ("[MN]", "[m]", "line 1, column B1.floor_8 [m]", "is a length"),
        ("[ms]", "[N]", "line 1, column time [N]", "is a force"),
        ("B1.floor_8", "roof", "line 1, column roof [MN]", "expected '<building>.floor_<k> [N]'"),
        ("[kN]", "[kN] up", "line 1, column B2.floor_1 [kN] up", "or 'time [s]'"),
        ("B2.floor_1 [kN]", "B1.floor_8 [N]", "line 1, column B1.floor_8 [N]", "duplicate column"),
        ("5,2.5,-40", "5,2.5", "line 3", "expected 3 cells as in the header, found 2"),
        ("5,2.5,-40", "5,x,-40", "line 3, column B1.floor_8 [MN]", "a finite number"),
        ("5,2.5,-40", "20,2.5,-40", "line 4, column time [ms]", "times that increase"),
        ("0,0,0\n5", "-1,0,0\n5", "line 2, column time [ms]", "from 0 s or later"),
        ("\n5,2.5,-40\n20,0,0", "", "", "at least two lines"),
        (",", ";", "line 1", "semicolons"),
        ("5,2.5", "5," + "9" * 200_000, "line 3", "not a line of a CSV file"),
    ],
)
def test_faults_of_the_table(broken: Broken, old: str, new: str, key: str, expected: str) -> None:
    assert old in BLAST
    faults = faults_of(with_loads(broken(), BLAST.replace(old, new)))
    assert key in faults, faults
    assert expected in faults[key]


@pytest.mark.parametrize(
    ("old", "new", "key", "expected"),
    [
        ("blast.csv", "gone.csv", "loads[0].file", "no such file"),
        ("[0, -2, 0]", "[0, 0, 0]", "loads[0].direction", "a vector that is not zero"),
        ("direction = [0, -2, 0]\n", "", "loads[0].direction", "missing"),
    ],
)
def test_faults_of_the_section(broken: Broken, old: str, new: str, key: str, expected: str) -> None:
    faults = faults_of(with_loads(broken(), loads=LOADS.replace(old, new)))
    assert expected in faults[key]


def test_a_table_that_ends_with_a_force(tmp_path: Path) -> None:
    path = tmp_path / "blast.csv"
    for last, found in (("0", 0), ("1e-3", 1)):
        path.write_text(f"time [s],B.floor_1 [N]\n0,5\n1,{last}\n", encoding="utf-8")
        table = read_force_table(path, [])
        assert table is not None
        assert len(list(early_ends(path, table, 2.0))) == found
        assert not list(early_ends(path, table, 1.0))


def test_a_direction_along_the_edge_of_the_3d_model(structured: Broken) -> None:
    transient = '\n[transient]\ntime_step = "1 ms"\n'
    path = with_loads(structured(), loads=LOADS.replace("[0, -2, 0]", "[1, 0, 0]") + transient)
    faults = faults_of(path)
    assert "at right angles to the impact edge of B1" in faults["loads[0].direction"]
    assert load_case(with_loads(structured(), loads=LOADS + transient)).loads
