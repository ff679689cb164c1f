"""Figure and tables of the comparison of two runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from impactfem.plot.style import BLUE, RED, figure, letter, span
from impactfem.plot.table import Cell, Table
from impactfem.report.comparison import Comparison

FIGURE = "comparison_spectra.png"
CASES = "comparison_cases"
TABLE = "comparison_spectra"
DIRECTIONS = "comparison_directions"
NEAR = 0.05
"""Difference of which the table of the directions counts the ordinates that are within it."""


def cases_table(found: Comparison) -> Table:
    """Which runs are compared, at which points and frequencies, and what is left out.

    Args:
        found: The comparison.
    """

    def row(words: str, name: str) -> tuple[Cell, ...]:
        values = (found.store.attrs[f"{kind}{name}"] for kind in ("", "other_"))
        return (words, *(v if isinstance(v, str) else f"{v:.4g}" for v in values))

    told = found.store.attrs
    upto = f"up to {found.highest:g} Hz"
    low = 100.0 * float(told["interpolated_low"])
    alone = (str(told["alone"]), str(told["other_alone"]))
    points = f"{len(found.probes)}, within {float(told['farthest']):.3g} m"
    rows = (
        row("title", "title"),
        row("case file", "case_file"),
        row("folder", "folder"),
        row("building", "building"),
        row("its floors and plan", "shape"),
        row("mean side of its triangles [m]", "element"),
        row(f"frequencies {upto}", "frequencies"),
        *_both("frequencies compared", found.range),
        *_both("interpolated: sharp peaks may be low by", f"{low:.2g} %" if low else "not"),
        row("points", "points"),
        *_both("points compared", points),
        *_both("points left out: too far apart", str(told["moved"])),
        *([row("points left out: only here", "alone")] if any(alone) else []),
    )
    title = f"floor response spectra ({100.0 * found.damping:g} %) of two runs, {upto}"
    return Table(CASES, title, (("", ""), ("this run", ""), ("the other", "")), rows)


def _both(words: str, value: str) -> list[tuple[Cell, ...]]:
    """A row with the same in both columns; none without a value."""
    return [(words, value, value)] if value else []


def comparison_table(found: Comparison) -> Table:
    """The largest differences of each spectrum, at which frequency, and the peaks of both.

    Args:
        found: The comparison.
    """
    f = found.frequency[found.known]
    rows = []
    both = (found.differences(of_peak=over)[:, found.known] for over in (False, True))
    for (k, c), apart, of_peak in zip(found.names, *both, strict=True):
        at, at_peak = int(apart.argmax()), int(of_peak.argmax())
        differences = (apart[at], f[at], of_peak[at_peak], f[at_peak])
        place = (found.probes[k], found.components[c], float(found.distance[k]))
        rows.append((*place, *map(float, differences), *found.peaks(k, c)))
    columns = (
        *(("point", ""), ("direction", ""), ("distance of both points", "m")),
        *(("largest difference", "-"), ("at", "Hz")),
        *(("largest over the peak", "-"), ("at", "Hz")),
        *(("peak", "m/s2"), ("peak of the other", "m/s2")),
    )
    title = f"floor response spectra ({100.0 * found.damping:g} %) of {_cases(found)}"
    return Table(TABLE, title, columns, tuple(rows))


def directions_table(found: Comparison) -> Table:
    """For each direction the largest differences of its spectra, and how many ordinates are near.

    Args:
        found: The comparison.
    """
    apart, of_peak = (found.differences(of_peak=over)[:, found.known] for over in (False, True))
    axes = np.array([c for _, c in found.names])
    rows: list[tuple[Cell, ...]] = []
    for c, name in enumerate(found.components):
        mine = axes == c
        if mine.any():
            peaks = np.array([found.peaks(k, axis) for k, axis in found.names if axis == c])
            one = apart[mine]
            figures = (
                np.abs(peaks[:, 0] / peaks[:, 1] - 1.0).max(),
                of_peak[mine].max(),
                one.max(),
                np.percentile(one, 95.0),
                (one <= NEAR).mean(),
            )
            whole = int((one.max(axis=1) <= NEAR).sum())
            rows.append((name, len(one), *map(float, figures), whole))
    columns = (
        *(
            ("direction", ""),
            ("spectra", ""),
            ("largest of peaks", "-"),
            ("largest over the peak", "-"),
        ),
        *(("largest difference", "-"), ("95 % of ordinates", "-")),
        *((f"ordinates within {NEAR:g}", "-"), (f"spectra within {NEAR:g}", "")),
    )
    title = f"differences by direction, of {_cases(found)}"
    return Table(DIRECTIONS, title, columns, tuple(rows))


def _cases(found: Comparison) -> str:
    """Both runs and what was compared, as the end of a title."""
    return (
        f"{found.words()} and of {found.words(other=True)}, at {found.range} and "
        f"{len(found.probes)} points"
    )


def comparison_figure(path: Path, found: Comparison) -> None:
    """The spectrum with the largest difference over its peak in both runs, and δ of all spectra.

    Args:
        path: The PNG file.
        found: The comparison.
    """
    largest, k, c, at = found.worst(of_peak=True)
    f, apart = found.frequency, 100.0 * found.differences()
    caption = (
        f"Floor response spectra ({100.0 * found.damping:g} % damping) of this run, "
        f"{found.words()}, and of the other, {found.words(other=True)}, at {found.range} and "
        f"{len(found.probes)} points. (a) where they differ most, over the peak: "
        f"{found.probes[k].replace('_', ' ')} along $e_{found.components[c]}$, "
        f"{100.0 * largest:.2g} % at {at:.3g} Hz. (b) difference over the other one at the same "
        f"frequency, of the {len(apart)} spectra of points that move; dotted: {found.highest:g} Hz."
    )
    with figure(path, (1, 2), (9.0, 3.8), caption) as (_, axes):
        axes[0].semilogx(f, found.spectrum(k, c), color=BLUE, label="this run")
        other = found.spectrum(k, c, other=True)
        axes[0].semilogx(f, other, color=RED, ls="--", label="the other")
        axes[0].set_ylabel("pseudo-acceleration [m/s²]")
        axes[0].set_ylim(bottom=0.0)
        axes[1].semilogx(f, apart.max(axis=0), color=BLUE, label="largest")
        axes[1].semilogx(f, np.median(apart, axis=0), color=RED, ls="--", label="median")
        axes[1].set_ylabel("difference [%]")
        if apart.any():
            axes[1].set_yscale("log")
        axes[1].yaxis.set_major_formatter("{x:g}")
        for panel in axes:
            panel.axvline(found.highest, color="0.4", ls=":")
            panel.set_xlabel("frequency [Hz]")
            panel.legend(loc="best")
            span(panel, f)
        letter(axes)
