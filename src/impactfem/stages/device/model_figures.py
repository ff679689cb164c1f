"""Figures of a device: its elements (24), its modes (25) and its mechanical model (26)."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import NDArray

from impactfem.plot.style import BLUE, GREEN, ORANGE, RED, figure, letter
from impactfem.stages.device.selection import (
    Drawing,
    anchor_of,
    drawing_of,
    modes_of,
)

Array = NDArray[np.float64]

GREY = "0.35"
SHOWN = 4
"""Most modes that are drawn."""
AMPLITUDE = 0.3
"""Largest displacement of a drawn mode over the height of the device."""


def modes_figure(path: Path, store: xr.Dataset, device: str) -> None:
    """Figure 25: the modes that move along the shown direction.

    Raises:
        ValueError: The device is made of modes and has no shapes.
    """
    drawn = _drawing(store, device)
    axis = drawn.axis
    every = modes_of(store, device)
    mass, frequency = every["effective_mass"].sel(component=axis).values, every["mode_frequency"]
    modes = [int(k) for k in np.flatnonzero(mass > 1e-6 * mass.sum())][:SHOWN]
    about = "x" if axis == "y" else "y"
    caption = (
        f"Figure 25: Modes of {device} that move along $e_{axis}$ and rotate about "
        f"$e_{about}$, relative to the anchor and not to scale, with their effective masses "
        f"along $e_{axis}$ and the parts of their sum, {mass.sum():.5g} kg. Dashed: at rest."
    )
    with figure(path, (1, len(modes)), (max(2.9 * len(modes), 4.0), 3.5), caption) as (_, axes):
        for panel, mode in zip(axes, modes, strict=True):
            _mode(panel, drawn, mode)
            panel.text(
                0.03,
                0.98,
                f"f = {float(frequency[mode]):.2f} Hz\n"
                f"{mass[mode]:.5g} kg, {100.0 * mass[mode] / mass.sum():.3g} %",
                transform=panel.transAxes,
                va="top",
                fontsize=8.0,
            )
        axes[0].set_ylabel("height [m]")
        axes[0].legend(loc="lower left", fontsize=7.0)
        letter(axes)


def elements_figure(path: Path, store: xr.Dataset, device: str) -> None:
    """Figure 24: the elements of the device to scale.

    Raises:
        ValueError: The device is made of modes and has no springs.
    """
    drawn = _drawing(store, device)
    _, floor, nodes = anchor_of(store, device)
    caption = (
        f"Figure 24: Elements of {device}, in elevation in the plane "
        f"$(e_{drawn.axis}, e_z)$: a body on {'a beam' if _has_beam(drawn) else 'a rigid link'} on "
        f"springs, anchored by rigid links to {nodes} node{'s' * (nodes > 1)} of floor {floor}."
    )
    with figure(path, (1, 1), (6.5, 4.4), caption) as (drawing, axes):
        _elevation(axes[0], drawn)
        drawing.legend(loc="outside upper center", ncols=3)


def model_figure(path: Path, store: xr.Dataset, device: str) -> None:
    """Figure 26: the mechanical model of the device, with its values and modes.

    Raises:
        ValueError: The device is made of modes and has no springs.
    """
    drawn = _drawing(store, device)
    axis = drawn.axis
    caption = (
        f"Figure 26: Mechanical model of {device} in the plane $(e_{axis}, e_z)$, "
        "and its modes in this plane with their effective masses."
    )
    with figure(path, (1, 1), (6.5, 4.4), caption) as (_, axes):
        _mechanics(axes[0], drawn, _mode_lines(store, device, axis))


def _drawing(store: xr.Dataset, device: str) -> Drawing:
    drawn = drawing_of(store, device)
    if drawn is None:
        raise ValueError(f"device {device} is made of modes")
    return drawn


def _top(drawn: Drawing) -> float:
    """Height of the device [m]."""
    return float(np.nanmax([drawn.length, drawn.height, drawn.beam_length]))


def _body(drawn: Drawing) -> Array:
    """Outline of the body at rest, from its lower left on, shape (5, 2) [m]; of its size if known.

    A cylinder has its middle where the case has its mass centre only if both are as high; it stands
    on the floor.
    """
    if math.isnan(drawn.radius):
        half, low, high = 0.15 * _top(drawn), drawn.height * 0.85, drawn.height * 1.15
    else:
        half, low, high = drawn.radius, 0.0, drawn.length
    return np.array([[-half, low], [half, low], [half, high], [-half, high], [-half, low]])


def _mode(panel: Axes, drawn: Drawing, mode: int) -> None:
    outline = _body(drawn)
    shift, slope = drawn.shift[mode], drawn.slope[mode]
    # The body turns about its mass centre, the last level.
    arm = outline - np.array([0.0, drawn.height])
    moved = np.column_stack([shift[-1] + slope[-1] * arm[:, 1], -slope[-1] * arm[:, 0]])
    largest = float(max(np.abs(moved[:, 0]).max(), np.abs(shift).max()))
    sign = 1.0 if shift[-1] >= 0.0 else -1.0
    factor = sign * AMPLITUDE * _top(drawn) / largest
    x = factor * shift
    for at_rest in (outline, np.array([[0.0, 0.0], [0.0, drawn.height]])):
        panel.plot(at_rest[:, 0], at_rest[:, 1], color=GREY, ls="--", lw=0.8)
    panel.plot(*(outline + factor * moved).T, color=RED, lw=1.0, label="body")
    panel.plot(
        x, drawn.levels, color=BLUE, lw=2.0, label="beam" if _has_beam(drawn) else "rigid link"
    )
    panel.plot(x[0], 0.0, "s", color=ORANGE, ms=5, label="base")
    panel.plot(x[-1], drawn.height, "o", color="black", ms=4, label="mass centre")
    half = float(np.abs(outline[:, 0]).max())
    # So wide that the width of the panel, not its height, gives the scale.
    reach = max(half + 1.35 * AMPLITUDE * _top(drawn), 0.95 * _top(drawn))
    panel.axhline(0.0, color="black", lw=1.5)
    panel.set_xlim(-reach, reach)
    panel.set_ylim(-0.75 * _top(drawn), 1.5 * _top(drawn))
    panel.set_aspect("equal")
    panel.set_xlabel(f"{drawn.axis} [m]")
    panel.grid(False)


def _has_beam(drawn: Drawing) -> bool:
    return not math.isnan(drawn.beam_length)


def _elevation(panel: Axes, drawn: Drawing) -> None:
    """The parts in the colours of the paper's figure 24, each with a label."""
    outline, top = _body(drawn), _top(drawn)
    half = float(np.abs(outline[:, 0]).max())
    panel.fill(outline[:, 0], outline[:, 1], color=RED, alpha=0.12)
    panel.plot(outline[:, 0], outline[:, 1], color=RED, lw=1.0, label="body, rigid")
    if _has_beam(drawn):
        panel.plot([0.0, 0.0], [0.0, drawn.beam_length], color=RED, lw=3.0, label="beam")
    panel.plot(0.0, drawn.height, "o", color="black", ms=5, label="mass centre")
    # As wide as high at least, however slim the device is.
    reach = max(1.6 * half, 0.95 * top)
    panel.axhline(-0.16 * top, color=BLUE, lw=4.0, label="floor")
    # Springs have no length: they are drawn apart to be seen.
    for x in np.linspace(-half, half, 5):
        label = "rigid links to the floor" if x == half else None
        panel.plot([0.0, x], [-0.06 * top, -0.15 * top], color=GREEN, lw=1.5, label=label)
    panel.plot([0.0, 0.0], [0.0, -0.06 * top], color=ORANGE, lw=5.0, label="springs of the base")
    panel.annotate(
        "",
        (half + 0.12 * reach, 0.0),
        xytext=(half + 0.12 * reach, drawn.height),
        arrowprops={"arrowstyle": "<->", "color": GREY, "shrinkA": 0.0, "shrinkB": 0.0},
    )
    panel.text(half + 0.15 * reach, 0.5 * drawn.height, f"{drawn.height:g} m", va="center")
    panel.set_xlim(-reach, reach)
    panel.set_ylim(-0.25 * top, 1.15 * top)
    panel.set_aspect("equal")
    panel.set_xlabel(f"{drawn.axis} [m]")
    panel.set_ylabel("height [m]")
    panel.grid(False)


