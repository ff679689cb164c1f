"""The quick start and the tutorials, followed as they are written."""

import subprocess
import sys

import pytest

from impactfem import cli, study

from .pages import ROOT
from .tutorial import Step, edited, follow, steps

DOCS = ROOT / "docs"
TUTORIALS = [page for page in sorted((DOCS / "tutorials").glob("*.md")) if page.stem != "index"]
RUN = ("new", "check", "examples")
"""Commands of the program that are quick enough to be run for each page."""


def reader(monkeypatch, capsys, folder, commands=RUN):
    """A reader in a folder, who runs some commands of the program, and those of the system."""
    monkeypatch.chdir(folder)
    done = []

    def run(words):
        if words[0] != "impactfem":
            subprocess.run(words, cwd=folder, check=True)
        elif words[1] in commands:
            monkeypatch.setattr(sys, "argv", words)
            try:
                cli.main()
            except SystemExit as end:
                assert not end.code, f"{' '.join(words)}: {capsys.readouterr().err}"
            done.append((words[1:], capsys.readouterr()))

    return run, done


@pytest.mark.slow
@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_cases_of_a_tutorial_are_valid(page, tmp_path, monkeypatch, capsys):
    run, done = reader(monkeypatch, capsys, tmp_path)
    follow(page, tmp_path, run)
    checked = {words[1] for words, _ in done if words[0] == "check"}
    written = {step.name for step in steps(page) if step.name.endswith(".toml")}
    assert checked >= written and checked
    lines = [line for _, found in done for line in found.err.splitlines()]
    warnings = [line for line in lines if line.startswith("warning")]
    shown = page.read_text(encoding="utf-8").count("\nwarning: ")
    assert len(warnings) <= shown, "a reader meets a warning that the page does not show"


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(
    ("page", "values"),
    [
        ("quick-start.md", [("pounding.required_separation", "30 mm", 1e3)]),
        (
            "tutorials/sticks.md",
            [
                ("pounding.required_separation", "55.2 mm", 1e3),
                ("pounding.main_impact_band_force", "1.61 MN", 1e-6),
                ("frs.largest", "57.7 m/s²", 1.0),
            ],
        ),
    ],
)
def test_numbers_of_a_page_are_those_of_its_runs(page, values, tmp_path, monkeypatch, capsys):
    run, done = reader(monkeypatch, capsys, tmp_path, ("new", "check", "run"))
    follow(DOCS / page, tmp_path, run)
    (case,) = (words[1] for words, _ in done if words[0] == "run")
    result = study.open_run(tmp_path / "runs" / case.removesuffix(".toml"))
    text = (DOCS / page).read_text(encoding="utf-8")
    for name, shown, factor in values:
        assert factor * result.value(name) == pytest.approx(float(shown.split()[0]), rel=5e-3), name
        assert shown in text


def test_pages_have_steps():
    assert len(TUTORIALS) == 7
    for page in [DOCS / "quick-start.md", *TUTORIALS]:
        kinds = [step.kind for step in steps(page)]
        assert "sh" in kinds and {"file", "edit"} & set(kinds), page.name


def test_steps_of_a_page(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(
        "# Page\n\n```toml\n# a.toml\nb = 1\n```\n\n```toml\n[c]\n```\n\n"
        "```text\n# d.csv: rows.\n1,2\n```\n\n```text\nwarning: a\n```\n\n"
        "```diff\n--- a.toml\n-b = 1\n+b = 2\n```\n\n"
        "```sh\nimpactfem check \\\n  a.toml\n```\n\n```toml\n# a.toml (continued)\n[c]\n```\n",
        encoding="utf-8",
    )
    assert list(steps(page)) == [
        Step("file", "a.toml", "# a.toml\nb = 1\n"),
        Step("file", "d.csv", "# d.csv: rows.\n1,2\n"),
        Step("edit", "a.toml", "-b = 1\n+b = 2\n"),
        Step("sh", "", "impactfem check    a.toml\n"),
        Step("continued", "a.toml", "# a.toml (continued)\n[c]\n"),
    ]
    commands = []
    follow(page, tmp_path, commands.append)
    assert commands == [["impactfem", "check", "a.toml"]]
    text = (tmp_path / "a.toml").read_text(encoding="utf-8")
    assert text == "# a.toml\nb = 2\n\n# a.toml (continued)\n[c]\n"


def test_an_edit_has_one_place():
    text = "a = 1\nb = 2   # first\na = 1\nc = 3\n"
    assert edited(text, "-a = 1\n-c = 3\n+c = 4\n") == "a = 1\nb = 2   # first\nc = 4\n"
    for wrong in ("-a = 1\n", "-b = 2\n-c = 3\n"):
        with pytest.raises(ValueError, match="places"):
            edited(text, wrong)
