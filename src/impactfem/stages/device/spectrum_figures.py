"""Figures of the damping study: dampings (28), spectra at the anchor (29), demands beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED, figure, letter, span
from impactfem.stages.device.history_figures import case_colour, case_dashes
from impactfem.stages.device.verdict import rigid_words
from impactfem.stages.device.view import (
    BROADENED,
    GUPTA,
    LINDLEY_YOW,
    ROTATIONS,
    WITH,
    WITHOUT,
    DeviceView,
)

Array = NDArray[np.float64]

RANGE = (0.5, 500.0)
"""Frequencies of figure 28 [Hz]."""
HATCHES = ("", "", "////", "", "xxxx", "", "....")
NOT_DONE = " No bar: the spectrum ends before the range that the method needs."
RIGID_COLOURS = {"none": "0.75", GUPTA: "0.45", LINDLEY_YOW: "#7a4fa3"}
"""Of the bars of the demands."""


def damping_figure(path: Path, view: DeviceView) -> None:
    """Figure 28: Rayleigh's damping ratio by damping case."""
    frequency: Array = np.asarray(np.geomspace(*RANGE, 400), dtype=np.float64)
    caption = (
        "Figure 28: Rayleigh damping ratio of the buildings over the frequency by damping case. "
        f"Dotted: modes of {view.devices[0]} along $e_{view.direction}$."
    )
    with figure(path, (1, 1), (6.5, 3.8), caption) as (_, axes):
        panel = axes[0]
        for c in _drawn_order(view):
            ratio = 100.0 * view.damping(c).ratio(frequency)
            colour, dashes, width = _look(view, c)
            look = {"color": colour, "ls": dashes, "lw": width}
            panel.loglog(frequency, ratio, label=view.cases[c], **look)
        for k in view.shown_modes(0):
            panel.axvline(float(view.mode_frequency(0)[k]), color="0.5", ls=":", lw=0.9)
        panel.set_xlabel("frequency [Hz]")
        panel.set_ylabel("damping ratio [%]")
        panel.xaxis.set_major_formatter("{x:g}")
        panel.yaxis.set_major_formatter("{x:g}")
        span(panel, frequency)
        panel.legend(loc="upper left")


def spectra_figure(view: DeviceView, device: int) -> CurveFigure:
    """Figure 29: spectra of the floor at the anchor, without and with impacts, by damping case."""
    ratio = 100.0 * float(view.mode_damping(device)[0])
    caption = (
        f"Figure 29: Pseudo-acceleration response spectra at the anchor of {view.devices[device]} "
        f"along $e_{view.direction}$ at {ratio:.3g} % damping, without the device, by the damping "
        "of the buildings: without impact (a) and with impacts (b). Dotted: modes of the device."
    )
    panels = []
    for impact in (WITHOUT, WITH):
        curves = []
        for c in _drawn_order(view):
            spectrum, (colour, dash, width) = view.spectrum(device, impact, c), _look(view, c)
            top = int(np.argmax(spectrum))
            label = f"{view.cases[c]}: {spectrum[top]:.3g} m/s² at {view.frequency[top]:.3g} Hz"
            curves.append(Curve(view.frequency, spectrum, label, colour, dash, width))
        panel = Panel(
            "frequency [Hz]",
            "pseudo-acceleration [m/s²]",
            curves,
            log="x",
            bottom=0.0,
            room=0.15 + 0.11 * len(view.cases),  # for a line of the legend each
            marks=[float(view.mode_frequency(device)[k]) for k in view.shown_modes(device)],
            legend="upper left",
        )
        panels.append(panel)
    name = view.of_device("figure_29_anchor_spectra", device)
    return CurveFigure(name, caption, panels, size=(9.0, 3.6))


