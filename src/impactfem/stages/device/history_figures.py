"""Figures of the force of a device on the floor over time (27), by damping (30)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.style import BLUE, RED, figure, letter, span
from impactfem.stages.device.selection import (
    WITH,
    WITHOUT,
    detailed_force,
    direction,
    file_stem,
    force_by_spectrum,
    force_history,
    headline,
    own_is_a_case,
)
from impactfem.stages.stores import names_of

CASES = ("#56B4E9", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")
"""Okabe and Ito's colours of the damping cases in their order; the own damping is black."""
WINDOW = (0.05, 0.15)
"""What is shown before and after the largest force [s]."""
DASHES = ("-", "-", "-.", "-", "--", "--")
"""Of the damping cases: colours that are equally dark in print have different ones."""


def case_colour(case: int) -> str:
    """Colour of a damping case, the same in all figures."""
    return CASES[(case - 1) % len(CASES)] if case else "black"


def case_dashes(case: int) -> str:
    """Dashes of a damping case, the same in all figures."""
    return DASHES[(case - 1) % len(DASHES)] if case else "--"


def force_figure(store: xr.Dataset, device: str) -> CurveFigure:
    """Figure 27: the force without and with impacts, with the buildings' own damping."""
    axis, time = direction(store), store["time"].values
    caption = (
        f"Figure 27: Force of {device} on the floor along $e_{axis}$ over time: without impact (a) "
        "and with impacts (b), with the building's own damping. Dashed: largest value by response "
        f"spectrum analysis ({headline(store)})."
    )
    panels = []
    for impact, colour in ((WITHOUT, BLUE), (WITH, RED)):
        force, ends = 1e-3 * force_history(store, device, impact).values, time[[0, -1]]
        k, level = int(np.argmax(np.abs(force))), 1e-3 * force_by_spectrum(store, device, impact)
        peak = f"{1e-3 * detailed_force(store, device, impact):.4g} kN at {time[k]:.3f} s"
        around = (f"±{level:.4g} kN by spectrum", "0.35", "--", 0.9)
        curves = [
            Curve(time, force, "", colour, width=0.6),
            Curve(time[k : k + 1], force[k : k + 1], peak, "black", "", marker="o"),
            Curve(ends, np.full(2, level), *around),
            Curve(ends, np.full(2, -level), "", *around[1:]),
        ]
        panels.append(Panel("time [s]", f"force $F_{axis}$ [kN]", curves, room=0.3))
    stem = file_stem(store, "figure_27_shear_force", device)
    return CurveFigure(stem, caption, panels, size=(9.0, 3.4))


def damping_forces_figure(path: Path, store: xr.Dataset, device: str) -> None:
    """Figure 30: the force without and with impacts by damping case, and around its largest."""
    axis, time = direction(store), store["time"].values
    caption = (
        f"Figure 30: Force of {device} on the floor along $e_{axis}$ over time by the damping of "
        "the buildings: without impact (a) and with impacts (b), and around the largest force: "
        "without (c) and with (d)."
    )
    # The buildings' own damping is drawn where no case repeats it. What is damped least is behind.
    every = names_of(store, "case")
    number = {case: k for k, case in enumerate(every)}
    drawn_cases = every[int(own_is_a_case(store)) :]
    cases = sorted(drawn_cases, key=lambda case: -detailed_force(store, device, WITH, case))
    with figure(path, (2, 2), (9.0, 6.0), caption) as (drawn, axes):
        for column, impact in enumerate((WITHOUT, WITH)):
            whole, near = axes[column], axes[2 + column]
            for case in cases:
                force, c = 1e-3 * force_history(store, device, impact, case), number[case]
                for panel, width in ((whole, 0.5), (near, 0.9)):
                    panel.plot(
                        time,
                        force,
                        color=case_colour(c),
                        lw=width,
                        ls=case_dashes(c) if panel is near else "-",
                        label=case,
                    )
            span(whole, time)
            at = _largest_at(store, device, impact, cases)
            near.set_xlim(max(time[0], at - WINDOW[0]), min(time[-1], at + WINDOW[1]))
            near.xaxis.set_major_locator(MaxNLocator(5))
            near.ticklabel_format(axis="x", useOffset=False)
            for panel in (whole, near):
                _force_axis(panel, axis)
        handles, labels = axes[2].get_legend_handles_labels()
        order = sorted(range(len(cases)), key=lambda k: number[cases[k]])
        drawn.legend(
            [handles[k] for k in order],
            [labels[k] for k in order],
            loc="outside upper center",
            ncols=len(order),
        )
        letter(axes)


def _largest_at(store: xr.Dataset, device: str, impact: str, cases: list[str]) -> float:
    """Time of the largest force of all damping cases [s]."""
    largest = max(cases, key=lambda case: detailed_force(store, device, impact, case))
    return float(abs(force_history(store, device, impact, largest)).idxmax("time"))


def _force_axis(panel: Axes, axis: str) -> None:
    panel.set_xlabel("time [s]")
    panel.set_ylabel(f"force $F_{axis}$ [kN]")
