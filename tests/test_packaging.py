"""Package, recipes and citation agree; public names have one place and no placeholder."""

import json
import re
import shutil
import subprocess
import tomllib
from datetime import date
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement

from docs._ext.public_names import PublicNames, public_names
from impactfem import __version__

ROOT = Path(__file__).parents[1]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = PYPROJECT["project"]
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
CODEMETA = json.loads((ROOT / "codemeta.json").read_text(encoding="utf-8"))
RECIPE = yaml.safe_load((ROOT / "conda-recipe" / "meta.yaml").read_text(encoding="utf-8"))
ENVIRONMENT = yaml.safe_load((ROOT / "environment.yml").read_text(encoding="utf-8"))
# conda-forge's names of packages that have another one on PyPI.
CONDA = {"gmsh": "python-gmsh", "matplotlib": "matplotlib-base"}
PLACEHOLDER = re.compile(
    r"URL-OF-|\bexample\.(?:org|com|net)\b|<your\b|\bYOUR[-_]|\b(?:OWNER|USER)/|\bghcr\.io/[a-z]"
)
ALLOWED = ("tests/",)
"""Files in which addresses of examples are data of a test."""


def tracked():
    """The text files of the project."""
    if shutil.which("git") is None:
        pytest.skip("git is not installed")
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if listed.returncode != 0:
        pytest.skip("this folder is not a clone")
    for name in filter(None, listed.stdout.split("\0")):
        path = ROOT / name
        if path.is_file() and not name.startswith(ALLOWED):
            try:
                yield name, path.read_text(encoding="utf-8")
            except UnicodeDecodeError:
                continue


def placeholders(text):
    return [found[0] for found in PLACEHOLDER.finditer(text)]


def second_copies(names, files):
    """Files other than those that must hold a public name, and the pages made from it."""
    holders = {"pyproject.toml", "CITATION.cff", "codemeta.json", "README.md", "docs/install.md"}
    values = [value for value in vars(names).values() if value]
    return [name for name, text in files if name not in holders and any(v in text for v in values)]


def test_versions_agree():
    release = re.search(
        r"^## \[([\d.]+)\] - (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M
    )
    assert release is not None
    versions = {
        "package": PROJECT["version"],
        "program": __version__,
        "citation": CITATION["version"],
        "codemeta": CODEMETA["version"],
        "conda": RECIPE["package"]["version"],
        "changelog": release[1],
    }
    assert set(versions.values()) == {PROJECT["version"]}, versions
    assert CITATION["date-released"] == date.fromisoformat(release[2])
    assert CODEMETA["dateModified"] == release[2]


def test_conda_has_all_dependencies():
    wanted = {Requirement(text).name for text in PROJECT["dependencies"]}
    listed = {Requirement(re.split("[ =>]", row)[0]).name for row in ENVIRONMENT["dependencies"]}
    recipe = {row.split()[0] for row in RECIPE["requirements"]["run"]}
    assert {CONDA.get(name, name) for name in wanted} <= recipe
    assert {"python-gmsh" if name == "gmsh" else name for name in wanted} <= listed
    fenicsx = {"fenics-dolfinx", "petsc4py", "slepc4py", "mpi4py", "h5py", "netcdf4"}
    assert fenicsx <= recipe and fenicsx <= listed


def test_there_is_no_placeholder():
    found = {name: placeholders(text) for name, text in tracked()}
    assert {name: words for name, words in found.items() if words} == {}


@pytest.mark.parametrize(
    "text",
    [
        "git clone URL-OF-THIS-REPOSITORY impactfem",
        "https://example.org/impactfem",
        "git clone https://github.com/<your name>/impactfem",
        "docker pull ghcr.io/someone/impactfem",
    ],
)
def test_a_placeholder_is_found(text):
    assert placeholders(text)


def test_public_names_have_one_place():
    names = public_names()
    assert second_copies(names, tracked()) == []
    urls = PROJECT.get("urls", {})
    assert urls.get("Repository", "") == names.repository
    assert urls.get("Documentation", "") == names.documentation
    assert CITATION.get("repository-code", "") == names.repository
    assert CODEMETA.get("codeRepository", "") == names.repository


def test_a_second_copy_is_found():
    names = PublicNames("https://forge.test/impactfem", "", "registry.test/impactfem", "")
    files = [("pyproject.toml", vars(names)["image"]), ("docs/a.md", "registry.test/impactfem:1")]
    assert second_copies(names, files) == ["docs/a.md"]


def test_lines_of_public_names():
    private = PublicNames("", "", "", "")
    assert "clone https" not in private.sources and "container image" in private.note
    assert "docker build" in private.get_image
    public = PublicNames("https://forge.test/i", "https://docs.test", "registry.test/i", "i")
    assert "https://forge.test/i" in public.sources
    assert "docker pull registry.test/i" in public.get_image and public.note == ""


def test_a_missing_name_is_an_error():
    with pytest.raises(TypeError, match="image"):
        public_names({"tool": {"impactfem": {"public": {"repository": ""}}}})
