"""Figures of the pages on benchmarks: drawings of the problems, and how their errors fall.

``impactfem verify --json FILE`` and then ``python docs/_ext/benchmark_figures.py FILE...`` write
``docs/benchmarks/NAME.svg`` and, of benchmarks with a fitted order, ``NAME_convergence.svg``.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from verification import read_entries

from impactfem.system.errors import ImpactfemError
from impactfem.verify.shells import rectangle

FOLDER = Path(__file__).parents[1] / "benchmarks"
STYLE = {
    "svg.fonttype": "none",  # text that can be searched
    "svg.hashsalt": "impactfem",
    "font.size": 9,
    "font.family": "sans-serif",
    "lines.linewidth": 1.2,
    "lines.solid_capstyle": "round",
}
INK, BLUE, RED = "#333333", "#1f6fb4", "#c0392b"

LARGEST = (5.0, 2.8)  # in
SIZES = {"newmark_order": "time step [s]", "beam_frequencies": "length of an element [m]"}
"""What errors are drawn over; by default the size of elements over that of the model."""

Drawing = Callable[[Axes], None]
Span = tuple[float, float]
DRAWINGS: dict[str, tuple[Drawing, Span, Span, float]] = {}


def drawing(x: Span, y: Span, stretch: float = 1.0) -> Callable[[Drawing], Drawing]:
    """Register the drawing of the benchmark of the same name, what it spans, and its width."""

    def register(draw: Drawing) -> Drawing:
        DRAWINGS[draw.__name__] = draw, x, y, stretch
        return draw

    return register


@drawing((-0.35, 3.4), (-0.4, 3.2), 1.7)
def eurocode_ordinates(ax: Axes) -> None:
    """The elastic spectrum with its four branches."""
    T = np.linspace(0.0, 3.0, 400)
    B, C, D = 0.15, 0.5, 2.0
    S = np.select([T < B, T < C, T < D], [1.0 + 1.5 * T / B, 2.5, 2.5 * C / np.maximum(T, C)], 0.0)
    S = np.where(T >= D, 2.5 * C * D / np.maximum(T, D) ** 2, S)
    ax.plot(T, S, color=BLUE, lw=2)
    for at, name in ((B, "$T_B$"), (C, "$T_C$"), (D, "$T_D$")):
        y = float(np.interp(at, T, S))
        ax.plot([at, at], [0, y], color=INK, lw=0.8, ls=":")
        ax.text(at, -0.25, name, ha="center")
    for x, y, text in (
        (0.25, 2.65, r"$2.5\, a_g S \eta$"),
        (0.85, 1.75, r"$\propto 1/T$"),
        (2.3, 0.75, r"$\propto 1/T^2$"),
        (-0.33, 1.0, "$a_g S$"),
    ):
        ax.text(x, y, text)
    axes(ax, (0, 3.2), (0, 3.0), "T", "$S_e$")


@drawing((-7, 7), (-1.2, 11.5))
def cantilever(ax: Axes) -> None:
    """A stick of ten storeys with a force at its top, and its deflection."""
    ground(ax, (-0.8, 0.8), 0.0)
    z = np.linspace(0.0, 10.0, 11)
    ax.plot(0 * z, z, color=INK, lw=2)
    ax.plot(0 * z, z, "o", color=INK, ms=4)
    fine = np.linspace(0.0, 10.0, 50)
    ax.plot(1.6 * (fine / 10) ** 2 * (1.5 - 0.5 * fine / 10), fine, color=BLUE, ls="--")
    arrow(ax, (-2.0, 10.0), (-0.15, 10.0), "P")
    dimension(ax, (-1.4, 0.0), (-1.4, 10.0), "L")
    ax.text(1.4, 4.5, "E I, G $A_v$")
    ax.text(1.75, 9.8, "u")


@drawing((-1.6, 4.6), (-1.0, 2.5))
def newmark_order(ax: Axes) -> None:
    """An oscillator on ground that moves."""
    ground(ax, (-1.5, 4.5), 0.0)
    ax.plot([-1, -1], [0, 1.5], color=INK, lw=3)
    spring(ax, (-1, 0.9), (2, 0.9), "k, c")
    box(ax, (2, 0.2), 1.4, 1.4, "m")
    arrow(ax, (0.6, -0.85), (2.4, -0.85), r"$a_0 \sin \Omega t$", color=RED)
    arrow(ax, (2.7, 1.9), (3.7, 1.9), "x")


@drawing((-3.5, 5.0), (-0.4, 2.9))
def shock_on_wall(ax: Axes) -> None:
    """A mass on a spring that touches another spring, on a wall."""
    wall(ax, -3.0, (-0.2, 1.8), left=True)
    spring(ax, (-3, 0.8), (0, 0.8), "k")
    box(ax, (0, 0.1), 1.4, 1.4, "m")
    spring(ax, (1.4, 0.8), (4.4, 0.8), "K, no tension")
    wall(ax, 4.4, (-0.2, 1.8))
    arrow(ax, (0.2, 2.0), (1.6, 2.0), "$v_0$", color=BLUE)


@drawing((-0.4, 6.8), (-1.3, 2.0))
def unilateral_bar(ax: Axes) -> None:
    """A bar that flies against a rigid wall, and the wave in it."""
    box(ax, (0, 0), 6.0, 0.8, "")
    ax.fill_between([4.2, 6.0], 0, 0.8, color=RED, alpha=0.25, lw=0)
    ax.plot([4.2, 4.2], [-0.15, 0.95], color=RED)
    arrow(ax, (4.2, 1.2), (3.0, 1.2), "c", color=RED)
    arrow(ax, (0.4, 1.2), (1.8, 1.2), "$v_0$", color=BLUE)
    wall(ax, 6.0, (-0.7, 1.6))
    dimension(ax, (0, -0.5), (6, -0.5), r"L;  F = $\rho$ c S $v_0$ for 2 L/c")


@drawing((-0.8, 1.8), (-0.4, 1.15))
def mindlin_plate(ax: Axes) -> None:
    """The square plate on its distorted mesh."""
    nodes, triangles = rectangle(1.0, 1.0, 8, 8, 0.15)
    ax.triplot(nodes[:, 0], nodes[:, 1], triangles=triangles, color="#9aa5b1", lw=0.6)
    ax.plot([0, 1, 1, 0, 0], [0, 0, 1, 1, 0], color=INK, lw=2)
    for x, y, turn in ((0.5, -0.09, 0), (0.5, 1.05, 0), (-0.09, 0.5, 90), (1.05, 0.5, 90)):
        text = r"$w = 0,\ \theta_t = 0$"
        ax.text(x, y, text, ha="center" if not turn else "left", rotation=turn, va="center")
    dimension(ax, (0, -0.2), (1, -0.2), "L;  t/L = 0.1, 0.01, 0.001")


@drawing((-30, 68), (2, 44))
def scordelis_lo(ax: Axes) -> None:
    """The roof between two diaphragms, seen from above one corner."""
    R, L, half = 25.0, 50.0, np.radians(40.0)

    def shown(x: Any, phi: Any) -> tuple[Any, Any]:
        y, z = R * np.sin(phi), R * np.cos(phi)
        return 0.9 * x + 0.55 * y, 0.28 * x - 0.3 * y + 0.9 * z

    arc = np.linspace(-half, half, 60)
    for x in np.linspace(0.0, L, 9):
        end = x in (0.0, L)
        ax.plot(*shown(x, arc), color=INK if end else "#9aa5b1", lw=2 if end else 0.6)
    for phi in np.linspace(-half, half, 9):
        free = abs(abs(phi) - half) < 1e-9
        ax.plot(
            *shown(np.array([0, L]), phi),
            color=BLUE if free else "#9aa5b1",
            lw=1.5 if free else 0.6,
        )
    point = shown(0.5 * L, half)
    ax.plot(*point, "o", color=RED)
    arrow(ax, point, (point[0], point[1] - 6), "", color=RED)
    ax.text(point[0] + 1.5, point[1] - 4.5, "w", color=RED)
    ax.text(*shown(0.12 * L, 1.25 * half), "free edge", color=BLUE, va="top")
    x, y = shown(0.0, -half)
    ax.text(x - 1, y - 1, "rigid diaphragm", ha="right")
    x, y = shown(L, 0.0)
    ax.text(x - 16, y + 3, "own weight")


@drawing((-0.6, 6.4), (-2.2, 1.3))
def beam_frequencies(ax: Axes) -> None:
    """A beam held at one end, and its first two bending modes."""
    wall(ax, 0.0, (-1.2, 1.2), left=True)
    box(ax, (0, -0.2), 6.0, 0.4, "")
    x = np.linspace(0.0, 6.0, 100)
    for root, color in ((1.875, BLUE), (4.694, RED)):
        s = root * x / 6.0
        ratio = (np.cosh(root) + np.cos(root)) / (np.sinh(root) + np.sin(root))
        mode = np.cosh(s) - np.cos(s) - ratio * (np.sinh(s) - np.sin(s))
        ax.plot(x, mode / np.abs(mode).max(), color=color, ls="--")
    dimension(ax, (0, -1.5), (6, -1.5), "6 m;  0.5 m x 0.8 m")


@drawing((-3.2, 16.4), (-2.2, 4.4))
def slab_strip_impact(ax: Axes) -> None:
    """A strip that is hit on an edge, and the wave that runs across."""
    box(ax, (0, 0), 15.6, 1.2, "")
    x = np.linspace(4.0, 9.0, 80)
    ax.plot(x, 1.9 + 1.3 * np.sin(np.pi * (x - 4.0) / 5.0), color=BLUE)
    ax.plot([0, 4, 4], [1.9, 1.9, 1.9], color=BLUE)
    ax.plot([9, 15.6], [1.9, 1.9], color=BLUE)
    arrow(ax, (9.2, 2.7), (11.5, 2.7), "c", color=BLUE)
    ax.text(6.5, 3.4, r"velocity F/($\rho$ c A)", ha="center", color=BLUE)
    arrow(ax, (-2.6, 0.6), (-0.1, 0.6), "F(t)", color=RED)
    dimension(ax, (0, -0.7), (15.6, -0.7), "15.6 m, free at both ends")


@drawing((-0.3, 5.6), (-1.0, 1.35))
def spectrum_sdll06(ax: Axes) -> None:
    """The triangular pulse of base acceleration, and an undamped oscillator's answer."""
    ax.plot([0, 1, 2, 5], [0, 1, 0, 0], color=RED, lw=2)
    t = np.linspace(0.0, 5.0, 400)
    w = 2.1
    ramp = [np.where(t > s, (t - s) - np.sin(w * (t - s)) / w, 0.0) for s in (0.0, 1.0, 2.0)]
    x = -(ramp[0] - 2.0 * ramp[1] + ramp[2]) / w**2
    ax.plot(t, x / np.abs(x).max() * 0.8, color=BLUE)
    ax.text(1.15, 0.95, "a(t), from 0 to A in $t_1$", color=RED)
    ax.text(4.2, 0.6, "x(t)", color=BLUE)
    axes(ax, (0, 5.2), (-0.9, 1.2), "t", "")


