"""The gallery lists every shipped case with a small thumbnail."""

import re

import pytest
from PIL import Image

from docs._ext.gallery import PICTURES, WIDTH, case_files

from .pages import ROOT

PAGE = ROOT / "docs" / "gallery.md"
ROW = re.compile(
    r"^\| !\[[^]]+\]\(figures/gallery/(\w+)\.png\) \| `impactfem (?:run|fit) geometry/(\w+)"
)
LARGEST = 60_000
"""Largest size of a thumbnail [bytes]."""


def listed(text):
    """The thumbnail and the case of each row."""
    return [match.groups() for line in text.splitlines() if (match := ROW.match(line))]


def missing(text):
    """Shipped cases without a row."""
    return {path.stem for path in case_files()} - {case for _, case in listed(text)}


def test_every_case_has_a_row_with_its_thumbnail():
    text = PAGE.read_text(encoding="utf-8")
    rows = listed(text)
    assert missing(text) == set()
    assert len(rows) == len(set(rows)) == len(case_files())
    assert all(picture == case for picture, case in rows)


@pytest.mark.parametrize("path", case_files(), ids=lambda path: path.stem)
def test_a_thumbnail_is_small(path):
    picture = PICTURES / f"{path.stem}.png"
    assert picture.stat().st_size < LARGEST
    with Image.open(picture) as opened:
        assert opened.width == WIDTH
