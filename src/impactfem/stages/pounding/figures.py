"""The figures of the stage `pounding`, from its stores, in the paper's layout and numbering."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.style import BUILDINGS, DASHES, GREEN, floor_looks
from impactfem.stages.pounding.model_figures import case_figure, contact_figure, stick_figure
from impactfem.stages.stores import open_store


def stick_figures(folder: Path) -> list[Path]:
    """Draw figures 2, 3, 5, 8, 9 and 10 into `figures/`; the files.

    Those about impacts are left out when nothing can touch.
    """
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    drawn = [target / name for name in ("figure_02_case.png", "figure_03_stick.png")]
    with (
        open_store(folder / "motion.nc") as motion,
        open_store(folder / "pounding.nc") as sticks,
        open_store(folder / "forces.nc") as forces,
    ):
        case_figure(drawn[0], motion, sticks, forces)
        stick_figure(drawn[1], sticks)
        curves = [_response(sticks), _floor_spectra(sticks)]
        if sticks.sizes["pair"]:
            drawn.append(target / "figure_05_contact.png")
            contact_figure(drawn[-1], sticks, forces)
            curves.append(_forces(sticks, forces))
        return [*drawn, *(figure.write_png(target) for figure in curves)]


def stick_curves(folder: Path) -> list[CurveFigure]:
    """Ground motion, floor spectra and impact forces, for the report; argument as above."""
    with open_store(folder / "pounding.nc") as sticks, open_store(folder / "forces.nc") as forces:
        direction = str(sticks.attrs["shown_direction"])
        ground = Curve(sticks["time"].values, sticks["ground"].sel(axis=direction).values, "ground")
        panel = Panel("time [s]", "acceleration [m/s²]", [ground])
        motion = CurveFigure(
            "motion", f"Ground acceleration along $e_{direction}$.", [panel], columns=1
        )
        hit = bool(forces["force"].size) and float(abs(forces["force"]).max()) > 0.0
        return [motion, _floor_spectra(sticks), *([_forces(sticks, forces)] if hit else [])]


def _response(sticks: xr.Dataset) -> CurveFigure:
    direction = str(sticks.attrs["shown_direction"])
    time, moving = sticks["time"].values, sticks.sel(component=direction)
    tops = [
        moving.isel(station=moving["station_building"] == name).isel(station=-1)
        for name in sticks["building"].values
    ]
    panels = [
        Panel(
            "time [s]",
            label,
            [
                Curve(
                    time,
                    factor * top[name].values,
                    f"{top.station_building.item()}, floor {top.station_floor.item()}",
                    BUILDINGS[index % len(BUILDINGS)],
                    DASHES[index % len(DASHES)],
                    width=0.8,
                )
                for index, top in enumerate(tops)
            ],
            room=0.2,
            legend="" if name != "displacement" else "upper right",
        )
        for name, factor, label in (
            ("displacement", 1e2, f"displacement $u_{direction}$ [cm]"),
            ("velocity", 1.0, f"velocity $\\dot u_{direction}$ [m/s]"),
            ("acceleration", 1.0, f"acceleration $\\ddot u_{direction}$ [m/s²]"),
        )
    ]
    last = ""
    if sticks.sizes["pair"]:
        last = ", and the gap between them (d)"
        gap = sticks["gap"].isel(pair=sticks["pair_required_separation"].argmax("pair"))
        curve = Curve(time, 1e2 * gap.values, str(gap.pair.item()), "black", width=0.8)
        contact = Curve(time[[0, -1]], 0.0 * time[[0, -1]], "contact", GREEN, "--", width=0.8)
        panels.append(Panel("time [s]", "gap [cm]", [curve, contact], room=0.2))
    caption = (
        "Figure 8: Displacement (a) and velocity (b) relative to the ground, absolute acceleration "
        f"(c) along $e_{direction}$ of the top floors{last}, over time."
    )
    return CurveFigure("figure_08_response", caption, panels, size=(9.0, 5.6))


def _forces(sticks: xr.Dataset, forces: xr.Dataset) -> CurveFigure:
    time, every = forces["time"].values, 1e-6 * forces["force"].transpose("pair", "time")
    force = every.isel(pair=every.max("time").argmax("pair"))
    name, dt = str(force["pair"].item()), time[1] - time[0]
    whole = [Curve(time, force.values, name.replace("-", " and "))]
    for k, other in enumerate(every):
        if str(other["pair"].item()) != name and float(abs(other).max()) > 0.0:
            label = str(other["pair"].item()).replace("-", " and ")
            colour = BUILDINGS[(k + 1) % len(BUILDINGS)]
            whole.append(Curve(time, other.values, label, colour, further=True))
    near: list[Curve] = []
    impacts = sticks.isel(impact=sticks["impact_pair"] == name)
    if impacts.sizes["impact"]:
        impact = impacts.isel(impact=impacts["impact_peak_force"].argmax("impact"))
        start, end = float(impact["impact_first_contact"]), float(impact["impact_end"])
        margin = 0.25 * (end - start) + dt
        shown = (time >= start - margin) & (time <= end + margin)
        label = f"{impact['impact_steps']:.0f} computed times, {1e3 * (end - start):.1f} ms"
        near = [Curve(time[shown], force.values[shown], label, marker=".")]
    caption = (
        f"Figure 9: Impact force of the pair {name} (a), and its main impact with the computed "
        "times (b). Positive in compression; the force pulls at the end of an impact when the law "
        "allows tension."
    )
    axes = ("time [s]", "impact force [MN]")
    note = "" if near else "no impact"
    panels = [Panel(*axes, whole, legend=""), Panel(*axes, near, room=0.25, note=note)]
    return CurveFigure("figure_09_forces", caption, panels, size=(9.0, 3.2))


def _floor_spectra(sticks: xr.Dataset) -> CurveFigure:
    direction = str(sticks.attrs["shown_direction"])
    studied = str(sticks.attrs["studied_building"])
    spectra = sticks.sel(direction=direction).isel(damping=0)
    floors = spectra.isel(station=spectra["station_building"] == studied)
    frequency, damping = sticks["frequency"].values, float(floors["damping"])
    caption = (
        f"Figure 10: Floor response spectra (pseudo-acceleration, {100 * damping:g} % damping) of "
        f"building {studied} along $e_{direction}$ at the mass centres, with pounding (a) and "
        "without contact (b)."
    )
    looks = floor_looks(floors.sizes["station"])
    panels = [
        Panel(
            "frequency [Hz]",
            "pseudo-acceleration [m/s²]",
            [
                Curve(frequency, psa.values, f"floor {psa.station_floor.item()}", *look.values())
                for look, psa in zip(
                    looks, floors[name].transpose("station", "frequency"), strict=True
                )
            ],
            log="x",
            bottom=0.0,
            room=0.05,
            legend=legend,
            reverse=True,
        )
        for name, legend in (("psa", ""), ("psa_free", "upper right"))
    ]
    return CurveFigure("figure_10_floor_spectra", caption, panels, alike=True)
