"""Links between pages, to files and to headings lead somewhere."""

import ast
import re

import pytest

from impactfem.verify.manual import BENCHMARKS, FULL

from .pages import PAGES, ROOT, anchors, blocks, broken


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    assert broken(page) == []


def test_broken_links_are_found(tmp_path):
    (tmp_path / "other.md").write_text("# One & `two`\n\n## Three\n\n## Three\n", encoding="utf-8")
    page = tmp_path / "page.md"
    page.write_text(
        "[a](other.md) [b](other.md#one--two) [c](other.md#three-1) [d](#here) <https://a.b>\n\n"
        "[e](gone.md)\n\n![f](gone.png)\n\n[g](other.md#four)\n\n[h](#there)\n\n# Here\n",
        encoding="utf-8",
    )
    assert anchors(tmp_path / "other.md") == {"one--two", "three", "three-1"}
    assert broken(page) == [
        "page.md, line 3: there is no gone.md",
        "page.md, line 5: there is no gone.png",
        "page.md, line 7: other.md has no heading #four",
        "page.md, line 9: page.md has no heading #there",
    ]


REQUIREMENTS = ROOT / "docs" / "requirements.md"
NAMED = re.compile(r"`(?:tests/)?([\w/]*test_\w+\.py)(?:::(\w+))?`")
ROW = re.compile(r"(?m)^\| <a [^>]*>(\w\w-\d+)</a> \| .+? \| (.*?) \|$")
BENCHMARK = re.compile(r"\]\(verification\.md#(\w+)\)")


def missing(text):
    """Tests that a text names and that do not exist."""
    for file, name in NAMED.findall(text):
        path = ROOT / "tests" / file
        if not path.is_file():
            yield file
        elif name:
            nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if name not in {node.name for node in nodes if isinstance(node, ast.FunctionDef)}:
                yield f"{file}::{name}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_tests_that_a_page_names_exist(page):
    assert list(missing(page.read_text(encoding="utf-8"))) == []


def test_each_requirement_is_held():
    rows = ROW.findall(REQUIREMENTS.read_text(encoding="utf-8"))
    numbers = [number for number, _ in rows]
    assert len(rows) > 40 and len(set(numbers)) == len(numbers)
    for number, held in rows:
        assert NAMED.search(held) or BENCHMARK.search(held), number


def test_each_benchmark_holds_a_requirement():
    named = BENCHMARK.findall(REQUIREMENTS.read_text(encoding="utf-8"))
    assert set(named) == {*BENCHMARKS, *FULL}


def test_each_page_of_a_benchmark_is_whole():
    """Its drawing, its rows of the manual, the errors it must see, the command."""
    folder = ROOT / "docs" / "benchmarks"
    pages = [page for page in folder.glob("*.md") if page.stem != "index"]
    drawings = {path.stem.removesuffix("_convergence") for path in folder.glob("*.svg")}
    assert len(pages) >= 10 and drawings == {page.stem for page in pages}
    manual = (ROOT / "docs" / "verification.md").read_text(encoding="utf-8")
    for page in pages:
        text = page.read_text(encoding="utf-8")
        (include,) = (b.text for b in blocks(page) if b.language == "include} ../verification.md")
        assert f"### `{page.stem}`" in include and f"### `{page.stem}`" in manual
        seen = text[text.index("## Detected errors") :]
        assert NAMED.search(seen) and f"impactfem verify --only {page.stem}`" in seen
