"""The pages of docs/notebooks are those of the notebooks, with small pictures."""

import jupytext
import pytest

from .pages import ROOT, blocks

NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.py"))
PAGES = ROOT / "docs" / "notebooks"
LARGEST = 150_000
"""Largest size of a picture [bytes]."""


def page_of(path):
    return PAGES / f"{path.stem}.md"


def differences(notebook, page):
    """Cells that the page lacks, or blocks of code that the notebook lacks."""
    text = page.read_text(encoding="utf-8")
    code = [block.text.strip() for block in blocks(page) if block.language == "python"]
    cells = [cell.source.strip() for cell in notebook.cells if cell.cell_type == "code"]
    words = [cell.source.strip() for cell in notebook.cells if cell.cell_type == "markdown"]
    found = [f"order: {a!r}" for a, b in zip(cells, code, strict=False) if a != b]
    return (
        found
        + [f"missing: {a!r}" for a in cells[len(code) :]]
        + [f"too much: {a!r}" for a in code[len(cells) :]]
        + [f"missing: {a!r}" for a in words if a not in text]
    )


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_page_has_the_cells_of_its_notebook(path):
    assert differences(jupytext.read(path, fmt="py:percent"), page_of(path)) == []


def test_every_page_is_that_of_a_notebook_and_in_the_list():
    pages = {path.stem for path in PAGES.glob("*.md")} - {"index"}
    assert pages == {path.stem for path in NOTEBOOKS}
    listed = (PAGES / "index.md").read_text(encoding="utf-8")
    for name in pages:
        assert f"]({name}.md)" in listed and f"({name}_thumbnail.png)" in listed


def test_pictures_are_small_and_used():
    texts = "".join(page.read_text(encoding="utf-8") for page in PAGES.glob("*.md"))
    pictures = sorted(PAGES.glob("*.png"))
    assert len(pictures) > len(NOTEBOOKS)
    assert [path.name for path in pictures if path.stat().st_size > LARGEST] == []
    assert [path.name for path in pictures if path.name not in texts] == []
