"""Links between pages, to files and to headings lead somewhere."""

import pytest

from .pages import PAGES, ROOT, anchors, broken, targets


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    assert broken(page) == []


def test_there_are_links():
    assert len({target for page in PAGES for _, target in targets(page)}) > 20


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
