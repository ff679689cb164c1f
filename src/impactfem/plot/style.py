"""How figures look: one size, one palette, panels lettered as in the paper; and their files.

What is drawn by lines is SVG, whose text is text; fields are PNG.
"""

import html
import io
import re
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.style
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends import backend_agg, backend_svg
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from impactfem.plot.words import CAPTION, SEEN, Words
from impactfem.system.arrays import Array
from impactfem.system.files import atomic

DOTS = 200.0
"""Of a PNG in an inch: enough for print."""
SETTINGS: dict[str, Any] = {
    "font.size": 9.0,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "lines.linewidth": 1.0,
    "legend.fontsize": 8.0,
    "legend.framealpha": 0.9,
    "figure.dpi": DOTS,
    # A third of a point: less than the width of any line.
    "path.simplify_threshold": 0.3,
    "svg.fonttype": "none",
    # The first one sets the widths; a reader without it has one of nearly the same.
    "font.sans-serif": ["DejaVu Sans", "Verdana"],
}
KEPT = 128
"""Colours of a PNG that are kept exactly: white, and those of its fields."""
CURVE = 1000
"""Letters of the tag of a curve of many points."""
_TAG = re.compile(r"<[^>]*>")
_LONG = re.compile(r"\d+\.\d{3,}")
_LINE = re.compile(r"[ML][-\d. ]*(?:L[-\d. ]*)+")
# Okabe and Ito's colours: told apart with any colour vision, and in print.
BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
BUILDINGS = (BLUE, RED, GREEN, ORANGE)
DASHES = ("-", "--", "-.", ":")
"""Of the buildings, with their colours: blue and red are equally dark in print."""
ORDERED: tuple[Any, ...] = (
    *DASHES,
    (0, (8, 2)),
    (0, (8, 2, 2, 2)),
    (0, (4, 1, 1, 1, 1, 1)),
    (0, (1, 4)),
)
"""Of curves in an order, of which neighbours are hardly told apart by their lightness alone."""
HANDLE = 3.0
"""Length of a line in a legend that shows dashes, in sizes of its letters."""


def ordered_colours(count: int) -> list[Any]:
    """Colours of curves in an order, the first one darkest; all of them dark enough for print."""
    return [mpl.colormaps["viridis"](0.78 * k / max(count - 1, 1)) for k in range(count)]


def floor_colours(count: int) -> list[Any]:
    """A colour for each floor from the lowest, dark at the top, where the impacts are."""
    return ordered_colours(count)[::-1]


def ordered_looks(count: int) -> list[dict[str, Any]]:
    """Colour and dashes of curves in an order, as matplotlib takes them."""
    return [
        {"color": colour, "ls": ORDERED[k % len(ORDERED)]}
        for k, colour in enumerate(ordered_colours(count))
    ]


def floor_looks(count: int) -> list[dict[str, Any]]:
    """Colour and dashes for each floor from the lowest; the line of the top one is solid."""
    return ordered_looks(count)[::-1]


class _Plain(LogFormatter):
    """0.5, 2, 30 and not powers of ten, where a short logarithmic axis has such ticks."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        return f"{x:g}" if super().__call__(x, pos) else ""


def own_style(**settings: Any) -> AbstractContextManager[None]:
    """Draw with `SETTINGS`, and otherwise with the defaults: a user's own settings do not count."""
    return mpl.style.context(["default", SETTINGS | settings])


