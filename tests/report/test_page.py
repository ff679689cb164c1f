"""The report of a run."""

import json
import re
import shutil
from html.parser import HTMLParser
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from impactfem import study
from impactfem.cli import app
from impactfem.report import overview
from impactfem.report.overview import number, quantity
from impactfem.report.page import assumptions, write_report
from impactfem.report.run_files import FLOWCHART, SCENE
from impactfem.stages.manifest import file_digest
from impactfem.system.errors import ImpactfemError, InputError

VOID = {"meta", "img", "br", "link", "input", "hr", "source"}


class Page(HTMLParser):
    """The tags of a page: what is open, which anchors and addresses it has."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.ids, self.links, self.addresses, self.words = [], [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.ids += [found["id"]] if "id" in found else []
        if tag == "a":
            self.links.append(found["href"])
        self.addresses += [found[k] for k in ("src", "poster") if k in found]
        self.addresses += [found["href"]] if tag == "link" else []
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if self.open[-1] != tag:
            raise ValueError(f"</{tag}> closes <{self.open[-1]}>")
        self.open.pop()

    def handle_data(self, data):
        if not {"script", "style"} & set(self.open):
            self.words.append(data.strip())


@pytest.fixture(scope="module")
def text(finished):
    return (finished.folder / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def test_tags_are_closed_and_it_needs_no_other_file(page):
    assert page.open == []
    assert len(set(page.ids)) == len(page.ids)
    assert {link[1:] for link in page.links if link.startswith("#")} <= set(page.ids)
    assert all(one.startswith("data:") for one in page.addresses)


def test_everything_that_the_run_drew_is_in_it(finished, page):
    drawn = sorted((finished.folder / "figures").glob("*.svg"))
    assert drawn and {f"svg_{path.stem}" for path in drawn} <= set(page.ids)
    tables = sorted((finished.folder / "tables").glob("*.csv"))
    assert tables and {f"csv_{path.stem}" for path in tables} <= set(page.ids)


def test_checks_and_results_are_those_of_the_run(finished, page):
    checks = json.loads((finished.folder / "checks.json").read_text(encoding="utf-8"))
    assert {check["stage"] for check in checks} >= {"pounding"}
    assert {check["text"] for check in checks} <= set(page.words)
    summary = json.loads((finished.folder / "summary.json").read_text(encoding="utf-8"))
    assert {entry["name"] for entry in summary} <= set(page.words)


@pytest.fixture
def run(finished, tmp_path):
    """A copy of the finished run, to be changed."""
    return shutil.copytree(finished.folder, tmp_path / "run")


def rewritten(run, **contents):
    """Put other contents into files of a run, signed as its own; gives the page."""
    made = run / "provenance.json"
    provenance = json.loads(made.read_text(encoding="utf-8"))
    for name, content in contents.items():
        path = run / f"{name}.json"
        path.write_text(json.dumps(content), encoding="utf-8")
        provenance["files"][path.name] = file_digest(path)
    made.write_text(json.dumps(provenance), encoding="utf-8")
    return Page(write_report(run, study.STAGES).read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("checks", "counted"),
    [
        (
            {"energy: met": True, "other": True, "missed": False, "energy: told": None},
            "2 of 3 met (✓). 1 line tells what has no limit (•), with its stage. Not met (!):",
        ),
        (
            {"other": True, "first": None, "second": None},
            "1 of 1 met (✓). 2 lines tell what has no limit (•), with their stages.",
        ),
        ({"other": True}, "1 of 1 met (✓)."),
        ({"missed": False}, "0 of 1 met (✓). Not met (!):"),
    ],
)
def test_what_is_told_is_not_counted_as_met(run, checks, counted):
    listed = [{"stage": "pounding", "good": good, "text": text} for text, good in checks.items()]
    words = rewritten(run, checks=listed).words
    assert [one for one in words if "met (✓)" in one] == [counted]
    mark = {True: "✓", False: "!", None: "•"}
    for text, good in checks.items():
        # On the first page what is missed, and what is met and a key to the rest.
        first = good is False or (good is True and "energy" in text)
        places = [k for k, word in enumerate(words) if word == text]
        assert len(places) == 1 + first
        assert {words[k - 1] for k in places} == {mark[good]}


def test_it_is_made_again_from_the_folder_alone(run, tmp_path, text, monkeypatch):
    (run / "report.html").unlink()
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["report", "run"])
    assert result.exit_code == 0 and "report: run/report.html" in result.output
    assert (run / "report.html").read_text(encoding="utf-8") == text


def test_the_overview_of_an_earlier_run_goes(run):
    """This run has no 3D building any more."""
    figures = run / "figures"
    for name in (FLOWCHART, SCENE):
        (figures / name).write_text("of an earlier run")
    study.make_report(run)
    assert not (figures / SCENE).exists()
    assert (figures / FLOWCHART).read_bytes().startswith(b"<svg")


CHANGED = "it is missing, or not"


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        *((n, c, "") for n in ("summary.json", "case.json") for c in ("{", '"words"')),
        *(("pounding.stage.json", content, "") for content in ("{", '"words"')),
        *((name, None, CHANGED) for name in ("summary.json", "case.json", "forces.csv")),
        ("pounding.nc", "no store", CHANGED),
    ],
)
def test_a_file_that_is_broken_or_changed_is_named(run, name, content, words):
    path = run / name
    path.write_text(path.read_text("utf-8") + "\n" if content is None else content, "utf-8")
    with pytest.raises(ImpactfemError, match=re.escape(f"cannot read {path}: {words}")):
        study.make_report(run)


def test_a_stage_of_another_run_is_refused(run):
    """As a run that was killed after some of its stages leaves it."""
    path = run / "pounding.stage.json"
    manifest = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps(manifest | {"inputs": "other"}), encoding="utf-8")
    with pytest.raises(ImpactfemError, match=r"pounding\.stage\.json: the stage has other inputs"):
        write_report(run, study.STAGES)


def test_another_run_in_its_folder_is_left_alone(finished, run):
    """Its stages are no part of the run, and its figures stay."""
    inner = shutil.copytree(finished.folder, run / "second")
    path = inner / "pounding.stage.json"
    listed = json.loads(path.read_text(encoding="utf-8"))
    listed["files"] = dict.fromkeys(listed["files"], "another digest")
    path.write_text(json.dumps(listed), encoding="utf-8")
    study.make_report(run)
    assert (inner / "figures" / FLOWCHART).is_file()


def test_a_stage_of_before_may_be_tidied_up(run):
    other = run / "device.stage.json"
    files = {"device.nc": "gone", "tables/device.csv": "gone"}
    other.write_text(json.dumps({"inputs": "old", "seconds": {}, "files": files}))
    write_report(run, study.STAGES)
    (run / "device.nc").write_bytes(b"damaged")
    with pytest.raises(ImpactfemError, match=r"cannot read .*device\.nc: it is missing, or not"):
        write_report(run, study.STAGES)


QUANTITIES = (
    (121590782.2, "N", "121.59 MN"),
    (-0.0131, "s", "-13.1 ms"),
    (685364.0, "N s", "685.36 kN s"),
    (0.0, "N", "0 N"),
    (9.7e-12, "m/N", "9.7e-12 m/N"),
    (36.9, "m/s2", "36.9 m/s2"),
    (83.54e9, "N/m", "83.54 GN/m"),
    (0.5, "-", "0.5"),
    (342594.0, "-", "342,594"),
    (None, "N", "–"),
)


def test_numbers_and_quantities():
    assert [quantity(value, unit) for value, unit, _ in QUANTITIES] == [q[2] for q in QUANTITIES]
    values = (None, 0.0, 1234567.0, 12345.6, 1e-4)
    assert [number(x) for x in values] == ["–", "0", "1.235e+06", "12346", "0.0001"]


LAW = {"type": "kelvin-voigt", "stiffness": 1e11, "restitution": None, "damping_ratio": 0.12}
TAKEN = "Restitution and contact stiffness come from one impact of the 3D model"


@pytest.mark.parametrize(
    ("laws", "wall", "taken"),
    [
        ({"beam": LAW, "floor": LAW | {"stiffness": "calibrated"}}, True, True),
        ({"beam": LAW, "floor": LAW | {"restitution": "calibrated"}}, True, True),
        ({"floor": LAW, "corner": {"type": "hertz", "stiffness": 3e11}}, True, False),
        ({"floor": LAW}, False, None),
    ],
)
def test_whether_a_law_takes_values_from_the_wall(laws, wall, taken):
    case = {
        "structure": {"building": "B1"},
        "wall_impact": {"floors": [8]} if wall else None,
        "transient": None,
        "devices": [],
        "contact_laws": laws,
        "report": {"assumptions": [], "reference": None},
    }
    found = "\n".join(one["text"] for _, group in assumptions(case) for one in group)
    unused = "those of the impact on a rigid wall are not used"
    assert (TAKEN in found, unused in found) == (taken is True, taken is False)


def test_the_map_of_the_study_comes_first(finished, text):
    assert (finished.folder / "figures" / "figure_04_flowchart.svg").is_file()
    assert re.findall(r'<figure id="((?:svg|png)_[^"]*)"', text)[0] == "svg_figure_04_flowchart"


def tiles(value=1.759e6, stiffness="calibrated"):
    """Those of a run in which others hit harder than the first building."""
    summary = [
        {"name": "pounding.peak_force.floor_3", "value": 0.5e6, "unit": "N", "note": ""},
        {
            "name": "pounding.main_impact_force",
            "value": value,
            "unit": "N",
            "note": "pair tower.storey_2_at_0.12-annex.floor_1",
        },
        {"name": "calibration.epsilon", "value": 0.467, "unit": "-", "note": ""},
    ]
    laws = {"floor": {"stiffness": stiffness, "restitution": 0.6}, "edge": {"stiffness": 1e10}}
    values = {entry["name"]: entry["value"] for entry in summary}
    run = SimpleNamespace(summary=summary, values=values, case={"contact_laws": laws})
    return overview.tiles(run)


def test_the_force_of_the_first_tile_is_that_of_the_largest_impact():
    words = "largest impact force of the sticks, pair tower.storey 2 at 0.12 and annex.floor 1"
    for value, text in ((1.759e6, "1.759 MN"), (634.2, "634.2 N")):
        assert tiles(value)[0] == (text, words)
    assert not [words for _, words in tiles(None) if "force" in words]


@pytest.mark.parametrize(("stiffness", "used"), [("calibrated", True), (1e11, False)])
def test_whether_the_wall_gives_the_law(stiffness, used):
    (words,) = (words for value, words in tiles(stiffness=stiffness) if value == "0.467")
    assert words.endswith("at a rigid wall" if used else "; not used here, the case gives the law")


def test_the_tile_of_a_device_is_along_the_shown_direction():
    forces = {
        f"device.f{axis}.detailed.impact": v for axis, v in zip("yxz", (3e3, 1.0, 9e3), strict=True)
    }
    run = SimpleNamespace(summary=[], values=forces, case={"contact_laws": {}})
    assert overview.tiles(run) == [("3 kN", "force on the first device's anchor")]


def beside_a_paper(run):
    """Put a publication beside a run: a value given, one reproduced, one that differs."""
    case = json.loads((run / "case.json").read_text(encoding="utf-8"))
    names = {"motion.pga": ("scaled", 1.0), "motion.sa_max": ("result", 1.0)}
    names["motion.duration_of_a_paper"] = ("result", 1.0)
    values = [{"name": name, "tolerance": 0.1, "reason": None} for name in names]
    item = {"kind": "figure", "title": "it", "tells": None, "shows": [], "given": False}
    reason = "Ours was scaled to it."
    case["report"]["reference"] = {
        "title": "A paper",
        "assumptions": [],
        "given": [{"kind": "scaled", "names": ["motion.pga"], "reason": reason}],
        "items": [item | {"number": str(k), "values": [v]} for k, v in enumerate(values)],
    }
    about = {"unit": "m/s2", "relation": "=", "note": ""}
    summary = [
        {"name": name, "value": 1.0, "paper": 1.0 if name != "motion.duration_of_a_paper" else 3.0}
        | about
        | {"kind": kind}
        for name, (kind, _) in names.items()
    ]
    return rewritten(run, case=case, summary=summary)


def test_a_stage_that_this_version_does_not_know(run):
    with pytest.raises(InputError, match="stages that this version does not know: pounding"):
        write_report(run, ())


def test_what_is_given_counts_apart(run, caplog):
    with caplog.at_level("DEBUG", "impactfem"):
        words = beside_a_paper(run).words
    counts = "1 reproduced, 1 differs, 1 given or fitted"
    assert [r.getMessage() for r in caplog.records if "compared" in r.getMessage()] == [
        f"report: compared with the publication, figures: {counts}",
        f"report: compared with the publication, values: {counts}",
    ]
    # On the first page and where the figures are: reproduced, differs, given, and so on.
    rows = [words[k + 1 : k + 20] for k, word in enumerate(words) if word == "figures"]
    found = [[word for word in row if word][:6] for row in rows]
    assert found == [["1", "1", "1", "0", "0", "0"]] * 2
    assert "Ours was scaled to it." in words and "– scaled" in words
    # What differs most stands on the first page, at its figure and among all results.
    assert words.count("motion.duration_of_a_paper") == 3
    assert words.count("motion.sa_max") == 2
