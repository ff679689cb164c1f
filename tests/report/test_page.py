"""The report of a run."""

import html
import json
import re
import shutil
from importlib.resources import files

import pytest
from typer.testing import CliRunner

from impactfem import study
from impactfem.cli import app
from impactfem.report.facts import number, quantity
from impactfem.report.page import content_policy, write_report
from impactfem.report.picture import passive
from impactfem.report.run_files import SCENE, SPECTRA
from impactfem.report.sections import TEMPLATES
from impactfem.stages.manifest import file_digest
from impactfem.system.errors import ImpactfemError, InputError

from .page_faults import LEAST, PAIRS, Page, contrast, schemes


@pytest.fixture(scope="module")
def text(finished):
    return (finished.folder / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def test_tags_are_closed_and_it_needs_no_other_file(finished, page):
    assert page.open == [] and page.faults == []
    assert all(one.startswith("data:") for one in page.addresses)
    # Nothing is lacking without the files that it leads to, which are there.
    inside = {link for link in page.links if not link.startswith("#")}
    assert inside and all((finished.folder / link).is_file() for link in inside)


def test_figures_are_numbered_in_their_order(text):
    found = [int(number) for number in re.findall(r"<b>Figure (\d+)\. [^<]+\.</b>", text)]
    assert found == [*range(1, len(found) + 1)] and len(found) > 5


def test_everything_that_the_run_drew_is_in_it(finished, page):
    figures, tables = finished.folder / "figures", finished.folder / "tables"
    drawn = [path for path in figures.iterdir() if path.suffix in (".png", ".svg")]
    assert drawn and {f"{path.suffix[1:]}_{path.stem}" for path in drawn} <= set(page.ids)
    assert {f"csv_{path.stem}" for path in tables.glob("*.csv")} <= set(page.ids)


FAULTS = (
    ('<img src="data:">', "img without alt"),
    ("<svg><title>of it</title></svg>", "svg without its role"),
    ('<svg role="img"><g></g></svg>', "svg without a title"),
    ("<h1>one</h1><h3>three</h3>", "h1 before h3"),
    ('<b id="a"></b><b id="a"></b>', "id a twice"),
    ('<a href="#b">there</a>', "no place b"),
    ("<iframe></iframe>", "iframe without title"),
    ("<video></video>", "video without aria-label"),
    ("<th>name</th>", "th without scope"),
    ('<div tabindex="0"></div>', "in the order of the keyboard without role and label"),
    ("<html></html>", "no language"),
)


@pytest.mark.parametrize(("text", "fault"), FAULTS)
def test_what_a_page_may_lack(text, fault):
    assert Page(text).faults == [fault]


@pytest.mark.parametrize("scheme", ["light", "dark", "paper"])
def test_contrast(scheme):
    css = (files("impactfem.report") / "templates" / "report.css").read_text("utf-8")
    colours = schemes(css)[scheme]
    assert min(contrast(colours[a], colours[b]) for a, b in PAIRS) >= LEAST
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") < LEAST < contrast("#767676", "#ffffff")


def test_checks_are_those_of_the_run(finished, page):
    checks = json.loads((finished.folder / "checks.json").read_text(encoding="utf-8"))
    assert {check["stage"] for check in checks} >= {"pounding"}
    assert {check["quantity"] for check in checks} <= set(page.words)


def test_the_appendix_follows_the_decision_report(text):
    """Each chapter and each figure appears in one part only."""
    decision, appendix = text.split('id="appendix"')
    assert re.findall(r'<section id="(\w+)"', appendix) == []
    chapters = re.findall(r'<section id="(\w+)"', decision)
    order = ["verdict", "elevation", "model", "impacts", "floors", "checks", "limitations"]
    assert [name for name in chapters if name in order] == order
    figures = [set(re.findall(r'<figure id="(\w+)"', part)) for part in (decision, appendix)]
    assert "svg_elevation" in figures[0] and figures[1] and not figures[0] & figures[1]


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


def test_it_is_made_again_from_the_folder_alone(run, tmp_path, text, monkeypatch):
    (run / "report.html").unlink()
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["report", "run"])
    assert result.exit_code == 0 and "report: run/report.html" in result.output
    assert (run / "report.html").read_text(encoding="utf-8") == text


def test_the_overview_of_an_earlier_run_goes(run):
    """This run has no 3D building any more."""
    figures = run / "figures"
    for name in (SCENE, f"{SPECTRA}.png"):
        (figures / name).write_text("of an earlier run")
    study.make_report(run)
    assert not [*figures.glob("*.html"), *figures.glob("*.png")]
    assert f"{SPECTRA}.svg" in {p.name for p in figures.iterdir()}


