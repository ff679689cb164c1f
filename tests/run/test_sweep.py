"""A case over values of its keys, run into one table."""

import csv
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from impactfem import study
from impactfem.stages.pounding import stage as sticks
from impactfem.system.errors import InputError, SolutionError

MODULE = sys.modules["impactfem.run.sweep"]  # its function has the same name
FACTORS = {"buildings[0].stiffness_factor": [0.5, 2.0]}
FREQUENCY = "sticks.west.frequency.1"


@pytest.fixture
def case(new_case: Callable[..., Path], tmp_path: Path, no_figures: None) -> Path:
    return new_case(tmp_path)


def rows_of(folder: Path) -> list[dict[str, str]]:
    with (folder / "sweep.csv").open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_a_table_of_all_variants(case: Path, tmp_path: Path) -> None:
    """Stiffness four times as high: every frequency twice as high."""
    swept = study.sweep(case, FACTORS, stage="pounding", out=tmp_path / "s", show=[FREQUENCY])
    assert swept.failed == 0 and swept.shown == (FREQUENCY,)
    low, high = rows_of(tmp_path / "s")
    column = f"{FREQUENCY} [Hz]"
    assert float(high[column]) == pytest.approx(2.0 * float(low[column]), rel=1e-9)
    assert [row["buildings[0].stiffness_factor [-]"] for row in (low, high)] == ["0.5", "2.0"]
    for row in (low, high):
        summary = tmp_path / "s" / "runs" / row["variant"] / "summary.json"
        for entry in json.loads(summary.read_text()):
            cell = row[f"{entry['name']} [{entry['unit']}]"]
            assert cell == ("" if entry["value"] is None else repr(entry["value"]))
    log = (tmp_path / "s" / "sweep.log").read_text()
    assert "2 variants" in log and "variant 2 of 2" in log
    assert not list(tmp_path.glob("s/**/*.part"))


def test_a_variant_is_a_case_of_its_own(case: Path, tmp_path: Path) -> None:
    swept = study.sweep(case, FACTORS, stage="pounding", out=tmp_path / "s")
    results = swept.table.results.iloc[1].dropna()
    path = tmp_path / "s" / "cases" / f"{results.name}.toml"
    again = study.run(path, out=tmp_path / "again", stage="pounding")
    values = {scalar.name: scalar.value for scalar in again.scalars if scalar.value is not None}
    assert values == results.to_dict()
    folder = tmp_path / "s" / "runs" / results.name
    held = study.run(path, out=folder, stage="pounding", resume=True)
    assert held.reused == ["pounding"]


