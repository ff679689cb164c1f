"""How much of a floor the envelope of its points has: beside that of all its vertices."""

from __future__ import annotations

import numpy as np

from impactfem.plot.table import Cell, Table
from impactfem.stages.design.view import VERTICES, DesignView


def coverage_table(view: DesignView) -> Table | None:
    """Of each floor and direction, what its points have of the envelope of all its vertices.

    Args:
        view: The design spectra.

    Returns:
        The table; None where there are no spectra over whole floors.
    """
    source = view.case
    rows: list[tuple[Cell, ...]] = []
    for s, x in view.places:
        station = source.stations[s]
        for d, damping in enumerate(source.damping):
            whole = view.whole(d, s, x)
            if whole is None:
                continue
            frequency, vertices = whole
            at, share = view.reached(s, x)
            worst, peak = int(np.argmin(share[:-1])), int(np.argmax(vertices))
            rows.append(
                (
                    *(station.building, station.floor, source.directions[x], _cell(damping)),
                    view.number_of_points(s, x) - int(view.vertex_counts[s, x]),
                    *(int(view.vertex_counts[s, x]), view.vertices(s)),
                    *map(_cell, (view.probes_peak(d, s, x), source.psa[0, d, s, x].max())),
                    *map(_cell, (vertices[peak], frequency[peak])),
                    *map(_cell, (share[worst], at[worst], share[-1])),
                )
            )
    if not rows:
        return None
    return Table(
        "design_coverage",
        "What the points of each floor have of the envelope of all its vertices, as computed",
        (
            *(("building", ""), ("floor", ""), ("direction", ""), ("damping", "-")),
            *(("probes", ""), ("vertices that govern", ""), ("vertices", "")),
            ("peak of the probes alone", "m/s2"),
            ("peak of the points", "m/s2"),
            ("peak of all vertices, without samples between", "m/s2"),
            ("at", "Hz"),
            ("least part at any frequency, sampled alike", "-"),
            ("there", "Hz"),
            ("part of the peak acceleration", "-"),
        ),
        tuple(rows),
    )


def vertex_table(view: DesignView) -> Table | None:
    """The vertices that govern: where they are, their peaks, and where they are the largest.

    Args:
        view: The design spectra.

    Returns:
        The table; None without such vertices.
    """
    store, source = view.store, view.case
    if "vertex" not in store.dims:
        return None
    probes = store.sizes["point"] - store.sizes["vertex"]
    rows: list[tuple[Cell, ...]] = []
    for v, s in enumerate(store["vertex_station"].values):
        x = source.directions.index(str(store["vertex_direction"].values[v]))
        largest = store["governing"].values[:, s, x] == probes + v
        rows.append(
            (
                *(source.stations[s].building, source.stations[s].floor, source.directions[x]),
                int(store["vertex_node"].values[v]),
                *map(_cell, store["vertex_position"].values[v]),
                _cell(float(largest.mean())),
            )
        )
    return Table(
        VERTICES,
        "The vertices that govern the envelopes of the floors under the case's motion",
        (
            *(("building", ""), ("floor", ""), ("direction", ""), ("node", "")),
            *((axis, "m") for axis in "xyz"),
            ("part of the frequencies at which it is the largest", "-"),
        ),
        tuple(rows),
    )


def _cell(value: float) -> Cell:
    return float(f"{value:.6g}")
