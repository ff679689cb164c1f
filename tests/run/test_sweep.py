"""A case over values of its keys, run into one table."""

import csv
import json
import os
import shutil
import sys

import pandas as pd
import pytest

from impactfem import study
from impactfem.run import loop
from impactfem.stages.pounding import stage as sticks
from impactfem.system.errors import InputError, SolutionError
from no_pictures import no_pictures

MODULE = sys.modules["impactfem.run.sweep"]  # its function has the same name
FACTORS = {"buildings[0].stiffness_factor": [0.5, 2.0]}
FREQUENCY = "sticks.west.frequency.1"


@pytest.fixture
def case(new_case, tmp_path, no_figures):
    return new_case(tmp_path)


@pytest.fixture(scope="module")
def swept(new_case, tmp_path_factory):
    """A sweep over two factors in `s` beside its case, not to be changed."""
    folder = tmp_path_factory.mktemp("swept")
    with pytest.MonkeyPatch.context() as patch:
        no_pictures(patch)
        return study.sweep(new_case(folder), FACTORS, stage="pounding", out=folder / "s")


@pytest.fixture
def again(swept, tmp_path):
    """A copy of that sweep and its case."""
    shutil.copytree(swept.folder.parent, tmp_path, dirs_exist_ok=True)
    return tmp_path / "small.toml"


def rows_of(folder):
    with (folder / "sweep.csv").open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_a_table_of_all_variants(swept):
    """Stiffness four times as high: every frequency twice as high."""
    folder = swept.folder
    assert swept.failed == 0
    low, high = rows_of(folder)
    column = f"{FREQUENCY} [Hz]"
    assert float(high[column]) == pytest.approx(2.0 * float(low[column]), rel=1e-9)
    assert [row["buildings[0].stiffness_factor [-]"] for row in (low, high)] == ["0.5", "2.0"]
    for row in (low, high):
        summary = folder / "runs" / row["variant"] / "summary.json"
        for entry in json.loads(summary.read_text()):
            cell = row[f"{entry['name']} [{entry['unit']}]"]
            assert cell == ("" if entry["value"] is None else repr(entry["value"]))
    log = (folder / "sweep.log").read_text()
    assert "2 variants" in log and "variant 2 of 2" in log
    assert not list(folder.glob("**/*.part"))


@pytest.mark.usefixtures("no_figures")
def test_a_variant_is_a_case_of_its_own(swept, again, tmp_path):
    results = swept.table.results.iloc[1].dropna()
    path = tmp_path / "s" / "cases" / f"{results.name}.toml"
    alone = loop.run(path, out=tmp_path / "alone", stage="pounding")
    values = {scalar.name: scalar.value for scalar in alone.scalars if scalar.value is not None}
    assert values == results.to_dict()
    folder = tmp_path / "s" / "runs" / results.name
    held = loop.run(path, out=folder, stage="pounding", resume=True)
    assert held.reused == ["pounding"]


@pytest.mark.usefixtures("no_figures")
def test_finished_variants_are_reused(swept, again, tmp_path, monkeypatch):
    monkeypatch.setattr(sticks, "run_sticks", _fail)
    wider = {"buildings[0].stiffness_factor": [0.5, 1.0, 2.0]}
    found = study.sweep(again, wider, stage="pounding", out=tmp_path / "s")
    assert found.failed == 1
    assert found.table.results.iloc[[0, 2]].equals(swept.table.results)
    assert found.table.errors.iloc[1] == "grew without bound"
    assert found.table.results.iloc[1].isna().all()


def _fail(*_, **__):
    raise SolutionError("grew without bound")


def test_a_stage_with_the_same_inputs_is_computed_once(case, tmp_path, monkeypatch):
    """The sticks do not depend on the ensemble."""
    calls = []
    compute = sticks.run_sticks
    monkeypatch.setattr(sticks, "run_sticks", lambda *a, **k: calls.append(1) or compute(*a, **k))
    swept = study.sweep(case, {"title": ["a", "b"]}, stage="pounding", out=tmp_path / "s")
    assert len(calls) == 1 and swept.failed == 0
    found = swept.table.results
    assert (found.nunique() <= 1).all() and len(found) == 2
    # Nor in a later sweep into the same folder, under another name.
    later = study.sweep(case, {"title": ["d"]}, stage="pounding", out=tmp_path / "s")
    assert len(calls) == 1 and later.table.results.iloc[0].equals(found.iloc[0])


