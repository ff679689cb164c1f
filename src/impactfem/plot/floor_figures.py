"""Figures of floor response spectra: one a building, a panel for each floor."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator
from numpy.typing import NDArray

from impactfem.plot.style import BLUE, GREEN, ORANGE, RED, figure
from impactfem.spectra.product import DesignFloorSpectra

COLUMNS = 4
PANEL = (2.6, 2.0)  # width and height [inch]
LEGEND_WIDTH = 3.4  # of the two entries of a direction [inch]
DIRECTION_COLOURS = {"x": RED, "y": BLUE, "z": GREEN}


def floor_figures(folder: Path, design: DesignFloorSpectra) -> list[Path]:
    """Draw the spectra of each building at the first damping.

    Args:
        folder: Where to.
        design: The spectra.

    Returns:
        The files.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    buildings = dict.fromkeys(station.building for station in design.source.stations)
    return [_figure(folder, design, building) for building in buildings]


def _figure(folder: Path, design: DesignFloorSpectra, building: str) -> Path:
    source = design.source
    numbers = [s for s, station in enumerate(source.stations) if station.building == building]
    columns = min(COLUMNS, len(numbers))
    rows = math.ceil(len(numbers) / columns)
    path = folder / f"floor_spectra_{building}.png"
    caption = (
        f"Floor response spectra of building {building} (pseudo-acceleration, "
        f"{100.0 * source.damping[0]:g} % damping) as computed (thin) and for design (thick); "
        f"{design.broadening_text}. Dotted: zero-period acceleration. {design.motions_text}."
    )
    width = max(PANEL[0] * columns, 2.0 * PANEL[0])
    # Two entries a direction; a row of the legend holds as many directions as there is room for.
    across = 2 * min(len(source.directions), max(1, int(width / LEGEND_WIDTH)))
    legend_rows = math.ceil(2 * len(source.directions) / across)
    size = (width, PANEL[1] * rows + 0.25 + 0.2 * legend_rows)
    with figure(path, (rows, columns), size, caption) as (drawn, axes):
        top = 1.08 * float(max(design.psa[0, numbers].max(), design.raw[0, numbers].max()))
        for index, (panel, s) in enumerate(zip(axes, numbers, strict=False)):
            _panel(panel, design, s)
            panel.set_title(
                f"({_letter(index)}) {source.stations[s].label}", loc="left", fontsize=9
            )
            panel.set_ylim(0.0, top if top > 0.0 else 1.0)
            if index % columns == 0:
                panel.set_ylabel("acceleration [m/s²]")
            else:
                panel.tick_params(labelleft=False)
            if index + columns >= len(numbers):
                panel.set_xlabel("frequency [Hz]")
            else:
                panel.tick_params(labelbottom=False)
        for panel in axes[len(numbers) :]:
            panel.set_visible(False)
        handles, labels = axes[0].get_legend_handles_labels()
        # A legend is filled column by column, read row by row.
        order = [k for column in range(across) for k in range(column, len(labels), across)]
        drawn.legend(
            [handles[k] for k in order],
            [labels[k] for k in order],
            loc="outside upper center",
            ncols=across,
        )
    return path


def _panel(panel: Axes, design: DesignFloorSpectra, s: int) -> None:
    source = design.source
    for x, direction in enumerate(source.directions):
        colour = DIRECTION_COLOURS.get(direction, ORANGE)
        along = f"along $e_{direction}$"
        panel.semilogx(
            source.frequency, design.raw[0, s, x], color=colour, lw=0.6, label=f"computed, {along}"
        )
        panel.semilogx(
            design.frequency,
            design.psa[0, s, x],
            color=colour,
            lw=1.4,
            alpha=0.75,
            label=f"for design, {along}",
        )
        panel.axhline(float(design.zpa[s, x]), color=colour, lw=0.8, ls=":")
    frequency_axis(panel, source.frequency)


def frequency_axis(panel: Axes, frequency: NDArray[np.float64]) -> None:
    """Let a logarithmic axis span frequencies, with a label at each power of ten.

    Args:
        panel: The panel.
        frequency: Ascending, shape (n_f,) [Hz].
    """
    low, high = float(frequency[0]), float(frequency[-1])
    if high > low:
        panel.set_xlim(low, high)
        exponents = range(math.ceil(math.log10(low)), math.floor(math.log10(high)) + 1)
        if len(exponents) > 1:
            panel.xaxis.set_major_locator(FixedLocator([10.0**k for k in exponents]))
            panel.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            panel.xaxis.set_minor_formatter(FuncFormatter(lambda *_: ""))
        else:
            panel.xaxis.set_minor_locator(NullLocator())


def _letter(index: int) -> str:
    """a, b, ..., z, aa, ab, ..."""
    ahead, last = divmod(index, 26)
    return (_letter(ahead - 1) if ahead else "") + chr(ord("a") + last)
