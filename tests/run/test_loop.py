"""A run that is killed, one that draws nothing, and what is written of results."""

import json
import math
import multiprocessing
import shutil
import signal
import sys
from dataclasses import replace
from pathlib import Path

import pytest
import xarray as xr

from frame_case import QUICK
from impactfem.case import Published
from impactfem.run import loop
from impactfem.run.loop import run, write_summary
from impactfem.stages.manifest import read_manifest
from impactfem.system.errors import SolutionError
from impactfem.system.files import write_netcdf
from impactfem.system.own_process import OwnProcessError
from impactfem.system.scalar import Scalar, scalars_of, values_of, with_scalars

GEOMETRY = Path(__file__).parents[2] / "geometry"
PROGRAM = Path(sys.executable).parent / "impactfem"


def results(folder, names):
    """Scalars, and the content of stores."""
    stores = {}
    for name in names:
        with xr.open_dataset(folder / name, engine="netcdf4") as store:
            stores[name] = store.load()
    return json.loads((folder / "summary.json").read_text(encoding="utf-8")), stores


def test_results_alone(finished, edited, tmp_path):
    """Nothing is drawn, what was drawn of other results goes, and the next run draws."""
    shutil.copytree(finished.case.parent, tmp_path, dirs_exist_ok=True)
    case, folder = tmp_path / finished.case.name, tmp_path / "other"
    shutil.copytree(finished.folder, folder)

    def drawn():
        return {
            path.relative_to(folder)
            for place in ("figures", "tables", "products")
            for path in (folder / place).iterdir()
        }

    before = drawn()
    assert before and (folder / "report.html").is_file()
    run(case, out=folder, draw=False)  # with nothing to compute it stays as it is
    assert drawn() == before and (folder / "report.html").is_file()
    edited(case, ('gap = "2 cm"', 'gap = "2.5 cm"'))
    other = run(case, out=folder, draw=False)
    assert not other.reused and not drawn() and not (folder / "report.html").exists()
    assert other.key_results != finished.run.key_results
    again = run(case, out=folder)
    assert again.reused == ["pounding"] and drawn() == before
    assert again.scalars == other.scalars and (folder / "report.html").is_file()


def test_drawn_while_others_compute(finished, tmp_path, monkeypatch, caplog):
    """In a process of its own, with the same outcome; an error of it stops the run at its end."""
    monkeypatch.setattr(loop, "LONG", 0.0)
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    apart, own = [], loop.in_own_process
    monkeypatch.setattr(
        loop, "in_own_process", lambda f, name, *a: apart.append(name) or own(f, name, *a)
    )
    found = run(finished.case, out=tmp_path / "run")
    assert apart == ["pounding"] and "pounding: tables and figures" in found.times
    one, other = (read_manifest(of.folder, "pounding") for of in (found, finished))
    assert one.drawn_from == other.drawn_from
    drawn, expected = (
        # Workbooks tell when they were made.
        {name: digest for name, digest in of.drawings.items() if not name.endswith(".xlsx")}
        for of in (one, other)
    )
    assert drawn == expected and one.drawings.keys() == other.drawings.keys()
    caplog.clear()
    assert run(finished.case, out=found.folder).reused == ["pounding"]
    assert "drawn again" not in caplog.text and apart == ["pounding"]

    def fail(*_):
        raise OwnProcessError("no ink")

    monkeypatch.setattr(loop, "in_own_process", fail)
    with pytest.raises(OwnProcessError, match="no ink"):
        run(finished.case, out=tmp_path / "other")
    assert (tmp_path / "other" / "pounding.nc").exists()
    assert not (tmp_path / "other" / "report.html").exists()