def test_variants_that_fail_are_named(case, tmp_path, monkeypatch):
    """By an error of the program's own, and by any other; the one between them has its results."""
    compute = sticks.run_sticks
    errors = {0.5: SolutionError("two\nlines"), 2.0: ZeroDivisionError("x")}

    def run_sticks(one, *rest, **named):
        if one.buildings[0].stiffness_factor in errors:
            raise errors[one.buildings[0].stiffness_factor]
        return compute(one, *rest, **named)

    monkeypatch.setattr(sticks, "run_sticks", run_sticks)
    factors = {"buildings[0].stiffness_factor": [0.5, 1.0, 2.0]}
    swept = study.sweep(case, factors, stage="pounding", out=tmp_path / "s")
    assert swept.failed == 2
    rows = rows_of(tmp_path / "s")
    assert [row["error"] for row in rows] == ["two; lines", "", "ZeroDivisionError: x"]
    low, good, high = (row[f"{FREQUENCY} [Hz]"] for row in rows)
    assert low == high == "" and float(good) > 0.0
    assert "failed: " in (tmp_path / "s" / "sweep.log").read_text()


@pytest.mark.parametrize(
    ("settings", "options", "expected"),
    [
        (["damping.rato=1", "contacts[0].gap=1,1"], {"stage": "roof"}, "gap.*\n.*rato.*\n.*roof"),
        (["damping.ratio=150 %,3 %"], {}, "ratio = '150 %': expected a number"),
        (
            ["damping.ratio=3 %"],
            {"stage": "building"},
            r"structure: expected a section \[buildings.structure\]",
        ),
        ([], {}, "expected a key with its values"),
        # The case itself comes first.
        (["damping.rato=1"], {"gap": "2 kg"}, r"small\.toml: contacts\[0\]\.gap = '2 kg'"),
    ],
)
def test_nothing_runs_or_is_written_with_bad_input(
    case, tmp_path, edited, settings, options, expected
):
    options = dict(options)
    edited(case, ('gap = "2 cm"', f'gap = "{options.pop("gap", "2 cm")}"'))
    before = sorted(tmp_path.iterdir())
    with pytest.raises(InputError, match=expected):
        study.sweep(case, settings, out=tmp_path / "s", **options)
    assert sorted(tmp_path.iterdir()) == before


def test_a_folder_of_something_else(case, tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "run.log").touch()
    with pytest.raises(InputError, match="holds other files"):
        study.sweep(case, FACTORS, out=tmp_path / "run")
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / "sweep.log").touch()
    with pytest.raises(InputError, match="holds other files"):
        loop.run(case, out=tmp_path / "s")


@pytest.mark.usefixtures("no_figures")
def test_results_to_show(again, tmp_path, caplog):
    """Those that are there, and a warning of each name that is not."""
    names = [FREQUENCY.replace("west", "wst"), "xyz*"]
    found = study.sweep(
        again, FACTORS, stage="pounding", out=tmp_path / "s", show=[FREQUENCY, *names]
    )
    assert found.shown == (FREQUENCY,)
    assert f"no result is called {names[0]}; did you mean '{FREQUENCY}'?" in caplog.text
    assert "result is called" in caplog.text


def assert_same_tables(one, other):
    """They differ by rounding alone; the other may have the first variants alone."""
    found, expected = (pd.read_csv(f / "sweep.csv").select_dtypes("number") for f in (other, one))
    expected = expected.head(len(found))
    residuals = [name for name in expected if "residual" in name]
    pd.testing.assert_frame_equal(
        found.drop(columns=residuals), expected.drop(columns=residuals), rtol=1e-9, atol=1e-12
    )


def test_processes_give_the_same(swept, case, tmp_path):
    first = {"buildings[0].stiffness_factor": [0.5]}
    study.sweep(case, first, stage="pounding", out=tmp_path / "two", processes=2)
    assert_same_tables(swept.folder, tmp_path / "two")


def test_a_process_that_is_killed_is_told(case, tmp_path, monkeypatch):
    monkeypatch.setattr(MODULE, "run_variant", _die)
    swept = study.sweep(case, FACTORS, stage="pounding", out=tmp_path / "s", processes=2)
    assert swept.failed == 2
    assert swept.table.errors.str.startswith("its process ended: ").all()


def _die(*_, **__):
    os._exit(9)


def test_an_interrupt_ends_the_sweep(case, tmp_path, monkeypatch):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(sticks, "run_sticks", interrupt)
    with pytest.raises(KeyboardInterrupt):
        study.sweep(case, FACTORS, stage="pounding", out=tmp_path / "s")
    assert not (tmp_path / "s" / "sweep.csv").exists()