@contextmanager
def sheet(
    path: Path, panels: tuple[int, int], size: tuple[float, float], caption: str, seen: str = ""
) -> Iterator[tuple[Figure, list[Axes]]]:
    """A figure with panels; it is written to `path` with its words when the block ends.

    Args:
        path: An SVG file, for lines, or a PNG file, for fields; its folder is made.
        panels: Rows and columns.
        size: Width and height [inch].
        caption: What it shows; mathematics between $. It is not drawn.
        seen: The text alternative; "" for the first sentence of the caption.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    salt = {"svg.hashsalt": f"{path.stem} {caption}"}  # ids are those of one figure, in every run
    with own_style(**salt):
        # No pyplot: no global state, no display, nothing to close.
        drawn = Figure(figsize=size, layout="constrained")
        grid: Any = drawn.subplots(*panels, squeeze=False)
        axes: list[Axes] = list(grid.flat)
        yield drawn, axes
        for axis in [axis for panel in axes for axis in (panel.xaxis, panel.yaxis)]:
            if axis.get_scale() == "log":
                axis.set_major_formatter("{x:g}")
                axis.set_minor_formatter(_Plain())
        # Laid out once here: savefig would draw everything once more for it.
        drawn.get_layout_engine().execute(drawn)  # type: ignore[union-attr]
        drawn.set_layout_engine("none")
        words = Words(caption, seen)
        words = words if seen else replace(words, seen=words.title)
        with atomic(path) as temporary:
            if path.suffix == ".svg":
                temporary.write_text(_svg(drawn, words), encoding="utf-8")
            else:
                _write_png(drawn, temporary, words)


def _svg(drawn: Figure, words: Words) -> str:
    """The figure as an element that a page can hold: nothing in it names or formats the page."""
    buffer = io.StringIO()
    # savefig would draw twice: once to see what is where, which is known here.
    canvas: Any = backend_svg.FigureCanvasSVG(drawn)
    canvas.print_svg(buffer, metadata={"Date": None})
    text = buffer.getvalue()
    said = "".join(
        f"<{tag}>{html.escape(one, quote=False)}</{tag}>"
        for tag, one in (("title", words.title), ("desc", words.seen), ("metadata", words.caption))
    )
    text = re.sub(r"<metadata>.*?</metadata>", lambda _: said, text, count=1, flags=re.S)
    # Its style would be that of the whole page, as would the names of its groups.
    text = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", text, count=1, flags=re.S)
    text = re.sub(r'<g id="[^"]*"', "<g", text[text.index("<svg") :])
    look = 'role="img" style="stroke-linejoin: round; stroke-linecap: butt"'
    text = text.replace("<svg", f"<svg {look}", 1)
    return re.sub(r">\n\s*<", "><", _TAG.sub(lambda tag: _shorter(tag[0]), text))


def _shorter(tag: str) -> str:
    """A tag with numbers to a hundredth of a point, of a long curve to a tenth."""
    # Lines to points stand one after the other.
    digits = 1 if len(tag) > CURVE else 2
    tag = _LONG.sub(lambda number: f"{float(number[0]):.{digits}f}".rstrip("0").rstrip("."), tag)
    tag = re.sub(r"\s*\n(?=[A-Za-z\"])", "", tag)
    tag = re.sub(r"\b([MLCQ]) ", r"\1", tag)
    return _LINE.sub(lambda line: line[0][0] + line[0][1:].replace("L", " "), tag)


def _write_png(drawn: Figure, path: Path, words: Words) -> None:
    """The figure in 256 colours, however rare: a marker keeps its colour, a scale its ends."""
    canvas: Any = backend_agg.FigureCanvasAgg(drawn)
    canvas.draw()
    image = np.asarray(canvas.buffer_rgba())[..., :3]  # the ground is opaque
    # The most frequent colours, in steps of 4 in 256, which are not seen; then one after the other
    # that which is farthest from all that there are.
    pixels = np.minimum((image.astype(np.int32) + 2) // 4 * 4, 255)
    packed = (pixels @ (1 << np.array([16, 8, 0]))).ravel()
    codes, where, counts = np.unique(packed, return_inverse=True, return_counts=True)
    every = np.stack([codes >> 16, codes >> 8 & 255, codes & 255], axis=-1)
    frequent, palette = np.argsort(-counts), np.zeros((256, 3), dtype=np.int64)
    away, nearest = np.full(len(every), np.inf), np.zeros(len(every), dtype=np.uint8)
    for n in range(min(256, len(every))):
        palette[n] = every[frequent[n] if n < KEPT else away.argmax()]
        distance = ((every - palette[n]) ** 2).sum(axis=1)
        nearest[distance < away] = n
        away = np.minimum(away, distance)
    reduced = Image.fromarray(nearest[where].reshape(pixels.shape[:2]), "P")
    reduced.putpalette(palette.ravel().tolist())
    said = PngInfo()
    said.add_itxt(CAPTION, words.caption)
    said.add_itxt(SEEN, words.seen)
    reduced.save(path, format="png", optimize=True, pnginfo=said, dpi=(DOTS, DOTS))


def letter(axes: Sequence[Axes]) -> None:
    """Letter the panels (a), (b), ..., (z), (aa), ... at their upper left."""
    for index, panel in enumerate(axes):
        ahead, last = divmod(index, 26)
        name = (chr(ord("a") + ahead - 1) if ahead else "") + chr(ord("a") + last)
        panel.set_title(f"({name})", loc="left", fontsize=9.0)


def span(panel: Axes, values: Array) -> None:
    """Let the x-axis span ascending values; a single one keeps its own margins."""
    if values[0] < values[-1]:
        panel.set_xlim(values[0], values[-1])