@pytest.mark.parametrize(
    ("name", "content"),
    [
        *((name, '"words"') for name in ("summary.json", "pounding.stage.json")),
        *((name, None) for name in ("case.json", "forces.csv")),
        ("pounding.nc", "no store"),
    ],
)
def test_a_damaged_or_changed_file_is_named(run, name, content):
    path = run / name
    path.write_text(path.read_text("utf-8") + "\n" if content is None else content, "utf-8")
    with pytest.raises(ImpactfemError, match=re.escape(f"cannot read {path}: ")):
        study.make_report(run)


def test_a_stage_of_another_run_is_refused(run):
    """As a run that was killed after some of its stages leaves it."""
    path = run / "pounding.stage.json"
    manifest = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps(manifest | {"inputs": "other"}), encoding="utf-8")
    with pytest.raises(ImpactfemError, match=r"pounding\.stage\.json: "):
        write_report(run, study.STAGES)


SVG = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">{}</svg>'


@pytest.mark.parametrize(
    "content",
    [
        "<script>alert(1)</script>",
        "<g onload='alert(1)'/>",
        "<g ONLOAD='alert(1)'/>",
        "<a xlink:href='javascript:alert(1)'><path/></a>",
        "<image href='https://example.org/a.png'/>",
        "<image href='data:image/svg+xml,x'/>",
        "<use xlink:href='other.svg#a'/>",
        "<foreignObject><b/></foreignObject>",
        "<style>@import 'a.css'</style>",
        "<path style='fill: url(https://example.org/a)'/>",
        "<x:script xmlns:x='http://www.w3.org/2000/svg'/>",
        "<!--><script>alert(1)</script> -->",
        "<![CDATA[<script>alert(1)</script>]]>",
        "<?xml-stylesheet href='a'?>",
        "<animate attributeName='href' to='javascript:alert(1)'/>",
        "<g>",
    ],
)
def test_a_figure_that_does_more_than_draw_is_refused(tmp_path, content):
    path = tmp_path / "a.svg"
    with pytest.raises(ImpactfemError, match=r"a\.svg: expected an"):
        passive(path, SVG.format(content).encode())
    drawn = "<g><!-- a --><path style='fill: url(#h)'/><use xlink:href='#m'/></g>"
    assert passive(path, SVG.format(drawn).encode()) == SVG.format(drawn.replace("<!-- a -->", ""))


def test_a_foreign_figure_is_not_shown(run):
    """The hashes of its run are those of its content, which anybody can write."""
    figure, manifest = run / "figures" / "case.svg", run / "pounding.stage.json"
    figure.write_text(figure.read_text().replace("</svg>", "<script>alert(1)</script></svg>"))
    made = json.loads(manifest.read_text())
    for listed in (made["files"], made["drawings"]):
        if "figures/case.svg" in listed:
            listed["figures/case.svg"] = file_digest(figure)
    manifest.write_text(json.dumps(made))
    with pytest.raises(ImpactfemError, match=r"case\.svg"):
        study.make_report(run)


def test_the_page_may_run_its_own_scripts_alone(text):
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)
    assert policy and text.index(policy[0]) < text.index("<script>")
    allowed = html.unescape(policy[1])
    assert "default-src 'none'" in allowed and "'unsafe-inline'" not in allowed.partition(";")[0]
    scripts = re.findall(r"<script[^>]*>(.*?)</script>", text, re.S)
    assert scripts and allowed == content_policy(scripts)
    assert content_policy(["a"]) != content_policy(["b"])
    assert all('sandbox="allow-scripts"' in tag for tag in re.findall(r"<iframe[^>]*?srcdoc", text))
    assert 'sandbox="allow-scripts"' in (TEMPLATES / "report.html").read_text("utf-8")


def test_another_run_in_its_folder_is_left_alone(finished, run):
    """Its stages are no part of the run, and its figures stay."""
    inner = shutil.copytree(finished.folder, run / "second")
    path = inner / "pounding.stage.json"
    listed = json.loads(path.read_text(encoding="utf-8"))
    listed["files"] = dict.fromkeys(listed["files"], "another digest")
    path.write_text(json.dumps(listed), encoding="utf-8")
    study.make_report(run)
    assert (inner / "figures" / f"{SPECTRA}.svg").is_file()


def test_a_stage_of_before_may_be_tidied_up(run):
    other = run / "device.stage.json"
    files = {"device.nc": "gone", "tables/device.csv": "gone"}
    other.write_text(json.dumps({"inputs": "old", "seconds": {}, "files": files}))
    write_report(run, study.STAGES)
    (run / "device.nc").write_bytes(b"damaged")
    with pytest.raises(ImpactfemError, match=r"device\.nc: "):
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


