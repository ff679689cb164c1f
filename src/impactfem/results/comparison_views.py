"""Figure and table of two runs beside each other."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from impactfem.results.comparison import Comparison
from impactfem.results.style import BLUE, RED, figure, letter, span
from impactfem.results.table import Table

FIGURE = "comparison_spectra.png"
TABLE = "comparison_spectra"


def comparison_table(found: Comparison) -> Table:
    """The largest difference of each spectrum, at which frequency, and the peaks of both.

    Args:
        found: The comparison.
    """
    f = found.frequency[found.known]
    rows = []
    for (k, c), apart in zip(found.names, found.differences[:, found.known], strict=True):
        at = int(apart.argmax())
        ours = found.spectrum(k, c)[found.known]
        theirs = found.spectrum(k, c, other=True)[found.known]
        peaks = float(ours.max()), float(theirs.max())
        distance = float(found.distance[k])
        rows.append(
            (found.probes[k], found.components[c], distance, float(apart[at]), float(f[at]), *peaks)
        )
    columns = (
        *(("point", ""), ("direction", ""), ("distance of both points", "m")),
        *(
            ("largest difference", "-"),
            ("at", "Hz"),
            ("peak", "m/s2"),
            ("peak of the other", "m/s2"),
        ),
    )
    title = (
        f"floor response spectra ({100.0 * found.damping:g} %) beside '{found.title}', up to "
        f"{found.highest:g} Hz"
    )
    return Table(TABLE, title, columns, tuple(rows))


def comparison_figure(path: Path, found: Comparison) -> None:
    """The spectrum with the largest difference in both runs, and δ of all over the frequency.

    Args:
        path: The PNG file.
        found: The comparison.
    """
    largest, probe, component, at = found.worst
    k, c = found.probes.index(probe), found.components.index(component)
    f, apart = found.frequency, 100.0 * found.differences
    caption = (
        f"Floor response spectra ({100.0 * found.damping:g} % damping) of this run and of "
        f"'{found.title}'. (a) where they differ most up to {found.highest:g} Hz: {probe} along "
        f"$e_{component}$, {100.0 * largest:.2g} % at {at:.3g} Hz. (b) difference over the other "
        f"one, of the {len(apart)} spectra of points that move; dotted: {found.highest:g} Hz."
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
            panel.legend(loc="upper left")
            span(panel, f)
        letter(axes)
