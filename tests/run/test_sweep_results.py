"""The table and the figure of a sweep."""

import csv
import json
import math
from pathlib import Path

import matplotlib.image
import pytest

from impactfem.run.sweep_results import SweepResults, SweepRow, draw_sweep, write_sweep
from impactfem.system.scalar import Scalar

KEYS = (("mesh.thickness", "m"), ("solver", ""))


def row(thickness: float, solver: str, peak: float | None, error: str = "") -> SweepRow:
    scalars = [
        Scalar("frs.peak", peak, "m/s2"),
        Scalar("frs.steps", 7.0, "-"),
        Scalar("frs.force", None if peak is None else 2.0 * peak, "N"),
    ]
    known = {} if error else {scalar.name: scalar for scalar in scalars}
    return SweepRow(f"{thickness}-{solver}", (thickness, solver), known, error)


@pytest.fixture
def results() -> SweepResults:
    rows = (
        row(0.3, "full", 3.0),
        row(0.2, "full", 2.0),
        row(0.2, "reduced", None),
        row(0.3, "reduced", math.inf),
        row(0.4, "full", None, "grew; without bound"),
    )
    return SweepResults("A case", KEYS, rows, {"frs.force": 5.0})


def test_everything_as_csv_and_json(results: SweepResults, tmp_path: Path) -> None:
    files = write_sweep(tmp_path, results, ["frs.peak"])
    assert [file.name for file in files] == ["sweep.csv", "sweep.json", "sweep.png"]
    with files[0].open(newline="", encoding="utf-8") as stream:
        head, *rows = csv.reader(stream)
    names = ["frs.peak [m/s2]", "frs.steps [-]", "frs.force [N]"]
    assert head == ["variant", "mesh.thickness [m]", "solver", *names, "error"]
    assert rows[0] == ["0.3-full", "0.3", "full", "3.0", "7.0", "6.0", ""]
    assert rows[2] == ["0.2-reduced", "0.2", "reduced", "", "7.0", "", ""]
    assert rows[3][3] == ""  # infinity is no result
    assert rows[4] == ["0.4-full", "0.4", "full", "", "", "", "grew; without bound"]
    told = json.loads(files[1].read_text(encoding="utf-8"))
    assert told["keys"][0] == {"key": "mesh.thickness", "unit": "m"}
    assert told["units"] == {"frs.peak": "m/s2", "frs.steps": "-", "frs.force": "N"}
    assert told["variants"][0]["values"] == {"mesh.thickness": 0.3, "solver": "full"}
    assert told["variants"][0]["results"]["frs.peak"] == 3.0
    assert told["variants"][0]["error"] is None
    assert told["variants"][4]["error"] == "grew; without bound"
    assert told["variants"][4]["results"] == {}


def test_what_is_shown(results: SweepResults) -> None:
    """Without names: what differs, published values first."""
    assert results.chosen([]) == ["frs.force", "frs.peak"]
    assert results.chosen(["frs.*"]) == ["frs.peak", "frs.steps", "frs.force"]
    assert results.chosen(["frs.steps", "frs.s*", "nothing"]) == ["frs.steps"]
    same = SweepResults("A case", KEYS, results.rows[:1], {})
    assert same.chosen([]) == ["frs.peak", "frs.steps", "frs.force"]


def test_the_short_table(results: SweepResults) -> None:
    table = results.table(["frs.peak"])
    assert [name for name, _ in table.columns] == ["mesh.\nthickness", "solver", "frs.\npeak", ""]
    assert table.rows[0] == (0.3, "full", 3.0, "")
    assert table.rows[4] == (0.4, "full", None, "failed")
    assert "failed" in table.as_text()


@pytest.mark.parametrize(
    ("rows", "zipped", "drawn"),
    [
        (slice(0, 2), False, True),
        (slice(0, 1), False, False),  # a point is no line
        (slice(1, 3), False, False),
        (slice(0, 2), True, True),
    ],
)
def test_the_figure(
    results: SweepResults, tmp_path: Path, rows: slice, zipped: bool, drawn: bool
) -> None:
    some = SweepResults("A case", KEYS, results.rows[rows], {}, zipped)
    path = tmp_path / "a.png"
    assert draw_sweep(path, some, ["frs.peak", "frs.steps", "frs.force"]) is drawn
    assert path.exists() is drawn
    if drawn:
        assert matplotlib.image.imread(path).std() > 0.0


def test_keys_that_run_together_are_one_line(tmp_path: Path) -> None:
    rows = (row(0.2, "full", 2.0), row(0.3, "reduced", 3.0))
    for zipped in (True, False):
        results = SweepResults("A case", KEYS, rows, {}, zipped)
        assert draw_sweep(tmp_path / "a.png", results, ["frs.peak"]) is zipped


def test_words_are_not_drawn(results: SweepResults, tmp_path: Path) -> None:
    some = SweepResults(
        "A case",
        (("solver", ""),),
        tuple(SweepRow(r.name, r.values[1:], r.scalars) for r in results.rows[:2]),
        {},
    )
    assert not draw_sweep(tmp_path / "a.png", some, ["frs.peak"])


def test_a_figure_of_before_goes(results: SweepResults, tmp_path: Path) -> None:
    write_sweep(tmp_path, results, ["frs.peak"])
    assert write_sweep(tmp_path, results, [])[-1].name == "sweep.json"
    assert not (tmp_path / "sweep.png").exists()
