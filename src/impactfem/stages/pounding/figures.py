"""The figures of the stage `pounding` and their data."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from impactfem.plot.curves import (
    NONE,
    Curve,
    CurveFigure,
    Panel,
    hatching_note,
    published_point,
    unresolved,
)
from impactfem.plot.figure import figure
from impactfem.plot.floor_field import line_load_maps
from impactfem.plot.floor_products import FloorDesigns, building_page, floor_designs
from impactfem.plot.style import BUILDINGS, DASHES, GREEN, ORANGE, RED, floor_looks
from impactfem.spectra.product import DesignFloorSpectra
from impactfem.stages.drawing import FigureData
from impactfem.stages.pounding.elevation import Point
from impactfem.stages.stores import by_line, damping_of, names_of
from impactfem.system.arrays import Array

OTHERS = (RED, GREEN, ORANGE, "#CC79A7", "black")
"""Colours of pairs that touch in addition to the one with the largest force."""
CUT = 0.01
"""Part of the largest line loads that is drawn in the last colour: single points have these."""
MOST = 4
"""Lines, or pairs in addition to the main one, that are drawn: those with the largest forces."""
MARGIN = 0.15
"""Part of the length of the main impact that is shown before and after it."""


class PoundingData(FigureData):
    """The data of the figures of the stage."""

    @cached_property
    def sticks(self) -> xr.Dataset:
        """`pounding.nc`."""
        return self.opened("pounding.nc")

    @cached_property
    def motion(self) -> xr.Dataset:
        """`motion.nc`."""
        return self.opened("motion.nc")

    @cached_property
    def points(self) -> xr.Dataset:
        """`forces.nc`, with a force for each point of contact."""
        return self.opened("forces.nc")

    @cached_property
    def forces(self) -> xr.Dataset:
        """`forces.nc`, with a force for each line of contact."""
        return by_line(self.points)

    @cached_property
    def loads(self) -> LineLoads | None:
        """Line loads of contacts in 3D."""
        return line_loads(self.sticks, self.points)

    @cached_property
    def equipment(self) -> list[tuple[str, str, Point]]:
        """Building, name and place [m] of each anchor of a device."""
        return [
            (device.building, device.name, anchor.point)
            for device in self.case.devices
            for anchor in device.anchor_points
        ]

    @cached_property
    def translations(self) -> DesignFloorSpectra:
        """Floor response spectra at the mass centres, for design."""
        return self._designs.translations

    @cached_property
    def rotations(self) -> DesignFloorSpectra | None:
        """The same of rotations; None if there are none."""
        return self._designs.rotations

    @cached_property
    def _designs(self) -> FloorDesigns:
        return floor_designs(self.folder / "pounding.nc", self.case.spectra)

    @cached_property
    def building(self) -> list[str]:
        """Names of the buildings."""
        return names_of(self.sticks, "building")

    @cached_property
    def undesigned(self) -> set[str]:
        """Names of the buildings without design spectra of a 3D model."""
        return set(self.building) - {one.name for one in self.case.in_time}


@figure(
    "impact_forces",
    "Impacts",
    "Impact forces",
    when=lambda sticks: sticks.sizes["pair"],
)
def impact_forces(
    sticks: xr.Dataset, forces: xr.Dataset, published: Mapping[str, float]
) -> CurveFigure:
    """Draw the impact forces of the pairs, and the main impact."""
    time, every = forces["time"].values, 1e-6 * forces["force"].transpose("pair", "time")
    force = every.isel(pair=every.max("time").argmax("pair"))
    name, dt = str(force["pair"].item()), time[1] - time[0]
    whole = [Curve(time, force.values, _pair(name))]
    others = [one for one in every if str(one["pair"].item()) != name and abs(one).max() > 0.0]
    others.sort(key=lambda one: -float(one.max()))
    touching = len(others) + 1
    for k, other in enumerate(others := others[:MOST]):
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
    what = f"Impact force between {_pair(name)} (a), and its main impact"
    if others:
        which = f"{touching} pairs that touch"
        if touching > 1 + len(others):
            which = f"{1 + len(others)} pairs with the largest forces, of {touching} that touch"
        what = f"Impact forces of the {which} (a), and the main impact, between {_pair(name)},"
    caption = (
        f"{what} with the computed times (b). Positive in compression"
        f"{'; the force pulls at the end of an impact' if (force < 0.0).any() else ''}."
    )
    axes = ("time [s]", "impact force [MN]")
    note = "" if near else "no impact"
    panels = [Panel(*axes, whole, room=0.1 * len(whole)), Panel(*axes, near, room=0.25, note=note)]
    return CurveFigure(caption, panels, size=(9.0, 3.2))


@figure("response", "Impacts", "Displacement, velocity and acceleration of the top floors")
def response(sticks: xr.Dataset) -> CurveFigure:
    """Draw the response of the top floor of each building, and the gap."""
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
        f"Displacement (a) and velocity (b) relative to the ground{under}, absolute "
        f"acceleration (c) along $e_{direction}$ of the top floors{last}, over time."
    )
    return CurveFigure(caption, panels, size=(9.0, 5.6))


def _pair(name: str) -> str:
    """Both ends of a pair in words."""
    words = re.sub(r"\.(?=floor_|storey_)", " ", name.replace("-", " and "))
    return words.replace("_", " ")


@figure("pounding_spectra", "Floor spectra", "Floor spectra with pounding and without contact")
def pounding_spectra(sticks: xr.Dataset, published: Mapping[str, float]) -> CurveFigure:
    """Draw the floor response spectra of the studied building along the shown direction."""
    direction = str(sticks.attrs["shown_direction"])
    studied = str(sticks.attrs["studied_building"])
    spectra = sticks.sel(direction=direction).isel(damping=0)
    floors = spectra.isel(station=spectra["station_building"] == studied)
    frequency, damping = sticks["frequency"].values, float(floors["damping"])
    caption = (
        f"Floor response spectra (pseudo-acceleration, {100 * damping:g} % damping) of "
        f"building {studied} along $e_{direction}$ at the mass centres, with pounding (a) and "
        f"without contact (b).{hatching_note(sticks, frequency[-1])}"
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
        options["hatched"] = unresolved(sticks, frequency[-1])
        panels.append(Panel("frequency [Hz]", "pseudo-acceleration [m/s²]", curves, **options))
    return CurveFigure(caption, panels, alike=True)


@figure(
    "floor_spectra",
    "Floor spectra",
    "Floor response spectra for design",
    each="building",
    default="undesigned",
)
def floor_spectra(translations: DesignFloorSpectra, building: str) -> CurveFigure:
    """Draw the floor response spectra of a building, computed and for design."""
    return building_page(translations, building)


@figure(
    "floor_rotations",
    "Floor spectra",
    "Floor response spectra of rotations for design",
    each="building",
    default=False,
)
def floor_rotations(rotations: DesignFloorSpectra, building: str) -> CurveFigure:
    """Draw the spectra of rotations of the floors of a building, computed and for design."""
    return building_page(rotations, building)


@figure("damping", "Models and damping", "Damping ratio of the buildings", default=False)
def damping(sticks: xr.Dataset) -> CurveFigure:
    """Draw the damping ratio by the law of each building, and those of the modes of each stick."""
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
    return CurveFigure(caption, [panel], columns=1, size=(6.5, 3.8), lettered=False)


class LineLoads(NamedTuple):
    """Line loads between edges in the main impact."""

    start: float  #: time of the first contact [s]
    #: Of each line: time from the first contact (n_t,) [ms], distance along the line (n,) [m],
    #: load (n, n_t) [MN/m].
    maps: dict[str, tuple[Array, Array, Array]]


def line_loads(sticks: xr.Dataset, points: xr.Dataset) -> LineLoads | None:
    """Compute the line loads of 3D models from the forces of the points; None without a force."""
    if "hat_a" not in points or not sticks.sizes["impact"]:
        return None
    main = sticks.isel(impact=sticks["impact_peak_force"].argmax("impact"))
    start, end = float(main["impact_first_contact"]), float(main["impact_end"])
    margin = MARGIN * (end - start)
    time = points["time"].values
    shown = points.isel(time=(time >= start - margin) & (time <= end + margin))
    t = 1e3 * (shown["time"].values - start)
    loads: dict[str, tuple[Array, Array, Array]] = {}
    for name in dict.fromkeys(points["line"].values.astype(str).tolist()):
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
            loads[name] = t, place, load / width[:, None]
    return LineLoads(start, loads) if loads else None


@figure(
    "edge_forces",
    "Impacts",
    "Line load between the buildings in the main impact",
    ending="png",
)
def edge_forces(path: Path, loads: LineLoads) -> None:
    """Draw maps of the line load over edge and time, of the lines with the largest loads."""
    largest = sorted(loads.maps, key=lambda name: -float(loads.maps[name][2].max()))[:MOST]
    every = [loads.maps[name][2] for name in largest]
    pushing = np.concatenate([load[load > 0.0] for load in every])
    most = float(pushing.max())
    caption = (
        "Line load between the edges in contact over the distance along the edges and the time "
        f"from the first contact of the main impact at {loads.start:.4g} s. Largest value: "
        f"{most:.3g} MN/m, between {largest[0]}."
    )
    seen = (
        f"Line load by colour over time and edge, of {len(largest)} lines; at most {most:.3g} MN/m."
    )
    limit = float(np.quantile(pushing, 1.0 - CUT))
    line_load_maps(path, caption, seen, {name: loads.maps[name] for name in largest}, limit)
