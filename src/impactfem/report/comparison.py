"""Comparison of two runs: one table of their scalar results, and overlaid floor spectra."""

import math
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.figure import figure
from impactfem.plot.style import BLUE, RED
from impactfem.plot.table import Cell, Table, heads
from impactfem.report.run_files import RunFiles
from impactfem.stages.transient.selection import at_floor, floors_of

TABLE, FIGURE = "comparison", "comparison_spectra"
FIRST = (
    "pounding.main_impact_band_force",
    "pounding.mean_force_5ms",
    "pounding.main_impact_force",
    "pounding.impacts",
    "pounding.required_separation",
    "frs.largest",
    "transient.frs.largest",
    "device.f?.detailed.impact",
)
"""Results that come before others."""
LABELS = ("this run", "the other")


def comparison_table(run: RunFiles, other: RunFiles) -> Table:
    """Return the scalar results of both runs in SI with their ratio, those of `FIRST` first."""
    units = {one["name"]: one["unit"] for one in (*other.summary, *run.summary)}
    names = dict.fromkeys([*run.values, *other.values])
    rows: list[tuple[Cell, ...]] = []
    for name in sorted(names, key=lambda name: not any(fnmatchcase(name, p) for p in FIRST)):
        a, b = run.values.get(name), other.values.get(name)
        ratio = None if a is None or not b else a / b
        rows.append((name, units[name], a, b, ratio))
    title = f"results of {run.folder} and of {other.folder}"
    return Table(TABLE, title, heads("name; unit; this run; the other; ratio [-]"), tuple(rows))


@figure(FIGURE, "Floor spectra", "Floor spectra of both runs")
def spectra_figure(target: Path, run: RunFiles, other: RunFiles, highest: float) -> list[Path]:
    """Draw the floor spectra of both runs at the mass centres up to a frequency [Hz].

    Spectra are along the shown direction of the first run. Nothing is drawn where the runs have no
    floor of a 3D model or no damping in common. Gives the files.
    """
    if not (run.has("transient.nc") and other.has("transient.nc")):
        return []
    panels: list[Panel] = []
    with run.store("transient.nc") as one, other.store("transient.nc") as another:
        d, stores = str(one.attrs["shown_direction"]), (one, another)
        common = [x for x in one["damping"].values if np.isclose(x, another["damping"]).any()]
        floors = set(floors_of(one, "centre")) & set(floors_of(another, "centre"))
        for floor in sorted(floors, reverse=True) if common else ():
            curves = []
            for store, label, colour in zip(stores, LABELS, (BLUE, RED), strict=True):
                psa = at_floor(store, "centre", floor)["psa"].sel(component=d)
                psa = psa.sel(damping=common[0], method="nearest")
                psa = psa.sel(frequency=slice(None, highest * (1.0 + 1e-9)))
                dash = "-" if store is one else "--"
                curves.append(Curve(psa["frequency"].values, psa.values, label, colour, dash))
            title = f"floor {floor}, mass centre, {d}"
            axes = "frequency [Hz]", "pseudo-acceleration [m/s²]"
            panels.append(Panel(*axes, curves, title, "x"))
    if not panels:
        return []
    caption = (
        f"Floor response spectra of {run.folder} and of {other.folder}, damping "
        f"{100.0 * common[0]:g} %, up to {highest:g} Hz."
    )
    size = 9.0, 2.6 * math.ceil(len(panels) / 2)
    path = target / f"{FIGURE}.svg"
    CurveFigure(caption, panels, size=size).write(path)
    return [path]