@drawing((-0.5, 14.3), (-1.5, 1.2))
def device_sdld25(ax: Axes) -> None:
    """Eight masses between nine springs and dashpots, both ends held."""
    wall(ax, 0.0, (-0.6, 0.6), left=True)
    for k in range(8):
        spring(ax, (1.6 * k, 0), (1.6 * k + 1.0, 0), "k, c" if k == 0 else "", coils=3)
        box(ax, (1.6 * k + 1.0, -0.3), 0.6, 0.6, f"P{k + 1}")
    spring(ax, (12.8, 0), (13.8, 0), "", coils=3)
    wall(ax, 13.8, (-0.6, 0.6))
    arrow(ax, (5.8, -1.2), (8.0, -1.2), "both ends move together", color=RED)


def axes(ax: Axes, x: tuple[float, float], y: tuple[float, float], along: str, up: str) -> None:
    """Two arrows as axes."""
    ax.annotate("", (x[1], 0), (x[0], 0), arrowprops={"arrowstyle": "->", "color": INK})
    ax.annotate("", (x[0], y[1]), (x[0], y[0]), arrowprops={"arrowstyle": "->", "color": INK})
    ax.text(x[1], 0, f" {along}", va="center")
    ax.text(x[0], y[1], f"{up} ", ha="right")


