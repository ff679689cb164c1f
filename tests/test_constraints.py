"""The tested versions of dependencies: complete, within the bounds of pyproject.toml, and used."""

import sys
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
FILES = sorted(ROOT.glob("constraints/python3.*.txt"))
DEBIAN = {"numpy", "scipy"}
"""Packages that Debian's python3-dolfinx brings; pip takes a newer one where others need it."""


def pinned(path):
    """The version of each package in a file of constraints."""
    lines = path.read_text(encoding="utf-8").splitlines()
    rows = [Requirement(line) for line in lines if not line.startswith("#")]
    assert all(str(row.specifier).startswith("==") for row in rows)
    return {canonicalize_name(row.name): str(row.specifier).removeprefix("==") for row in rows}


def required():
    """What pyproject.toml requires for a run, the tests and the documentation."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    return [Requirement(text) for group in groups for text in group]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_all_dependencies_have_a_tested_version(path):
    versions = pinned(path)
    for requirement in required():
        name = canonicalize_name(requirement.name)
        if name in versions:
            assert requirement.specifier.contains(versions[name]), name
        else:
            assert name in DEBIAN, name


def test_the_environment_has_the_tested_versions():
    """`scripts/bootstrap` has installed them; elsewhere there may be others."""
    path = ROOT / f"constraints/python3.{sys.version_info.minor}.txt"
    if Path(sys.prefix) != ROOT / ".venv" or path not in FILES:
        pytest.skip("not the environment of scripts/bootstrap, or a Python without tested versions")
    versions = pinned(path)
    names = {canonicalize_name(requirement.name) for requirement in required()} & set(versions)
    assert {name: version(name) for name in names} == {name: versions[name] for name in names}
