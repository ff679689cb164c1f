"""Figures of floor response spectra of the 3D building: 13, 15 and 19, with their error bands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import NDArray

from impactfem.plot.style import (
    BLUE,
    HANDLE,
    RED,
    figure,
    floor_looks,
    letter,
    ordered_looks,
    span,
)
from impactfem.spectra.design import ENDED
from impactfem.stages.transient.view import XYZ, TransientView, stick_psa, stick_station

Array = NDArray[np.float64]


def centre_spectrum(path: Path, view: TransientView, sticks: xr.Dataset) -> None:
    """Figure 13: the spectrum of the top floor's mass centre, 3D and sticks."""
    top = view.top
    probe = view.centres[top]
    station = stick_station(sticks, view.building, top)
    other = stick_psa(sticks, station, view.direction) if station is not None else None
    caption = (
        f"Figure 13: Floor response spectrum (pseudo-acceleration, {100 * view.damping:g} % "
        f"damping) along $e_{view.direction}$ at the mass centre of floor {top}: 3D model and "
        f"sticks.{_note(view, [probe])}"
    )
    look, sticks_look = {"color": BLUE}, {"color": RED, "ls": "--"}
    with figure(path, (1, 1), (6.5, 4.0), caption) as (_, axes):
        if other is not None:
            _curve(axes[0], sticks["frequency"].values, other, sticks_look, "sticks", peak=True)
        _curve(axes[0], view.frequency, view.psa(probe), look, "3D", view.band(probe), peak=True)
        _finish(axes[0], view, "pseudo-acceleration [m/s²]")
        axes[0].legend(loc="upper left")


def across_spectra(path: Path, view: TransientView) -> None:
    """Figure 15: spectra at some distances from the impact."""
    shown = view.shown_distances
    probes = [view.line[k] for k in shown]
    caption = (
        f"Figure 15: Floor response spectra ({100 * view.damping:g} % damping) along "
        f"$e_{view.direction}$ of floor {view.top} at distances d from its impact edge: "
        f"displacement (a) and pseudo-acceleration (b).{_note(view, probes)}"
    )
    labels = [f"d = {view.distance[k]:.1f} m" for k in shown]
    _displacement_and_acceleration(path, view, probes, labels, caption)


def edge_spectra(path: Path, view: TransientView) -> None:
    """Figure 19: spectra at the impact edges of all floors."""
    probes = list(view.edges.values())
    caption = (
        f"Figure 19: Floor response spectra ({100 * view.damping:g} % damping) along "
        f"$e_{view.direction}$ at the middle of the impact edges of the floors: displacement (a) "
        f"and pseudo-acceleration (b).{_note(view, probes)}"
    )
    labels = [f"floor {floor}" for floor in view.edges]
    _displacement_and_acceleration(path, view, probes, labels, caption, from_top=True)


def _displacement_and_acceleration(
    path: Path,
    view: TransientView,
    probes: Sequence[int],
    labels: Sequence[str],
    caption: str,
    *,
    from_top: bool = False,
) -> None:
    with figure(path, (1, 2), (9.0, 4.0), caption) as (_, axes):
        looks = (floor_looks if from_top else ordered_looks)(len(probes))
        for look, probe, label in zip(looks, probes, labels, strict=True):
            sd, sd_band = 1e2 * view.sd(probe), 1e2 * view.sd_band(probe)
            _curve(axes[0], view.frequency, sd, look, label, sd_band)
            _curve(axes[1], view.frequency, view.psa(probe), look, label, view.band(probe))
        _finish(axes[0], view, "spectral displacement [cm]")
        _finish(axes[1], view, "pseudo-acceleration [m/s²]")
        handles, names = axes[1].get_legend_handles_labels()
        order = slice(None, None, -1) if from_top else slice(None)
        axes[1].legend(handles[order], names[order], loc="upper left", handlelength=HANDLE)
        letter(axes)


def _curve(
    panel: Axes,
    frequency: Array,
    values: Array,
    look: Mapping[str, Any],
    label: str,
    band: Array | None = None,
    *,
    peak: bool = False,
) -> None:
    if band is not None and band.any():
        panel.fill_between(
            frequency, values - band, values + band, color=look["color"], alpha=0.35, lw=0.0
        )
    if peak:
        k = int(np.argmax(values))
        panel.plot(frequency[k], values[k], "o", color=look["color"], ms=4)
        label = f"{label}: {values[k]:.1f} m/s² at {frequency[k]:.0f} Hz"
    panel.semilogx(frequency, values, label=label, **look)


def _finish(panel: Axes, view: TransientView, label: str) -> None:
    panel.set_xlabel("frequency [Hz]")
    panel.set_ylabel(label)
    span(panel, view.frequency)
    panel.set_ylim(bottom=0.0)
    mark_unknown(panel, view, view.frequency[-1])


def mark_unknown(panel: Axes, view: TransientView, highest: float) -> None:
    """Hatch the frequencies above those that the reduced model is meant for."""
    if view.reduced and view.maximum_frequency < highest:
        panel.axvspan(
            view.maximum_frequency, highest, facecolor="none", edgecolor="0.6", hatch="///", lw=0.0
        )


def _note(view: TransientView, probes: Sequence[int]) -> str:
    """What the band and the hatching are, and whether the spectra end."""
    if not view.reduced:
        return _end_note(view, probes)
    largest = 0.0
    for probe in probes:
        psa = view.psa(probe)[view.known]
        moves = psa > 0.0
        share = view.band(probe)[view.known][moves] / psa[moves]
        largest = max(largest, float(share.max(initial=0.0)))
    band = f"error band of the reduced model{view.band_note}"
    note = f" Shaded: {band}, at most {100 * largest:.2g} %"
    if view.maximum_frequency < view.frequency[-1]:
        note += f"; hatched: above {view.maximum_frequency:g} Hz, for which it is not made"
    return f"{note}.{_end_note(view, probes)}"


def _end_note(view: TransientView, probes: Sequence[int]) -> str:
    """Where the spectra have not come to the peak acceleration at the highest known frequency."""
    ratio = view.ends[list(probes), XYZ.index(view.direction)]
    off = np.nan_to_num(np.abs(np.log(ratio)))
    if not (off > np.log(ENDED)).any():
        return ""
    worst = int(off.argmax())
    last = view.frequency[view.known][-1]
    return f" Not ended at {last:.3g} Hz: there {ratio[worst]:.2g} times the peak acceleration."
