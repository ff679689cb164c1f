"""The pages of the documentation as data: links, headings, blocks of code."""

import re
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from markdown_it import MarkdownIt
from mdit_py_plugins.anchors import anchors_plugin

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")], key=str)
PARSER = MarkdownIt("commonmark").enable("table").use(anchors_plugin, max_level=6)
SHELL = re.compile(r"(?m)^(\S*/)?(impactfem|mpirun|sbatch|scripts/[a-z-]+|python -m impactfem)\b")
TOML = re.compile(r"""(?m)\A(\[+[\w.]+\]+|[\w.]+ = (["'\[{]|true|false|-?[\d._]+$))""")


@dataclass(frozen=True)
class Block:
    """A block of code on a page, or a command in a line of its text."""

    page: Path
    line: int
    language: str
    text: str

    def __str__(self):
        return f"{self.page.relative_to(self.page.anchor)}, line {self.line}"


def tokens(page):
    """All tokens of a page, those within lines of text included, with the line they are in."""
    line = 0
    for token in PARSER.parse(page.read_text(encoding="utf-8")):
        line = token.map[0] + 1 if token.map else line
        token.meta["line"] = line
        yield token
        for child in token.children or ():
            child.meta["line"] = line
            yield child


def blocks(page):
    """The blocks of code of a page; of one that does not say it the language is guessed."""
    found = []
    for token in tokens(page):
        if token.type in ("fence", "code_block"):
            named = token.info.strip().strip("{}") if token.type == "fence" else ""
            language = named or language_of(token.content)
            found.append(Block(page, token.meta["line"], language, token.content))
    return found


def spans(page):
    """Pieces of code in lines of text that are commands."""
    return [
        Block(page, token.meta["line"], "sh", token.content)
        for token in tokens(page)
        if token.type == "code_inline" and SHELL.match(token.content)
    ]


def language_of(text):
    """Language of a block that does not say it; empty when it is none of those checked."""
    if SHELL.search(text):
        return "sh"
    if re.match(r"(from|import) \w", text):
        return "python"
    return "toml" if TOML.match(text) else ""


def targets(page):
    """Line and target of each link and picture of a page that leads to no other site."""
    found = []
    for token in tokens(page):
        target = token.attrs.get("href" if token.type == "link_open" else "src")
        if token.type in ("link_open", "image") and not re.match(r"[a-z]+:", str(target)):
            found.append((token.meta["line"], unquote(str(target))))
    return found


def anchors(page):
    """What links to headings of a page may end with, as GitHub and MyST make it."""
    return {token.attrs["id"] for token in tokens(page) if token.type == "heading_open"}


def broken(page):
    """Links of a page whose file or heading does not exist, in words."""
    faults, known = [], {}
    for line, target in targets(page):
        name, _, anchor = target.partition("#")
        file = (page.parent / name) if name else page
        if not file.exists():
            faults.append(f"{page.name}, line {line}: there is no {name}")
            continue
        if anchor and file not in known:
            known[file] = anchors(file)
        if anchor and anchor not in known[file]:
            faults.append(f"{page.name}, line {line}: {file.name} has no heading #{anchor}")
    return faults
