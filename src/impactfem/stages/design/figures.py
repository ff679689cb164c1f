"""Figures of the design spectra of the 3D building: a page for each direction and damping."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from impactfem.plot.floor_figures import frequency_axis
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED, figure
from impactfem.spectra.product import DesignFloorSpectra
from impactfem.stages.design.products import DesignProducts

COLUMNS = 4
PANEL = (2.5, 2.1)
"""Width and height [inch]."""
GREY = "0.72"


def design_figures(folder: Path, products: DesignProducts) -> list[Path]:
    """Draw all figures of the design spectra.

    Args:
        folder: The run's folder.
        products: The design spectra.

    Returns:
        The files.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    target = folder / "figures"
    target.mkdir(parents=True, exist_ok=True)
    source = products.case.source
    files = []
    for x, direction in enumerate(source.directions):
        for d, damping in enumerate(source.damping):
            ending = f"{direction}_{100.0 * damping:g}pct.png"
            files.append(target / f"design_spectra_{ending}")
            _case_page(files[-1], products, d, x)
            if products.statistics:
                files.append(target / f"design_ensemble_{ending}")
                _ensemble_page(files[-1], products, d, x)
    return files


def _case_page(path: Path, products: DesignProducts, d: int, x: int) -> None:
    design = products.case
    source = design.source
    caption = (
        f"{_head(design, d, x)} under the case's motion: envelope of {_points(products)} of each "
        "floor of the 3D model as computed and for design, beside that of all vertices of the "
        "floor, without samples between, and the design spectrum of the sticks at the mass centre, "
        f"where there are such; {design.broadening_text}. Dotted: zero-period acceleration."
    )
    with _page(path, design, caption) as (drawn, axes):
        for s, panel in enumerate(axes):
            panel.semilogx(
                source.frequency, design.raw[d, s, x], color=BLUE, lw=0.6, label="3D, computed"
            )
            panel.semilogx(
                design.frequency, design.psa[d, s, x], color=BLUE, lw=1.5, label="3D, for design"
            )
            stick = products.of_stick(d, s, x)
            if stick is not None:
                panel.semilogx(*stick, color=RED, lw=1.1, ls="--", label="sticks, for design")
            whole = products.view.whole(d, s, x)
            if whole is not None:
                label = "3D, all vertices, computed"
                panel.semilogx(*whole, color=GREEN, lw=0.7, label=label)
            panel.axhline(float(design.zpa[s, x]), color=BLUE, lw=0.8, ls=":")
        _finish(drawn, axes, design)


def _ensemble_page(path: Path, products: DesignProducts, d: int, x: int) -> None:
    members = products.view.members
    if members is None:
        raise ValueError("the store has no ensemble")
    design = products.case
    caption = (
        f"{_head(design, d, x)} over {len(members.motions)} motions, envelope of "
        f"{_points(products)} of each floor of the 3D model: design spectra of the mean and of the "
        "84 % fractiles, beside that of the case's own motion; "
        f"{design.broadening_text}. Grey: the members as computed."
    )
    lines = (
        ("mean", "mean", BLUE, "-"),
        ("p84", "84 %", RED, "-"),
        ("p84_lognormal", "84 %, lognormal", ORANGE, "--"),
    )
    with _page(path, design, caption) as (drawn, axes):
        for s, panel in enumerate(axes):
            for member in members.psa[:, d, s, x]:
                panel.semilogx(members.frequency, member, color=GREY, lw=0.4)
            panel.plot([], [], color=GREY, lw=0.8, label="members")
            for name, label, colour, style in lines:
                one = products.statistics[name]
                panel.semilogx(
                    one.frequency, one.psa[d, s, x], color=colour, lw=1.3, ls=style, label=label
                )
            panel.semilogx(
                design.frequency,
                design.psa[d, s, x],
                color="black",
                lw=0.9,
                ls=":",
                label="the case's motion",
            )
        _finish(drawn, axes, design)


def _points(products: DesignProducts) -> str:
    whole = products.view.vertex_counts.any()
    return "the probes and of the governing vertices" if whole else "the PROBES ALONE"


def _head(design: DesignFloorSpectra, d: int, x: int) -> str:
    source = design.source
    return (
        f"Floor response spectra of building {source.stations[0].building} along "
        f"$e_{source.directions[x]}$ ({100.0 * source.damping[d]:g} % damping)"
    )


@contextmanager
def _page(
    path: Path, design: DesignFloorSpectra, caption: str
) -> Iterator[tuple[Figure, list[Axes]]]:
    """A page with a panel for each floor."""
    count = len(design.source.stations)
    columns = min(COLUMNS, count)
    rows = math.ceil(count / columns)
    size = (max(PANEL[0] * columns, 3.0 * PANEL[0]), PANEL[1] * rows + 0.4)
    with figure(path, (rows, columns), size, caption) as (drawn, axes):
        for spare in axes[count:]:
            spare.set_visible(False)
        yield drawn, axes[:count]


def _finish(drawn: Figure, axes: list[Axes], design: DesignFloorSpectra) -> None:
    """Scales, labels and one legend for all panels."""
    source = design.source
    columns = min(COLUMNS, len(axes))
    for index, (panel, station) in enumerate(zip(axes, source.stations, strict=True)):
        panel.set_title(station.label, loc="left", fontsize=9)
        panel.set_ylim(bottom=0.0)
        frequency_axis(panel, source.frequency)
        if index % columns == 0:
            panel.set_ylabel("acceleration [m/s²]")
        if index + columns >= len(axes):
            panel.set_xlabel("frequency [Hz]")
        else:
            panel.tick_params(labelbottom=False)
    handles, labels = axes[0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside upper center", ncols=len(labels))