def _mechanics(panel: Axes, drawn: Drawing, modes: list[str]) -> None:
    """Mass, beam, spring along and spring about, with their values; lengths mean nothing."""
    other = "x" if drawn.axis == "y" else "y"
    _coils(panel, (-1.5, 0.0), (-0.4, 0.0))
    panel.plot([-0.4, 0.0], [0.0, 0.0], color=ORANGE, lw=1.6)
    panel.plot([-1.5, -1.5], [-0.25, 0.25], color="black", lw=2.5)
    _spiral(panel)
    panel.plot([-0.3, 0.3], [-0.55, -0.55], color="black", lw=2.5)
    panel.plot([0.0, 0.0], [0.0, 1.6], color=RED, lw=2.5)
    panel.plot(0.0, 1.6, "o", color="black", ms=13)
    panel.plot(0.0, 0.0, "s", color=ORANGE, ms=6)
    label = (
        f"$m$ = {drawn.mass:.5g} kg at {drawn.height:g} m\n$J_{other}$ = {drawn.inertia:.4g} kg m²"
    )
    panel.text(0.22, 1.6, label, va="center")
    if _has_beam(drawn):
        carried = f"\n{drawn.beam_mass:.4g} kg" if drawn.beam_mass > 0.0 else ""
        bending = _power(drawn.beam_bending, "N m²")
        text = f"beam, {drawn.beam_length:g} m\n$E I$ = {bending}{carried}"
    else:
        text = "rigid"
    panel.text(0.15, 0.85, text, va="center")
    panel.text(
        -0.95,
        0.33,
        f"$K_{{{drawn.axis}{drawn.axis}}}$ = {_power(drawn.spring, 'N/m')}",
        ha="center",
    )
    panel.text(
        0.42,
        -0.28,
        f"$K_{{r{other}{other}}}$ = {_power(drawn.turning, 'N m/rad')}",
        va="center",
    )
    panel.text(-1.6, -0.85, "\n".join(modes), va="top", fontsize=8.5)
    for start, end, name in (
        ((-1.5, 1.1), (-1.0, 1.1), f"$e_{drawn.axis}$"),
        ((-1.5, 1.1), (-1.5, 1.6), "$e_z$"),
    ):
        panel.annotate("", end, xytext=start, arrowprops={"arrowstyle": "->", "color": GREY})
        panel.text(end[0] + 0.06, end[1], name, va="center")
    panel.set_xlim(-1.8, 2.2)
    panel.set_ylim(-1.0 - 0.21 * len(modes), 2.0)
    panel.set_axis_off()


