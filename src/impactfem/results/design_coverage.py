"""How much of a floor the envelope of its points covers: beside that of all its vertices."""

from __future__ import annotations

import numpy as np

from impactfem.results.design_view import DesignView
from impactfem.results.table import Cell, Table
from impactfem.spectra.interpolation import interpolate_frequency


def coverage_table(view: DesignView) -> Table | None:
    """Of each floor and direction, where its vertices exceed the envelope of the points most.

    Args:
        view: The design spectra.

    Returns:
        The table; None where there are no spectra over whole floors.
    """
    source = view.case
    rows: list[tuple[Cell, ...]] = []
    for s, station in enumerate(source.stations):
        for x, direction in enumerate(source.directions):
            for d, damping in enumerate(source.damping):
                whole = view.whole(d, s, x)
                if whole is None:
                    continue
                frequency, vertices = whole
                points = interpolate_frequency(source.frequency, source.psa[0, d, s, x], frequency)
                peak, worst = int(np.argmax(vertices)), int(np.argmax(vertices - points))
                rows.append(
                    (
                        *(station.building, station.floor, direction),
                        *_cells(damping),
                        *(len(station.points), view.vertices(s)),
                        *_cells(source.psa[0, d, s, x].max(), vertices[peak], frequency[peak]),
                        *_cells(points[worst], vertices[worst], frequency[worst]),
                    )
                )
    if not rows:
        return None
    return Table(
        "design_coverage",
        "Envelope of the points of each floor beside that of all its vertices, as computed",
        (
            *(("building", ""), ("floor", ""), ("direction", ""), ("damping", "-")),
            *(("points", ""), ("vertices", "")),
            ("peak of the points", "m/s2"),
            ("peak of the vertices", "m/s2"),
            ("at", "Hz"),
            ("points where the vertices exceed them most", "m/s2"),
            ("vertices there", "m/s2"),
            ("there", "Hz"),
        ),
        tuple(rows),
    )


def _cells(*values: float) -> tuple[Cell, ...]:
    return tuple(float(f"{value:.6g}") for value in values)
