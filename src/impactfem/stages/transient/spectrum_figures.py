"""Figures of floor response spectra of the 3D building: 13, 15 and 19, with their error bands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.style import BLUE, RED, floor_looks, ordered_looks
from impactfem.spectra.design import ENDED
from impactfem.stages.stores import open_stores
from impactfem.stages.transient.selection import (
    at_floor,
    known,
    of_kind,
    of_sticks,
    sd_band,
    shown,
    shown_line,
    wave_floor,
)

Array = NDArray[np.float64]


def transient_curves(folder: Path) -> list[CurveFigure]:
    """Figures 13, 15 and 19, for the report.

    Args:
        folder: The run's folder, with `transient.nc` and `pounding.nc`.
    """
    with open_stores(folder) as opened:
        return spectra_figures(shown(opened("transient.nc")), opened("pounding.nc"))


def spectra_figures(response: xr.Dataset, sticks: xr.Dataset) -> list[CurveFigure]:
    """Figures 13, 15 and 19, as far as there are probes for them."""
    figures = [centre_spectrum(response, sticks)]
    if of_kind(response, "line").sizes["probe"]:
        figures.append(across_spectra(response))
    if of_kind(response, "edge").sizes["probe"]:
        figures.append(edge_spectra(response))
    return figures


def centre_spectrum(response: xr.Dataset, sticks: xr.Dataset) -> CurveFigure:
    """Figure 13: the spectrum of the top floor's mass centre, 3D and sticks.

    The page has those of all other mass centres and points in addition.
    """
    top = wave_floor(response)
    centre = at_floor(response, "centre", top)
    other = of_sticks(sticks, "psa", response)
    caption = (
        f"Figure 13: Floor response spectrum (pseudo-acceleration, {_percent(response)} damping) "
        f"along $e_{response['component'].item()}$ at the mass centre of floor {top}: 3D model and "
        f"sticks.{_note(response, [centre['probe'].item()])}"
    )
    curves = [] if other is None else _with_peak(_curve(other, "sticks", (RED, "--")))
    curves += _with_peak(_curve(centre["psa"], "3D", (BLUE, "-"), centre["psa_band"]))
    good = known(response)
    points = [
        (f"floor {psa['probe_floor'].item()}, mass centre", psa)
        for psa in of_kind(good, "centre")["psa"][::-1]
        if psa["probe_floor"].item() != top
    ]
    for psa in of_kind(good, "point")["psa"]:
        points.append((str(psa["probe"].item()).replace("_", " "), psa))
    looks = ordered_looks(len(points))
    curves += [
        _curve(psa, label, tuple(look.values()), further=True)
        for look, (label, psa) in zip(looks, points, strict=True)
    ]
    panel = _panel(response, "pseudo-acceleration [m/s²]", curves)
    return CurveFigure("figure_13_centre_spectrum", caption, [panel], columns=1, size=(6.5, 4.0))


def across_spectra(response: xr.Dataset) -> CurveFigure:
    """Figure 15: spectra at some distances from the impact; the page has all of them."""
    line = shown_line(response)
    caption = (
        f"Figure 15: Floor response spectra ({_percent(response)} damping) along "
        f"$e_{response['component'].item()}$ of floor {wave_floor(response)} at distances d from "
        "its impact edge: displacement (a) and pseudo-acceleration (b)."
        f"{_note(response, line['probe'].values)}"
    )
    every = of_kind(response, "line")
    labels = [f"d = {distance:.1f} m" for distance in every["distance"].values]
    drawn = set(line["probe"].values)
    further = [probe not in drawn for probe in every["probe"].values]
    shades = iter(ordered_looks(len(drawn)))
    looks = [{"color": "0.6", "ls": ":"} if late else next(shades) for late in further]
    return _both("figure_15_across_spectra", every, labels, looks, caption, further=further)


def edge_spectra(response: xr.Dataset) -> CurveFigure:
    """Figure 19: spectra at the impact edges of all floors."""
    edges = of_kind(response, "edge")
    caption = (
        f"Figure 19: Floor response spectra ({_percent(response)} damping) along "
        f"$e_{response['component'].item()}$ at the middle of the impact edges of the floors: "
        "displacement (a) and pseudo-acceleration (b)."
        f"{_note(response, edges['probe'].values)}"
    )
    labels = [f"floor {floor}" for floor in edges["probe_floor"].values]
    looks = floor_looks(len(labels))
    return _both("figure_19_edge_spectra", edges, labels, looks, caption, reverse=True)


def _percent(response: xr.Dataset) -> str:
    return f"{100 * response['damping'].item():g} %"


def _both(
    name: str,
    probes: xr.Dataset,
    labels: Sequence[str],
    looks: Sequence[dict[str, Any]],
    caption: str,
    *,
    further: Sequence[bool] = (),
    reverse: bool = False,
) -> CurveFigure:
    """Spectral displacement and pseudo-acceleration of probes."""
    sd, band = 1e2 * probes["sd"], 1e2 * sd_band(probes)
    late = further or [False] * len(labels)
    displacement, acceleration = (
        [
            _curve(one, label, tuple(look.values()), half, further=only)
            for one, label, look, half, only in zip(values, labels, looks, bands, late, strict=True)
        ]
        for values, bands in ((sd, band), (probes["psa"], probes["psa_band"]))
    )
    panels = [
        _panel(probes, "spectral displacement [cm]", displacement, legend=""),
        _panel(probes, "pseudo-acceleration [m/s²]", acceleration, reverse=reverse),
    ]
    return CurveFigure(name, caption, panels)


def _curve(
    spectrum: xr.DataArray,
    label: str,
    look: Sequence[Any],
    band: xr.DataArray | None = None,
    *,
    further: bool = False,
) -> Curve:
    frequency, values = spectrum["frequency"].values, spectrum.values
    colour, dash = look
    around = None
    if band is not None and band.any() and not further:
        around = (values - band.values, values + band.values)
    return Curve(frequency, values, label, colour, dash, band=around, further=further)


def _with_peak(curve: Curve) -> list[Curve]:
    """A spectrum whose label says its peak, which is marked."""
    k = int(np.argmax(curve.y))
    label = f"{curve.label}: {curve.y[k]:.1f} m/s² at {curve.x[k]:.0f} Hz"
    at = slice(k, k + 1)
    return [
        Curve(curve.x[at], curve.y[at], "", curve.colour, "", marker="o"),
        replace(curve, label=label),
    ]


def _panel(
    response: xr.Dataset,
    label: str,
    curves: Sequence[Curve],
    *,
    legend: str = "upper left",
    reverse: bool = False,
) -> Panel:
    hatched = unknown(response, float(response["frequency"][-1]))
    return Panel(
        "frequency [Hz]",
        label,
        curves,
        log="x",
        bottom=0.0,
        hatched=hatched,
        legend=legend,
        reverse=reverse,
    )


def unknown(response: xr.Dataset, highest: float) -> tuple[float, float] | None:
    """The frequencies above those that the reduced model is meant for, up to the highest [Hz]."""
    meant = float(response.attrs["maximum_frequency"])
    return (meant, highest) if response.attrs["solver"] != "full" and meant < highest else None


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