def arrow(
    ax: Axes, start: Sequence[float], end: Sequence[float], text: str, color: str = INK
) -> None:
    """An arrow with its name above the middle."""
    ax.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": color, "lw": 1.5})
    x, y = (0.5 * (a + b) for a, b in zip(start, end, strict=True))
    ax.annotate(text, (x, y), (0, 4), textcoords="offset points", ha="center", color=color)


def box(ax: Axes, corner: tuple[float, float], width: float, height: float, text: str) -> None:
    """A body with its name."""
    x, y = corner
    ax.add_patch(mpl.patches.Rectangle(corner, width, height, fc="#dfe6ee", ec=INK))
    ax.text(x + 0.5 * width, y + 0.5 * height, text, ha="center", va="center")


def dimension(ax: Axes, start: tuple[float, float], end: tuple[float, float], text: str) -> None:
    """A line with arrows at both ends and a length."""
    ax.annotate("", end, start, arrowprops={"arrowstyle": "<->", "color": INK, "lw": 0.8})
    x, y = (0.5 * (a + b) for a, b in zip(start, end, strict=True))
    upright = start[0] == end[0]
    shift, side = ((-4, 0), "right") if upright else ((0, -4), "center")
    ax.annotate(
        text, (x, y), shift, textcoords="offset points", ha=side, va="center" if upright else "top"
    )


