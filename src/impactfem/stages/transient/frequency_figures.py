"""Figures in the frequency domain: acceleration (20), impact forces (21), transfer (22)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from impactfem.plot.style import BLUE, RED, figure, floor_colours, letter, ordered_colours
from impactfem.stages.transient.power import force_spectra, power_spectrum
from impactfem.stages.transient.spectrum_figures import mark_unknown
from impactfem.stages.transient.view import TransientView

Array = NDArray[np.float64]

SHOWN_EDGES = 3
DECADES = 5.0
"""Decades of a power spectral density that are shown."""


def lower_floor(view: TransientView) -> int:
    """The floor of figures 20 and 22 (a): the one below that with the line, if it has an edge."""
    edges = [floor for floor in view.edges if floor <= view.top] or list(view.edges)
    return edges[-2] if len(edges) > 1 else edges[-1]


def edge_figure(path: Path, view: TransientView) -> None:
    """Figure 20: acceleration at the impact edge of the floor below the top, and its PSD."""
    floor = lower_floor(view)
    values = view.acceleration(view.edges[floor])
    frequency, density = power_spectrum(values, view.time_step)
    caption = (
        f"Figure 20: Acceleration along $e_{view.direction}$ at the middle of the impact edge of "
        f"floor {floor} over time (a), and its power spectral density (b; Welch's method, segments "
        f"of {1.0 / frequency[1]:.2g} s)."
    )
    with figure(path, (1, 2), (9.0, 3.4), caption) as (_, axes):
        k = int(np.argmax(np.abs(values)))
        axes[0].plot(view.time, values, color=BLUE, lw=0.8)
        axes[0].plot(
            view.time[k],
            values[k],
            "o",
            color="black",
            ms=4,
            label=f"{values[k]:.1f} m/s² at {view.time[k]:.3f} s",
        )
        axes[0].set_xlim(view.time[0], view.time[-1])
        low, high = axes[0].get_ylim()
        axes[0].set_ylim(low, high + 0.2 * (high - low))
        axes[0].legend(loc="upper right")
        axes[0].set_xlabel("time [s]")
        axes[0].set_ylabel(f"acceleration $\\ddot u_{view.direction}$ [m/s²]")
        axes[1].loglog(frequency[1:], density[1:], color=BLUE)
        _density_axis(axes[1], view, frequency, density, "PSD of acceleration [(m/s²)²/Hz]")
        letter(axes)


def force_figure(path: Path, view: TransientView) -> None:
    """Figure 21: power spectral densities of the main impacts of the two upper loaded floors."""
    floors = list(view.loads)[-2:]
    spectra = force_spectra(view.force[:, [view.loads[f] for f in floors]], view.time_step)
    peaks = [view.time[int(np.argmax(np.abs(view.force[:, view.loads[f]])))] for f in floors]
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
        _density_axis(axes[0], view, spectra.frequency, 1e-12 * spectra.density, label)
        axes[0].legend(loc="lower left")


def transfer_figure(path: Path, view: TransientView) -> None:
    """Figure 22: acceleration over the impact force of a floor."""
    edges = dict(list(view.edges.items())[-SHOWN_EDGES:])
    at_edges = {f"edge of floor {floor}": probe for floor, probe in edges.items()}
    on_line = {
        f"d = {view.distance[k]:.1f} m": view.line[k] for k in view.shown_distances if view.line
    }
    loads = list(view.transfer_loads)[-2:]
    panels: list[tuple[int, Mapping[str, int], str]] = [
        (load, at_edges, f"force on floor {load}") for load in loads if at_edges
    ]
    if on_line:
        panels.append((loads[-1], on_line, f"force on floor {loads[-1]}, along floor {view.top}"))
    names = "; ".join(f"{what} ({chr(97 + k)})" for k, (_, _, what) in enumerate(panels))
    caption = (
        f"Figure 22: Transfer functions, acceleration along $e_{view.direction}$ over impact "
        f"force, at the middle of the impact edges and along the line of figure 14: {names}. "
        "Shaded: rigorous bound on the error of the reduced model, where it is below the value."
    )
    with figure(path, (1, len(panels)), (3.6 * len(panels), 3.6), caption) as (_, axes):
        f = view.transfer_frequency
        for panel, (load, probes, _) in zip(axes, panels, strict=True):
            colours = (floor_colours if probes is at_edges else ordered_colours)(len(probes))
            for colour, (label, probe) in zip(colours, probes.items(), strict=True):
                size, bound = view.transfer(load, probe), view.transfer_bound(load, probe)
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
            mark_unknown(panel, view, f[-1])
            panel.legend(loc="upper left")
        top = 1.1 * max(panel.get_ylim()[1] for panel in axes)
        for panel in axes:
            panel.set_ylim(0.0, top)
        letter(axes)


def _density_axis(
    panel: Axes, view: TransientView, frequency: Array, density: Array, label: str
) -> None:
    highest = float(frequency[-1])
    panel.set_xlim(min(max(float(view.frequency[0]), float(frequency[1])), highest / 2.0), highest)
    largest = float(np.max(density))
    if largest > 0.0:
        panel.set_ylim(10.0**-DECADES * largest, 3.0 * largest)
    panel.set_xlabel("frequency [Hz]")
    panel.set_ylabel(label)
