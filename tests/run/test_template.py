"""The template of `impactfem new` runs without a failed check, without parts and with all."""

import json

import pytest

from impactfem import study
from impactfem.case.template import PARTS, write_new_case
from impactfem.run import loop

COARSE = (
    ('size = "0.9 m"\n', 'size = "1.5 m"\n'),
    ('damping = ["2 %", "5 %"]\n', 'damping = ["5 %"]\n'),
    ('maximum = "200 Hz", per_decade = 50', 'maximum = "200 Hz", per_decade = 10'),
    ("motions = 100", "motions = 3"),
    ("structure_motions = 20", "structure_motions = 2"),
)
"""Coarser meshes and spectra, fewer motions: what takes most of the time."""
FILES = ("record", "equipment", "contact_search")


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """One folder for all runs: stages that have the same inputs are reused."""
    return tmp_path_factory.mktemp("runs")


def ran(folder, runs, parts):
    path = write_new_case(folder / "new", parts, minimal=True)[0]
    text = path.read_text(encoding="utf-8")
    for old, new in COARSE:
        text = text.replace(old, new)
    varied = '\n[sensitivity]\nparameters = ["gap"]\n' if "transient" in parts else ""
    path.write_text(text + varied, encoding="utf-8")
    run = loop.run(path, out=runs / "run", bar=False)
    checks = json.loads((run.folder / "checks.json").read_text(encoding="utf-8"))
    failed = [f"{one['stage']}: {one['text']}" for one in checks if one["passed"] is False]
    return study.open_run(run.folder), failed


def is_plausible(run):
    """Impacts at ordinary speeds, floors below 2 g, and some amplification."""
    assert run.value("pounding.impacts") >= 1
    assert 0.5e6 < run.value("pounding.peak_force.floor_3") < 3e6  # a pair of 240 t and 192 t
    assert run.value("pounding.required_separation") > 0.02  # the gap
    assert run.value("frs.floor_3.pfa") < 20.0


@pytest.mark.slow(10)
@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(
    "parts",
    [(), FILES, tuple(sorted({*PARTS} - {"steel_frame", "record"}))],
    ids=["none", "files", "all"],
)
def test_no_check_fails(tmp_path, runs, parts):
    run, failed = ran(tmp_path, runs, parts)
    assert failed == []
    if "loads" not in parts:
        is_plausible(run)