def _mode_lines(store: xr.Dataset, device: str, axis: str) -> list[str]:
    modes = modes_of(store, device)
    mass = modes["effective_mass"].sel(component=axis)
    modes = modes.isel(mode=(mass > 1e-6 * mass.sum()).values).isel(mode=slice(SHOWN))
    return [
        f"mode {k}: {f:.2f} Hz, {m:.5g} kg, damping {100.0 * damping:.3g} %"
        for k, f, m, damping in zip(
            modes["mode"].values,
            modes["mode_frequency"].values,
            modes["effective_mass"].sel(component=axis).values,
            modes["mode_damping"].values,
            strict=True,
        )
    ]


def _coils(panel: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    """A spring drawn as a zigzag from left to right."""
    across = np.array([0, 0, 1, -1, 1, -1, 1, -1, 0, 0]) * 0.12
    x = np.linspace(start[0], end[0], across.size)
    panel.plot(x, start[1] + across, color=ORANGE, lw=1.6)


def _spiral(panel: Axes) -> None:
    """A spring that turns: a spiral around the base that ends on its support."""
    turn = np.linspace(0.0, 5.0 * math.pi, 240)
    radius = 0.08 + 0.24 * turn / turn[-1]
    x, z = radius * np.sin(turn), radius * np.cos(turn)
    panel.plot(x, z, color=ORANGE, lw=1.6)
    panel.plot([x[-1], x[-1]], [z[-1], -0.55], color=ORANGE, lw=1.6)


def _power(value: float, unit: str) -> str:
    """A number as 1.4·10⁸ with its unit; "rigid" for an infinite one."""
    if math.isinf(value):
        return "rigid"
    if not value > 0.0:
        return f"{value:g} {unit}"
    power = math.floor(math.log10(value))
    return f"${value / 10.0**power:.3g} \\cdot 10^{{{power}}}$ {unit}"
