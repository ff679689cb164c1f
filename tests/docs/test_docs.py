"""The documentation is built without a warning, and opens without a network."""

import json
import re
import shutil
import subprocess
import sys
import tomllib

import pytest
import yaml

from .pages import ROOT

DOCS = ROOT / "docs"
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def sphinx(source, target):
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
    return subprocess.run(
        [*command, "-d", str(target) + ".doctrees", str(source), str(target)],
        capture_output=True,
        text=True,
    )


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    target = tmp_path_factory.mktemp("built") / "html"
    done = sphinx(DOCS, target)
    assert done.stderr == "" and done.returncode == 0
    return target


@pytest.mark.slow(10)
def test_every_page_is_built(built):
    pages = {p.relative_to(DOCS).with_suffix("") for p in DOCS.rglob("*.md")}
    assert {p.relative_to(built).with_suffix("") for p in built.rglob("*.html")} >= pages
    menu = (built / "index.html").read_text(encoding="utf-8")
    assert all(f'href="{page.as_posix()}.html"' in menu for page in pages if page.name != "index")


@pytest.mark.slow
def test_pages_open_without_a_network(built):
    for page in built.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert not re.search(r'<(script|img|link)[^>]*(src|href)="(https?:)?//', text), page
    contact = (built / "theory" / "contact.html").read_text(encoding="utf-8")
    assert contact.count("<math") > 20


@pytest.mark.slow
def test_docstrings_and_equations_arrive(built):
    sticks = (built / "api" / "sticks.html").read_text(encoding="utf-8")
    assert "impactfem.coupling.march.march" in sticks
    assert "M̂ a₁ = f₁ + Γᵀ F₁ - C v* - K u*,    M̂ = M + h C + h² K." in sticks
    assert "`" not in re.sub(r"<script.*?</script>", "", sticks, flags=re.DOTALL)


def small(folder, text):
    """A page with the settings of the documentation, built."""
    source = folder / "docs"
    shutil.copytree(DOCS / "_ext", source / "_ext")
    shutil.copytree(DOCS / "_static", source / "_static")
    shutil.copy(DOCS / "conf.py", source)
    known = "```{py:function} impactfem.study.run\n```\n"
    (source / "index.md").write_text(f"# Title\n\n{text}\n\n{known}", encoding="utf-8")
    return sphinx(source, folder / "html")


def test_what_is_wrong_on_a_page_is_told(tmp_path):
    wrong = "[a](gone.md) {py:func}`impactfem.study.runn` $\\nonsense$\n\n```{toctree}\nlost\n```"
    done = small(tmp_path, wrong)
    assert done.returncode != 0
    for word in ("gone.md", "impactfem.study.runn", "nonsense", "lost"):
        assert re.search(rf"WARNING: .*{word}", done.stderr), word


def test_citation():
    page = (DOCS / "cite.md").read_text(encoding="utf-8")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (paper,) = CITATION["references"]
    codemeta = json.loads((ROOT / "codemeta.json").read_text(encoding="utf-8"))
    assert CITATION["version"] == codemeta["version"] == project["version"]
    assert codemeta["referencePublication"]["name"] == paper["title"]
    assert f"version = {{{project['version']}}}" in page
    for value in (CITATION["title"], CITATION["authors"][0]["name"], paper["title"], paper["doi"]):
        assert value in page
    for key in ("journal", "volume", "start", "year"):
        assert f"{{{paper[key]}}}" in page
    names = [f"{author['family-names']}, {author['given-names']}" for author in paper["authors"]]
    assert " and ".join(names) in page
