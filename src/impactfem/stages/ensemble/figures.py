"""The figures, table and checks of the stage `ensemble`: percentiles over the motions."""

import re
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.lines import Line2D

from impactfem.case import Case
from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.figure import figure
from impactfem.plot.floor_products import FloorDesigns, building_page, floor_designs
from impactfem.plot.style import BLUE, ORANGE, RED, sheet
from impactfem.plot.table import Cell, Table
from impactfem.spectra.product import DesignFloorSpectra
from impactfem.stages.check import Check, Criterion
from impactfem.stages.drawing import FigureData
from impactfem.stages.inputs import published_values
from impactfem.stages.pounding.checks import SWING, SWING_AT_END
from impactfem.stages.stores import names_of, open_store

FACING = "pounding.facing_distance_min"
"""Scalar of the closest approach of floors that face each other and are in no contact pair."""


class EnsembleData(FigureData):
    """The data of the figures of the stage."""

    @cached_property
    def store(self) -> xr.Dataset:
        """`ensemble.nc`."""
        return self.opened("ensemble.nc")

    @cached_property
    def published(self) -> Mapping[str, float]:
        """Published values that other motions can miss, not those of the input."""
        return published_results(self.case)

    @cached_property
    def compared(self) -> Table | None:
        """The percentiles with published values; None without a published value."""
        table = bands(self.store, self.published)
        return None if all(row[-2] is None for row in table.rows) else table

    @cached_property
    def building(self) -> list[str]:
        """Names of the buildings."""
        return list(dict.fromkeys(names_of(self.store, "station_building")))

    @cached_property
    def translations(self) -> DesignFloorSpectra:
        """Spectra for design, of the mean over the motions."""
        return self._designs.translations

    @cached_property
    def rotations(self) -> DesignFloorSpectra | None:
        """The same of rotations; None if there are none."""
        return self._designs.rotations

    @cached_property
    def _designs(self) -> FloorDesigns:
        return floor_designs(self.folder / "ensemble.nc", self.case.spectra, "mean")


def published_results(case: Case) -> dict[str, float]:
    """Return published values that other motions can miss: not what all are scaled or given to."""
    same = ("input", "fitted", "scaled")
    return {n: v for n, v in published_values(case).items() if case.published[n].kind not in same}


def ensemble_table(folder: Path, published: Mapping[str, float]) -> list[Path]:
    """Write the table of `ensemble.nc`; published values by the name of the scalar."""
    with open_store(folder / "ensemble.nc") as store:
        (folder / "tables").mkdir(exist_ok=True)
        table = bands(store, published)
        return [table.comparing({"published", "inside"}).write_csv(folder / "tables")]


@figure("ensemble_spectra", "Floor spectra", "Floor response spectra over all motions")
def ensemble_spectra(store: xr.Dataset) -> CurveFigure:
    """Draw median and bands of some floors of the studied building."""
    direction, studied = str(store.attrs["shown_direction"]), store.attrs["studied_building"]
    of_building = store["station_building"] == studied
    spectra = store.sel(direction=direction).isel(damping=0, station=of_building)
    floors = spectra["station_floor"].values
    shown = np.unique(np.linspace(0, len(floors) - 1, 4).round().astype(int))[::-1]
    damping = float(spectra["damping"])
    caption = (
        f"Floor response spectra ({100 * damping:g} % damping) of building "
        f"{studied} along $e_{direction}$ over {store.sizes['motion']} "
        "motions, with pounding and without contact: median, 16th to 84th percentile (shaded) and "
        "5th to 95th percentile (dotted)."
    )
    panels = [
        Panel(
            "frequency [Hz]",
            "pseudo-acceleration [m/s²]",
            [
                *_with_band(spectra["psa_percentile"][{"station": s}], BLUE, "with pounding"),
                *_with_band(
                    spectra["psa_free_percentile"][{"station": s}], ORANGE, "without contact"
                ),
            ],
            title=f"floor {floors[s]}",
            log="x",
            bottom=0.0,
            legend="upper left" if s == shown[0] else "",
        )
        for s in shown
    ]
    rows, columns = (len(shown) + 1) // 2, min(2, len(shown))
    size = (9.0, 2.8 * rows)
    return CurveFigure(caption, panels, columns=columns, size=size)


@figure(
    "ensemble_design",
    "Floor spectra",
    "Floor response spectra for design, mean over the motions",
    each="building",
    default=False,
)
def ensemble_design(translations: DesignFloorSpectra, building: str) -> CurveFigure:
    """Draw the design spectra of a building, of the mean over the motions."""
    return building_page(translations, building)


@figure(
    "ensemble_rotations",
    "Floor spectra",
    "Spectra of rotations for design, mean over the motions",
    each="building",
    default=False,
)
def ensemble_rotations(rotations: DesignFloorSpectra, building: str) -> CurveFigure:
    """Draw the spectra of rotations of a building, of the mean over the motions."""
    return building_page(rotations, building)


