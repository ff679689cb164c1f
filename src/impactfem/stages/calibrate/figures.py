"""The figures of the stage `calibrate`, from its store, in the paper's layout and numbering."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from impactfem.plot.floor_field import COLOURS
from impactfem.plot.style import (
    BLUE,
    GREEN,
    ORANGE,
    RED,
    figure,
    floor_colours,
    letter,
    ordered_colours,
)
from impactfem.stages.calibrate.selection import (
    MODEL,
    STICK,
    damping_ratios,
    focus,
    half_wave,
    history_of,
    impacts_of,
    line_load,
    running_impulse,
)
from impactfem.stages.stores import open_store

CUT = 0.05
"""Part of the values of the line load that may lie beyond the upper end of the colours."""
MARKERS = "osD^vP*X"


def wall_figures(folder: Path) -> list[Path]:
    """Draw figures 6 and 7, the line load, the energies and, of several dampings, what they do.

    Args:
        folder: The run's folder, with `calibrate.nc`.

    Returns:
        The files in `figures/`.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    drawn: list[Path] = []
    with open_store(folder / "calibrate.nc") as store:
        makers: dict[str, Callable[[Path, xr.Dataset], None]] = {
            "figure_06_wall_impact.png": _forces,
            "figure_07_wall_stick.png": _with_stick,
            "wall_energy.png": _energy,
            "wall_line_load.png": _line_load,
        }
        if store.sizes["case"] > 1:
            makers["wall_damping.png"] = _damping
        for name, draw in sorted(makers.items()):
            draw(target / name, store)
            drawn.append(target / name)
    return drawn


def _colours(store: xr.Dataset) -> dict[int, Any]:
    """A colour for each floor that may hit, the same in all figures."""
    floors = store["floor"].values.tolist()
    return dict(zip(floors, floor_colours(len(floors)), strict=True))


def _and(floors: list[int]) -> str:
    """Floor numbers in words."""
    *first, last = (str(k) for k in floors)
    return f"floors {', '.join(first)} and {last}" if first else f"floor {last}"


def _forces(path: Path, store: xr.Dataset) -> None:
    name = store.attrs["building"]
    history, colours, time = history_of(store, MODEL), _colours(store), store["time"].values
    first, last = focus(store)
    shown = (time >= first) & (time <= last)
    before = int(np.argmax(shown))
    hitting = [found.floor for found in impacts_of(store, MODEL) if found.impacts]
    spared = [k for k in history.floors if k not in hitting]
    note = f" No contact of {_and(spared)}." if spared else ""
    caption = (
        f"Figure 6: Resultant of the contact forces on {_and(hitting)} of the 3D building "
        f"{name} in the first impact on the rigid wall (a), mean of each time step of "
        f"{1e3 * history.time_step:g} ms, and the impulse (b) over time.{note}"
    )
    with figure(path, (1, 2), (9.0, 3.4), caption) as (_, axes):
        for floor in reversed(hitting):
            force = 1e-6 * history.force[shown, history.column(floor)]
            impulse = 1e-3 * running_impulse(history, floor)
            impulse = impulse[shown] - impulse[before]
            axes[0].plot(time[shown], force, color=colours[floor], label=f"floor {floor}")
            label = f"floor {floor}, {impulse.max():.3g} kN·s"
            axes[1].plot(time[shown], impulse, color=colours[floor], label=label)
        axes[0].set_ylabel("contact force [MN]")
        axes[1].set_ylabel("impulse [kN·s]")
        for panel in axes:
            _focus_axis(panel, first, last)
            panel.set_xlabel("time [s]")
            _headroom(panel)
            panel.legend(loc="upper left")
        letter(axes)


def _with_stick(path: Path, store: xr.Dataset) -> None:
    name, side = (store.attrs[key] for key in ("building", "side"))
    top, time = int(store["floor"][-1]), store["time"].values
    update = str(store.attrs["stick_contact_update"])
    both = (
        (history_of(store, STICK), "stick", RED, "--"),
        (history_of(store, MODEL), "3D", BLUE, "-"),
    )
    caption = (
        f"Figure 7: Displacement (a) and velocity (b) towards the wall, on side {side}, of the "
        f"mass centre of floor {top} of building {name}, and impulse of its contact forces (c), "
        "over time: 3D model with unilateral contact, and stick on the penalty law "
        f"({update} contact force) with the ε and $K_{{Ceq}}$ that the 3D model gives."
    )
    panels = (
        ("displacement", 1e2, "displacement $u$ [cm]"),
        ("velocity", 1.0, "velocity $\\dot u$ [m/s]"),
        ("impulse", 1e-3, "impulse [kN·s]"),
    )
    with figure(path, (1, 3), (10.8, 3.2), caption) as (_, axes):
        for panel, (quantity, factor, label) in zip(axes, panels, strict=True):
            for history, kind, colour, dashes in both:
                values = (
                    running_impulse(history, top)
                    if quantity == "impulse"
                    else getattr(history, quantity)[:, history.column(top)]
                )
                panel.plot(time, factor * values, color=colour, ls=dashes, lw=0.9, label=kind)
            panel.set_ylabel(label)
            panel.set_xlabel("time [s]")
            panel.set_xlim(time[0], time[-1])
        axes[0].axhline(1e2 * store.attrs["gap"], color=GREEN, lw=0.9, ls=":", label="wall")
        _headroom(axes[0], 0.25)
        axes[0].legend(loc="upper right", ncols=3)
        letter(axes)


