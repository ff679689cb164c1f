"""A run that is killed, one that draws nothing, and what is written of results."""

import json
import math
import multiprocessing
import shutil
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
from impactfem.system.scalar import Scalar, scalars_of, with_scalars

GEOMETRY = Path(__file__).parents[2] / "geometry"
PROGRAM = Path(sys.executable).parent / "impactfem"


def results(folder, names):
    """Scalars, and the content of stores."""
    stores = {}
    for name in names:
        with xr.open_dataset(folder / name, engine="netcdf4") as store:
            stores[name] = store.load()
    return json.loads((folder / "summary.json").read_text(encoding="utf-8")), stores


def test_requested_figures_are_drawn_from_stored_results(finished, edited, tmp_path):
    """A later run adds them without computation, and removes them when they are not requested."""
    shutil.copytree(finished.case.parent, tmp_path, dirs_exist_ok=True)
    case, folder = tmp_path / finished.case.name, tmp_path / "other"
    shutil.copytree(finished.folder, folder)
    text = case.read_text(encoding="utf-8")
    assert not (folder / "figures" / "damping.svg").exists()
    for figures, drawn in (('["damping"]', True), ('["all"]', True), ("[]", False)):
        case.write_text(f"{text}\n[report]\nfigures = {figures}\n", encoding="utf-8")
        assert run(case, out=folder).reused == ["pounding"]
        assert (folder / "figures" / "damping.svg").exists() == drawn
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "Peak floor accelerations, impacts and equipment" in page


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
    edited(case, ('gap = "2 cm"', 'gap = "2.5 cm"'), ("title = ", 'allow = ["gap"]\ntitle = '))
    other = run(case, out=folder, draw=False)
    assert not other.reused and not drawn() and not (folder / "report.html").exists()
    assert other.console_lines()[-1] == f"results: {folder}"
    assert other.console_lines()[1] != finished.run.console_lines()[1]  # the gap
    again = run(case, out=folder)
    assert again.reused == ["pounding"] and drawn() == before
    assert again.scalars == other.scalars and (folder / "report.html").is_file()


@pytest.fixture
def two_cores(monkeypatch):
    """A second process in a run of any length."""
    monkeypatch.setattr(loop, "LONG", 0.0)
    monkeypatch.setenv("OMP_NUM_THREADS", "2")


def test_drawn_in_a_second_process(finished, tmp_path, two_cores, monkeypatch):
    """The drawings are those of one process; an error of them stops the run at its end."""
    found = run(finished.case, out=tmp_path / "run")
    assert "pounding: tables and figures" in found.times
    one, other = (read_manifest(of.folder, "pounding") for of in (found, finished))
    assert one.drawn_from == other.drawn_from and one.drawings.keys() == other.drawings.keys()
    assert run(finished.case, out=found.folder).reused == ["pounding"]
    assert read_manifest(found.folder, "pounding") == one
    monkeypatch.setattr(loop, "_draw_named", _fail)
    (found.folder / "pounding.stage.json").unlink()
    with pytest.raises(SolutionError, match="no ink"):
        run(finished.case, out=found.folder)
    assert (found.folder / "pounding.nc").exists()


def _fail(*_, **__):
    raise SolutionError("no ink")


@pytest.mark.slow
def test_computed_while_3d_models_are_computed(edited, tmp_path, two_cores, monkeypatch):
    """In a second process; an error elsewhere ends the process at once."""
    for name in ("frame.toml", "frame_floors.csv", "frame.msh"):
        shutil.copy(GEOMETRY / name, tmp_path)
    case, folder = edited(tmp_path / "frame.toml", *QUICK), tmp_path / "run"
    checked = loop.checked

    def lasting(*arguments, **options):
        found, estimate = checked(*arguments, **options)
        assert [one.name for one in estimate.stages] == ["building", "pounding"]
        stages = (replace(estimate.stages[0], seconds=1000.0), *estimate.stages[1:])
        return found, replace(estimate, stages=stages)

    monkeypatch.setattr(loop, "checked", lasting)
    here, compute = [], loop._compute

    def failing(stage, *_):
        raise SolutionError(f"no {stage.name}")

    monkeypatch.setattr(loop, "_compute", failing)
    with pytest.raises(SolutionError, match="no building"):
        run(case, out=folder, draw=False)
    for process in multiprocessing.active_children():
        process.join(60)
    assert not multiprocessing.active_children()
    monkeypatch.setattr(loop, "_compute", lambda one, *a: here.append(one.name) or compute(one, *a))
    found = run(case, out=folder, draw=False)
    assert here == ["building"] and not found.reused
    assert {name.partition(":")[0] for name in found.times} == {"building", "pounding"}
    assert "DEBUG   pounding: stores:" in (folder / "run.log").read_text(encoding="utf-8")
    assert run(case, out=folder, draw=False).reused == ["building", "pounding"]


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


def test_details_are_listed_if_they_are_published(tmp_path):
    path = tmp_path / "summary.json"
    theirs = Published(value=2.0, unit="N", source="table 1")
    details = [Scalar(name, 1.0, "N", detail=True) for name in ("a", "b")]
    write_summary(path, details, {"b": theirs})
    assert [entry["name"] for entry in json.loads(path.read_text())] == ["b"]


def test_scalars_through_a_store(tmp_path):
    store = with_scalars(xr.Dataset({"other": ("time", [1.0])}), SCALARS)
    write_netcdf(tmp_path / "store.nc", with_scalars(store, SCALARS[:3]))
    with xr.open_dataset(tmp_path / "store.nc", engine="netcdf4") as found:
        # What is not a number does not exist.
        assert scalars_of(found) == [*SCALARS[:2], replace(SCALARS[2], value=None)]
        assert found["result_value"].sel(result=SCALARS[0].name) == SCALARS[0].value
    assert scalars_of(with_scalars(store, [])) == []
    with pytest.raises(KeyError, match="result"):
        scalars_of(xr.Dataset())
