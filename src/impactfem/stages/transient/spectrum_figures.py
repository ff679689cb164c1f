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
from impactfem.stages.transient.selection import (
    at_floor,
    known,
    of_kind,
    of_sticks,
    sd_band,
    shown_line,
    wave_floor,
)

Array = NDArray[np.float64]


def centre_spectrum(path: Path, response: xr.Dataset, sticks: xr.Dataset) -> None:
    """Figure 13: the spectrum of the top floor's mass centre, 3D and sticks."""
    top = wave_floor(response)
    centre = at_floor(response, "centre", top)
    other = of_sticks(sticks, "psa", response)
    caption = (
        f"Figure 13: Floor response spectrum (pseudo-acceleration, {_percent(response)} damping) "
        f"along $e_{response['component'].item()}$ at the mass centre of floor {top}: 3D model and "
        f"sticks.{_note(response, [centre['probe'].item()])}"
    )
    look, sticks_look = {"color": BLUE}, {"color": RED, "ls": "--"}
    with figure(path, (1, 1), (6.5, 4.0), caption) as (_, axes):
        if other is not None:
            _curve(axes[0], other, sticks_look, "sticks", peak=True)
        _curve(axes[0], centre["psa"], look, "3D", centre["psa_band"], peak=True)
        _finish(axes[0], response, "pseudo-acceleration [m/s²]")
        axes[0].legend(loc="upper left")


def across_spectra(path: Path, response: xr.Dataset) -> None:
    """Figure 15: spectra at some distances from the impact."""
    line = shown_line(response)
    caption = (
        f"Figure 15: Floor response spectra ({_percent(response)} damping) along "
        f"$e_{response['component'].item()}$ of floor {wave_floor(response)} at distances d from "
        "its impact edge: displacement (a) and pseudo-acceleration (b)."
        f"{_note(response, line['probe'].values)}"
    )
    labels = [f"d = {distance:.1f} m" for distance in line["distance"].values]
    _displacement_and_acceleration(path, line, labels, caption)


def edge_spectra(path: Path, response: xr.Dataset) -> None:
    """Figure 19: spectra at the impact edges of all floors."""
    edges = of_kind(response, "edge")
    caption = (
        f"Figure 19: Floor response spectra ({_percent(response)} damping) along "
        f"$e_{response['component'].item()}$ at the middle of the impact edges of the floors: "
        "displacement (a) and pseudo-acceleration (b)."
        f"{_note(response, edges['probe'].values)}"
    )
    labels = [f"floor {floor}" for floor in edges["probe_floor"].values]
    _displacement_and_acceleration(path, edges, labels, caption, from_top=True)


def _percent(response: xr.Dataset) -> str:
    return f"{100 * response['damping'].item():g} %"


def _displacement_and_acceleration(
    path: Path,
    probes: xr.Dataset,
    labels: Sequence[str],
    caption: str,
    *,
    from_top: bool = False,
) -> None:
    sd, band = 1e2 * probes["sd"], 1e2 * sd_band(probes)
    with figure(path, (1, 2), (9.0, 4.0), caption) as (_, axes):
        looks = (floor_looks if from_top else ordered_looks)(probes.sizes["probe"])
        for k, (look, label) in enumerate(zip(looks, labels, strict=True)):
            one = probes.isel(probe=k)
            _curve(axes[0], sd.isel(probe=k), look, label, band.isel(probe=k))
            _curve(axes[1], one["psa"], look, label, one["psa_band"])
        _finish(axes[0], probes, "spectral displacement [cm]")
        _finish(axes[1], probes, "pseudo-acceleration [m/s²]")
        handles, names = axes[1].get_legend_handles_labels()
        order = slice(None, None, -1) if from_top else slice(None)
        axes[1].legend(handles[order], names[order], loc="upper left", handlelength=HANDLE)
        letter(axes)


def _curve(
    panel: Axes,
    spectrum: xr.DataArray,
    look: Mapping[str, Any],
    label: str,
    band: xr.DataArray | None = None,
    *,
    peak: bool = False,
) -> None:
    frequency, values = spectrum["frequency"].values, spectrum.values
    if band is not None and band.any():
        low, high = values - band.values, values + band.values
        panel.fill_between(frequency, low, high, color=look["color"], alpha=0.35, lw=0.0)
    if peak:
        k = int(np.argmax(values))
        panel.plot(frequency[k], values[k], "o", color=look["color"], ms=4)
        label = f"{label}: {values[k]:.1f} m/s² at {frequency[k]:.0f} Hz"
    panel.semilogx(frequency, values, label=label, **look)


def _finish(panel: Axes, response: xr.Dataset, label: str) -> None:
    frequency = response["frequency"].values
    panel.set_xlabel("frequency [Hz]")
    panel.set_ylabel(label)
    span(panel, frequency)
    panel.set_ylim(bottom=0.0)
    mark_unknown(panel, response, frequency[-1])


def mark_unknown(panel: Axes, response: xr.Dataset, highest: float) -> None:
    """Hatch the frequencies above those that the reduced model is meant for."""
    meant = float(response.attrs["maximum_frequency"])
    if response.attrs["solver"] != "full" and meant < highest:
        panel.axvspan(meant, highest, facecolor="none", edgecolor="0.6", hatch="///", lw=0.0)


def _note(response: xr.Dataset, probes: Sequence[str] | Array) -> str:
    """What the band and the hatching are, and whether the spectra end."""
    good = known(response).sel(probe=list(probes))
    if response.attrs["solver"] == "full":
        return _end_note(good)
    share = good["psa_band"] / good["psa"].where(good["psa"] > 0.0)
    largest = float(share.max().fillna(0.0))
    told = good["psa_band"].attrs.get("note")
    note = f" Shaded: error band of the reduced model{f' ({told})' if told else ''}, at most "
    note += f"{100 * largest:.2g} %"
    meant = float(response.attrs["maximum_frequency"])
    if meant < float(response["frequency"][-1]):
        note += f"; hatched: above {meant:g} Hz, for which it is not made"
    return f"{note}.{_end_note(good)}"


def _end_note(good: xr.Dataset) -> str:
    """Where the spectra have not come to the peak acceleration at the highest known frequency."""
    ratio = good["ends"].values
    off = np.nan_to_num(np.abs(np.log(ratio)))
    if not (off > np.log(ENDED)).any():
        return ""
    worst, last = int(off.argmax()), float(good["frequency"][-1])
    return f" Not ended at {last:.3g} Hz: there {ratio[worst]:.2g} times the peak acceleration."