@pytest.mark.slow
def test_computed_while_3d_models_are_made(edited, tmp_path, monkeypatch):
    """In a second process, with the same outcome; an error elsewhere ends it at once."""
    for name in ("frame.toml", "frame_floors.csv", "frame.msh"):
        shutil.copy(GEOMETRY / name, tmp_path)
    case, folder = edited(tmp_path / "frame.toml", *QUICK), tmp_path / "run"
    run(case, out=tmp_path / "other", draw=False)
    checked = loop.checked

    def lasting(*arguments, **options):
        found, estimate = checked(*arguments, **options)
        assert [one.name for one in estimate.stages] == ["building", "pounding"]
        stages = (replace(estimate.stages[0], seconds=1000.0), *estimate.stages[1:])
        return found, replace(estimate, stages=stages)

    monkeypatch.setattr(loop, "checked", lasting)
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    here, compute = [], loop._compute

    def failing(stage, *_):
        raise SolutionError(f"no {stage.name}")

    monkeypatch.setattr(loop, "_compute", failing)
    with pytest.raises(SolutionError, match="no building"):
        run(case, out=folder, draw=False)
    for child in multiprocessing.active_children():
        child.join(60.0)
        assert child.exitcode == -signal.SIGTERM

    monkeypatch.setattr(loop, "_compute", lambda one, *a: here.append(one.name) or compute(one, *a))
    found = run(case, out=folder, draw=False)
    assert here == ["building"] and not found.reused
    assert {name.partition(":")[0] for name in found.times} == {"building", "pounding"}
    assert "DEBUG   pounding: stores:" in (folder / "run.log").read_text(encoding="utf-8")
    one, other = (results(tmp_path / of, ["pounding.nc"])[1] for of in ("run", "other"))
    xr.testing.assert_allclose(one["pounding.nc"], other["pounding.nc"], rtol=1e-9)
    assert run(case, out=folder, draw=False).reused == ["building", "pounding"]
    assert here == ["building"]
    # On one core they come one after the other.
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    assert run(case, out=folder, draw=False, fresh=True).reused == []
    assert here == ["building", "building", "pounding"]


def _says(path, words):
    try:
        return path.read_text(encoding="utf-8").startswith(words)
    except FileNotFoundError:
        return False


SCALARS = [
    Scalar("a.b", 1.5, "N", "é"),
    Scalar("none", None, "s"),
    Scalar("nan", math.nan, "s"),
    Scalar("inf", math.inf, "-"),
]


@pytest.mark.parametrize("named", [{}, {"relation": ">", "kind": "fitted"}])
def test_entries(tmp_path, named):
    path = tmp_path / "summary.json"
    theirs = Published(value=2.0, unit="N", source="table 1", **named)
    write_summary(path, SCALARS, {"a.b": theirs, "elsewhere": theirs})
    entries = json.loads(path.read_text(encoding="utf-8"))
    about = {"paper": 2.0, "relation": "=", "kind": "result"} | named
    assert entries[0] == {"name": "a.b", "value": 1.5, "unit": "N", **about, "note": "é"}
    assert [entry["name"] for entry in entries] == ["a.b", "none", "nan", "inf"]
    for key in ("value", *about):
        assert [entry[key] for entry in entries[1:]] == [None] * 3
    write_summary(path, [], {})
    assert json.loads(path.read_text()) == []


def test_scalars_through_a_store(tmp_path):
    store = with_scalars(xr.Dataset({"other": ("time", [1.0])}), SCALARS)
    write_netcdf(tmp_path / "store.nc", with_scalars(store, SCALARS[:3]))
    with xr.open_dataset(tmp_path / "store.nc", engine="netcdf4") as found:
        # What is not a number does not exist.
        assert scalars_of(found) == [*SCALARS[:2], replace(SCALARS[2], value=None)]
        assert found["result_value"].sel(result=SCALARS[0].name) == SCALARS[0].value
        assert values_of(found) == {s.name: s.value for s in SCALARS[:2] if s.value is not None}
    assert scalars_of(with_scalars(store, [])) == []
    with pytest.raises(KeyError, match="result"):
        scalars_of(xr.Dataset())
