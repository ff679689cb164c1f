"""Lines, springs, arrows and labels of the sketches: one style for all of them.

The unit of length is 0.46 inch, the width of every sketch is ten units.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Ellipse, Polygon

__all__ = ["ACCENT", "GREY", "INK", "LIGHT", "SKETCHES", "Pen", "Point", "sketch"]

Point = tuple[float, float]

INK, ACCENT, GREY, LIGHT = "#333333", "#1f6fb4", "#9aa5b1", "#e9edf1"
WIDTH, UNIT = 10.0, 0.46
STYLE = {
    "svg.fonttype": "path",
    "svg.hashsalt": "impactfem",
    "font.family": "DejaVu Sans",
    "font.size": 10,
    "mathtext.fontset": "dejavusans",
    "lines.solid_capstyle": "round",
    "lines.linewidth": 1.4,
}


class Pen:
    """A sheet of ten units by the given height, and what is drawn on it.

    Args:
        height: Height of the sheet [unit].
    """

    def __init__(self, height: float) -> None:
        self.figure = Figure(figsize=(WIDTH * UNIT, height * UNIT), facecolor="white")
        self.axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0))
        self.axes.set(xlim=(0.0, WIDTH), ylim=(0.0, height))
        self.axes.axis("off")

    def line(
        self, *points: Point, color: str = INK, lw: float = 1.4, ls: str = "-", fill: str = ""
    ) -> None:
        """Draw a line through points; with `fill` a closed area of this colour."""
        x, y = zip(*points, strict=True)
        if fill:
            self.axes.add_patch(
                Polygon(points, closed=True, fc=fill, ec=color, lw=lw, ls=ls, zorder=2)
            )
        else:
            self.axes.plot(x, y, color=color, lw=lw, ls=ls)

    def curve(
        self,
        x: Sequence[float],
        y: Sequence[float],
        color: str = ACCENT,
        lw: float = 1.6,
        ls: str = "-",
    ) -> None:
        """Draw a curve."""
        self.axes.plot(x, y, color=color, lw=lw, ls=ls)

    def box(
        self, at: Point, width: float, height: float, text: str = "", fill: str = LIGHT
    ) -> None:
        """Draw a box from its lower left corner, with a text in its middle."""
        x, y = at
        corners = ((x, y), (x + width, y), (x + width, y + height), (x, y + height))
        self.line(*corners, fill=fill)
        if text:
            self.text((x + width / 2, y + height / 2), text)

    def dot(self, *points: Point, color: str = INK, size: float = 5.0) -> None:
        """Draw dots."""
        x, y = zip(*points, strict=True)
        self.axes.plot(x, y, "o", color=color, ms=size)

    def ring(
        self,
        at: Point,
        radius: float,
        *,
        color: str = INK,
        ls: str = "-",
        fill: str = "none",
        flat: float = 1.0,
    ) -> None:
        """Draw a circle, or an ellipse whose height is `flat` times its width."""
        self.axes.add_patch(
            Ellipse(at, 2 * radius, 2 * radius * flat, fc=fill, ec=color, ls=ls, lw=1.2, zorder=2)
        )

    def ball(self, at: Point, radius: float = 0.28) -> None:
        """Draw a lumped mass."""
        self.axes.add_patch(Circle(at, radius, fc=LIGHT, ec=INK, lw=1.4, zorder=2))

    def text(
        self,
        at: Point,
        text: str,
        color: str = INK,
        ha: str = "center",
        va: str = "center",
        size: float = 10,
    ) -> None:
        """Write a text."""
        self.axes.text(*at, text, color=color, ha=ha, va=va, size=size, linespacing=1.15)

    def arrow(
        self, start: Point, end: Point, text: str = "", *, color: str = ACCENT, at: Point = (0, 0.3)
    ) -> None:
        """Draw an arrow, with a text at the distance `at` from its middle."""
        style = {"arrowstyle": "-|>,head_width=0.22,head_length=0.45", "color": color, "lw": 1.5}
        style |= {"shrinkA": 0, "shrinkB": 0}
        self.axes.annotate("", xy=end, xytext=start, arrowprops=style)
        if text:
            x, y = (start[0] + end[0]) / 2 + at[0], (start[1] + end[1]) / 2 + at[1]
            self.text((x, y), text, color)

    def turn(self, centre: Point, radius: float, start: float, end: float, text: str = "") -> None:
        """Draw an arrow along an arc between two angles [deg]."""
        angle = np.radians(np.linspace(start, end, 40))
        x, y = centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)
        self.curve(x[:-2], y[:-2], lw=1.5)
        self.arrow((x[-5], y[-5]), (x[-1], y[-1]))
        if text:
            middle = np.radians((start + end) / 2)
            far = radius + 0.3
            self.text(
                (centre[0] + far * np.cos(middle), centre[1] + far * np.sin(middle)), text, ACCENT
            )

    def measure(
        self, start: Point, end: Point, text: str, *, at: Point = (0, 0.28), ha: str = "center"
    ) -> None:
        """Draw a dimension line, with a text at the distance `at` from its middle."""
        style = {"arrowstyle": "<|-|>,head_width=0.14,head_length=0.32", "color": INK, "lw": 0.9}
        style |= {"shrinkA": 0, "shrinkB": 0}
        self.axes.annotate("", xy=end, xytext=start, arrowprops=style)
        x, y = (start[0] + end[0]) / 2 + at[0], (start[1] + end[1]) / 2 + at[1]
        self.text((x, y), text, ha=ha)

    def thin(self, *points: Point, ls: str = ":") -> None:
        """Draw an auxiliary line."""
        self.line(*points, color=GREY, lw=1.0, ls=ls)

    def ground(self, x: Point, y: float) -> None:
        """Draw the ground from x[0] to x[1] at the height y."""
        self.line((x[0], y), (x[1], y), lw=1.8)
        for left in np.arange(x[0] + 0.25, x[1] + 0.01, 0.3):
            self.line((left, y), (left - 0.25, y - 0.25), lw=0.9)

    def wall(self, x: float, y: Point) -> None:
        """Draw a rigid wall whose face is at x, with the hatching on the right."""
        self.line((x, y[0]), (x, y[1]), lw=1.8)
        for low in np.arange(y[0], y[1] - 0.2, 0.3):
            self.line((x, low), (x + 0.25, low + 0.25), lw=0.9)

    def spring(
        self, start: Point, end: Point, *, color: str = INK, coils: int = 4, size: float = 0.2
    ) -> None:
        """Draw a spring."""
        share = np.r_[0.0, np.linspace(0.2, 0.8, 2 * coils + 1), 1.0]
        side = np.r_[0.0, 0.0, size * (-1.0) ** np.arange(2 * coils - 1), 0.0, 0.0]
        (x0, y0), (x1, y1) = start, end
        far = float(np.hypot(x1 - x0, y1 - y0))
        along, across = ((x1 - x0) / far, (y1 - y0) / far), (-(y1 - y0) / far, (x1 - x0) / far)
        self.axes.plot(
            x0 + far * share * along[0] + side * across[0],
            y0 + far * share * along[1] + side * across[1],
            color=color,
            lw=1.2,
            solid_joinstyle="round",
        )

    def dashpot(self, start: Point, end: Point, *, size: float = 0.18) -> None:
        """Draw a dashpot."""
        (x0, y0), (x1, y1) = np.array(start), np.array(end)
        a, b = np.array([x0, y0]), np.array([x1, y1])
        along = (b - a) / np.hypot(*(b - a))
        across = size * np.array([-along[1], along[0]])
        far = float(np.hypot(*(b - a)))
        low, high, piston = a + 0.38 * far * along, a + 0.66 * far * along, a + 0.54 * far * along
        for points in (
            (a, low),
            (high + across, low + across, low - across, high - across),
            (piston + 0.75 * across, piston - 0.75 * across),
            (piston, b),
        ):
            self.axes.plot(*np.array(points).T, color=INK, lw=1.2)

    def frame(self, at: Point, width: float, height: float, x: str, y: str) -> None:
        """Draw the axes of a diagram with their names."""
        self.arrow(at, (at[0] + width, at[1]), color=INK)
        self.arrow(at, (at[0], at[1] + height), color=INK)
        self.text((at[0] + width, at[1] - 0.32), x, ha="right")
        self.text((at[0] + 0.15, at[1] + height - 0.05), y, ha="left")


Draw = Callable[[Pen], None]
SKETCHES: dict[str, tuple[Draw, float]] = {}


def sketch(height: float) -> Callable[[Draw], Draw]:
    """Register the sketch of a name, with the height of its sheet [unit]."""

    def register(draw: Draw) -> Draw:
        SKETCHES[draw.__name__.removeprefix("draw_")] = draw, height
        return draw

    return register
