"""What a figure says in words: its caption, and what is seen in it; both stay in its file.

In an SVG they are `<metadata>`, and `<title>` and `<desc>` for screen readers; in a PNG they are
text chunks.
"""

import html
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from PIL import Image

from impactfem.system.errors import ImpactfemError

CAPTION, SEEN = "Description", "Alt"
"""Names of the text chunks of a PNG."""
FEW = 3
"""Panels at most of which each is described; of more, what they have in common."""
_MATHEMATICS = re.compile(r"\$([^$]*)\$")


@dataclass(frozen=True)
class Words:
    """What a figure says in words."""

    caption: str  #: what it shows; mathematics between $
    seen: str  #: axes, curves and the extreme, or what a picture has in it; no mathematics

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


def seen_in(axes: Sequence[Axes]) -> str:
    """What is seen in panels with curves: the axes, how many curves, and the largest value."""
    shown = [one for one in axes if one.figure is not None and one.axison]
    if not shown:
        return ""
    if len(shown) <= FEW:
        return " ".join(_sentence(one, len(shown) > 1) for one in shown)
    named = [name for one in shown if (name := _name(one))]
    largest = max(shown, key=lambda one: abs(_extreme(one)[0]))
    across = f": {', '.join(named)}" if named else ""
    return f"{len(shown)} panels{across}. Largest value in {_sentence(largest, True)}"


def _name(panel: Axes) -> str:
    titles = (panel.get_title(loc) for loc in ("left", "right", "center"))
    return " ".join(spoken(title) for title in titles if title)


def _sentence(panel: Axes, named: bool) -> str:
    """What is seen in a panel."""
    x, y = (spoken(one) for one in (panel.get_xlabel(), panel.get_ylabel()))
    value, place, label, count = _extreme(panel)
    text = f"{_name(panel)} " if named else ""
    text += f"{y} over {x}" if x and y else x or y
    if panel.get_xscale() == "log":
        text += ", logarithmic"
    if not count:
        return f"{text}."
    units = [re.search(r"\[(.*)\]$", one) for one in (x, y)]
    of_x, of_y = (f" {unit[1]}" if unit and unit[1] not in ("", "-") else "" for unit in units)
    text += f", {count} curve{'s' if count > 1 else ''}; "
    text += f"the largest value is {value:.4g}{of_y} at {place:.4g}{of_x}"
    text += f" ({spoken(label)})" if label and count > 1 else ""
    for line in panel.get_lines():
        known = str(line.get_label())
        if not known.startswith("published"):
            continue
        text += f"; {spoken(known)}"
        across, own = (np.asarray(one, dtype=float) for one in line.get_data())
        if own.size == 1:
            text += f" {own.item():.4g}{of_y} at {across.item():.4g}{of_x}"
        elif line.get_marker() == "|":  # a range
            text += f" from {across[0]:.4g} to {across[-1]:.4g}{of_x}"
    return f"{text}."


def _extreme(panel: Axes) -> tuple[float, float, str, int]:
    """The value of largest size of the curves, where, of which curve, and how many there are."""
    found: list[tuple[float, float, str]] = []
    for line in panel.get_lines():
        x, y = (np.asarray(one, dtype=float) for one in line.get_data())
        # Not what goes across the panel, nor points alone, nor straight lines.
        in_data = all(line.get_transform().contains_branch_seperately(panel.transData))
        if x.size < 3 or line.get_linestyle() == "None" or not in_data or np.isnan(y).all():
            continue
        k = int(np.nanargmax(np.abs(y)))
        label = str(line.get_label())
        found.append((float(y[k]), float(x[k]), "" if label.startswith("_") else label))
    largest = max(found, key=lambda one: abs(one[0]), default=(0.0, 0.0, ""))
    return (*largest, len(found))
