"""Figures of curves, described by what they show and drawn as SVG."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from impactfem.plot.style import BLUE, HANDLE, letter, sheet
from impactfem.plot.words import spoken
from impactfem.system.arrays import Array

SAMPLES = 2400
"""Points of a curve at most: twice what can be told apart; extremes of each interval are kept."""
ENTRY = 1.5
"""Width of an entry of a legend above the panels [inch]."""
FEW = 3
"""Most panels that the text alternative describes one by one."""
NONE: Mapping[str, float] = MappingProxyType({})
"""Published values of a case without a publication."""
SIZES = {"*": 11.0, "^": 8.0}
"""Of markers that are no samples of a curve, as published values [point]."""
BAND, THIN = 0.3, 2e-3
"""Opacity of a band; its width, over the largest value of its curve, below which it is not seen."""


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve of a panel."""

    x: Array  #: ascending, shape (n,)
    y: Array  #: shape (n,)
    label: str = ""  #: its name in the legend; "" for none
    colour: Any = BLUE  #: as matplotlib takes it
    dash: Any = "-"  #: as matplotlib takes it; "" for points alone
    width: float = 1.0  #: of the line
    marker: str = ""  #: as matplotlib takes it; "" for none
    #: Lower and upper values of a band, shape (n,) each; None for none.
    band: tuple[Array, Array] | None = None


