"""Files of figures as parts of the page: SVG as it is, pictures and films as data."""

from __future__ import annotations

import base64
import io
import re
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup, escape
from PIL import Image

from impactfem.plot.words import as_html, read_words
from impactfem.system.errors import ImpactfemError

CSS_DOTS = 96.0
"""Pixels of a page in an inch."""
QUALITY = 85
"""Of the pictures in the page, of 100."""
_NAMED = re.compile(r'(\bid="|url\(#|href="#)')
"""Where an SVG names one of its parts."""
_NUMBERED = re.compile(r"(^|<title>|<metadata>)Figure \d+: ")
"""The number in a publication that a case need not have; the page counts its own figures."""


@dataclass(frozen=True)
class Picture:
    """A figure of the page."""

    path: Path
    anchor: str  #: id of its place in the page
    number: int  #: in the order of the page
    markup: Markup  #: the picture itself
    caption: Markup  #: below it

    @property
    def zooms(self) -> bool:
        """Whether the page's script may enlarge it."""
        return self.path.suffix == ".svg"

    @property
    def film(self) -> bool:
        """Whether it moves, and is nothing for paper."""
        return self.path.suffix == ".mp4"


def picture(path: Path, anchor: str, number: int) -> Picture:
    """A file as a figure of the page.

    Raises:
        ImpactfemError: It cannot be read.
    """
    if path.suffix == ".mp4":
        title = path.stem.replace("_", " ")
        markup = Markup('<video controls muted loop playsinline aria-label="{}" src="{}"></video>')
        film = markup.format(f"Film: {title}", data(read(path), "video/mp4"))
        return Picture(path, anchor, number, film, escape(f"Film: {title}."))
    words = read_words(path)
    title = _NUMBERED.sub("", words.title) or path.stem.replace("_", " ")
    if path.suffix == ".svg":
        # Figures of several buildings may be alike, parts of a page have different names.
        drawn = _NAMED.sub(rf"\g<1>p{number}", read(path).decode())
        markup = Markup(_NUMBERED.sub(r"\1", drawn))
    else:
        with Image.open(path) as image:
            dots, packed = image.info.get("dpi", (CSS_DOTS,))[0], io.BytesIO()
            width, height = (round(CSS_DOTS * size / dots) for size in image.size)
            # A third of the PNG, which stays in the folder.
            image.convert("RGB").save(packed, "WEBP", quality=QUALITY)
        markup = Markup('<img loading="lazy" width="{}" height="{}" alt="{}" src="{}">').format(
            width, height, words.seen or title, data(packed.getvalue(), "image/webp")
        )
    caption = Markup(as_html(_NUMBERED.sub("", words.caption) or title))
    return Picture(path, anchor, number, markup, caption)


def data(content: bytes, kind: str) -> str:
    """The content of a file as an address."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def read(path: Path) -> bytes:
    """The bytes of a file.

    Raises:
        ImpactfemError: It cannot be read.
    """
    try:
        return path.read_bytes()
    except OSError as error:
        raise ImpactfemError(f"cannot read {path}: {error.strerror or error}") from error
