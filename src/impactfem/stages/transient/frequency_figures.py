"""Figures in the frequency domain: acceleration (20), impact forces (21), transfer (22)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import NDArray

from impactfem.plot.style import BLUE, RED, figure, floor_colours, letter, ordered_colours
from impactfem.stages.stores import time_step
from impactfem.stages.transient.power import force_spectra, power_spectrum
from impactfem.stages.transient.selection import (
    at_floor,
    floors_of,
    of_kind,
    shown_line,
    transfer,
    transfer_bound,
    wave_floor,
)
from impactfem.stages.transient.spectrum_figures import unknown

Array = NDArray[np.float64]

SHOWN_EDGES = 3
DECADES = 5.0
"""Decades of a power spectral density that are shown."""


def lower_floor(response: xr.Dataset) -> int:
    """The floor of figures 20 and 22 (a): the one below that with the line, if it has an edge."""
    floors = floors_of(response, "edge")
    edges = [floor for floor in floors if floor <= wave_floor(response)] or floors
    return edges[-2] if len(edges) > 1 else edges[-1]


def edge_figure(path: Path, response: xr.Dataset) -> None:
    """Figure 20: acceleration at the impact edge of the floor below the top, and its PSD."""
    floor, d = lower_floor(response), response["component"].item()
    time, values = response["time"].values, at_floor(response, "edge", floor).acceleration.values
    frequency, density = power_spectrum(values, time_step(response))
    caption = (
        f"Figure 20: Acceleration along $e_{d}$ at the middle of the impact edge of "
        f"floor {floor} over time (a), and its power spectral density (b; Welch's method, segments "
        f"of {1.0 / frequency[1]:.2g} s)."
    )
    with figure(path, (1, 2), (9.0, 3.4), caption) as (_, axes):
        k = int(np.argmax(np.abs(values)))
        label = f"{values[k]:.1f} m/s² at {time[k]:.3f} s"
        axes[0].plot(time, values, color=BLUE, lw=0.8)
        axes[0].plot(time[k], values[k], "o", color="black", ms=4, label=label)
        axes[0].set_xlim(time[0], time[-1])
        low, high = axes[0].get_ylim()
        axes[0].set_ylim(low, high + 0.2 * (high - low))
        axes[0].legend(loc="upper right")
        axes[0].set_xlabel("time [s]")
        axes[0].set_ylabel(f"acceleration $\\ddot u_{d}$ [m/s²]")
        axes[1].loglog(frequency[1:], density[1:], color=BLUE)
        _density_axis(axes[1], response, frequency, density, "PSD of acceleration [(m/s²)²/Hz]")
        letter(axes)


def force_figure(path: Path, response: xr.Dataset) -> None:
    """Figure 21: power spectral densities of the main impacts of the two upper loaded floors."""
    force = response["edge_force"].isel(edge=slice(-2, None)).transpose("time", "edge")
    floors = force["edge_floor"].values.tolist()
    spectra = force_spectra(force.values, time_step(response))
    peaks = abs(force).idxmax("time").values
    forces = " and ".join(f"{f} (at {t:.3f} s)" for f, t in zip(floors, peaks, strict=True))
    caption = (
        f"Figure 21: Power spectral densities of the main impact force on floor"
        f"{'s' if len(floors) > 1 else ''} {forces}, as the mean power over "
        f"{1e3 * spectra.duration:.0f} ms."
    )
    with figure(path, (1, 1), (6.5, 3.8), caption) as (_, axes):
        looks = ((RED, "--"), (BLUE, "-"))[-len(floors) :]
        for floor, density, (colour, dashes) in zip(floors, spectra.density, looks, strict=True):
            axes[0].loglog(
                spectra.frequency[1:],
                1e-12 * density[1:],
                color=colour,
                ls=dashes,
                label=f"floor {floor}",
            )
        label = "PSD of the impact force [MN²/Hz]"
        _density_axis(axes[0], response, spectra.frequency, 1e-12 * spectra.density, label)
        axes[0].legend(loc="lower left")


def transfer_figure(path: Path, response: xr.Dataset) -> None:
    """Figure 22: acceleration over the impact force of a floor."""
    edges = of_kind(response, "edge").isel(probe=slice(-SHOWN_EDGES, None))
    edges = edges.assign_coords(
        label=("probe", [f"edge of floor {floor}" for floor in edges["probe_floor"].values])
    )
    line = of_kind(response, "line")
    loads = response["transfer_load_floor"].values.tolist()[-2:]
    panels = [(load, edges, f"force on floor {load}") for load in loads if edges.sizes["probe"]]
    if line.sizes["probe"]:
        line = shown_line(response)
        line = line.assign_coords(
            label=("probe", [f"d = {distance:.1f} m" for distance in line["distance"].values])
        )
        what = f"force on floor {loads[-1]}, along floor {wave_floor(response)}"
        panels.append((loads[-1], line, what))
    names = "; ".join(f"{what} ({chr(97 + k)})" for k, (_, _, what) in enumerate(panels))
    caption = (
        f"Figure 22: Transfer functions, acceleration along $e_{response['component'].item()}$ "
        "over impact force, at the middle of the impact edges and along the line of figure 14: "
        f"{names}. "
        "Shaded: rigorous bound on the error of the reduced model, where it is below the value."
    )
    with figure(path, (1, len(panels)), (3.6 * len(panels), 3.6), caption) as (_, axes):
        f = response["transfer_frequency"].values
        for panel, (load, probes, _) in zip(axes, panels, strict=True):
            palette = floor_colours if probes is edges else ordered_colours
            colours = palette(probes.sizes["probe"])
            sizes, bounds = transfer(probes, load), transfer_bound(probes, load)
            for k, (colour, label) in enumerate(zip(colours, probes["label"].values, strict=True)):
                size, bound = sizes.isel(probe=k).values, bounds.isel(probe=k).values
                panel.semilogx(f, 1e6 * size, color=colour, label=label)
                sharp = bound < size
                within = np.where(sharp, bound, 0.0)
                panel.fill_between(
                    f,
                    1e6 * (size - within),
                    1e6 * (size + within),
                    where=sharp,
                    color=colour,
                    alpha=0.25,
                    linewidth=0.0,
                )
            panel.set_xlabel("frequency [Hz]")
            panel.set_ylabel("acceleration / force [10⁻⁶ kg⁻¹]")
            panel.set_xlim(f[0], f[-1])
            panel.set_ylim(bottom=0.0)
            if (above := unknown(response, f[-1])) is not None:
                panel.axvspan(*above, facecolor="none", edgecolor="0.6", hatch="///", lw=0.0)
            panel.legend(loc="upper left")
        top = 1.1 * max(panel.get_ylim()[1] for panel in axes)
        for panel in axes:
            panel.set_ylim(0.0, top)
        letter(axes)


def _density_axis(
    panel: Axes, response: xr.Dataset, frequency: Array, density: Array, label: str
) -> None:
    highest = float(frequency[-1])
    lowest = max(float(response["frequency"][0]), float(frequency[1]))
    panel.set_xlim(min(lowest, highest / 2.0), highest)
    largest = float(np.max(density))
    if largest > 0.0:
        panel.set_ylim(10.0**-DECADES * largest, 3.0 * largest)
    panel.set_xlabel("frequency [Hz]")
    panel.set_ylabel(label)
