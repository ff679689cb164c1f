"""The figure of the governing floor response spectra."""

import math
from pathlib import Path
from typing import Any

import xarray as xr

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.figure import figure
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED
from impactfem.report.buildings import in_3d
from impactfem.report.governing import MODEL, PLACES, STICK, Spectrum
from impactfem.report.run_files import SPECTRA, RunFiles
from impactfem.stages.stores import names_of
from impactfem.stages.transient.selection import known

PURPLE = "#7a4fa3"


@figure(SPECTRA, "Summary", "Governing floor response spectra")
def spectra_figure(run: RunFiles, spectra: list[Spectrum]) -> Path | None:
    """Draw the governing spectra of a building, and of an anchor or of a second building."""
    anchors = [one for one in spectra if one.at_anchor]
    buildings = dict.fromkeys(one.building for one in spectra if not one.at_anchor)
    panels = [_building_panel(run, spectra, name) for name in [*buildings][: 1 if anchors else 2]]
    for one in anchors[:1]:
        whole = one.psa if one.whole is None else one.whole
        curves = [_curve(whole, "with impacts", GREEN, "-")]
        if one.free is not None:
            curves.append(_curve(one.free, "without impact", GREEN, "--"))
        title = f"Anchor of {one.model}, {one.building}, direction {one.direction}"
        if math.isfinite(one.damping):
            title += f", {100.0 * one.damping:.3g} % damping"
        panels.append(_panel(curves, title, one.end))
    if not panels:
        return None
    caption = (
        "Governing floor response spectra with impact (solid) and without impact (dashed). "
        + ("Hatched: above the resolved band. " if any(p.hatched for p in panels) else "")
        + " ".join(f"({'ab'[k]}) {panel.title}." for k, panel in enumerate(panels))
    )
    size = (5.5 * len(panels), 3.3)
    path = run.folder / "figures" / f"{SPECTRA}.svg"
    CurveFigure(caption, panels, len(panels), size).write(path)
    return path


def _building_panel(run: RunFiles, spectra: list[Spectrum], building: str) -> Panel:
    """Return the spectra of the governing floor of a building along the governing direction."""
    # If a point on no floor governs: the point, and the governing floor of the stick.
    own = [one for one in spectra if one.building == building and not one.at_anchor]
    first = own[0]
    along = (one for one in own if (one.model, one.direction) == (STICK, first.direction))
    floor, curves = first.floor or next(along, first).floor, []
    touched = in_3d(run.case)
    with run.store("pounding.nc") as store:
        one = store[["psa", "psa_free"]].isel(damping=0)
        here = (one["station_building"] == building) & (one["station_floor"] == floor)
        if first.direction in names_of(store, "direction"):
            pounded = one.isel(station=here.values).sel(direction=first.direction)
            model = f"{MODEL}, {PLACES['centre']}" if building in touched else STICK
            for name, dash, words in (("psa", "-", "with impacts"), ("psa_free", "--", "without")):
                curves += [_curve(psa, f"{model}, {words}", BLUE, dash) for psa in pounded[name]]
    if building in run.models and run.models[building].ran("transient"):
        with run.models[building].store("transient.nc") as store:
            one = known(store[["psa"]].isel(damping=0)).sel(component=first.direction)
            kinds = {"centre": ORANGE, "edge": RED}
            if building in touched:
                del kinds["centre"]  # as it pounded
            for kind, colour in kinds.items():
                here = (one["probe_kind"] == kind) & (one["probe_floor"] == floor)
                at = one["psa"].isel(probe=here.values)
                curves += [_curve(psa, f"3D model, {PLACES[kind]}", colour, "-") for psa in at]
    if first.model == MODEL and first.place not in (PLACES["centre"], PLACES["edge"]):
        whole = first.psa if first.whole is None else first.whole
        curves.append(_curve(whole, f"3D model, {first.place}", PURPLE, "-"))
        if first.free is not None:
            curves.append(_curve(first.free, f"3D model, {first.place}, without", PURPLE, "--"))
    title = f"{building}, floor {floor}, " if floor else f"{building}, "
    title = f"{title}direction {first.direction}, {100.0 * first.damping:.3g} % damping"
    return _panel(curves, title, first.end)


def _curve(spectrum: xr.DataArray, label: str, colour: str, dash: str) -> Curve:
    return Curve(spectrum["frequency"].values, spectrum.values, label, colour, dash, width=1.3)


def _panel(curves: list[Curve], title: str, resolved_end: float) -> Panel:
    """Return a panel of spectra that is hatched above the resolved band."""
    axes: dict[str, Any] = {"log": "x", "bottom": 0.0, "legend": "best"}
    last = max(float(curve.x[-1]) for curve in curves)
    if last > resolved_end:
        axes["hatched"] = (resolved_end, last)
    return Panel("frequency [Hz]", "pseudo-acceleration [m/s²]", curves, title, **axes)
