"""Words that the style of the project bans, in README, documentation, notebooks and help texts."""

import re

import pytest
import typer.main

from impactfem.cli import app

from .pages import PARSER, ROOT

# Whole words, in any case. A meaning in brackets says which uses are banned.
BANNED = (
    "hardly meant",
    "is meant",
    "meant up to",
    "asked",  # for requested
    "told",
    "tells",
    "tried",  # for tested
    "beside",  # for compared with, together with
    "of its own",
    "as far as",
    "stands for",
    "by hand",  # for closed form
    "past",  # for beyond
    "so it is",
    "what is not",
    "as it is",
    "at work for",
    "end nowhere",
    "drawn aside",
    "taken in its place",
    "go together",
)
PATTERN = re.compile(r"\b(" + "|".join(BANNED).replace(" ", r"\s+") + r")\b", re.IGNORECASE)
QUOTED = re.compile(r"“[^”]*”|«[^»]*»|\"[^\"\n]*\"")
"""Quotations of sources."""

# Pages that still have banned words. The list only shrinks.
WAITING: set[str] = set()


def files():
    """README, the pages of the documentation and the notebooks."""
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    return sorted([*pages, *(ROOT / "notebooks").glob("*.py")], key=str)


def name_of(path):
    return path.relative_to(ROOT).as_posix()


def prose(path):
    """The text of a page without code and block quotations; all of a notebook's comments."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        return "\n".join(re.findall(r"(?m)^\s*#(.*)$", text))
    depth, found = 0, []
    for token in PARSER.parse(text):
        depth += {"blockquote_open": 1, "blockquote_close": -1}.get(token.type, 0)
        if token.type == "inline" and not depth:
            pieces = [c.content if c.type == "text" else " " for c in token.children]
            found.append("".join(pieces))
    return "\n".join(found)


def banned(text):
    """The banned words of a text, quotations aside."""
    return sorted({" ".join(x.split()).lower() for x in PATTERN.findall(QUOTED.sub(" ", text))})


@pytest.mark.parametrize("path", files(), ids=name_of)
def test_page(path):
    if name_of(path) not in WAITING:
        assert not banned(prose(path))


def test_pages_that_wait_still_have_such_words():
    by_name = {name_of(path): path for path in files()}
    mended = [name for name in WAITING if name not in by_name or not banned(prose(by_name[name]))]
    assert not mended, f"take out of WAITING: {sorted(mended)}"


def helps(command, name="impactfem"):
    """The help texts of a command and those below it, by its words."""
    context = command.make_context(name, [], resilient_parsing=True)
    yield name, command.get_help(context)
    for word, inner in getattr(command, "commands", {}).items():
        yield from helps(inner, f"{name} {word}")


@pytest.mark.parametrize(
    ("name", "text"), [pytest.param(*one, id=one[0]) for one in helps(typer.main.get_command(app))]
)
def test_help(name, text):
    assert text.startswith("Usage: ") and not banned(text)


def test_what_is_found(tmp_path):
    """A word of the list in text, also over two lines; not in code, quotations or longer words."""
    page = tmp_path / "page.md"
    for text, found in (
        ("The user is told so.", ["told"]),
        ("Values\nof its\nown.", ["of its own"]),
        ("- Tried, and\n- BESIDE the wall", ["beside", "tried"]),
        ("| a | b |\n|---|---|\n| past 450 Hz | c |", ["past"]),
        ("`told` and\n\n    tells\n", []),
        ("The paper says “the frame is drawn aside”.", []),
        ("> It is told\n", []),
        ("besides, untold pasta", []),
    ):
        page.write_text(text, encoding="utf-8")
        assert banned(prose(page)) == found, text
