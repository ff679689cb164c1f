"""The documentation stays short: words in all and on a page."""

import re

import pytest

from .pages import ROOT

PAGES = sorted((ROOT / "docs").rglob("*.md"))
GENERATED = {"case-file.md", "verification.md", "paper-case.md"}
WORD = re.compile(r"[^\W\d_][^\W\d_'’-]+")


def words(text):
    """Number of words of prose and tables; a name in code is one, blocks and addresses none."""
    text = re.sub(r"`[^`\n]+`", " name ", re.sub(r"(?s)```.*?```", " ", text))
    text = re.sub(r"(?s)<!--.*?-->|<[^>]+>", " ", text)
    text = re.sub(r"(?m)^ {4,}.*$", " ", text)
    return len(WORD.findall(re.sub(r"\]\([^)]*\)", "]", text)))


def test_words():
    assert words("two words `a_name.of` [four](more/words.md) 1.5 | <a id='x'>\n    code here") == 4


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_no_hand_written_page_is_long(page):
    if page.name not in GENERATED:
        assert words(page.read_text("utf-8")) <= 2500


def test_all_pages_together():
    assert sum(words(page.read_text("utf-8")) for page in PAGES) <= 75_000