@figure(
    "ensemble_published",
    "Published values",
    "Published values and the spread over the motions",
    default=False,
)
def ensemble_published(path: Path, compared: Table) -> None:
    """Draw the percentiles of each result divided by its published value."""
    rows = [row for row in compared.rows[::-1] if row[-2] is not None and float(row[-2]) != 0.0]
    caption = (
        "Results of the ensemble over their published values: median (dot), 16 % to 84 % (thick) "
        "and 5 % to 95 % (thin). The published value is 1, at the dashed line."
    )
    size = 7.5, 0.26 * len(rows) + 0.8
    outside = [in_words(str(row[0])) for row in rows if row[-1] != "yes"]
    seen = f"{len(rows)} bars over one another; outside: {', '.join(outside) or 'none'}."
    with sheet(path, (1, 1), size, caption, seen) as (_, axes):
        panel = axes[0]
        for y, row in enumerate(rows):
            paper = float(row[-2] or 1.0)
            p05, p16, p50, p84, p95 = (float(value or 0.0) / paper for value in row[3:8])
            # Not by colour alone: what is outside is open as well.
            inside = row[-1] == "yes"
            colour = BLUE if inside else RED
            panel.plot([p05, p95], [y, y], color=colour, lw=1.0, ls="-" if inside else "--")
            panel.plot([p16, p84], [y, y], color=colour, lw=4.0, solid_capstyle="butt")
            panel.plot(p50, y, "o", color="black", ms=3.5)
        panel.axvline(1.0, color="black", lw=0.8, ls="--")
        panel.set_yticks(range(len(rows)), [in_words(str(row[0])) for row in rows], fontsize=7.5)
        sides = (("inside 5 % to 95 %", BLUE, "-"), ("outside", RED, "--"))
        lines = [Line2D([], [], color=c, ls=dash, lw=1.5, label=name) for name, c, dash in sides]
        panel.legend(handles=lines, title="published value")
        panel.set_xlabel("over the published value [-]")
        panel.set_xlim(left=0.0)


def in_words(name: str) -> str:
    """The name of a scalar for a reader: "frs.floor_8.peak" is "FRS, floor 8, peak"."""
    text = name.removeprefix("pounding.").replace(".", ", ").replace("_", " ")
    return re.sub(r"\b(frs|pfa|pga|sa)\b", lambda word: word[0].upper(), text)


FAILED = Criterion(
    "ensemble.failed_motions",
    "failed motions",
    upper=0,
    consequence="Percentiles are those of fewer motions",
    remedy="See run.log for the reason of each failure",
)
FACING_OVERLAP = Criterion(
    "ensemble.facing_overlap",
    "motions under which floors overlap that are in no contact pair",
    upper=0,
    severity="invalid",
    consequence="These floors would collide; the computed impacts are not all",
    remedy="Add the pairs to [[contacts]]; tables/facing_floors.csv of the stage pounding lists "
    "them",
)
SWING_AT_THE_END = Criterion(
    "ensemble.swing_at_end",
    f"motions under which a building moves by more than {100.0 * SWING:g} % of its largest "
    "displacement at the end",
    upper=0,
    consequence="Later impacts are not computed",
    remedy="Raise pounding.duration",
)
PUBLISHED = Criterion(
    "ensemble.published_inside", "published values between the 5th and 95th percentile"
)


def ensemble_checks(folder: Path, published: Mapping[str, float]) -> list[Check]:
    """Return the checks of the stage; arguments as `ensemble_table`."""
    with open_store(folder / "ensemble.nc") as store:
        rows = [row for row in bands(store, published).rows if row[-1] is not None]
        failed, motions = store.sizes.get("failed", 0), store.sizes["motion"]
        nearest, swing = (
            store["value"].isel(scalar=store["scalar"] == name).values
            for name in (FACING, SWING_AT_END)
        )
    checks = [FAILED.check(failed, f"of {motions + failed}")]
    if nearest.size:
        checks.append(FACING_OVERLAP.check(int((nearest < 0.0).sum()), f"of {nearest.size}"))
    if swing.size:
        checks.append(SWING_AT_THE_END.check(int((swing > SWING).sum()), f"of {swing.size}"))
    if rows:
        outside = [str(row[0]) for row in rows if row[-1] == "no"]
        which = f"outside: {', '.join(outside)}" if outside else ""
        # Some lie outside even for a correct model; no source states how many may.
        checks.append(PUBLISHED.check(len(rows) - len(outside), f"of {len(rows)}", which))
    return checks


def bands(store: xr.Dataset, published: Mapping[str, float]) -> Table:
    """Percentiles of every result, and whether the published value lies inside 5 % to 95 %."""
    rows: list[tuple[Cell, ...]] = []
    for result in names_of(store, "scalar"):
        values = store.sel(scalar=result)
        known = int(values["value"].count())
        if not known:
            continue
        percentiles = values["value_percentile"].values.tolist()
        paper = published.get(result)
        inside = None
        if paper is not None:
            inside = "yes" if percentiles[0] <= paper <= percentiles[-1] else "no"
        rows.append((result, str(values["unit"].item()), known, *percentiles, paper, inside))
    return Table(
        "ensemble",
        f"Ensemble of {store.sizes['motion']} motions: percentiles, linear between the sorted "
        "values of those that have the result, the smallest one 0 %",
        (
            ("result", ""),
            ("unit", ""),
            ("motions", ""),
            *((f"{q:g} %", "") for q in store["percentile"].values),
            ("published", ""),
            ("inside", ""),
        ),
        tuple(rows),
    )


def _with_band(spectra: xr.DataArray, colour: str, label: str) -> list[Curve]:
    """The median with the band from 16 % to 84 %, and from 5 % to 95 % between dotted lines."""
    frequency = spectra["frequency"].values
    low, middle, high = (spectra.sel(percentile=q).values for q in (16.0, 50.0, 84.0))
    curves = [Curve(frequency, middle, label, colour, band=(low, high))]
    for q in (5.0, 95.0):
        curves.append(Curve(frequency, spectra.sel(percentile=q).values, "", colour, ":", 0.7))
    return curves
