"""docs/licences.md against the metadata of the packages."""

import re
import tomllib
from importlib.metadata import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]
DEPENDENCIES = [
    Requirement(line).name
    for line in tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
]
FAMILIES = r"AGPL|LGPL|GPL|BSD|MIT|Apache|MPL|Python|PSF"


def families(text):
    """Families of licences named in a text; matplotlib's is Python's."""
    return {"Python" if name == "PSF" else name for name in re.findall(FAMILIES, text)}


def declared(name):
    """The families that the metadata name: the expression, else classifiers, else the text."""
    given = metadata(name)
    classifiers = [c for c in given.get_all("Classifier") or [] if c.startswith("License")]
    expression, text = given.get("License-Expression"), given.get("License")
    return families(expression or " ".join(classifiers) or text or "")


def documented(name, page):
    """The families that the row of a package names."""
    for row in re.findall(r"^\| (.+?) \| (.+?) \|", page, flags=re.MULTILINE):
        if name.lower() in row[0].lower().split(", "):
            return families(row[1])
    return set()


@pytest.mark.parametrize("name", DEPENDENCIES)
def test_each_dependency_has_its_licence(name):
    page = (ROOT / "docs" / "licences.md").read_text()
    assert declared(name) and declared(name) <= documented(name, page)
