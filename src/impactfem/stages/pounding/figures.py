"""The figures of the stage `pounding`, from its stores, in the paper's layout and numbering."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import xarray as xr
from matplotlib.ticker import MaxNLocator

from impactfem.plot.style import (
    BUILDINGS,
    DASHES,
    GREEN,
    HANDLE,
    figure,
    floor_looks,
    letter,
    span,
)
from impactfem.stages.pounding import model_figures as figures_models
from impactfem.stages.stores import open_store


def stick_figures(folder: Path) -> list[Path]:
    """Draw figures 2, 3, 5, 8, 9 and 10 into `figures/`.

    Args:
        folder: The run's folder, with `motion.nc`, `pounding.nc` and `forces.nc`.

    Returns:
        The files; figures about impacts are left out when nothing can touch.
    """
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    drawn: list[Path] = []
    with (
        open_store(folder / "motion.nc") as motion,
        open_store(folder / "pounding.nc") as sticks,
        open_store(folder / "forces.nc") as forces,
    ):
        makers: dict[str, Callable[[Path], None]] = {
            "figure_02_case.png": lambda path: figures_models.case_figure(
                path, motion, sticks, forces
            ),
            "figure_03_stick.png": lambda path: figures_models.stick_figure(path, sticks),
            "figure_08_response.png": lambda path: _response(path, sticks),
            "figure_10_floor_spectra.png": lambda path: _floor_spectra(path, sticks),
        }
        if sticks.sizes["pair"]:
            makers["figure_05_contact.png"] = lambda path: figures_models.contact_figure(
                path, sticks, forces
            )
            makers["figure_09_forces.png"] = lambda path: _forces(path, sticks, forces)
        for name, draw in sorted(makers.items()):
            draw(target / name)
            drawn.append(target / name)
    return drawn


def _response(path: Path, sticks: xr.Dataset) -> None:
    direction = str(sticks.attrs["shown_direction"])
    time = sticks["time"].values
    moving = sticks.sel(component=direction)
    tops = [
        moving.isel(station=moving["station_building"] == name).isel(station=-1)
        for name in sticks["building"].values
    ]
    panels = (
        ("displacement", 1e2, f"displacement $u_{direction}$ [cm]"),
        ("velocity", 1.0, f"velocity $\\dot u_{direction}$ [m/s]"),
        ("acceleration", 1.0, f"acceleration $\\ddot u_{direction}$ [m/s²]"),
    )
    pairs = bool(sticks.sizes["pair"])
    last = ", and the gap between them (d)" if pairs else ""
    caption = (
        "Figure 8: Displacement (a) and velocity (b) relative to the ground, absolute acceleration "
        f"(c) along $e_{direction}$ of the top floors{last}, over time."
    )
    with figure(path, (2, 2), (9.0, 5.6), caption) as (_, axes):
        for panel, (name, factor, label) in zip(axes, panels, strict=False):
            for index, top in enumerate(tops):
                panel.plot(
                    time,
                    factor * top[name].values,
                    color=BUILDINGS[index % len(BUILDINGS)],
                    ls=DASHES[index % len(DASHES)],
                    lw=0.8,
                    label=f"{top.station_building.item()}, floor {top.station_floor.item()}",
                )
            panel.set_ylabel(label)
        axes[0].legend(loc="upper right")
        if pairs:
            gap = sticks["gap"].isel(pair=sticks["pair_required_separation"].argmax("pair"))
            axes[3].plot(time, 1e2 * gap, color="black", lw=0.8, label=gap.pair.item())
            axes[3].axhline(0.0, color=GREEN, lw=0.8, ls="--", label="contact")
            axes[3].legend(loc="upper right")
            axes[3].set_ylabel("gap [cm]")
        else:
            axes.pop().set_axis_off()
        for panel in axes:
            panel.set_xlabel("time [s]")
            panel.set_xlim(time[0], time[-1])
            # Room for the legend above the curves.
            low, high = panel.get_ylim()
            panel.set_ylim(low, high + 0.2 * (high - low))
        letter(axes)


def _forces(path: Path, sticks: xr.Dataset, forces: xr.Dataset) -> None:
    time = forces["time"].values
    force = 1e-6 * forces["force"]
    force = force.isel(pair=force.max("time").argmax("pair"))
    name = str(force["pair"].item())
    dt = time[1] - time[0]
    caption = (
        f"Figure 9: Impact force of the pair {name} (a), and its main impact with the computed "
        "times (b). Positive in compression; the force pulls at the end of an impact when the law "
        "allows tension."
    )
    with figure(path, (1, 2), (9.0, 3.2), caption) as (_, axes):
        axes[0].plot(time, force, color=BUILDINGS[0])
        axes[0].set_xlim(time[0], time[-1])
        impacts = sticks.isel(impact=sticks["impact_pair"] == name)
        if impacts.sizes["impact"]:
            impact = impacts.isel(impact=impacts["impact_peak_force"].argmax("impact"))
            start, end = float(impact["impact_first_contact"]), float(impact["impact_end"])
            margin = 0.25 * (end - start)
            shown = (time >= start - margin - dt) & (time <= end + margin + dt)
            axes[1].plot(
                time[shown],
                force[shown],
                color=BUILDINGS[0],
                marker=".",
                ms=4,
                label=f"{impact['impact_steps']:.0f} computed times, {1e3 * (end - start):.1f} ms",
            )
            axes[1].legend(loc="upper right")
            axes[1].set_ylim(top=1.25 * float(force.max()))
            axes[1].xaxis.set_major_locator(MaxNLocator(5))
        else:
            axes[1].text(0.5, 0.5, "no impact", ha="center", transform=axes[1].transAxes)
        for panel in axes:
            panel.set_xlabel("time [s]")
            panel.set_ylabel("impact force [MN]")
        letter(axes)


def _floor_spectra(path: Path, sticks: xr.Dataset) -> None:
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
    with figure(path, (1, 2), (9.0, 4.0), caption) as (_, axes):
        for panel, name in zip(axes, ("psa", "psa_free"), strict=True):
            curves = floors[name].transpose("station", "frequency")
            for look, psa in zip(looks, curves, strict=True):
                label = f"floor {psa.station_floor.item()}"
                panel.semilogx(frequency, psa, **look, label=label)
            panel.set_xlabel("frequency [Hz]")
            panel.set_ylabel("pseudo-acceleration [m/s²]")
            span(panel, frequency)
            panel.set_ylim(bottom=0.0)
        top = 1.05 * max(panel.get_ylim()[1] for panel in axes)
        for panel in axes:
            panel.set_ylim(0.0, top)
        handles, labels = axes[1].get_legend_handles_labels()
        axes[1].legend(handles[::-1], labels[::-1], loc="upper right", handlelength=HANDLE)
        letter(axes)
