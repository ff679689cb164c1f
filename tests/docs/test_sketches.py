"""Sketches of the theory pages and of the case file: complete, shown, and the same each time."""

import re
import sys

import pytest

from .pages import ROOT

FOLDER = ROOT / "docs" / "figures" / "sketches"


@pytest.fixture(scope="module")
def sketches():
    sys.path.insert(0, str(ROOT / "docs" / "_ext"))
    import sketches

    yield sketches
    sys.path.remove(str(ROOT / "docs" / "_ext"))


def shown():
    """Names of the sketches that pages show, with their descriptions."""
    for page in (ROOT / "docs").rglob("*.md"):
        text = page.read_text(encoding="utf-8")
        for words, name in re.findall(r"!\[([^\]]*)\]\([./]*figures/sketches/(\w+)\.svg\)", text):
            yield page, name, words


def test_each_sketch_is_drawn_and_shown(sketches):
    names = {name for _, name, _ in shown()}
    assert names == set(sketches.SKETCHES) == {path.stem for path in FOLDER.glob("*.svg")}
    assert all(len(words) > 20 for _, _, words in shown())


def test_each_theory_page_has_a_sketch():
    pages = {page for page, _, _ in shown()}
    theory = {page for page in (ROOT / "docs" / "theory").glob("*.md") if page.stem != "index"}
    assert len(theory) == 16 and theory <= pages


def test_sketches_do_not_change(sketches, tmp_path):
    one, two = (
        {file.name: file.read_bytes() for file in sketches.write(tmp_path / d)} for d in "ab"
    )
    assert one == two and len(one) == len(sketches.SKETCHES)
    assert b"<dc:date>" not in b"".join(one.values())
