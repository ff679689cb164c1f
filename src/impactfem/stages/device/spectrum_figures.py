"""Figures of the damping study: dampings (28), spectra at the anchor (29), demands beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED, figure, letter, span
from impactfem.stages.device.history_figures import case_colour, case_dashes
from impactfem.stages.device.selection import (
    BROADENED,
    GUPTA,
    LINDLEY_YOW,
    ROTATIONS,
    WITH,
    WITHOUT,
    anchor_spectrum,
    building_damping,
    detailed_force,
    direction,
    file_stem,
    force_by_spectrum,
    headline,
    modes_of,
    relative_difference,
    rigid_variants,
    shown_modes,
    variant,
    was_done,
)
from impactfem.stages.device.verdict import rigid_words
from impactfem.stages.stores import names_of

Array = NDArray[np.float64]

RANGE = (0.5, 500.0)
"""Frequencies of figure 28 [Hz]."""
HATCHES = ("", "", "////", "", "xxxx", "", "....")
NOT_DONE = " No bar: the spectrum ends before the range that the method needs."
RIGID_COLOURS = {"none": "0.75", GUPTA: "0.45", LINDLEY_YOW: "#7a4fa3"}
"""Of the bars of the demands."""


def damping_figure(path: Path, store: xr.Dataset) -> None:
    """Figure 28: Rayleigh's damping ratio by damping case."""
    first, *_ = names_of(store, "device")
    frequency: Array = np.asarray(np.geomspace(*RANGE, 400), dtype=np.float64)
    caption = (
        "Figure 28: Rayleigh damping ratio of the buildings over the frequency by damping case. "
        f"Dotted: modes of {first} along $e_{direction(store)}$."
    )
    with figure(path, (1, 1), (6.5, 3.8), caption) as (_, axes):
        panel = axes[0]
        for case in _drawn_order(store):
            ratio = 100.0 * building_damping(store, case).ratio(frequency)
            colour, dashes, width = _look(store, case)
            panel.loglog(frequency, ratio, label=case, color=colour, ls=dashes, lw=width)
        for mode in shown_modes(store, first)["mode_frequency"].values:
            panel.axvline(mode, color="0.5", ls=":", lw=0.9)
        panel.set_xlabel("frequency [Hz]")
        panel.set_ylabel("damping ratio [%]")
        panel.xaxis.set_major_formatter("{x:g}")
        panel.yaxis.set_major_formatter("{x:g}")
        span(panel, frequency)
        panel.legend(loc="upper left")


def spectra_figure(store: xr.Dataset, device: str) -> CurveFigure:
    """Figure 29: spectra of the floor at the anchor, without and with impacts, by damping case."""
    ratio = 100.0 * float(modes_of(store, device)["mode_damping"][0])
    caption = (
        f"Figure 29: Pseudo-acceleration response spectra at the anchor of {device} along "
        f"$e_{direction(store)}$ at {ratio:.3g} % damping, without the device, by the damping of "
        "the buildings: without impact (a) and with impacts (b). Dotted: modes of the device."
    )
    panels = []
    for impact in (WITHOUT, WITH):
        curves = []
        for case in _drawn_order(store):
            psa, look = anchor_spectrum(store, device, impact, case), _look(store, case)
            peak = f"{float(psa.max()):.3g} m/s² at {float(psa.idxmax('frequency')):.3g} Hz"
            curves.append(Curve(psa["frequency"].values, psa.values, f"{case}: {peak}", *look))
        panel = Panel(
            "frequency [Hz]",
            "pseudo-acceleration [m/s²]",
            curves,
            log="x",
            bottom=0.0,
            room=0.15 + 0.11 * store.sizes["case"],  # for a line of the legend each
            marks=shown_modes(store, device)["mode_frequency"].values.tolist(),
            legend="upper left",
        )
        panels.append(panel)
    name = file_stem(store, "figure_29_anchor_spectra", device)
    return CurveFigure(name, caption, panels, size=(9.0, 3.6))


def demand_figure(path: Path, store: xr.Dataset, device: str) -> None:
    """Tables 7 and 9 as bars: forces and their differences by damping case."""
    kinds: list[tuple[str, str | None, str]] = [
        ("detailed", None, "black"),
        ("RSA", headline(store), BLUE),
    ]
    for label, words, colour in (
        ("RSA, rotations", (ROTATIONS,), ORANGE),
        ("RSA, broadened", (BROADENED,), GREEN),
        ("RSA, rotations, broadened", (ROTATIONS, BROADENED), RED),
    ):
        choice = variant(store, *words)
        if choice is not None:
            kinds.append((label, choice, colour))
    for method, choice in rigid_variants(store).items():
        kinds.append((f"RSA, {rigid_words(method)}", choice, RIGID_COLOURS[method]))
    axis, cases = direction(store), names_of(store, "case")
    caption = (
        f"Largest force of {device} on the floor along $e_{axis}$ by the damping of "
        "the buildings, in the 3D model in detail and by response spectrum analysis (RSA, "
        f"{headline(store)}): without impact (a) and with impacts (b); difference from the "
        "detailed force, over it, without impact (c) and with impacts (d), positive where RSA is "
        "too low."
        + NOT_DONE
        * any(
            not was_done(store, device, impact, case, choice)
            for _, choice, _ in kinds
            if choice is not None
            for impact in (WITHOUT, WITH)
            for case in cases
        )
    )
    width = 0.8 / len(kinds)
    with figure(path, (2, 2), (9.0, 5.8), caption) as (drawn, axes):
        for column, impact in enumerate((WITHOUT, WITH)):
            for k, (label, choice, colour) in enumerate(kinds):
                at = np.arange(len(cases), dtype=np.float64)
                at += (k - 0.5 * (len(kinds) - 1)) * width
                force, difference = _demands(store, device, impact, choice)
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
            panel.set_xticks(range(len(cases)), cases)
            panel.grid(visible=False, axis="x")
            panel.set_axisbelow(True)
        for panel in axes[2:]:
            panel.set_ylim(low, high)
        handles, labels = axes[0].get_legend_handles_labels()
        drawn.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4))
        letter(axes)


def _demands(
    store: xr.Dataset, device: str, impact: str, choice: str | None
) -> tuple[Array, Array]:
    """Force [N] and its difference from the detailed one [-] of each damping case."""
    cases = names_of(store, "case")
    detailed = np.array([detailed_force(store, device, impact, case) for case in cases])
    if choice is None:
        return detailed, np.zeros_like(detailed)
    # An analysis that was not done has no bar.
    force = np.array([force_by_spectrum(store, device, impact, case, choice) for case in cases])
    off = [relative_difference(store, device, impact, case, choice) or 0.0 for case in cases]
    return force, np.array(off, dtype=np.float64)


def _drawn_order(store: xr.Dataset) -> list[str]:
    """Damping cases, and on top of them the own damping, which may be one of them again."""
    own, *cases = names_of(store, "case")
    return [*cases, own]


def _look(store: xr.Dataset, case: str) -> tuple[str, str, float]:
    """Colour, dashes and width of a damping case.

    The own damping is dashed over the others, so that these are seen below it.
    """
    cases = names_of(store, "case")
    number = cases.index(case)
    dashed = number == 0 and len(cases) > 1
    dashes = case_dashes(number) if dashed or number else "-"
    return case_colour(number), dashes, 0.9 if dashed else 1.2
