"""A figure of the page."""

import base64
import io
import re
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from markupsafe import Markup
from PIL import Image

from impactfem.plot.words import as_html, read_words
from impactfem.system.errors import ImpactfemError

CSS_DOTS = 96.0
"""Pixels of a page in an inch."""
QUALITY = 85
"""Of the pictures in the page, of 100."""
_NAMED = re.compile(r'(\bid="|url\(#|href="#)')
"""Where an SVG names one of its parts."""
ELEMENTS = frozenset(
    {
        "circle",
        "clipPath",
        "defs",
        "desc",
        "ellipse",
        "g",
        "image",
        "line",
        "linearGradient",
        "marker",
        "metadata",
        "path",
        "pattern",
        "polygon",
        "polyline",
        "radialGradient",
        "rect",
        "stop",
        "svg",
        "symbol",
        "text",
        "title",
        "tspan",
        "use",
    }
)
"""Elements of an SVG that draw or describe; others, as a script, have no place in a figure."""
_COMMENT = re.compile(r"<!-- (?:(?!--|>).)* -->", re.S)
_OUTSIDE = re.compile(r"url\(\s*[\"']?(?!#)|@import|expression\(", re.I)


@dataclass(frozen=True)
class Picture:
    """A figure of the page."""

    path: Path
    anchor: str  #: id of its place in the page
    number: int  #: in the order of the page
    title: str  #: its heading
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


def picture(path: Path, title: str, anchor: str, number: int) -> Picture:
    """A file as a figure of the page; ImpactfemError where it cannot be read."""
    if path.suffix == ".mp4":
        markup = Markup('<video controls muted loop playsinline aria-label="{}" src="{}"></video>')
        film = markup.format(title, data(read(path), "video/mp4"))
        return Picture(path, anchor, number, title, film, Markup())
    words = read_words(path)
    if path.suffix == ".svg":
        # Figures of several buildings may be alike, parts of a page have different names.
        markup = Markup(_NAMED.sub(rf"\g<1>p{number}", passive(path, read(path))))
    else:
        with Image.open(path) as image:
            dots, packed = image.info.get("dpi", (CSS_DOTS,))[0], io.BytesIO()
            width, height = (round(CSS_DOTS * size / dots) for size in image.size)
            # A third of the PNG, which stays in the folder.
            image.convert("RGB").save(packed, "WEBP", quality=QUALITY)
        markup = Markup('<img loading="lazy" width="{}" height="{}" alt="{}" src="{}">').format(
            width, height, words.seen or title, data(packed.getvalue(), "image/webp")
        )
    return Picture(path, anchor, number, title, markup, Markup(as_html(words.caption)))


def passive(path: Path, content: bytes) -> str:
    """Return the text of an SVG that only draws, without comments.

    The folder may come from somebody else. ImpactfemError where the file is no SVG, or would run
    or load something.
    """
    try:
        text = _COMMENT.sub("", content.decode())
        if "<!" in text or "<?" in text:  # HTML reads them in another way than XML
            raise ValueError("a declaration")
        for element in ElementTree.fromstring(text).iter():
            name = element.tag.rpartition("}")[2]
            if name not in ELEMENTS:
                raise ValueError(f"<{name}>")
            own = "data:image/png;" if name == "image" else "#"
            for attribute, value in element.attrib.items():
                kind = attribute.rpartition("}")[2].lower()
                outside = kind in ("href", "src") and not value.startswith(own)
                if kind.startswith("on") or outside or _OUTSIDE.search(value):
                    raise ValueError(f"{kind} of <{name}>")
    except (ValueError, ElementTree.ParseError) as error:
        raise ImpactfemError(
            f"cannot show {path}: expected an SVG that only draws, not {error}; "
            "'impactfem run' draws it again"
        ) from error
    return text


def data(content: bytes, kind: str) -> str:
    """The content of a file as an address."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def read(path: Path) -> bytes:
    """The bytes of a file; ImpactfemError where it cannot be read."""
    try:
        return path.read_bytes()
    except OSError as error:
        raise ImpactfemError(f"cannot read {path}: {error.strerror or error}") from error
