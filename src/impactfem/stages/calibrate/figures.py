"""The figures of the stage `calibrate` and their data."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.case.damping import OWN
from impactfem.plot.curves import Curve, CurveFigure, Panel, published_point
from impactfem.plot.figure import figure
from impactfem.plot.floor_field import line_load_maps
from impactfem.plot.style import (
    BLUE,
    GREEN,
    ORANGE,
    RED,
    floor_colours,
    letter,
    ordered_colours,
    sheet,
)
from impactfem.stages.calibrate.selection import (
    MODEL,
    STICK,
    damping_ratios,
    focus,
    half_wave,
    history_of,
    impacts_of,
    running_impulse,
)
from impactfem.stages.drawing import FigureData

CUT = 0.05
"""Part of the values of the line load that may lie beyond the upper end of the colours."""
MARKERS = "osD^vP*X"
THE_IMPACT = "The impact"


class CalibrationData(FigureData):
    """The data of the figures of the stage."""

    @cached_property
    def store(self) -> xr.Dataset:
        """`calibrate.nc`."""
        return self.opened("calibrate.nc")


def _and(floors: list[int]) -> str:
    """Floor numbers in words."""
    *first, last = (str(k) for k in floors)
    return f"floors {', '.join(first)} and {last}" if first else f"floor {last}"


@figure("wall_impact", THE_IMPACT, "Contact forces of the first impact on the wall")
def wall_impact(store: xr.Dataset, published: Mapping[str, float]) -> CurveFigure:
    """Draw contact forces and impulses of the floors."""
    history, time = history_of(store, MODEL), store["time"].values
    colours = dict(zip(history.floors, floor_colours(len(history.floors)), strict=True))
    first, last = focus(store)
    shown = (time >= first) & (time <= last)
    hitting = [found.floor for found in impacts_of(store, MODEL) if found.impacts]
    spared = [k for k in history.floors if k not in hitting]
    note = f" No contact of {_and(spared)}." if spared else ""
    caption = (
        f"Contact force (a) and impulse (b) of {_and(hitting)} of {store.attrs['building']} in "
        "the first impact on the rigid wall; force: mean of each time step of "
        f"{1e3 * history.time_step:g} ms.{note}"
    )
    forces, impulses = [], []
    for floor in reversed(hitting):
        force = 1e-6 * history.force[shown, history.column(floor)]
        impulse = 1e-3 * running_impulse(history, floor)[shown]
        impulse -= impulse[0]
        forces.append(Curve(time[shown], force, f"floor {floor}", colours[floor]))
        label = f"floor {floor}, {impulse.max():.3g} kN·s"
        impulses.append(Curve(time[shown], impulse, label, colours[floor]))
    # The end of the impact is where the impulse, of the highest floor, has its value.
    start, lasts, pushed = (
        published.get(f"calibration.{name}")
        for name in ("impact_time", "impact_duration", "impulse")
    )
    if start is not None and lasts is not None:
        known = {"start": start, "end": start + lasts, "force": 0.0}
        known |= {} if pushed is None else {"impulse": pushed}
        forces += published_point(known, "start", "force", "contact")
        forces += [replace(one, label="") for one in published_point(known, "end", "force")]
        impulses += published_point(known, "end", "impulse", f"floor {max(hitting)}", scale=1e-3)
    panels = [
        Panel("time [s]", label, curves, room=room, legend=f"upper {side}")
        for label, curves, side, room in (
            ("contact force [MN]", forces, "right", 0.12 * len(forces)),
            ("impulse [kN·s]", impulses, "left", 0.12),
        )
    ]
    return CurveFigure(caption, panels, size=(9.0, 3.4))


@figure("wall_stick", THE_IMPACT, "Impact on the wall: stick and 3D model", default=False)
def wall_stick(store: xr.Dataset) -> CurveFigure:
    """Draw displacement, velocity and impulse of the stick and of the 3D model."""
    name, side, update, gap = (
        store.attrs[key] for key in ("building", "side", "stick_contact_update", "gap")
    )
    top, time = int(store["floor"][-1]), store["time"].values
    caption = (
        f"Displacement (a) and velocity (b) of the mass centre of floor {top} of {name} towards "
        f"the wall, side {side}, and impulse (c): 3D model, and stick with the calibrated law "
        f"({update} contact force)."
    )
    labels = ("displacement $u$ [cm]", "velocity $\\dot u$ [m/s]", "impulse [kN·s]")
    curves: list[list[Curve]] = [[], [], []]
    for which, kind, colour, dash in ((STICK, "stick", RED, "--"), (MODEL, "3D", BLUE, "-")):
        history = history_of(store, which)
        u, v = (getattr(history, of)[:, -1] for of in ("displacement", "velocity"))
        for panel, values in zip(
            curves, (1e2 * u, v, 1e-3 * running_impulse(history, top)), strict=True
        ):
            panel.append(Curve(time, values, kind, colour, dash, width=0.9))
    curves[0].append(Curve(time[[0, -1]], np.full(2, 1e2 * gap), "wall", GREEN, ":", width=0.9))
    panels = [Panel("time [s]", *one, legend="") for one in zip(labels, curves, strict=True)]
    return CurveFigure(caption, panels, size=(9.0, 5.6), above=True)


@figure("wall_energy", THE_IMPACT, "Energies of the impact on the wall", default=False)
def wall_energy(store: xr.Dataset) -> CurveFigure:
    """Draw the energies over time and in the first impact, and their sum."""
    time, numerical = store["time"].values, store["numerical_energy"].values
    energies = {
        "kinetic": (store["kinetic_energy"].values, BLUE),
        "elastic": (store["elastic_energy"].values, ORANGE),
        "damped": (store["damped_energy"].values, GREEN),
        "contact": (-store["contact_work"].values, RED),
    }
    also = ""
    if np.any(numerical):
        energies["numerical"], also = (numerical, "0.5"), " and time stepping"
    energies["sum"] = (np.sum([values for values, _ in energies.values()], axis=0), "black")
    first, last = focus(store)
    caption = (
        f"Energies of the 3D model of {store.attrs['building']} at the wall: whole history (a) and "
        f"first impact (b). Damping, contact{also}: dissipated energy."
    )
    panels = [
        Panel(
            "time [s]",
            "energy [kJ]",
            [
                Curve(time[shown], 1e-3 * y[shown], name, look, "--" if name == "sum" else "-")
                for name, (y, look) in energies.items()
            ],
            legend="",
        )
        for shown in (slice(None), (time >= first) & (time <= last))
    ]
    return CurveFigure(caption, panels, size=(9.0, 4.0), alike=True, above=True)


@figure(
    "wall_line_load", THE_IMPACT, "Line load of the wall on the edges", default=False, ending="png"
)
def wall_line_load(path: Path, store: xr.Dataset) -> None:
    """Draw P_i / w_i, with the force P_i and the length w_i of point i, over edge and time."""
    load = 1e-6 * (store["constraint_force"] / store["constraint_length"]).transpose(
        "step", "constraint"
    )
    # A floor may touch later only.
    loads = {
        floor: of_floor
        for floor in store["floor"].values[::-1].tolist()
        if (of_floor := load[:, (store["constraint_floor"] == floor).values]).any()
    }
    # Corners and the first touch have the largest values and would take the colours for themselves.
    pushing = np.concatenate([one.values[one.values > 0.0] for one in loads.values()])
    limit = float(np.quantile(pushing, 1.0 - CUT))
    caption = (
        f"Line load of the wall on the edge of {_and(list(loads)[::-1])} of building "
        f"{store.attrs['building']} over the distance along the edge and the time of the first "
        "impact. Largest value: "
        f"{pushing.max():.3g} MN/m."
    )
    most = max(loads, key=lambda floor: float(loads[floor].max()))
    i, _ = np.unravel_index(loads[most].values.argmax(), loads[most].shape)
    seen = (
        f"Line load by colour over time and edge, of {len(loads)} floors: largest, "
        f"{pushing.max():.3g} MN/m, on floor {most} at {1e3 * float(store['step'][i]):.4g} ms."
    )
    place, floors = store["constraint_position"].values, store["constraint_floor"].values
    maps = {
        f"floor {floor}": (1e3 * one["step"].values, place[floors == floor], one.values.T)
        for floor, one in loads.items()
    }
    line_load_maps(path, caption, seen, maps, limit)


@figure(
    "wall_damping",
    THE_IMPACT,
    "Restitution, contact stiffness and duration over the damping",
    when=lambda store: store.sizes["case"] > 1,
    default=False,
)
def wall_damping(path: Path, store: xr.Dataset) -> None:
    """Draw the results of each damping case."""
    frequency = half_wave(store)
    ratio = 1e2 * damping_ratios(store, frequency)
    cases = store["case"].values.tolist()
    panels = (
        ("epsilon", 1.0, "restitution ε [-]"),
        ("K_Ceq", 1e-11, "contact stiffness $K_{Ceq}$ [$10^{11}$ N/m]"),
        ("impact_duration", 1e3, "duration of the impact [ms]"),
    )
    caption = (
        "Restitution (a), contact stiffness (b) and duration (c) of the first impact of floor "
        f"{store['floor'].values[-1]} of {store.attrs['building']} over the damping ratio at "
        f"{frequency:.3g} Hz, half the reciprocal of the duration."
    )
    # The damping of the case has no marker of its own below that of another case.
    repeated = {0} if np.isclose(ratio[1:], ratio[0], rtol=0.01).any() else set()
    cases = ["case" if case == OWN else case for case in cases]
    colours = ordered_colours(len(cases))
    with sheet(path, (2, 2), (7.5, 5.6), caption) as (_, axes):
        *axes, spare = axes
        spare.set_axis_off()
        for panel, (name, factor, label) in zip(axes, panels, strict=True):
            values = factor * store[name].values
            for k, case in enumerate(cases):
                if k in repeated:
                    continue
                look = {"marker": MARKERS[k % len(MARKERS)], "ls": "none", "color": colours[k]}
                panel.plot(float(ratio[k]), values[k], ms=6, label=case, **look)
            panel.set(xlabel=f"damping ratio at {frequency:.3g} Hz [%]", ylabel=label)
            right, top = 1.15 * float(ratio.max()), 1.25 * float(values.max())
            panel.set(xlim=(0.0, right), ylim=(0.0, top))
        axes[0].set_ylim(0.0, 1.0)
        spare.legend(*axes[0].get_legend_handles_labels(), loc="center", title="damping")
        letter(axes)
