"""Response spectrum analyses with other inputs than the anchor's own spectra, beside each other.

Inputs are the spectra of the anchor as computed, their envelope with those of further points or
over all dampings, and spectra of a file; several supports are combined in several ways.
"""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from impactfem.case.damping import OWN
from impactfem.plot.style import figure, letter
from impactfem.stages.device.history_figures import case_colour
from impactfem.stages.device.selection import (
    BROADENED,
    RIGID,
    ROTATIONS,
    WITH,
    WITHOUT,
    detailed_force,
    direction,
    force_by_spectrum,
    headline,
    was_done,
)
from impactfem.stages.stores import names_of

WORDS = {
    "": "computed spectra",
    "envelope": "envelope with further points",
    "envelope-dampings": "envelope over all dampings",
    "given": "given spectra",
    "supports-srss": "supports by root of squares",
    "supports-abs": "supports by absolute sum",
    "supports-algebraic": "supports in step",
    "supports-envelope": "supports in step by their envelope",
}
MARKERS = "os^Dvp*X"


def input_choices(store: xr.Dataset, device: str) -> dict[str, str]:
    """Analyses of a device with the headline's combination that differ by their input.

    Args:
        store: The store.
        device: Name of the device.

    Returns:
        By what they are in words: their names, the headline first.
    """
    found = {WORDS[""]: headline(store)}
    for choice in names_of(store, "choice"):
        parts = choice.removeprefix(f"{headline(store)}.").split(".")
        other = {ROTATIONS, BROADENED, *RIGID}
        if not choice.startswith(f"{headline(store)}.") or other & set(parts):
            continue
        if was_done(store, device, WITH, OWN, choice):
            found[", ".join(WORDS[part] for part in parts)] = choice
    return found


def inputs_figure(path: Path, store: xr.Dataset, device: str) -> None:
    """Force by response spectrum analysis over the detailed one, by the input of the analysis."""
    choices = input_choices(store, device)
    axis = direction(store)
    caption = (
        f"Largest force of {device} on the floor along $e_{axis}$ by response spectrum analysis "
        f"({headline(store)}) over that of the 3D model in detail, by the input of the analysis "
        "and by the damping of the buildings: without impact (a) and with impacts (b)."
    )
    with figure(path, (1, 2), (9.0, 1.5 + 0.34 * len(choices)), caption) as (drawn, axes):
        for panel, impact in zip(axes, (WITHOUT, WITH), strict=True):
            panel.axvline(1.0, color="black", lw=0.8)
            for c, case in enumerate(names_of(store, "case")):
                detailed = detailed_force(store, device, impact, case)
                if not detailed > 0.0:
                    continue
                ratio = [
                    force_by_spectrum(store, device, impact, case, one) / detailed
                    for one in choices.values()
                ]
                panel.plot(
                    ratio,
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
