"""The figures of the stage `pounding`, from its stores, in the paper's layout and numbering."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.plot.curves import NONE, Curve, CurveFigure, Panel, published_point
from impactfem.plot.floor_field import line_load_maps
from impactfem.plot.style import BUILDINGS, DASHES, GREEN, ORANGE, RED, floor_looks
from impactfem.stages.pounding.elevation import elevation_figure
from impactfem.stages.pounding.model_figures import case_figure, contact_figure, stick_figure
from impactfem.stages.stores import by_line, damping_of, names_of, open_store
from impactfem.system.arrays import Array

OTHERS = (RED, GREEN, ORANGE, "#CC79A7", "black")
"""Colours of pairs that touch in addition to the one with the largest force."""
CUT = 0.01
"""Part of the largest line loads that is drawn in the last colour: single points have these."""
MOST = 4
"""Lines that are drawn, those with the largest forces."""
MARGIN = 0.15
"""Part of the length of the main impact that is shown before and after it."""


def stick_figures(folder: Path, published: Mapping[str, float] = NONE) -> list[Path]:
    """Draw the figures for which the case has data, and return the files.

    Published values are in SI by the name of the result.
    """
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    drawn = [target / "figure_02_case.svg"]
    with (
        open_store(folder / "motion.nc") as motion,
        open_store(folder / "pounding.nc") as sticks,
        open_store(folder / "forces.nc") as points,
    ):
        forces = by_line(points)
        case_figure(drawn[0], motion, sticks, forces)
        drawn.append(target / "elevation.svg")
        elevation_figure(drawn[-1], sticks, forces)
        if (sticks["building_model"] != "structure").any():
            drawn.append(target / "figure_03_stick.svg")
            stick_figure(drawn[-1], sticks)
        curves = [_response(sticks), _floor_spectra(sticks, published), _damping(sticks)]
        if sticks.sizes["pair"]:
            drawn.append(target / "figure_05_contact.svg")
            contact_figure(drawn[-1], sticks, forces)
            curves.append(_forces(sticks, forces, published))
        if "line" in points and sticks.sizes["impact"]:
            drawn += edge_force_figure(target / "edge_forces.png", sticks, points)
        return [*drawn, *(one.write(target) for one in curves)]


def _response(sticks: xr.Dataset) -> CurveFigure:
    direction = str(sticks.attrs["shown_direction"])
    time, moving = sticks["time"].values, sticks.sel(component=direction)
    tops = [
        moving.isel(station=moving["station_building"] == name).isel(station=-1)
        for name in sticks["building"].values
    ]
    floors = [f"{t.station_building.item()}, floor {t.station_floor.item()}" for t in tops]
    looks = list(zip(tops, floors, itertools.cycle(BUILDINGS), itertools.cycle(DASHES)))
    panels = [
        Panel(
            "time [s]",
            label,
            [
                Curve(time, factor * top[name].values, floor, colour, dash, width=0.8)
                for top, floor, colour, dash in looks
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
        curve = Curve(time, 1e2 * gap.values, _pair(str(gap.pair.item())), "black", width=0.8)
        contact = Curve(time[[0, -1]], 0.0 * time[[0, -1]], "contact", GREEN, "--", width=0.8)
        panels.append(Panel("time [s]", "gap [cm]", [curve, contact], room=0.2))
    under = " under the first building" if "ground_apart" in sticks else ""
    caption = (
        f"Figure 8: Displacement (a) and velocity (b) relative to the ground{under}, absolute "
        f"acceleration (c) along $e_{direction}$ of the top floors{last}, over time."
    )
    return CurveFigure("figure_08_response", caption, panels, size=(9.0, 5.6))


def _forces(sticks: xr.Dataset, forces: xr.Dataset, published: Mapping[str, float]) -> CurveFigure:
    time, every = forces["time"].values, 1e-6 * forces["force"].transpose("pair", "time")
    force = every.isel(pair=every.max("time").argmax("pair"))
    name, dt = str(force["pair"].item()), time[1] - time[0]
    whole = [Curve(time, force.values, _pair(name))]
    others = [one for one in every if str(one["pair"].item()) != name and abs(one).max() > 0.0]
    for k, other in enumerate(others):
        colour, dash = OTHERS[k % len(OTHERS)], DASHES[1 + k % 3]
        whole.append(Curve(time, other.values, _pair(str(other["pair"].item())), colour, dash, 0.8))
    floor = forces["floor_a"].values[forces["pair"].values == name].item()
    key = "pounding.main_impact_time", f"pounding.peak_force.floor_{floor}"
    whole += published_point(published, *key, scale=1e-6)
    near: list[Curve] = []
    impacts = sticks.isel(impact=sticks["impact_pair"] == name)
    if impacts.sizes["impact"]:
        impact = impacts.isel(impact=impacts["impact_peak_force"].argmax("impact"))
        start, end = float(impact["impact_first_contact"]), float(impact["impact_end"])
        margin = 0.25 * (end - start) + dt
        shown = (time >= start - margin) & (time <= end + margin)
        label = f"{impact['impact_steps']:.0f} computed times, {1e3 * (end - start):.1f} ms"
        near = [Curve(time[shown], force.values[shown], label, marker=".")]
    what = (
        f"Impact forces of the pairs that touch (a), and the main impact, between {_pair(name)},"
        if others
        else f"Impact force between {_pair(name)} (a), and its main impact"
    )
    caption = (
        f"Figure 9: {what} with the computed times (b). Positive in compression"
        f"{'; the force pulls at the end of an impact' if (force < 0.0).any() else ''}."
    )
    axes = ("time [s]", "impact force [MN]")
    note = "" if near else "no impact"
    panels = [Panel(*axes, whole, room=0.1 * len(whole)), Panel(*axes, near, room=0.25, note=note)]
    return CurveFigure("figure_09_forces", caption, panels, size=(9.0, 3.2))


def _pair(name: str) -> str:
    """Both ends of a pair in words."""
    words = re.sub(r"\.(?=floor_|storey_)", " ", name.replace("-", " and "))
    return words.replace("_", " ")


def _floor_spectra(sticks: xr.Dataset, published: Mapping[str, float]) -> CurveFigure:
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
    panels = []
    for name, known in (("psa", published), ("psa_free", NONE)):
        curves: list[Curve] = []
        spectra_of_floors = floors[name].transpose("station", "frequency")
        for look, psa in zip(looks, spectra_of_floors, strict=True):
            floor = f"floor {psa.station_floor.item()}"
            curves.append(Curve(frequency, psa.values, floor, *look.values()))
            key = f"frs.{floor.replace(' ', '_')}.peak"
            curves += published_point(known, f"{key}_frequency", key, floor, look["color"])
        options: dict[str, Any] = {"log": "x", "bottom": 0.0, "room": 0.05, "reverse": True}
        options["legend"] = "upper left" if name == "psa" else ""
        panels.append(Panel("frequency [Hz]", "pseudo-acceleration [m/s²]", curves, **options))
    return CurveFigure("figure_10_floor_spectra", caption, panels, alike=True)


def _damping(sticks: xr.Dataset) -> CurveFigure:
    """The damping ratio by the law of each building, and those of the modes of each stick."""
    highest = float(sticks["frequency"][-1])
    lowest = 0.5 * min(float(sticks["mode_frequency"].min()), highest)
    frequency = np.geomspace(lowest, highest, 400)
    laws = {name: damping_of(sticks.sel(building=name)) for name in names_of(sticks, "building")}
    curves, words = [], []
    for name, law in laws.items():
        alike = [other for other, same in laws.items() if same == law]
        if name == alike[0]:
            colour, which = BUILDINGS[list(laws).index(name) % len(BUILDINGS)], ", ".join(alike)
            curves.append(Curve(frequency, 100.0 * law.ratio(frequency), which, colour))
            low, high = (100.0 * float(law.ratio(f)) for f in (2.0 * lowest, highest))
            words.append(f"{which} {low:.3g} % at {2.0 * lowest:.3g} Hz, {high:.3g} % at the end")
    for (name, _), colour in zip(laws.items(), itertools.cycle(BUILDINGS)):
        modes = sticks.sel(building=name)
        if modes["building_model"].item() != "stick":
            continue
        shown = modes.isel(mode=(modes["mode_frequency"] <= highest).values)
        ratio = 100.0 * shown["mode_ratio"].values
        f, label = shown["mode_frequency"].values, f"modes of {name}"
        curves.append(Curve(f, ratio, label, colour, dash="", marker="o"))
    of_modes = (
        ", and of the modes of the sticks on a clamped base" if len(curves) > len(words) else ""
    )
    caption = (
        "Damping ratio of the buildings over the frequency, up to the highest of the spectra"
        f"{of_modes}: {'; '.join(words)}."
    )
    # A law may have modes without damping, which a logarithmic axis does not show.
    log = "xy" if min(float(np.nanmin(curve.y)) for curve in curves) > 0.0 else "x"
    panel = Panel("frequency [Hz]", "damping ratio [%]", curves, log=log, legend="best")
    return CurveFigure("damping", caption, [panel], columns=1, size=(6.5, 3.8), lettered=False)


def edge_force_figure(path: Path, sticks: xr.Dataset, forces: xr.Dataset) -> list[Path]:
    """Maps of the line load over edge and time, while the main impact lasts; none without force."""
    main = sticks.isel(impact=sticks["impact_peak_force"].argmax("impact"))
    start, end = float(main["impact_first_contact"]), float(main["impact_end"])
    margin = MARGIN * (end - start)
    time = forces["time"].values
    shown = forces.isel(time=(time >= start - margin) & (time <= end + margin))
    loads: dict[str, tuple[Array, Array]] = {}
    for name in dict.fromkeys(forces["line"].values.astype(str).tolist()):
        line = shown.isel(pair=(shown["line"] == name).values)
        if not name or not line["force"].any():
            continue
        # Of a stick, and inside a storey, a hat has no width: that of the other side counts.
        widths = [0.5 * np.ptp(line[f"hat_{side}"].fillna(0.0).values, axis=1) for side in "ab"]
        width = np.maximum(*widths)
        along = line["offset_a"] - line["offset_a"].isel(pair=0)
        place = np.linalg.norm(along.transpose("pair", "axis").values, axis=1)
        load = 1e-6 * line["force"].transpose("pair", "time").values
        if (width > 0.0).all():
            loads[name] = place, load / width[:, None]
    if not loads:
        return []
    largest = sorted(loads, key=lambda name: -float(loads[name][1].max()))[:MOST]
    pushing = np.concatenate([loads[name][1][loads[name][1] > 0.0] for name in largest])
    most = float(pushing.max())
    t = 1e3 * (shown["time"].values - start)
    caption = (
        "Line load between the edges that touch in 3D, over the distance along them and the time "
        f"from the first contact of the main impact at {start:.4g} s, straight between the points "
        f"of contact. Largest value: {most:.3g} MN/m, between {largest[0]}."
    )
    seen = (
        f"Line load by colour over time and edge, of {len(largest)} lines; at most {most:.3g} MN/m."
    )
    limit = float(np.quantile(pushing, 1.0 - CUT))
    line_load_maps(path, caption, seen, {name: (t, *loads[name]) for name in largest}, limit)
    return [path]
