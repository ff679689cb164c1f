"""Plots to zoom into and read values off, of the spectra and forces of a run."""

from __future__ import annotations

import html
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from impactfem.plot.curves import CurveFigure, plain, thinned
from impactfem.report.run_files import RunFiles
from impactfem.spectra.statistics import STATISTICS
from impactfem.stages.design.products import design_products_of
from impactfem.stages.device.verdict import LOADS
from impactfem.stages.device.view import WITH, WITHOUT, DeviceView
from impactfem.stages.transient.selection import known, of_kind, shown, wave_floor

Array = NDArray[np.float64]

BLACK, GREY = "#222222", "#888888"
# Okabe and Ito's colours, and dashes beside them: told apart with any colour vision, and in print.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#000000", "#999999")
DASHES = ("solid", "dash", "dot", "dashdot")
SETTINGS = {"displaylogo": False, "responsive": True, "toImageButtonOptions": {"format": "svg"}}


@dataclass(frozen=True)
class Plot:
    """A plot of a page.

    Args:
        name: Its anchor.
        caption: What it shows, in a sentence.
        markup: Its HTML, which needs plotly's script on the page.
    """

    name: str
    caption: str
    markup: str

    @classmethod
    def of(cls, drawn: CurveFigure) -> Plot:
        """A figure of curves as a plot of a page."""
        return cls(f"plot_{drawn.name}", plain(html.escape(drawn.caption)), drawn.to_html())


def plots_of(run: RunFiles, stage: str) -> list[Plot]:
    """The plots of a stage.

    Args:
        run: The run.
        stage: Name of the stage.
    """
    makers: dict[str, Sequence[Callable[[RunFiles], Plot | None]]] = {
        "ensemble": (_ensemble,),
        "transient": (_structure_spectra, _across),
        "device": (_anchor_spectra, _device_forces),
        "design": (_design_spectra,),
    }
    made = [make(run) for make in makers.get(stage, ())]
    return [plot for plot in made if plot is not None]