@dataclass(frozen=True, eq=False)
class Panel:
    """Axes with curves."""

    xlabel: str  #: quantity along x with its unit
    ylabel: str  #: the same along y
    curves: Sequence[Curve]  #: the curves; later ones are drawn over earlier ones
    title: str = ""  #: of the panel; "" for none
    log: str = ""  #: "x" or "xy" for logarithmic axes; "" for none
    bottom: float | None = None  #: lower end along y; None for that of the curves
    room: float = 0.0  #: room above the curves, over their extent, as for a legend
    marks: Sequence[float] = ()  #: where dotted vertical lines stand
    hatched: tuple[float, float] | None = None  #: range along x that is hatched
    note: str = ""  #: text in the middle; "" for none
    legend: Any = "upper right"  #: place of the legend; "" for none
    reverse: bool = False  #: whether the legend lists the last curve first

    @property
    def ends(self) -> tuple[float, float]:
        """Extent of the curves along x."""
        shown = [curve.x for curve in self.curves if curve.dash]
        if not shown:
            return 0.0, 1.0
        return min(float(x[0]) for x in shown), max(float(x[-1]) for x in shown)

    @property
    def largest(self) -> tuple[float, float, str]:
        """The value of largest size, its place along x, and its curve; zeros without curves."""
        found = [(0.0, 0.0, "")]
        for curve in self.curves:
            if curve.dash and not np.isnan(curve.y).all():
                k = int(np.nanargmax(np.abs(curve.y)))
                found.append((float(curve.y[k]), float(curve.x[k]), curve.label))
        return max(found, key=lambda one: abs(one[0]))

    @property
    def seen(self) -> str:
        """The text alternative: axes, number of curves, largest value."""
        count = sum(1 for curve in self.curves if curve.dash)
        value, place, label = self.largest
        axes = " over ".join(spoken(label) for label in (self.ylabel, self.xlabel) if label)
        text = ": ".join(part for part in (spoken(self.title), axes) if part)
        text += f", {count} curve{'s' * (count > 1)}; largest value {value:.4g} at {place:.4g}"
        return text + (f" ({spoken(label)})." if label and count > 1 else ".")

    def draw(self, axes: Axes) -> None:
        """Draw it."""
        for one in self.curves:
            if one.band is not None and np.ptp(one.band, axis=0).max() > THIN * abs(one.y).max():
                some = slice(None, None, -(-one.x.size // (SAMPLES // 8)))
                x, below, above = one.x[some], one.band[0][some], one.band[1][some]
                axes.fill_between(x, below, above, color=one.colour, alpha=BAND, lw=0.0)
            look: dict[str, Any] = {"color": one.colour, "ls": one.dash or "none", "lw": one.width}
            points = (one.x, one.y) if "x" in self.log else thinned(one.x, one.y)
            look |= {"marker": one.marker, "ms": SIZES.get(one.marker, 4.0)}
            axes.plot(*points, label=one.label or None, **look)
        if "x" in self.log:
            axes.set_xscale("log")
        if "y" in self.log:
            axes.set_yscale("log")
        if self.ends[0] < self.ends[1]:
            axes.set_xlim(*self.ends)
        for mark in self.marks:
            axes.axvline(mark, color="0.5", ls=":", lw=0.9)
        if self.hatched is not None:
            look = {"facecolor": "none", "edgecolor": "0.6", "hatch": "///", "lw": 0.0}
            axes.axvspan(*self.hatched, **look)
        low, high = axes.get_ylim()
        low = low if self.bottom is None else self.bottom
        axes.set_ylim(low, high + self.room * (high - low))
        if "x" not in self.log:
            axes.xaxis.set_major_locator(MaxNLocator(5))
            axes.ticklabel_format(axis="x", useOffset=False)
        axes.set(xlabel=self.xlabel, ylabel=self.ylabel)
        axes.text(0.5, 0.5, self.note, ha="center", transform=axes.transAxes)
        handles, labels = axes.get_legend_handles_labels()
        if self.legend and labels:
            order = slice(None, None, -1 if self.reverse else 1)
            axes.legend(handles[order], labels[order], loc=self.legend, handlelength=HANDLE)


def unresolved(store: xr.Dataset, last: float) -> tuple[float, float] | None:
    """Return the part of spectra up to a last frequency above the resolved band of a store [Hz].

    None if there is none. A panel hatches it: its ordinates are information.
    """
    end = float(store.attrs.get("resolved_frequency", math.inf))
    return (end, last) if end < last * (1.0 - 1e-9) else None


def hatching_note(store: xr.Dataset, last: float) -> str:
    """Return what hatching of spectra up to a last frequency [Hz] means, or ""."""
    above = unresolved(store, last)
    return "" if above is None else f" Hatched: information, above the resolved {above[0]:.4g} Hz."


@dataclass(frozen=True, eq=False)
class CurveFigure:
    """A figure of panels with curves."""

    caption: str  #: what it shows
    panels: Sequence[Panel]  #: the panels, row by row
    columns: int = 2  #: panels in a row
    #: Width and height [inch].
    size: tuple[float, float] = (9.0, 4.0)
    alike: bool = False  #: whether all panels have the range along y of the largest
    lettered: bool = True  #: whether panels have letters, (a), (b), ..
    above: bool = False  #: whether one legend above the panels serves all

    @property
    def rows(self) -> int:
        """Rows of panels."""
        return math.ceil(len(self.panels) / self.columns)

    @property
    def seen(self) -> str:
        """The text alternative: axes, curves and largest value of each panel, or of the largest."""
        shown = [panel for panel in self.panels if panel.curves]
        if not shown:
            return ""
        if len(shown) <= FEW:
            return " ".join(panel.seen for panel in shown)
        largest = max(shown, key=lambda panel: abs(panel.largest[0]))
        titles = ", ".join(spoken(panel.title) for panel in shown if panel.title)
        return f"{len(shown)} panels{f': {titles}' if titles else ''}. Largest: {largest.seen}"

    def write(self, path: Path) -> Path:
        """Draw it into an SVG file; ImpactfemError if it cannot be written."""
        layout = (self.rows, self.columns)
        with sheet(path, layout, self.size, self.caption, self.seen) as (drawn, axes):
            for one, panel in zip(axes, self.panels, strict=False):
                panel.draw(one)
            for spare in axes[len(self.panels) :]:
                spare.remove()
            axes = axes[: len(self.panels)]
            if self.rows > 1 and len(axes) % self.columns == 1:
                # The last panel has its row for itself.
                grid = axes[-1].get_gridspec()
                axes[-1].set_subplotspec(grid[-1, :]) if grid is not None else None
            if self.alike:
                top = max(one.get_ylim()[1] for one in axes)
                for one in axes:
                    one.set_ylim(top=top)
            if self.lettered and len(axes) > 1:
                letter(axes)
            for one, panel in zip(axes, self.panels, strict=True):
                place: Any = "right" if self.lettered else "left"
                one.set_title(panel.title, fontsize=9.0, loc=place) if panel.title else None
            if self.above:
                handles, labels = axes[0].get_legend_handles_labels()
                # A legend is filled column by column; none is wider than the figure.
                rows = math.ceil(len(labels) * ENTRY / self.size[0])
                across = math.ceil(len(labels) / rows)
                drawn.legend(handles, labels, loc="outside upper center", ncols=across)
        return path


def hatched_page(page: CurveFigure, store: xr.Dataset) -> CurveFigure:
    """Return a figure of spectra with all panels hatched above the resolved band of a store."""
    last = max(float(curve.x[-1]) for panel in page.panels for curve in panel.curves)
    panels = [replace(panel, hatched=unresolved(store, last)) for panel in page.panels]
    return replace(page, panels=panels, caption=page.caption + hatching_note(store, last))


def published_point(
    published: Mapping[str, float],
    x: str,
    y: str,
    label: str = "",
    colour: Any = "black",
    scale: float = 1.0,
) -> list[Curve]:
    """A point whose coordinates are published; none where one of both is not.

    `x` and `y` are names of published values, which are in SI; `label` is what it is of in the
    legend, `scale` the unit of the axis along y over the SI unit.
    """
    if x not in published or y not in published:
        return []
    place = np.array([published[x]]), np.array([scale * published[y]])
    return [Curve(*place, _published(label), colour, "", marker="*")]


def published_level(
    published: Mapping[str, float], y: str, x: Array, label: str = "", scale: float = 1.0
) -> list[Curve]:
    """A published value as a line over the range of x; none where it is not published."""
    if y not in published:
        return []
    level = np.full(2, scale * published[y])
    words = f"{_published(label)}: {level[0]:.4g}"
    return [Curve(x[[0, -1]], level, words, "black", (0, (1, 3)), 1.4)]


def _published(label: str) -> str:
    return f"published, {label}" if label else "published"


def thinned(x: Array, y: Array) -> tuple[Array, Array]:
    """At most about `SAMPLES` points of a curve, (n,) each: least and largest of each interval."""
    size = -(-x.size // (SAMPLES // 2))
    if size <= 2:
        return x, y
    whole = x.size // size * size
    rows = y[:whole].reshape(-1, size)
    start = np.arange(0, whole, size)
    both = np.sort(np.stack([start + rows.argmin(axis=1), start + rows.argmax(axis=1)], axis=1))
    kept = np.unique(np.concatenate([both.ravel(), np.arange(whole, x.size)]))
    return x[kept], y[kept]
