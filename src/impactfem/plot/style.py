"""How figures look: one size, one palette, captions below, panels lettered as in the paper."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from impactfem.system.files import atomic

SETTINGS: dict[str, Any] = {
    "font.size": 9.0,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "lines.linewidth": 1.0,
    "legend.fontsize": 8.0,
    "legend.framealpha": 0.9,
    "figure.dpi": 150.0,
    "savefig.dpi": 150.0,
}
# Okabe and Ito's colours: told apart with any colour vision, and in print.
BLUE, ORANGE, GREEN, RED = "#0072B2", "#E69F00", "#009E73", "#D55E00"
BUILDINGS = (BLUE, RED, GREEN, ORANGE)
DASHES = ("-", "--", "-.", ":")
"""Of the buildings, beside their colours: blue and red are equally dark in print; and of curves in
an order, of which neighbours are hardly told apart by their lightness alone."""
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
        {"color": colour, "ls": DASHES[k % len(DASHES)]}
        for k, colour in enumerate(ordered_colours(count))
    ]


def floor_looks(count: int) -> list[dict[str, Any]]:
    """Colour and dashes for each floor from the lowest; the line of the top one is solid."""
    return ordered_looks(count)[::-1]


@contextmanager
def figure(
    path: Path, panels: tuple[int, int], size: tuple[float, float], caption: str
) -> Iterator[tuple[Figure, list[Axes]]]:
    """A figure with panels; it is written to `path` with its caption when the block ends.

    Args:
        path: The PNG file.
        panels: Rows and columns.
        size: Width and height without the caption [inch].
        caption: Text below the figure.
    """
    lines = textwrap.wrap(caption, int(size[0] * 15))
    below = 0.16 * len(lines) + 0.12
    with mpl.rc_context(SETTINGS):  # type: ignore[arg-type]
        # No pyplot: no global state, no display, nothing to close.
        drawn = Figure(figsize=(size[0], size[1] + below), layout="constrained")
        grid: Any = drawn.subplots(*panels, squeeze=False)
        axes: list[Axes] = list(grid.flat)
        yield drawn, axes
        for panel in axes:
            if panel.get_xscale() == "log":
                # 0.5, 1, 10 and not powers of ten: these are frequencies.
                panel.xaxis.set_major_formatter("{x:g}")
        share = below / (size[1] + below)
        drawn.get_layout_engine().set(rect=(0.0, share, 1.0, 1.0 - share))  # type: ignore[union-attr, call-arg]
        # Laid out once here: savefig would draw everything once more for it.
        drawn.get_layout_engine().execute(drawn)  # type: ignore[union-attr]
        drawn.set_layout_engine("none")
        drawn.text(0.02, 0.07 / (size[1] + below), "\n".join(lines), va="bottom", fontsize=8.5)
        with atomic(path) as temporary:
            drawn.savefig(temporary, format="png")


def letter(axes: Sequence[Axes]) -> None:
    """Letter the panels (a), (b), ..., (z), (aa), ... at their upper left."""
    for index, panel in enumerate(axes):
        ahead, last = divmod(index, 26)
        name = (chr(ord("a") + ahead - 1) if ahead else "") + chr(ord("a") + last)
        panel.set_title(f"({name})", loc="left", fontsize=9.0)


def span(panel: Axes, values: NDArray[np.float64]) -> None:
    """Let the x-axis span ascending values; a single one keeps its own margins."""
    if values[0] < values[-1]:
        panel.set_xlim(values[0], values[-1])