def _line_load(path: Path, store: xr.Dataset) -> None:
    by_floor = {k: 1e-6 * line_load(store, k) for k in store["floor"].values[::-1].tolist()}
    # A floor may touch later only.
    floors = [floor for floor, load in by_floor.items() if load.any()]
    loads = [by_floor[floor] for floor in floors]
    largest = max(float(load.max()) for load in loads)
    # Corners and the first touch have the largest values and would take the colours for themselves.
    pushing = np.concatenate([load.values[load.values > 0.0] for load in loads])
    limit = float(np.quantile(pushing, 1.0 - CUT))
    whose, name = _and(floors[::-1]), store.attrs["building"]
    caption = (
        f"Line load of the wall on the edge of {whose} of building {name} over the "
        "distance along the edge and the time of the first impact, straight between the vertices "
        f"of the mesh. Largest value: {largest:.3g} MN/m."
    )
    with figure(path, (1, len(floors)), (2.7 * len(floors) + 1.2, 3.6), caption) as (drawn, axes):
        for panel, floor, load in zip(axes, floors, loads, strict=True):
            mappable = panel.pcolormesh(
                1e3 * load["step"],
                load["position"],
                load.T,
                shading="gouraud",
                cmap=COLOURS,
                vmin=0.0,
                vmax=limit,
            )
            panel.set_xlabel("time [ms]")
            panel.xaxis.set_major_locator(MaxNLocator(5))
            panel.grid(False)
            panel.set_title(f"floor {floor}", fontsize=9.0)
        axes[0].set_ylabel("distance along the edge [m]")
        bar = drawn.colorbar(mappable, ax=axes, location="right", aspect=30, pad=0.02, extend="max")
        bar.set_label("line load [MN/m]")
        letter(axes)


def _energy(path: Path, store: xr.Dataset) -> None:
    building, time = store.attrs["building"], store["time"].values
    curves = [
        ("kinetic", store["kinetic_energy"].values, BLUE, "-"),
        ("elastic", store["elastic_energy"].values, ORANGE, "-"),
        ("damped", store["damped_energy"].values, GREEN, "-"),
        ("contact", -store["contact_work"].values, RED, "-"),
    ]
    numerical = store["numerical_energy"].values
    if np.any(numerical):
        curves.append(("numerical", numerical, "0.5", "-"))
    curves.append(("sum", np.sum([values for _, values, _, _ in curves], axis=0), "black", "--"))
    first, last = focus(store)
    also = " and time stepping" if np.any(numerical) else ""
    caption = (
        f"Energies of the 3D building {building} in front of the wall, over all the time (a) "
        f"and in the first impact (b); what damping and contact{also} have taken so far. Contact"
        " takes the energy of nodes that stop at the wall; it falls with mesh and time step."
    )
    with figure(path, (1, 2), (9.0, 3.8), caption) as (_, axes):
        for panel in axes:
            for name, values, colour, dashes in curves:
                panel.plot(time, 1e-3 * values, color=colour, ls=dashes, label=name)
            panel.set_xlabel("time [s]")
            panel.set_ylabel("energy [kJ]")
        axes[0].set_xlim(time[0], time[-1])
        _focus_axis(axes[1], first, last)
        _headroom(axes[0], 0.3)
        axes[1].set_ylim(axes[0].get_ylim())
        axes[0].legend(loc="upper right", ncols=3)
        letter(axes)


def _damping(path: Path, store: xr.Dataset) -> None:
    frequency = half_wave(store)
    ratio = 1e2 * damping_ratios(store, frequency)
    cases = [str(case) for case in store["case"].values]
    top, building = store["floor"].values[-1], store.attrs["building"]
    panels = (
        ("epsilon", 1.0, "restitution ε [-]"),
        ("K_Ceq", 1e-11, "contact stiffness $K_{Ceq}$ [$10^{11}$ N/m]"),
        ("impact_duration", 1e3, "duration of the impact [ms]"),
    )
    caption = (
        f"Restitution by equation 5 (a), contact stiffness by equation 6 (b) and duration of the "
        f"first impact (c) of floor {top} of building {building} over the Rayleigh "
        f"damping ratio of the building at {frequency:.3g} Hz, the frequency whose half wave lasts "
        f'as long as the impact of the case "{cases[0]}".'
    )
    colours = ordered_colours(len(cases))
    with figure(path, (1, 3), (10.0, 3.2), caption) as (_, axes):
        for panel, (name, factor, label) in zip(axes, panels, strict=True):
            values = factor * store[name].values
            for k, case in enumerate(cases):
                panel.plot(
                    float(ratio[k]),
                    values[k],
                    MARKERS[k % len(MARKERS)],
                    color=colours[k],
                    ms=6,
                    label=case,
                )
            panel.set_xlabel(f"damping ratio at {frequency:.3g} Hz [%]")
            panel.set_ylabel(label)
            panel.set_xlim(0.0, 1.15 * float(ratio.max()))
            panel.set_ylim(0.0, 1.25 * float(values.max()))
        axes[0].set_ylim(0.0, 1.0)
        axes[0].legend(loc="best")
        letter(axes)


def _focus_axis(panel: Axes, first: float, last: float) -> None:
    panel.set_xlim(first, last)
    panel.xaxis.set_major_locator(MaxNLocator(5))
    panel.ticklabel_format(axis="x", useOffset=False)


def _headroom(panel: Axes, share: float = 0.12) -> None:
    """Room for the legend above the curves."""
    low, high = panel.get_ylim()
    panel.set_ylim(low, high + share * (high - low))