REFERENCE = {"title": "A paper", "assumptions": [], "given": []}


def beside_a_paper(run):
    """Put a publication beside a run: a value given, one reproduced, one that differs."""
    case = json.loads((run / "case.json").read_text(encoding="utf-8"))
    names = {"motion.pga": ("scaled", 1.0), "motion.sa_max": ("result", 1.0)}
    names["motion.duration_of_a_paper"] = ("result", 1.0)
    values = [{"name": name, "tolerance": 0.1, "reason": None} for name in names]
    item = {"kind": "figure", "title": "it", "tells": None, "shows": [], "given": False}
    reason = "Ours was scaled to it."
    given = [{"kind": "scaled", "names": ["motion.pga"], "reason": reason}]
    items = [item | {"number": str(k), "values": [v]} for k, v in enumerate(values)]
    case["report"]["reference"] = REFERENCE | {"given": given, "items": items}
    about = {"unit": "m/s2", "relation": "=", "note": ""}
    summary = [
        {"name": name, "value": 1.0, "paper": 1.0 if name != "motion.duration_of_a_paper" else 3.0}
        | about
        | {"kind": kind}
        for name, (kind, _) in names.items()
    ]
    return rewritten(run, case=case, summary=summary)


def test_a_stage_that_this_version_does_not_know(run):
    with pytest.raises(InputError, match="pounding"):
        write_report(run, ())


def test_given_values_are_counted_apart(run):
    words = beside_a_paper(run).words
    # Reproduced, differs, given, and so on.
    rows = [words[k + 1 : k + 20] for k, word in enumerate(words) if word == "figures"]
    found = [[word for word in row if word][:6] for row in rows]
    assert found == [["1", "1", "1", "0", "0", "0"]]
    # A result that differs is in the list of the largest differences and at its figure.
    assert words.count("motion.duration_of_a_paper") == 2
    assert words.count("motion.sa_max") == 1


@pytest.mark.parametrize(
    "signed", [{}, {"author": "A. <b>Ng</b>", "checker": "K. Ito", "revision": '"B"\\ }'}]
)
def test_signatures(run, signed):
    """Names of the case, or empty cells; of a case of before as well."""
    case = json.loads((run / "case.json").read_text(encoding="utf-8"))
    for key in ("author", "checker", "revision"):
        case["report"].pop(key)
    case["report"] |= signed
    page = rewritten(run, case=case)
    assert page.faults == []
    for role in ("author", "checker"):
        where = page.words.index(role.capitalize())
        assert next(w for w in page.words[where + 1 :] if w) == signed.get(
            role, {"author": "Checker", "checker": "Revision"}[role]
        )


def test_input_files(finished, page):
    made = json.loads((finished.folder / "provenance.json").read_text(encoding="utf-8"))
    digests = made["input_files"]
    assert len(digests) == 3 and set(digests) | set(digests.values()) <= set(page.words)


def test_links_between_figures_and_the_publication(run):
    case = json.loads((run / "case.json").read_text(encoding="utf-8"))
    item = {"kind": "figure", "number": "9", "title": "it", "tells": None, "given": False}
    item |= {"shows": ["figures/impact_forces*", "figures/none*"], "values": []}
    case["report"]["reference"] = REFERENCE | {"items": [item]}
    page = rewritten(run, case=case)
    assert {"#figure_9", "#svg_impact_forces"} <= set(page.links) and page.faults == []
    assert any("figures/none" in word for word in page.words)


def test_tables_stay_in_their_files(run):
    """Their place in the page names the file and its number of rows."""
    manifest = run / "pounding.stage.json"
    listed = json.loads(manifest.read_text(encoding="utf-8"))
    path = run / "tables/impacts.csv"
    path.write_text("time [s]\n" + "0.12345\n" * 61, encoding="utf-8")
    listed["drawings"]["tables/impacts.csv"] = file_digest(path)
    manifest.write_text(json.dumps(listed), encoding="utf-8")
    page = Page(write_report(run, study.STAGES).read_text(encoding="utf-8"))
    assert "csv_impacts" in page.ids and "tables/impacts.csv" in page.links
    assert "(61)" in page.words and "0.12345" not in page.words


def test_words_of_the_page(page):
    """Both parts, with what is folded; the paper's case has 8,000 at most."""
    words = " ".join(page.words).split()
    assert sum(any(letter.isalpha() for letter in word) for word in words) < 3000
