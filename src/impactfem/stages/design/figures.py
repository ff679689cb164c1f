"""Figures of the design spectra of the 3D building, and of the members of an ensemble."""

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.plot.curves import Curve, CurveFigure, hatched_page
from impactfem.plot.figure import figure
from impactfem.plot.floor_products import building_page, floor_page
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED, letter, sheet
from impactfem.spectra.product import DesignFloorSpectra, FloorSpectrumSet
from impactfem.spectra.statistics import over_members
from impactfem.stages.design.envelopes import largest_impact
from impactfem.stages.design.products import DesignProducts, design_products_of
from impactfem.stages.drawing import FigureData
from impactfem.stages.stores import names_of, of_run

SPECTRA, MOTIONS = "Floor spectra for design", "Over the motions"
"""Sections of the report."""
GREY = "0.72"
STATISTICS = (
    ("mean", "mean", BLUE, "-"),
    ("p84", "84 %", RED, "-"),
    ("p84_lognormal", "84 %, lognormal", ORANGE, "--"),
)
"""Name of a statistic over motions, its label, colour and dashes."""
DEVICES = 3
"""Panels of devices in a row."""


class DesignData(FigureData):
    """The data of the figures of the stage."""

    @cached_property
    def store(self) -> xr.Dataset:
        """`design.nc`."""
        return self.opened("design.nc")

    @cached_property
    def products(self) -> DesignProducts:
        """The design spectra."""
        rules, sticks = self.case.spectra, of_run(self.folder, "pounding.nc")
        return design_products_of(self.store, sticks, rules.broadening, rules.clipping)

    @property
    def members(self) -> FloorSpectrumSet | None:
        """Spectra under the motions of an ensemble; None without one."""
        return self.products.members

    @property
    def rotations(self) -> DesignFloorSpectra | None:
        """Spectra of rotations; None if there are none."""
        return self.products.rotations

    @property
    def spectrum(self) -> list[str]:
        """Directions and dampings of the spectra, as "y_5pct"."""
        return [
            f"{direction}_{100.0 * damping:g}pct"
            for direction in names_of(self.store, "direction")
            for damping in self.store["damping"].values
        ]

    @property
    def shown_spectrum(self) -> list[str]:
        """The spectrum along the shown direction at the first damping."""
        direction, damping = self.store.attrs["shown_direction"], self.store["damping"].values[0]
        return [f"{direction}_{100.0 * damping:g}pct"]


def _place(products: DesignProducts, spectrum: str) -> tuple[int, int]:
    """Indices of the damping and of the direction of a spectrum."""
    source = products.case.source
    for d, x in np.ndindex(len(source.damping), len(source.directions)):
        if spectrum == f"{source.directions[x]}_{100.0 * source.damping[d]:g}pct":
            return d, x
    raise KeyError(spectrum)


@figure(
    "design_spectra",
    SPECTRA,
    "Design spectra of the floors",
    each="spectrum",
    default="shown_spectrum",
)
def design_spectra(products: DesignProducts, spectrum: str) -> CurveFigure:
    """Draw the design spectra under the motion of the case, a panel for each floor."""
    design, (d, x) = products.case, _place(products, spectrum)
    caption = (
        f"under the case's motion: envelope of {_points(products)}, computed and for design "
        f"({design.broadening_text}). Dotted: ZPA. Scales differ."
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
    return _page(products, d, x, caption, floors)


@figure("design_rotations", SPECTRA, "Design spectra of rotations of the floors", default=False)
def design_rotations(rotations: DesignFloorSpectra) -> CurveFigure:
    """Draw the spectra of rotations of the 3D model, computed and for design."""
    return building_page(rotations, rotations.source.stations[0].building)


@figure(
    "design_ensemble",
    MOTIONS,
    "Design spectra over the motions",
    each="spectrum",
    default=False,
)
def design_ensemble(
    products: DesignProducts, members: FloorSpectrumSet, spectrum: str
) -> CurveFigure:
    """Draw the design spectra of statistics over the motions, a panel for each floor."""
    design, (d, x) = products.case, _place(products, spectrum)
    caption = (
        f"over {len(members.motions)} motions, envelope of {_points(products)}: mean and 84th "
        f"percentile for design ({design.broadening_text}). Grey: members. Scales differ."
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
    return _page(products, d, x, caption, floors)


def _page(
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
    page = floor_page(f"{head} {caption}", panels, lettered=False)
    return hatched_page(page, products.store)


def _points(products: DesignProducts) -> str:
    whole = products.store["vertex_count"].any()
    return "the probes and governing vertices" if whole else "the probes alone"


@figure(
    "design_device_force",
    MOTIONS,
    "Anchor forces over the motions",
    when=lambda store: "device" in store.dims,
    default=False,
)
def design_device_force(path: Path, store: xr.Dataset) -> None:
    """Draw the largest force on each anchor against the largest impact force of each motion."""
    axis, names = str(store.attrs["shown_direction"]), names_of(store, "device")
    impact = 1e-6 * largest_impact(store["member_impact_force"].values)
    columns = min(DEVICES, len(names))
    rows = -(-len(names) // columns)
    caption = (
        f"Largest anchor force along $e_{axis}$ by time history and by response spectrum analysis "
        f"over the largest impact force, for {len(impact)} motions. Lines: mean (solid), 84th "
        "percentile (dashed)."
    )
    size = (max(5.0, 3.4 * columns), 3.2 * rows)
    looks = (("force", BLUE, "o", "3D model"), ("spectrum", ORANGE, "^", "response spectra"))
    with sheet(path, (rows, columns), size, caption) as (_, axes):
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
