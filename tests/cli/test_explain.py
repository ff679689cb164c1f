"""`impactfem explain`: keys, results and checks."""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from docs.pages import anchors
from impactfem.explain import CHECKS_PAGE, RESULTS_PAGE, _entries, checks, explain, unit_of
from impactfem.run.stages import STAGES
from impactfem.stages.check import CRITERIA
from impactfem.system.errors import InputError

DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("contacts.gap", ["contacts.gap: key of the case file", "length", "[m]", "required"]),
        ("contacts[0].gap", ["contacts.gap: key of the case file", "#contacts.gap"]),
        ("contact_laws.stiffness", ["kelvin-voigt", "hertz", "N/m^1.5", '"calibrated"']),
        ("contact_laws.floor.stiffness", ["contact_laws.NAME.stiffness: key", "kelvin-voigt"]),
        ("pounding.time_step", ["[pounding]", "[s]", "#pounding.time_step"]),
        ("pounding.update", ["implicit", "lagged", "default"]),
        ("buildings[1].structure.mesh.size", ["buildings.structure.mesh.size: key", "[m]"]),
        ("buildings.floors.mass", ["Floor table (CSV)", "[kg]", "#floor-table.mass"]),
        ("contacts", ["keys", "normal", "gap"]),
        ('free."damping.ratio".bounds', ["key of the fit file", "fit.md"]),
        ("targets[0].deviation", ["key of the fit file"]),
        ("report.reference", ["key of the case file"]),
        ("pounding.peak_force.floor_5", ["result of summary.json", "unit     N", "floor"]),
        ("building.B2.frequency.1", ["result of summary.json", "Hz"]),
        ("device.fy.detailed.no_impact", ["result of summary.json", "unit     N"]),
        ("reduce.transfer_function_error", [": check", "#transfer-function-error"]),
        ("pounding.motion_criteria", ["without limits", "SRP 3.7.1"]),
        ("pounding.steps_per_impact", [": check", "points_per_impact", "#steps-per-impact"]),
        ("B2/pounding.steps_per_impact", [": check"]),
        ("steps-per-impact", [": check"]),
        ("Steps per impact", [": check"]),
        # A result and a check.
        ("calibration.basis_error", [": check", "result of summary.json"]),
    ],
)
def test_entries(program, name, expected):
    ended = program("explain", name)
    assert ended.code == 0 and not [word for word in expected if word not in ended.out]


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("contacts.gapp", "contacts.gap"),
        ("contact_laws.stiffnes", "contact_laws.NAME.stiffness"),
        ("steps-per-impakt", "steps-per-impact"),
        ("poundng.time_step", "pounding.time_step"),
    ],
)
def test_an_unknown_name(program, name, near):
    ended = program("explain", name)
    assert ended.code == 2 and ended.out == "" and ended.err.count("\n") == 1
    assert f"did you mean '{near}'" in ended.err


def test_nothing_near(program):
    ended = program("explain", "qqqq")
    assert ended.code == 2 and "summary.json" in ended.err


def test_with_a_run(program, finished, tmp_path):
    name = "pounding.main_impact_force"
    (entry,) = (
        one
        for one in json.loads((finished.folder / "summary.json").read_text(encoding="utf-8"))
        if one["name"] == name
    )
    ended = program("explain", name, "--run", finished.folder)
    assert ended.code == 0 and f"value    {entry['value']:.6g}" in ended.out
    ended = program("explain", name, "--run", tmp_path)
    assert ended.code == 2 and "--run" in ended.err


def test_every_result_of_a_run_has_a_unit_and_a_description(finished):
    """By the names alone, as without a run."""
    summary = json.loads((finished.folder / "summary.json").read_text(encoding="utf-8"))
    other = [one["name"] for one in summary if unit_of(one["name"]) != one["unit"]]
    assert len(summary) > 30 and not other
    for one in summary:
        text = "\n".join(explain(one["name"]))
        assert "result of summary.json" in text and text.count("\n") >= 3


def test_every_key_is_documented_where_it_says():
    page = (DOCS / "case-file.md").read_text(encoding="utf-8")
    known = set(re.findall(r'id="([^"]+)"', page))
    entries = [one for several in _entries().values() for one in several]
    pages = [one.page.partition("#") for one in entries]
    assert len(entries) > 400
    assert not {anchor for name, _, anchor in pages if name == "case-file.md"} - known
    assert {name for name, _, _ in pages} == {"case-file.md", "fit.md"}


def test_every_check_has_its_section():
    """A heading for each check that can fail, which is its anchor; an invented one has none."""
    assert STAGES  # which declare the checks
    ids = [one.id for one in CRITERIA.values() if one.consequence]
    found, known = checks(), anchors(DOCS / "how-to" / "failed-checks.md")
    names = {one.rpartition(".")[2].replace("_", "-") for one in ids}
    assert len(ids) > 40 and names == set(found) and names <= known
    assert all(10 < len(text.split()) < 90 for _, text in found.values())
    for one in ids:
        assert f"{one}: check" in "\n".join(explain(one))
    with pytest.raises(InputError):
        explain("pounding.roof_lifted")
    assert "roof-lifted" not in known


def test_keys_in_the_sections_exist():
    """Those that a remedy sets, as `time_step = "0.2 ms"`, and sections as `[pounding]`."""
    page = (DOCS / "how-to" / "failed-checks.md").read_text(encoding="utf-8")
    entries = _entries()["case file"]
    keys = {one.path[-1] or one.path[-2] for one in entries}
    tables = {one.table.partition(" ")[0].strip("[]") for one in entries}
    named = re.findall(r"`\[+([\w.]+)\]+`", page)
    assert named and not set(named) - tables
    typed = re.findall(r"`(\w+) = ", page)
    assert typed and not set(typed) - keys


def test_its_pages_are_shipped():
    """A wheel has them below share/impactfem, as the source tree has them."""
    project = tomllib.loads((DOCS.parent / "pyproject.toml").read_text(encoding="utf-8"))
    shipped = project["tool"]["setuptools"]["data-files"]
    for page in (CHECKS_PAGE, RESULTS_PAGE):
        assert page in shipped[f"share/impactfem/{Path(page).parent.as_posix()}"]
    assert "docs/limits.md" not in shipped["share/impactfem/docs"]


def test_it_is_quick(tmp_path):
    """Without finite elements, and without the packages of plots."""
    code = (
        "import sys; sys.argv = ['impactfem', 'explain', 'contacts.gap']\n"
        "from impactfem.cli import main\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        "print({'dolfinx', 'petsc4py', 'matplotlib', 'pyvista'} & {*sys.modules})"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.stdout.splitlines()[-1] == "set()", done.stderr