def demand_figure(path: Path, view: DeviceView, device: int) -> None:
    """Tables 7 and 9 as bars: forces and their differences by damping case."""
    kinds: list[tuple[str, str | None, str]] = [
        ("detailed", None, "black"),
        ("RSA", view.headline, BLUE),
    ]
    for label, words, colour in (
        ("RSA, rotations", (ROTATIONS,), ORANGE),
        ("RSA, broadened", (BROADENED,), GREEN),
        ("RSA, rotations, broadened", (ROTATIONS, BROADENED), RED),
    ):
        choice = view.variant(*words)
        if choice is not None:
            kinds.append((label, choice, colour))
    for method, choice in view.rigid_variants().items():
        kinds.append((f"RSA, {rigid_words(method)}", choice, RIGID_COLOURS[method]))
    axis = view.direction
    caption = (
        f"Largest force of {view.devices[device]} on the floor along $e_{axis}$ by the damping of "
        "the buildings, in the 3D model in detail and by response spectrum analysis (RSA, "
        f"{view.headline}): without impact (a) and with impacts (b); difference from the detailed "
        "force, over it, without impact (c) and with impacts (d), positive where RSA is too low."
        + NOT_DONE
        * any(
            not view.done(device, k, c, choice)
            for _, choice, _ in kinds
            if choice is not None
            for k in (WITHOUT, WITH)
            for c in range(len(view.cases))
        )
    )
    width = 0.8 / len(kinds)
    with figure(path, (2, 2), (9.0, 5.8), caption) as (drawn, axes):
        for column, impact in enumerate((WITHOUT, WITH)):
            for k, (label, choice, colour) in enumerate(kinds):
                at = np.arange(len(view.cases), dtype=np.float64)
                at += (k - 0.5 * (len(kinds) - 1)) * width
                force, difference = _demands(view, device, impact, choice)
                # Orange and red, green and red are equally dark in print.
                look: dict[str, Any] = {
                    "color": colour,
                    "hatch": HATCHES[k % len(HATCHES)],
                    "edgecolor": "white",
                }
                axes[column].bar(at, 1e-3 * force, width, label=label, lw=0.0, **look)
                if choice is not None:
                    axes[2 + column].bar(at, 100.0 * difference, width, lw=0.0, **look)
            axes[column].set_ylabel(f"force $F_{axis}$ [kN]")
            axes[2 + column].set_ylabel("difference [%]")
            axes[2 + column].axhline(0.0, color="black", lw=0.8)
        low = min(panel.get_ylim()[0] for panel in axes[2:])
        high = max(panel.get_ylim()[1] for panel in axes[2:])
        for panel in axes:
            panel.set_xticks(range(len(view.cases)), view.cases)
            panel.grid(visible=False, axis="x")
            panel.set_axisbelow(True)
        for panel in axes[2:]:
            panel.set_ylim(low, high)
        handles, labels = axes[0].get_legend_handles_labels()
        drawn.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4))
        letter(axes)


def _demands(view: DeviceView, device: int, impact: int, choice: str | None) -> tuple[Array, Array]:
    """Force [N] and its difference from the detailed one [-] of each damping case."""
    cases = range(len(view.cases))
    detailed = np.array([view.detailed(device, impact, c) for c in cases])
    if choice is None:
        return detailed, np.zeros_like(detailed)
    # An analysis that was not done has no bar.
    force = np.array([view.by_spectrum(device, impact, c, choice) for c in cases])
    difference = np.array(
        [view.difference(device, impact, c, choice) or 0.0 for c in cases], dtype=np.float64
    )
    return force, difference


def _drawn_order(view: DeviceView) -> list[int]:
    """Damping cases, and on top of them the own damping, which may be one of them again."""
    return [*range(1, len(view.cases)), 0]


def _look(view: DeviceView, case: int) -> tuple[str, str, float]:
    """Colour, dashes and width of a damping case.

    The own damping is dashed over the others, so that these are seen below it.
    """
    dashed = case == 0 and len(view.cases) > 1
    dashes = case_dashes(case) if dashed or case else "-"
    return case_colour(case), dashes, 0.9 if dashed else 1.2