def _ensemble(run: RunFiles) -> Plot:
    with run.store("ensemble.nc") as store:
        building, direction = store.attrs["studied_building"], store.attrs["shown_direction"]
        percentile = [float(q) for q in store["percentile"].values]
        frequency, floors = store["frequency"].values, store["station_floor"].values
        psa = store["psa_percentile"].sel(direction=direction).isel(damping=0)
        bands = psa.transpose("percentile", "station", "frequency").values
        count = store.sizes["motion"]
    plot = go.Figure()
    top = int(np.argmax(floors))
    for number, q in enumerate(percentile):
        middle = q == 50.0
        style = {"color": COLOURS[0] if middle else GREY, "width": 2 if middle else 1}
        plot.add_scatter(
            x=frequency,
            y=bands[number, top],
            name="median" if middle else f"{q:g} %",
            line={**style, "dash": DASHES[abs(number - len(percentile) // 2) % len(DASHES)]},
        )
    caption = (
        f"Floor response spectrum of floor {int(floors[top])} of the stick of {building} along "
        f"{direction} over {count} motions: percentiles."
    )
    return _spectrum("plot_ensemble", caption, plot)


def _structure_spectra(run: RunFiles) -> Plot:
    with run.store("transient.nc") as store:
        response = known(shown(store)).load()
    building, direction = response.attrs["building"], response["component"].item()
    frequency, top = response["frequency"].values, wave_floor(response)
    kinds = (("centre", "mass centre"), ("edge", "impact edge"))
    curves = [
        (f"floor {probe['probe_floor'].item()}, {place}", probe)
        for kind, place in kinds
        for probe in of_kind(response, kind)["psa"][::-1]
    ]
    others = of_kind(response, "point")["psa"]
    curves += [(probe["probe"].item().replace("_", " "), probe) for probe in others]
    plot = go.Figure()
    for number, (name, psa) in enumerate(curves):
        at_first = name in (f"floor {top}, mass centre", f"floor {top}, impact edge")
        visible = True if at_first else "legendonly"
        line = _line(number)
        plot.add_scatter(x=frequency, y=psa.values, name=name, line=line, visible=visible)
        if at_first:
            band = response["psa_band"].sel(probe=psa["probe"])
            low, high = (psa - band).values, (psa + band).values
            plot.add_scatter(
                x=np.concatenate([frequency, frequency[::-1]]),
                y=np.concatenate([high, np.maximum(low[::-1], 1e-9)]),
                fill="toself",
                fillcolor=line["color"],
                opacity=0.25,
                line_width=0,
                name=f"{name}, error band",
                hoverinfo="skip",
            )
    caption = (
        f"Floor response spectra of the 3D model of {building} along {direction}, "
        f"{100 * response['damping'].item():g} % damping, with the error band of the reduced "
        "basis. Further points: click in the legend."
    )
    return _spectrum("plot_structure_spectra", caption, plot)


def _across(run: RunFiles) -> Plot | None:
    with run.store("transient.nc") as store:
        line = of_kind(known(shown(store)), "line").load()
    if line.sizes["probe"] < 2:
        return None
    plot = go.Figure()
    for number, psa in enumerate(line["psa"]):
        name = f"d = {psa['distance'].item():.3g} m"
        plot.add_scatter(x=line["frequency"].values, y=psa.values, name=name, line=_line(number))
    caption = (
        f"Floor response spectra across floor {wave_floor(line)} of the 3D model along "
        f"{line['component'].item()}, {100 * line['damping'].item():g} % damping, by the distance "
        "d from the impact edge."
    )
    return _spectrum("plot_across", caption, plot)


def _anchor_spectra(run: RunFiles) -> Plot:
    plot, number = go.Figure(), 0
    with run.store("device.nc") as store:
        view = DeviceView(store)
        for d, device in enumerate(view.devices):
            for c, case in enumerate(view.cases):
                for impact, load in LOADS.items():
                    dash = "dash" if impact == WITHOUT else "solid"
                    style = {"color": COLOURS[number // 2 % len(COLOURS)], "dash": dash}
                    visible = True if d == 0 and c == 0 else "legendonly"
                    name = f"{device}, damping {case}, {load}"
                    y = view.spectrum(d, impact, c)
                    plot.add_scatter(x=view.frequency, y=y, name=name, line=style, visible=visible)
                    number += 1
        for f in view.mode_frequency(0):
            if view.frequency[0] <= f <= view.frequency[-1]:
                plot.add_vline(x=f, line_dash="dot", line_color=GREY, line_width=1)
        caption = (
            f"Spectra of the floor at the anchors along {view.direction}, at the damping of the "
            f"devices; dotted: the frequencies of {view.devices[0]}."
        )
    return _spectrum("plot_anchor_spectra", caption, plot)


def _device_forces(run: RunFiles) -> Plot:
    plot = go.Figure()
    with run.store("device.nc") as store:
        view = DeviceView(store)
        for d, device in enumerate(view.devices):
            for impact in (WITH, WITHOUT):
                t, f = thinned(view.time, 1e-3 * view.force(d, impact))
                style = {"color": COLOURS[(2 * d + impact) % len(COLOURS)], "width": 1}
                visible = True if d == 0 else "legendonly"
                name = f"{device}, {LOADS[impact]}"
                plot.add_scatter(x=t, y=f, name=name, line=style, visible=visible)
        caption = f"Force F{view.direction} of the devices on the floor."
    return _plot("plot_device_forces", caption, plot, "time [s]", "force [kN]")


def _design_spectra(run: RunFiles) -> Plot:
    wanted = run.case["spectra"]
    with run.store("design.nc") as store:
        made = design_products_of(
            store, run.folder / "pounding.nc", wanted["broadening"], wanted["clipping"]
        )
        direction, building = made.view.direction, made.view.building
        column = made.view.directions.index(direction)
    floors = [station.floor for station in made.case.source.stations]
    plot = go.Figure()
    for s in range(len(floors) - 1, -1, -1):
        visible = True if s == len(floors) - 1 else "legendonly"
        curves = [("this motion", made.case, COLOURS[0], "solid")]
        for number, (name, spectra) in enumerate(made.statistics.items()):
            dash = DASHES[(number + 1) % len(DASHES)]
            curves.append((STATISTICS[name], spectra, COLOURS[(number + 1) % len(COLOURS)], dash))
        for name, spectra, colour, dash in curves:
            plot.add_scatter(
                x=spectra.frequency,
                y=spectra.psa[0, s, column],
                name=f"floor {floors[s]}, {name}",
                line={"color": colour, "dash": dash},
                visible=visible,
            )
        stick = made.of_stick(0, s, column)
        if stick is not None:
            grey = {"color": GREY, "dash": "dot"}
            name = f"floor {floors[s]}, stick"
            plot.add_scatter(x=stick[0], y=stick[1], name=name, line=grey, visible=visible)
    damping = 100.0 * float(made.case.source.damping[0])
    caption = (
        f"Design spectra of the floors of {building} along {direction}, {damping:g} % damping: "
        f"{made.view.enveloped}; broadened. Further floors: click in the legend."
    )
    return _spectrum("plot_design", caption, plot)


def _line(number: int) -> dict[str, Any]:
    return {
        "color": COLOURS[number % len(COLOURS)],
        "dash": DASHES[number // len(COLOURS) % len(DASHES)],
    }


def _spectrum(name: str, caption: str, plot: Any) -> Plot:
    plot.update_xaxes(type="log")
    return _plot(name, caption, plot, "frequency [Hz]", "pseudo-acceleration [m/s²]")


def _plot(name: str, caption: str, plot: Any, across: str, up: str) -> Plot:
    plot.update_layout(
        template="simple_white",
        height=430,
        # Above the legend there is room for the buttons.
        margin={"l": 60, "r": 10, "t": 36, "b": 45},
        xaxis_title=across,
        yaxis_title=up,
        legend={"font_size": 11},
        font={"family": "inherit", "color": BLACK},
    )
    plot.update_xaxes(showgrid=True, gridcolor="#dddddd")
    plot.update_yaxes(showgrid=True, gridcolor="#dddddd")
    for trace in plot.data:
        # Half the size: four digits are more than can be read off.
        trace.x, trace.y = np.float32(trace.x), np.float32(trace.y)
    markup = plot.to_html(
        full_html=False, include_plotlyjs=False, div_id=name, config=SETTINGS, default_width="100%"
    )
    return Plot(name, caption, markup)
