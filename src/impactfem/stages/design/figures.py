"""Figures of the design spectra of the 3D building: a page for each direction and damping."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED
from impactfem.spectra.product import DesignFloorSpectra
from impactfem.stages.design.products import DesignProducts, design_products_of
from impactfem.stages.stores import open_store

COLUMNS = 4
PANEL = (2.5, 2.1)
"""Width and height [inch]."""
GREY = "0.72"
STATISTICS = (
    ("mean", "mean", BLUE, "-"),
    ("p84", "84 %", RED, "-"),
    ("p84_lognormal", "84 %, lognormal", ORANGE, "--"),
)
"""Name of a statistic over motions, its label, colour and dashes."""


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
    for x in range(len(source.directions)):
        for d in range(len(source.damping)):
            files.append(_case_page(products, d, x).write_png(target))
            if products.statistics:
                files.append(_ensemble_page(products, d, x).write_png(target))
    return files


def design_curves(folder: Path) -> list[CurveFigure]:
    """Design spectra along the shown direction at the first damping, for the report.

    Args:
        folder: The run's folder, with `design.nc`, `pounding.nc` and `case.json`.
    """
    wanted = json.loads((folder / "case.json").read_text(encoding="utf-8"))["spectra"]
    sticks = folder / "pounding.nc"
    with open_store(folder / "design.nc") as store:
        made = design_products_of(store, sticks, wanted["broadening"], wanted["clipping"])
        return [_case_page(made, 0, made.view.directions.index(made.view.direction))]


def _case_page(products: DesignProducts, d: int, x: int) -> CurveFigure:
    """The case's motion; the page has the statistics over an ensemble in addition."""
    design = products.case
    source = design.source
    caption = (
        f"{_head(design, d, x)} under the case's motion: envelope of {_points(products)} of each "
        "floor of the 3D model as computed and for design, beside that of all vertices of the "
        "floor, without samples between, and the design spectrum of the sticks at the mass centre, "
        f"where there are such; {design.broadening_text}. Dotted: zero-period acceleration."
    )
    floors = []
    for s in range(len(source.stations)):
        curves = [
            Curve(source.frequency, design.raw[d, s, x], "3D, computed", BLUE, width=0.6),
            Curve(design.frequency, design.psa[d, s, x], "3D, for design", BLUE, width=1.5),
        ]
        stick = products.of_stick(d, s, x)
        if stick is not None:
            curves.append(Curve(*stick, "sticks, for design", RED, "--", width=1.1))
        whole = products.view.whole(d, s, x)
        if whole is not None:
            curves.append(Curve(*whole, "3D, all vertices, computed", GREEN, width=0.7))
        ends, zpa = design.frequency[[0, -1]], design.zpa[s, x].repeat(2)
        curves.append(Curve(ends, zpa, "", BLUE, ":", width=0.8))
        floors.append([*curves, *_statistics(products, d, s, x, further=True)])
    return _page("design_spectra", design, d, x, caption, floors)


def _ensemble_page(products: DesignProducts, d: int, x: int) -> CurveFigure:
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
    floors = []
    for s in range(len(design.source.stations)):
        curves = [
            Curve(members.frequency, psa, "" if k else "members", GREY, width=0.4)
            for k, psa in enumerate(members.psa[:, d, s, x])
        ]
        curves += _statistics(products, d, s, x)
        own = Curve(design.frequency, design.psa[d, s, x], "the case's motion", "black", ":", 0.9)
        floors.append([*curves, own])
    return _page("design_ensemble", design, d, x, caption, floors)


def _statistics(
    products: DesignProducts, d: int, s: int, x: int, *, further: bool = False
) -> list[Curve]:
    found = products.statistics
    return [
        Curve(found[n].frequency, found[n].psa[d, s, x], label, colour, dash, 1.3, further=further)
        for n, label, colour, dash in STATISTICS
        if n in found
    ]


def _page(
    name: str,
    design: DesignFloorSpectra,
    d: int,
    x: int,
    caption: str,
    floors: Sequence[Sequence[Curve]],
) -> CurveFigure:
    """A page with a panel for each floor."""
    source, count = design.source, len(floors)
    columns = min(COLUMNS, count)
    panels = [
        Panel(
            "frequency [Hz]" if k + columns >= count else "",
            "acceleration [m/s²]" if k % columns == 0 else "",
            curves,
            title=station.label,
            log="x",
            bottom=0.0,
            legend="",
        )
        for k, (station, curves) in enumerate(zip(source.stations, floors, strict=True))
    ]
    size = (max(PANEL[0] * columns, 3.0 * PANEL[0]), PANEL[1] * math.ceil(count / columns) + 0.4)
    stem = f"{name}_{source.directions[x]}_{100.0 * source.damping[d]:g}pct"
    return CurveFigure(
        stem, caption, panels, columns=columns, size=size, lettered=False, above=True
    )


def _points(products: DesignProducts) -> str:
    whole = products.view.vertex_counts.any()
    return "the probes and of the governing vertices" if whole else "the PROBES ALONE"


def _head(design: DesignFloorSpectra, d: int, x: int) -> str:
    source = design.source
    return (
        f"Floor response spectra of building {source.stations[0].building} along "
        f"$e_{source.directions[x]}$ ({100.0 * source.damping[d]:g} % damping)"
    )
