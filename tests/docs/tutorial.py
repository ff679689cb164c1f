"""The files, edits and commands of a tutorial, in the order of its page."""

import re
import shlex
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from .pages import blocks

NAMED = re.compile(r"# ([\w.-]+\.(?:toml|csv))(?: \(continued\))?[:\n]")


@dataclass(frozen=True)
class Step:
    """A file to write or to go on with, an edit of a file, or lines of shell."""

    kind: str  # "file", "continued", "edit" or "sh"
    name: str
    text: str


def steps(page: Path) -> Iterator[Step]:
    """What a reader of the page does, from top to bottom; other blocks are output."""
    for block in blocks(page):
        named = NAMED.match(block.text)
        if block.language == "diff":
            head, _, text = block.text.partition("\n")
            yield Step("edit", head.removeprefix("--- "), text)
        elif block.language == "sh":
            yield Step("sh", "", block.text.replace("\\\n", " "))
        elif named and block.language in ("toml", "text"):
            continued = "(continued)" in block.text.partition("\n")[0]
            yield Step("continued" if continued else "file", named[1], block.text)


def edited(text: str, diff: str) -> str:
    """A text in which lines of a diff that begin with a minus are those that follow with a plus.

    Such a line is the beginning of a line of the text, which may go on with a comment. Lines that
    follow each other in the diff follow each other at one place of the text.
    """
    lines = text.splitlines()
    for part in re.findall(r"(?:^-.*\n)+(?:^\+.*\n)*", diff, flags=re.MULTILINE):
        old = [line[1:] for line in part.splitlines() if line[0] == "-"]
        new = [line[1:] for line in part.splitlines() if line[0] == "+"]
        places = [
            first
            for first in range(len(lines) - len(old) + 1)
            if all(lines[first + k].startswith(was) for k, was in enumerate(old))
        ]
        if len(places) != 1:
            raise ValueError(f"{len(places)} places of the file have the lines from {old[0]!r} on")
        lines[places[0] : places[0] + len(old)] = new
    return "\n".join(lines) + "\n"


def follow(page: Path, folder: Path, command: Callable[[list[str]], None]) -> None:
    """Do in a folder what a page says; its commands are passed on by word."""
    for step in steps(page):
        file = folder / step.name
        if step.kind == "file":
            file.write_text(step.text, encoding="utf-8")
        elif step.kind == "continued":
            with file.open("a", encoding="utf-8") as stream:
                stream.write("\n" + step.text)
        elif step.kind == "edit":
            file.write_text(edited(file.read_text(encoding="utf-8"), step.text), encoding="utf-8")
        else:
            for line in step.text.splitlines():
                if words := shlex.split(line, comments=True):
                    command(words)