def test_finished_variants_are_reused(
    case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = study.sweep(case, FACTORS, stage="pounding", out=tmp_path / "s")
    monkeypatch.setattr(sticks, "run_sticks", _fail)
    wider = {"buildings[0].stiffness_factor": [0.5, 1.0, 2.0]}
    again = study.sweep(case, wider, stage="pounding", out=tmp_path / "s")
    assert again.failed == 1
    assert again.table.results.iloc[[0, 2]].equals(first.table.results)
    assert again.table.errors.iloc[1] == "grew without bound"
    assert again.table.results.iloc[1].isna().all()


def _fail(*_: object, **__: object) -> None:
    raise SolutionError("grew without bound")


def test_a_stage_with_the_same_inputs_is_computed_once(
    case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The sticks do not depend on the ensemble."""
    calls = []
    compute = sticks.run_sticks
    monkeypatch.setattr(sticks, "run_sticks", lambda *a, **k: calls.append(1) or compute(*a, **k))
    swept = study.sweep(case, {"title": ["a", "b", "c"]}, stage="pounding", out=tmp_path / "s")
    assert len(calls) == 1 and swept.failed == 0
    found = swept.table.results
    assert (found.nunique() <= 1).all() and len(found) == 3
    # Nor in a later sweep into the same folder, under another name.
    later = study.sweep(case, {"title": ["d"]}, stage="pounding", out=tmp_path / "s")
    assert len(calls) == 1 and later.table.results.iloc[0].equals(found.iloc[0])


@pytest.mark.parametrize(
    ("error", "told"),
    [(SolutionError("two\nlines"), "two; lines"), (ZeroDivisionError("x"), "ZeroDivisionError: x")],
)
def test_a_variant_that_fails_is_named(
    case: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    error: Exception,
    told: str,
) -> None:
    compute = sticks.run_sticks

    def run_sticks(one, *rest, **named):  # type: ignore[no-untyped-def]
        if one.buildings[0].stiffness_factor == 0.5:
            raise error
        return compute(one, *rest, **named)

    monkeypatch.setattr(sticks, "run_sticks", run_sticks)
    swept = study.sweep(case, FACTORS, stage="pounding", out=tmp_path / "s")
    assert swept.failed == 1
    low, high = rows_of(tmp_path / "s")
    assert low["error"] == told and low[f"{FREQUENCY} [Hz]"] == ""
    assert high["error"] == "" and float(high[f"{FREQUENCY} [Hz]"]) > 0.0
    assert "failed: " in (tmp_path / "s" / "sweep.log").read_text()


def test_an_interrupt_ends_the_sweep(
    case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(sticks, "run_sticks", interrupt)
    with pytest.raises(KeyboardInterrupt):
        study.sweep(case, FACTORS, stage="pounding", out=tmp_path / "s")
    assert not (tmp_path / "s" / "sweep.csv").exists()


@pytest.mark.parametrize(
    ("settings", "options", "expected"),
    [
        (["damping.rato=1", "contacts[0].gap=1:2"], {"stage": "roof"}, "rato.*\n.*gap.*\n.*roof"),
        (["damping.ratio=150 %,3 %"], {}, "ratio = '150 %': expected a number"),
        (
            ["damping.ratio=3 %"],
            {"stage": "building"},
            r"structure: expected a section \[buildings.structure\]",
        ),
        (["damping.ratio=1 %,2 %", "title=a"], {"zipped": True}, "--zip"),
        ([], {}, "one key or more"),
        # The case itself comes first.
        (["damping.rato=1"], {"gap": "2 kg"}, r"small\.toml: contacts\[0\]\.gap = '2 kg'"),
    ],
)
def test_nothing_runs_or_is_written_with_bad_input(
    case: Path,
    tmp_path: Path,
    edited: Callable[..., Path],
    settings: list[str],
    options: dict[str, object],
    expected: str,
) -> None:
    options = dict(options)
    edited(case, ('gap = "2 cm"', f'gap = "{options.pop("gap", "2 cm")}"'))
    before = sorted(tmp_path.iterdir())
    with pytest.raises(InputError, match=expected):
        study.sweep(case, settings, out=tmp_path / "s", **options)
    assert sorted(tmp_path.iterdir()) == before


def test_a_folder_of_something_else(case: Path, tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "run.log").touch()
    with pytest.raises(InputError, match="this one holds other files"):
        study.sweep(case, FACTORS, out=tmp_path / "run")
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / "sweep.log").touch()
    with pytest.raises(InputError, match="this one holds other files"):
        study.run(case, out=tmp_path / "s")


def test_a_result_that_is_not_there(
    case: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    names = [FREQUENCY.replace("west", "wst"), "xyz*"]
    swept = study.sweep(case, FACTORS, stage="pounding", out=tmp_path / "s", show=names)
    assert swept.shown == ()
    assert f"no result is called {names[0]}; did you mean '{FREQUENCY}'?" in caplog.text
    assert "no result is called xyz*" in caplog.text


def assert_same_tables(one: Path, other: Path) -> None:
    """They differ by rounding alone."""
    found, expected = (pd.read_csv(f / "sweep.csv").select_dtypes("number") for f in (other, one))
    residuals = [name for name in expected if "residual" in name]
    pd.testing.assert_frame_equal(
        found.drop(columns=residuals), expected.drop(columns=residuals), rtol=1e-9, atol=1e-12
    )


def test_processes_give_the_same(case: Path, tmp_path: Path) -> None:
    one = {"buildings[0].stiffness_factor": [0.5]}
    study.sweep(case, one, stage="pounding", out=tmp_path / "one")
    study.sweep(case, one, stage="pounding", out=tmp_path / "two", processes=2)
    assert_same_tables(tmp_path / "one", tmp_path / "two")


@pytest.mark.slow
def test_ranks_give_the_same(
    case: Path, tmp_path: Path, under_mpirun: Callable[..., subprocess.CompletedProcess[str]]
) -> None:
    """With an ensemble in each variant, which has workers of its own in a program of one."""
    with case.open("a", encoding="utf-8") as stream:
        stream.write("\n[ensemble]\nmotions = 2\n")
    study.sweep(case, FACTORS, out=tmp_path / "one")
    program = Path(sys.executable).with_name("impactfem")
    words = ["--set", "buildings[0].stiffness_factor=0.5,2.0", "--out", tmp_path / "ranks"]
    ended = under_mpirun(3, program, "sweep", case, *words)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.count("results: ") == 1
    assert float(rows_of(tmp_path / "one")[0]["ensemble.members [-]"]) == 2.0
    assert_same_tables(tmp_path / "one", tmp_path / "ranks")
    for folder in (tmp_path / "ranks" / "runs").iterdir():
        assert json.loads((folder / "provenance.json").read_text())["ranks"] == 1


def test_a_process_that_is_killed_is_told(
    case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(MODULE, "run_alone", _die)
    swept = study.sweep(case, FACTORS, stage="pounding", out=tmp_path / "s", processes=2)
    assert swept.failed == 2
    assert swept.table.errors.str.startswith("its process ended: ").all()


def _die(*_: object) -> None:
    os._exit(9)
