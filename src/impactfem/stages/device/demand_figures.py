"""Figures of the largest forces by damping case: all analyses (tables 7 and 9), and by input.

Inputs are the spectra of the anchor as computed, their envelope with those of further points or
over all dampings, and spectra of a file; several supports are combined in several ways.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.plot.style import BLUE, GREEN, ORANGE, RED, figure, letter
from impactfem.stages.device.selection import (
    BROADENED,
    GUPTA,
    LINDLEY_YOW,
    LOADS,
    RIGID_WORDS,
    ROTATIONS,
    WITHOUT,
    Load,
    direction,
    headline,
    input_variants,
    rigid_variants,
    variant,
)
from impactfem.stages.stores import names_of

CASES = ("#56B4E9", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")
"""Okabe and Ito's colours of the damping cases in their order; the own damping is black."""
DASHES = ("-", "-", "-.", "-", "--", "--")
"""Of the damping cases: colours that are equally dark in print have different ones."""
HATCHES = ("", "", "////", "", "xxxx", "", "....")
NOT_DONE = " No bar: the spectrum ends before the range that the method needs."
RIGID_COLOURS = {"none": "0.75", GUPTA: "0.45", LINDLEY_YOW: "#7a4fa3"}
"""Of the bars of the demands."""
MARKERS = "os^Dvp*X"


def case_colour(case: int) -> str:
    """Colour of a damping case by its number, the same in all figures."""
    return CASES[(case - 1) % len(CASES)] if case else "black"


def case_dashes(case: int) -> str:
    """Dashes of a damping case, the same in all figures."""
    return DASHES[(case - 1) % len(DASHES)] if case else "--"


def demand_figure(path: Path, store: xr.Dataset, device: str) -> None:
    """Tables 7 and 9 as bars: forces and their differences by damping case."""
    kinds: list[tuple[str, str | None, str]] = [
        ("detailed", None, "black"),
        ("RSA", headline(store), BLUE),
        ("RSA, rotations", variant(store, ROTATIONS), ORANGE),
        ("RSA, broadened", variant(store, BROADENED), GREEN),
        ("RSA, rotations, broadened", variant(store, ROTATIONS, BROADENED), RED),
    ]
    kinds[2:] = [kind for kind in kinds[2:] if kind[1] is not None]
    for method, name in rigid_variants(store).items():
        kinds.append((f"RSA, {RIGID_WORDS[method]}", name, RIGID_COLOURS[method]))
    axis, cases = direction(store), names_of(store, "case")
    loads = {impact: [Load(store, device, impact, case) for case in cases] for impact in LOADS}
    caption = (
        f"Largest force of {device} on the floor along $e_{axis}$ by the damping of "
        "the buildings, in the 3D model in detail and by response spectrum analysis (RSA, "
        f"{headline(store)}): without impact (a) and with impacts (b); difference from the "
        "detailed force, over it, without impact (c) and with impacts (d), positive where RSA is "
        "too low."
    )
    every = [load for several in loads.values() for load in several]
    if not all(load.was_done(choice) for _, choice, _ in kinds for load in every):
        caption += NOT_DONE
    width = 0.8 / len(kinds)
    with figure(path, (2, 2), (9.0, 5.8), caption) as (drawn, axes):
        for forces, differences, impact in zip(axes[:2], axes[2:], LOADS, strict=True):
            for k, (label, choice, colour) in enumerate(kinds):
                at = np.arange(len(cases)) + (k - 0.5 * (len(kinds) - 1)) * width
                # Orange and red, green and red are equally dark in print.
                look: dict[str, Any] = {
                    "color": colour,
                    "hatch": HATCHES[k % len(HATCHES)],
                    "edgecolor": "white",
                    "lw": 0.0,
                }
                # An analysis that was not done has no bar.
                found = [load.components(choice).sel(component=axis) for load in loads[impact]]
                forces.bar(at, 1e-3 * np.array(found), width, label=label, **look)
                if choice is not None:
                    off = [100.0 * (load.difference(choice) or 0.0) for load in loads[impact]]
                    differences.bar(at, off, width, **look)
            forces.set_ylabel(f"force $F_{axis}$ [kN]")
            differences.set_ylabel("difference [%]")
            differences.axhline(0.0, color="black", lw=0.8)
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


def inputs_figure(path: Path, store: xr.Dataset, device: str) -> None:
    """Force by response spectrum analysis over the detailed one, by the input of the analysis."""
    choices = input_variants(store, device)
    axis = direction(store)
    caption = (
        f"Largest force of {device} on the floor along $e_{axis}$ by response spectrum analysis "
        f"({headline(store)}) over that of the 3D model in detail, by the input of the analysis "
        "and by the damping of the buildings: without impact (a) and with impacts (b)."
    )
    with figure(path, (1, 2), (9.0, 1.5 + 0.34 * len(choices)), caption) as (drawn, axes):
        for panel, impact in zip(axes, LOADS, strict=True):
            panel.axvline(1.0, color="black", lw=0.8)
            for c, case in enumerate(names_of(store, "case")):
                load = Load(store, device, impact, case)
                if not load.detailed > 0.0:
                    continue
                panel.plot(
                    [load.by_spectrum(one) / load.detailed for one in choices.values()],
                    range(len(choices)),
                    ls="",
                    marker=MARKERS[c % len(MARKERS)],
                    color=case_colour(c),
                    markerfacecolor="none" if c == 0 else case_colour(c),
                    ms=8.0 if c == 0 else 5.0,
                    label=case,
                )
            panel.set_yticks(range(len(choices)), list(choices) if impact == WITHOUT else [])
            panel.set_ylim(len(choices) - 0.5, -0.5)
            panel.set_xlim(left=0.0, right=1.08 * max(panel.get_xlim()[1], 1.0))
            panel.set_xlabel(f"force $F_{axis}$ over the detailed one [-]")
        handles, labels = axes[1].get_legend_handles_labels()
        if handles:
            drawn.legend(handles, labels, loc="outside upper center", ncols=len(labels))
        letter(axes)