def ground(ax: Axes, x: tuple[float, float], y: float) -> None:
    """Ground, hatched below."""
    ax.plot(x, (y, y), color=INK, lw=1.5)
    ax.fill_between(x, y - 0.05 * (x[1] - x[0]), y, hatch="////", fc="none", ec="#9aa5b1", lw=0)


def wall(ax: Axes, x: float, y: tuple[float, float], *, left: bool = False) -> None:
    """A wall, hatched behind."""
    ax.plot((x, x), y, color=INK, lw=1.5)
    depth = 0.15 * (y[1] - y[0]) * (-1 if left else 1)
    ax.fill_betweenx(y, x, x + depth, hatch="////", fc="none", ec="#9aa5b1", lw=0)


def spring(
    ax: Axes, start: tuple[float, float], end: tuple[float, float], text: str, coils: int = 6
) -> None:
    """A spring with its name above."""
    x = np.linspace(start[0], end[0], 4 * coils + 1)
    y = start[1] + 0.2 * np.sin(0.5 * np.pi * np.arange(x.size)) * (np.arange(x.size) % 2)
    ax.plot(x, y, color=INK, lw=1)
    middle = (0.5 * (start[0] + end[0]), start[1])
    ax.annotate(text, middle, (0, 14), textcoords="offset points", ha="center")


def convergence(ax: Axes, entries: Sequence[Mapping[str, Any]]) -> None:
    """Errors over sizes of elements or steps, each with a line of the order that is expected."""
    several = len({entry["name"] for entry in entries}) > 1
    for entry, color in zip(entries, (BLUE, RED, "#2e8b57"), strict=False):
        sizes, errors = np.array(entry["convergence"]).T
        label = f"{entry['name'].split(',')[-1].strip()}: " if several else ""
        label += f"order {entry['computed']:.2f}"
        ax.loglog(sizes, errors, "o-", color=color, ms=4, label=label)
    order = entry["reference"]
    ax.loglog(
        sizes,
        0.4 * errors[0] * (sizes / sizes[0]) ** order,
        color=INK,
        lw=0.8,
        ls="--",
        label=f"order {order:g}{' is the least' if entry['at_least'] else ''}",
    )
    ax.set(xlabel=SIZES.get(entry["benchmark"], "1 / elements a side"), ylabel="error")
    ax.minorticks_off()
    ax.set_xticks(sizes, [f"{size:.3g}" for size in sizes])
    ax.grid(color="#dddddd", lw=0.5)
    ax.legend(frameon=False)


def saved(path: Path, draw: Drawing, size: tuple[float, float], **place: Any) -> None:
    """Draw into an SVG file that is the same each time."""
    with mpl.rc_context(STYLE):
        figure = Figure(size)
        draw(figure.add_axes(**place) if place else figure.add_subplot())
        tight = {} if place else {"bbox_inches": "tight"}
        figure.savefig(path, metadata={"Date": None, "Creator": None}, **tight)


def problem(name: str, path: Path) -> None:
    """Draw a problem to scale, without a frame."""
    draw, x, y, stretch = DRAWINGS[name]
    width, height = stretch * (x[1] - x[0]), y[1] - y[0]
    scale = min(LARGEST[0] / width, LARGEST[1] / height)

    def bare(ax: Axes) -> None:
        ax.set(xlim=x, ylim=y)
        ax.set_axis_off()
        draw(ax)

    saved(path, bare, (scale * width, scale * height), rect=(0, 0, 1, 1))


def main(files: Sequence[str]) -> int:
    """Write all drawings, and the convergence of the benchmarks in the files."""
    if not files:
        sys.stderr.write("usage: python docs/_ext/benchmark_figures.py FILE...\n")
        return 2
    try:
        entries = [entry for file in files for entry in read_entries(Path(file))]
    except ImpactfemError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    for name in DRAWINGS:
        problem(name, FOLDER / f"{name}.svg")
        orders = [e for e in entries if e["benchmark"] == name and e["convergence"]]
        if orders:
            file = FOLDER / f"{name}_convergence.svg"
            saved(file, partial(convergence, entries=orders), (4.2, 3.0))
    sys.stdout.write(f"{FOLDER}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
