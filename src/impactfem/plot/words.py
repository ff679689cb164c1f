"""The words in the file of a figure: its caption, and its text alternative.

In an SVG they are `<metadata>`, and `<title>` and `<desc>` for screen readers; in a PNG they are
text chunks.
"""

import html
import re
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from impactfem.system.errors import ImpactfemError

CAPTION, SEEN = "Description", "Alt"
"""Names of the text chunks of a PNG."""
_MATHEMATICS = re.compile(r"\$([^$]*)\$")


@dataclass(frozen=True)
class Words:
    """The words of a figure."""

    caption: str  #: mathematics between $
    seen: str  #: the text alternative, without mathematics

    @property
    def title(self) -> str:
        """The first sentence of the caption, without mathematics and letters of panels."""
        first, *_ = re.split(r"\.(?:\s|$)", self.caption, maxsplit=1)
        return spoken(re.sub(r" \([a-z]{1,2}\)", "", first))


def read_words(path: Path) -> Words:
    """The words in a figure's file, SVG or PNG; empty ones where it has none.

    ImpactfemError where it cannot be read.
    """
    try:
        if path.suffix == ".svg":
            text = path.read_text(encoding="utf-8")
            found = (re.search(f"<{tag}>(.*?)</{tag}>", text, re.S) for tag in ("metadata", "desc"))
            caption, seen = (html.unescape(one[1]) if one else "" for one in found)
            return Words(caption, seen)
        with Image.open(path) as image:
            return Words(*(str(image.info.get(key, "")) for key in (CAPTION, SEEN)))
    except (OSError, ValueError) as error:
        raise ImpactfemError(f"cannot read {path}: {error}") from error


def as_html(text: str) -> str:
    """A text with mathematics for matplotlib as HTML: subscripts, and dots for derivatives."""

    def marked(found: re.Match[str]) -> str:
        words = re.sub(r"\\(d+)ot\s*(\w)", lambda m: m[2] + "\u0307\u0308"[len(m[1]) - 1], found[1])
        return re.sub(r"_\{?(\w+)\}?", r"<sub>\1</sub>", words)

    return _MATHEMATICS.sub(marked, html.escape(text, quote=False))


def spoken(text: str) -> str:
    """A text without mathematics: of a unit vector its direction, of other symbols nothing."""
    text = re.sub(r"\$e_\{?(\w+)\}?\$", r"\1", text)
    return re.sub(r"\s*\$[^$]*\$", "", text)
