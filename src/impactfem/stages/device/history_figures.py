"""Figures of the force of a device on the floor over time (27), by damping (30)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.style import BLUE, RED, figure, letter, span
from impactfem.stages.device.view import WITH, WITHOUT, DeviceView

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


def force_figure(view: DeviceView, device: int) -> CurveFigure:
    """Figure 27: the force without and with impacts, with the buildings' own damping."""
    name, axis = view.devices[device], view.direction
    caption = (
        f"Figure 27: Force of {name} on the floor along $e_{axis}$ over time: without impact (a) "
        "and with impacts (b), with the building's own damping. Dashed: largest value by response "
        f"spectrum analysis ({view.headline})."
    )
    panels = []
    for impact, colour in ((WITHOUT, BLUE), (WITH, RED)):
        force, ends = 1e-3 * view.force(device, impact), view.time[[0, -1]]
        k, level = int(np.argmax(np.abs(force))), 1e-3 * view.by_spectrum(device, impact)
        peak = f"{1e-3 * view.detailed(device, impact):.4g} kN at {view.time[k]:.3f} s"
        around = (f"±{level:.4g} kN by spectrum", "0.35", "--", 0.9)
        curves = [
            Curve(view.time, force, "", colour, width=0.6),
            Curve(view.time[k : k + 1], force[k : k + 1], peak, "black", "", marker="o"),
            Curve(ends, np.full(2, level), *around),
            Curve(ends, np.full(2, -level), "", *around[1:]),
        ]
        panels.append(Panel("time [s]", f"force $F_{axis}$ [kN]", curves, room=0.3))
    stem = view.of_device("figure_27_shear_force", device)
    return CurveFigure(stem, caption, panels, size=(9.0, 3.4))


def damping_forces_figure(path: Path, view: DeviceView, device: int) -> None:
    """Figure 30: the force without and with impacts by damping case, and around its largest."""
    name, axis = view.devices[device], view.direction
    caption = (
        f"Figure 30: Force of {name} on the floor along $e_{axis}$ over time by the damping of the "
        "buildings: without impact (a) and with impacts (b), and around the largest force: without "
        "(c) and with (d)."
    )
    # The buildings' own damping is drawn where no case repeats it. What is damped least is behind.
    drawn_cases = range(int(view.own_is_a_case), len(view.cases))
    cases = sorted(drawn_cases, key=lambda c: -view.detailed(device, WITH, c))
    with figure(path, (2, 2), (9.0, 6.0), caption) as (drawn, axes):
        for column, impact in enumerate((WITHOUT, WITH)):
            whole, near = axes[column], axes[2 + column]
            for c in cases:
                force = 1e-3 * view.force(device, impact, c)
                for panel, width in ((whole, 0.5), (near, 0.9)):
                    panel.plot(
                        view.time,
                        force,
                        color=case_colour(c),
                        lw=width,
                        ls=case_dashes(c) if panel is near else "-",
                        label=view.cases[c],
                    )
            span(whole, view.time)
            at = _largest_at(view, device, impact, cases)
            near.set_xlim(max(view.time[0], at - WINDOW[0]), min(view.time[-1], at + WINDOW[1]))
            near.xaxis.set_major_locator(MaxNLocator(5))
            near.ticklabel_format(axis="x", useOffset=False)
            for panel in (whole, near):
                _force_axis(panel, axis)
        handles, labels = axes[2].get_legend_handles_labels()
        order = sorted(range(len(cases)), key=lambda k: cases[k])
        drawn.legend(
            [handles[k] for k in order],
            [labels[k] for k in order],
            loc="outside upper center",
            ncols=len(order),
        )
        letter(axes)


def _largest_at(view: DeviceView, device: int, impact: int, cases: list[int]) -> float:
    """Time of the largest force of all damping cases [s]."""
    largest = max(cases, key=lambda c: view.detailed(device, impact, c))
    force = view.force(device, impact, largest)
    return float(view.time[int(np.argmax(np.abs(force)))])


def _force_axis(panel: Axes, axis: str) -> None:
    panel.set_xlabel("time [s]")
    panel.set_ylabel(f"force $F_{axis}$ [kN]")
