"""Docstrings as they are written here, made fit for Sphinx.

They are plain text: `names` between single backticks, and equations as indented blocks, which keep
their layout. In reStructuredText the first would be a reference, and signs such as | and * markup.
"""

from __future__ import annotations

import re

from docutils.nodes import Element
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx

SECTIONS = ("Args:", "Returns:", "Raises:", "Yields:", "Attributes:", "Examples:", "Note:")
LITERAL = re.compile(r"(``[^`]+``|:[a-z:]+:`[^`]+`)")
MARKUP = re.compile(r"[\\|]|(?<!^)\*|(?<=\w)_(?=\W|$)")
NAME = re.compile(r"`([^`]+)`")


def escaped(line: str) -> str:
    """A line with names as literals and everything else as plain text."""
    parts = LITERAL.split(NAME.sub(_literal, _protected(line)))
    for i in range(0, len(parts), 2):
        parts[i] = MARKUP.sub(r"\\\g<0>", parts[i])
    return "".join(parts).replace("\0", "`")


def _protected(line: str) -> str:
    """Roles and literals with their backticks hidden, so that names alone have some."""
    return LITERAL.sub(lambda found: found[0].replace("`", "\0"), line)


def _literal(found: re.Match[str]) -> str:
    return f"\0\0{found[1]}\0\0"


def prepared(lines: list[str]) -> list[str]:
    """A docstring in reStructuredText, its sections as Google writes them.

    Args:
        lines: The docstring, without the indentation of its code.
    """
    result: list[str] = []
    in_section = False
    for paragraph in _paragraphs(lines):
        first = paragraph[0]
        indented = first.startswith(" ")
        in_section = first in SECTIONS or (in_section and indented)
        laid_out = any(line.startswith(" ") for line in paragraph)
        if laid_out and not in_section and not first.startswith(("* ", "- ")):
            result += ["::", "", *(f"    {line}" for line in paragraph), ""]
        else:
            result += [*(escaped(line) for line in paragraph), ""]
    return result


def _paragraphs(lines: list[str]) -> list[list[str]]:
    found: list[list[str]] = [[]]
    for line in lines:
        if line.strip():
            found[-1].append(line)
        elif found[-1]:
            found.append([])
    return [paragraph for paragraph in found if paragraph]


def _prepare(
    app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]
) -> None:
    """Change a docstring in place, before its sections are read."""
    # Napoleon takes what is before a colon in the first line of these for their type.
    comment = ["..", ""] if what in ("attribute", "data", "property") else []
    lines[:] = [*comment, *prepared(lines)]


def _unknown(app: Sphinx, env: object, node: pending_xref, shown: Element) -> Element | None:
    """Show a name that has no page as it is, where a docstring refers to it."""
    return shown if str(node.get("refdoc", "")).startswith("api/") else None


def setup(app: Sphinx) -> dict[str, bool]:
    """Prepare docstrings ahead of napoleon, whose priority is 500; settle their references."""
    app.connect("missing-reference", _unknown)
    app.connect("autodoc-process-docstring", _prepare, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
