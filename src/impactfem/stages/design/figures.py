"""Figures of the design spectra of the 3D building, and of the members of an ensemble."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.plot.curves import Curve, CurveFigure
from impactfem.plot.floor_products import floor_page
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED, figure, letter
from impactfem.spectra.product import FloorSpectrumSet
from impactfem.spectra.statistics import over_members
from impactfem.stages.design.envelopes import largest_impact
from impactfem.stages.design.products import DesignProducts
from impactfem.stages.stores import names_of

GREY = "0.72"
STATISTICS = (
    ("mean", "mean", BLUE, "-"),
    ("p84", "84 %", RED, "-"),
    ("p84_lognormal", "84 %, lognormal", ORANGE, "--"),
)
"""Name of a statistic over motions, its label, colour and dashes."""
DEVICES = 3
"""Panels of devices in a row."""


def design_figures(folder: Path, products: DesignProducts) -> list[Path]:
    """Draw the design spectra along each direction at each damping, and the forces on the anchors.

    Gives the files. ImpactfemError: a file cannot be written.
    """
    target = folder / "figures"
    source = products.case.source
    files = []
    for x, d in np.ndindex(len(source.directions), len(source.damping)):
        files.append(_case_page(products, d, x).write(target))
        if products.members is not None:
            files.append(_ensemble_page(products, products.members, d, x).write(target))
    if "device" in products.store.dims:
        files.append(target / "design_device_force.svg")
        _force_figure(files[-1], products.store)
    return files


def _case_page(products: DesignProducts, d: int, x: int) -> CurveFigure:
    design = products.case
    caption = (
        f"under the case's motion: envelope of {_points(products)} of each floor of the 3D model "
        "as computed and for design; of all vertices of the floor, without samples between; design "
        "spectrum of the mass centre in the pounding, if computed; "
        f"{design.broadening_text}. Dotted: zero-period acceleration. Scales of "
        "the floors differ."
    )
    floors = []
    for s in range(len(design.source.stations)):
        place = d, s, x
        curves = [
            Curve(design.source.frequency, design.raw[place], "3D, computed", BLUE, width=0.6),
            Curve(design.frequency, design.psa[place], "3D, for design", BLUE, width=1.5),
        ]
        stick, whole = products.of_stick(place), products.of_vertices(place)
        if stick is not None:
            curves.append(Curve(*stick, "pounding, for design", RED, "--", width=1.1))
        if whole is not None:
            curves.append(Curve(*whole, "3D, all vertices, computed", GREEN, width=0.7))
        ends, zpa = design.frequency[[0, -1]], design.zpa[s, x].repeat(2)
        curves.append(Curve(ends, zpa, "", BLUE, ":", width=0.8))
        floors.append(curves)
    return _page("design_spectra", products, d, x, caption, floors)


def _ensemble_page(
    products: DesignProducts, members: FloorSpectrumSet, d: int, x: int
) -> CurveFigure:
    design = products.case
    caption = (
        f"over {len(members.motions)} motions, envelope of {_points(products)} of each floor of "
        "the 3D model: design spectra of the mean, of the 84 % fractiles and of the "
        f"case's own motion; {design.broadening_text}. Grey: the members as computed. "
        "Scales of the floors differ."
    )
    floors = []
    for s in range(len(design.source.stations)):
        curves = [
            Curve(members.frequency, psa, "" if k else "members", GREY, width=0.4)
            for k, psa in enumerate(members.psa[:, d, s, x])
        ]
        for name, label, colour, dash in STATISTICS:
            if (one := products.statistics.get(name)) is not None:
                curves.append(Curve(one.frequency, one.psa[d, s, x], label, colour, dash, 1.3))
        own = Curve(design.frequency, design.psa[d, s, x], "the case's motion", "black", ":", 0.9)
        floors.append([*curves, own])
    return _page("design_ensemble", products, d, x, caption, floors)


def _page(
    name: str,
    products: DesignProducts,
    d: int,
    x: int,
    caption: str,
    floors: Sequence[Sequence[Curve]],
) -> CurveFigure:
    """A page with a panel for each floor."""
    source = products.case.source
    damping, direction = f"{100.0 * source.damping[d]:g}", source.directions[x]
    head = (
        f"Floor response spectra of building {source.stations[0].building} along $e_{direction}$ "
        f"({damping} % damping)"
    )
    panels = [(station.label, one) for station, one in zip(source.stations, floors, strict=True)]
    stem = f"{name}_{direction}_{damping}pct"
    return floor_page(stem, f"{head} {caption}", panels, lettered=False)


def _points(products: DesignProducts) -> str:
    whole = products.store["vertex_count"].any()
    return "the probes and of the governing vertices" if whole else "the PROBES ALONE"


def _force_figure(path: Path, store: xr.Dataset) -> None:
    axis, names = str(store.attrs["shown_direction"]), names_of(store, "device")
    impact = 1e-6 * largest_impact(store["member_impact_force"].values)
    columns = min(DEVICES, len(names))
    rows = -(-len(names) // columns)
    caption = (
        f"Largest force on the anchor along $e_{axis}$ in the 3D model and by response spectrum "
        f"analysis ({store.attrs['analysis']}), against the largest impact force, "
        f"for each of {len(impact)} motions. Lines: mean (solid) and 84 % fractile (dashed) of "
        "either."
    )
    size = (max(5.0, 3.4 * columns), 3.2 * rows)
    looks = (("force", BLUE, "o", "3D model"), ("spectrum", ORANGE, "^", "response spectra"))
    with figure(path, (rows, columns), size, caption) as (_, axes):
        for spare in axes[len(names) :]:
            spare.set_visible(False)
        for panel, name in zip(axes, names, strict=False):
            for kind, colour, marker, label in looks:
                values = store[f"member_device_{kind}"].sel(device=name, component=axis).values
                force = 1e-3 * values
                panel.plot(impact, force, marker, color=colour, ms=4.5, label=label, alpha=0.85)
                for statistic, style in (("mean", "-"), ("p84", "--")):
                    level = float(over_members(force, statistic))
                    panel.axhline(level, color=colour, lw=0.9, ls=style)
            panel.set(xlabel="largest impact force [MN]", ylabel=f"force of {name} [kN]")
            panel.set_ylim(bottom=0.0)
        axes[0].legend(loc="best")
        if len(names) > 1:
            letter(axes[: len(names)])
