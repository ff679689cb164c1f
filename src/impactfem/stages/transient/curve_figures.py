"""Figures of the 3D building over time and frequency, at its probes."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from impactfem.plot.curves import (
    NONE,
    Curve,
    CurveFigure,
    Panel,
    hatching_note,
    published_level,
    published_point,
    unresolved,
)
from impactfem.plot.figure import figure
from impactfem.plot.style import (
    BLUE,
    DASHES,
    ORANGE,
    RED,
    floor_colours,
    floor_looks,
    ordered_colours,
    ordered_looks,
)
from impactfem.spectra.design import ENDED
from impactfem.stages.stores import time_step
from impactfem.stages.transient.physics import force_spectra, power_spectrum
from impactfem.stages.transient.selection import (
    at_floor,
    floors_of,
    known,
    main_impact,
    main_side,
    of_kind,
    of_pounding,
    pounded,
    shown_line,
    struck,
    transfer,
    wave_floor,
)
from impactfem.system.arrays import Array

BEFORE, AFTER = 0.5, 2.0
"""What is shown about the main impact, in parts of how long it lasts."""
SILENT = 1e-3
"""Part of its largest force below which a floor is left out there."""
SHOWN_EDGES = 3
DECADES = 5.0
"""Decades of a power spectral density that are shown."""
POINTS = (RED, ORANGE, "#CC79A7", "#56B4E9", "black")
"""Colours of user-defined points, which no floor has."""
MOST_POINTS = 10
"""User-defined points that are shown one by one; the legend has no room for more."""
PSA = "pseudo-acceleration [m/s²]"
SPECTRA = "Floor spectra of the 3D model"
HISTORIES = "Histories and waves"
FORCES = "Impact forces and transfer"
MAPS = "Maps of the floors"
"""Sections of the report."""


def _hit(response: xr.Dataset) -> bool:
    """Whether the response has an impact on an edge."""
    return main_impact(response) is not None and response.sizes["edge"] > 0


def _has_transfer(response: xr.Dataset) -> bool:
    probes = shown_line(response).sizes["probe"] + of_kind(response, "edge").sizes["probe"]
    return bool(response.sizes.get("transfer_load", 0) and probes)


def focus(response: xr.Dataset) -> slice | None:
    """The times that are shown of the main impact [s]; None without one."""
    impact = main_impact(response)
    if impact is None:
        return None
    lasts = max(impact[1] - impact[0], time_step(response))
    return slice(impact[0] - BEFORE * lasts, impact[1] + AFTER * lasts)


@figure("centre_spectrum", SPECTRA, "Floor spectra at the mass centres: 3D model and pounding")
def centre_spectrum(
    response: xr.Dataset, sticks: xr.Dataset, published: Mapping[str, float] = NONE
) -> CurveFigure:
    """Draw the spectra of the top mass centre by 3D model and pounding, and of the others."""
    top = wave_floor(response)
    centre = at_floor(response, "centre", top)
    other, model = of_pounding(sticks, "psa", response), pounded(sticks, response)
    caption = (
        f"{_spectra_words(response)} at the mass centre of floor {top}, 3D model and {model} (a), "
        "and at the mass centres of all floors and user-defined points, 3D model (b)."
        f"{_note(centre.expand_dims('probe'))}"
    )
    curves = [] if other is None else _with_peak(_spectrum(other, model, (RED, "--")))
    curves += _with_peak(_spectrum(centre["psa"], "3D", (BLUE, "-"), centre["psa_band"]))
    for name, label, colour in (("frs", "sticks", RED), ("transient.frs", "3D", BLUE)):
        key = f"{name}.floor_{top}.peak"
        curves += published_point(published, f"{key}_frequency", key, label, colour)
    panels = [_spectrum_panel(response, PSA, curves)]
    centres, points = (of_kind(response, kind)["psa"] for kind in ("centre", "point"))
    others = [(f"floor {psa['probe_floor'].item()}", psa) for psa in centres]
    looks = floor_looks(len(others))
    own = [(str(psa["probe"].item()).replace("_", " "), psa) for psa in points]
    if len(own) > MOST_POINTS:
        own = [(f"largest of {len(own)} points", points.max("probe"))]
    others += own
    looks += [{"color": POINTS[k % len(POINTS)], "ls": DASHES[k % 4]} for k in range(len(own))]
    if len(others) > 1:
        every = [
            _spectrum(psa, label, tuple(look.values()))
            for look, (label, psa) in zip(looks, others, strict=True)
        ]
        panels.append(_spectrum_panel(response, PSA, every, reverse=True))
    size = (4.5 * len(panels) + 0.5, 3.8)
    return CurveFigure(caption, panels, len(panels), size)


@figure(
    "across_spectra",
    SPECTRA,
    "Floor spectra along the line across the floor",
    when=lambda response: shown_line(response).sizes["probe"],
)
def across_spectra(response: xr.Dataset, published: Mapping[str, float] = NONE) -> CurveFigure:
    """Draw the spectra at distances from the impact edge."""
    line, top = shown_line(response), wave_floor(response)
    caption = (
        f"{_spectra_words(response)} of floor {top} at distances d from its impact edge: "
        f"displacement (a) and pseudo-acceleration (b).{_note(line)}"
    )
    labels = [f"d = {distance:.1f} m" for distance in line["distance"].values]
    looks = ordered_looks(len(labels))
    # Near the impact the spectrum is highest there, and exceeds what the edge is said to.
    names = "transient.frs.near_highest_at", f"transient.pfa.edge_{top}"
    near = published_point(published, *names, f"{labels[0]}: exceeded", looks[0]["color"])
    panels = _both(line, labels, looks, [replace(one, marker="^") for one in near])
    return CurveFigure(caption, panels)


@figure(
    "edge_spectra",
    SPECTRA,
    "Floor spectra at the impact edges",
    when=lambda response: of_kind(response, "edge").sizes["probe"],
)
def edge_spectra(response: xr.Dataset, published: Mapping[str, float] = NONE) -> CurveFigure:
    """Draw the spectra at the middle of the impact edges."""
    edges, top = of_kind(response, "edge"), wave_floor(response)
    caption = (
        f"{_spectra_words(response)} at the middle of the impact edges of the floors: displacement "
        f"(a) and pseudo-acceleration (b).{_note(edges)}"
    )
    labels = [f"floor {floor}" for floor in edges["probe_floor"].values]
    # Where the floor below the one with the line is published to be above it, if it is.
    floors = [floor for floor in floors_of(edges, "edge") if floor <= top][-2:]
    name = "_above_".join(f"floor_{floor}" for floor in floors)
    ends = [published.get(f"transient.frs.{name}.{end}") for end in ("lowest", "highest")]
    higher = []
    if None not in ends:
        x, level = np.array(ends, dtype=float), 0.03 * float(known(edges)["psa"].max())
        words = "published, floor {} above floor {}".format(*floors)
        higher = [Curve(x, np.full(2, level), words, "black", width=1.4, marker="|")]
    panels = _both(edges, labels, floor_looks(len(labels)), higher, reverse=True)
    return CurveFigure(caption, panels)


@figure(
    "centre",
    HISTORIES,
    "Response of the mass centre of the top floor",
    default=False,
)
def centre(response: xr.Dataset, sticks: xr.Dataset) -> CurveFigure:
    """Draw displacement and acceleration of the top mass centre by 3D model and pounding."""
    d, top, main = response["component"].item(), wave_floor(response), focus(response)
    model = pounded(sticks, response)
    centre = at_floor(response, "centre", top)
    every = slice(*centre["time"].values[[0, -1]])
    caption = (
        "Displacement relative to the ground (a) and absolute acceleration (b) along "
        f"$e_{d}$ of the mass centre of floor {top}"
        f"{', and its main impact (c)' if main else ''}: 3D model and {model}."
    )
    acceleration = f"acceleration $\\ddot u_{d}$ [m/s²]"
    wanted = [
        ("displacement", 1e2, f"displacement $u_{d}$ [cm]", every),
        ("acceleration", 1.0, acceleration, every),
        *([("acceleration", 1.0, acceleration, main)] if main else []),
    ]
    panels = []
    for name, factor, label, times in wanted:
        other, curves = of_pounding(sticks, name, response), []
        if other is not None:
            part = factor * other.sel(time=times)
            curves.append(_history(part, model, RED, dash="--", width=0.8))
        curves.append(_history(factor * centre[name].sel(time=times), "3D", BLUE, width=0.8))
        panels.append(Panel("time [s]", label, curves, legend=""))
    panels[0] = replace(panels[0], room=0.35, legend="upper right")
    size = (9.0, 2.8 * math.ceil(len(panels) / 2) + 0.4)
    return CurveFigure(caption, panels, size=size)


@figure(
    "across",
    HISTORIES,
    "Acceleration along the line across the floor",
    when=lambda response: shown_line(response).sizes["probe"],
    default=False,
)
def across(response: xr.Dataset) -> CurveFigure:
    """Draw the acceleration at some distances from the impact, and in the main impact."""
    d, main, probes = response["component"].item(), focus(response), shown_line(response)
    caption = (
        f"Acceleration along $e_{d}$ of floor {wave_floor(response)} at distances d "
        "from its impact edge, on the line across it, over time (a)"
        f"{', and the main impact (b)' if main else ''}."
    )
    panels = []
    for times in (slice(None), *([main] if main else [])):
        histories = probes["acceleration"].transpose("probe", "time").sel(time=times)
        curves = [
            _history(one, f"d = {one['distance'].item():.1f} m", colour, width=0.8)
            for one, colour in zip(histories, ordered_colours(len(histories)), strict=True)
        ]
        label = f"acceleration $\\ddot u_{d}$ [m/s²]"
        panels.append(Panel("time [s]", label, curves, legend=""))
    panels[-1] = replace(panels[-1], legend="lower right")
    return CurveFigure(caption, panels, len(panels), (9.0, 3.6))


@figure(
    "edge",
    HISTORIES,
    "Acceleration at the impact edge",
    when=lambda response: of_kind(response, "edge").sizes["probe"],
    default=False,
)
def edge(response: xr.Dataset, published: Mapping[str, float]) -> CurveFigure:
    """Draw the acceleration at the impact edge of the floor below the top, and its PSD."""
    floors = floors_of(response, "edge")
    floors = [floor for floor in floors if floor <= wave_floor(response)] or floors
    floor, d = floors[-2:][0], response["component"].item()
    history = at_floor(response, "edge", floor)["acceleration"]
    frequency, density = power_spectrum(history.values, time_step(response))
    k = int(np.argmax(np.abs(history.values)))
    peak = history.isel(time=[k])
    label = f"{peak.item():.1f} m/s² at {peak['time'].item():.3f} s"
    caption = (
        f"Acceleration along $e_{d}$ at the middle of the impact edge of "
        f"floor {floor} over time (a), and its power spectral density (b; Welch's method, segments "
        f"of {1.0 / frequency[1]:.2g} s)."
    )
    curves = [
        _history(history, "", BLUE, width=0.8),
        _history(peak, label, "black", dash="", marker="o"),
        *published_level(published, f"transient.pfa.edge_{floor}", history["time"].values),
    ]
    panels = [
        Panel("time [s]", f"acceleration $\\ddot u_{d}$ [m/s²]", curves, room=0.2),
        _density_panel(
            response, frequency, [density], [("", BLUE, "-")], "PSD of acceleration [(m/s²)²/Hz]"
        ),
    ]
    return CurveFigure(caption, panels, size=(9.0, 3.4))


@figure(
    "edge_impacts",
    FORCES,
    "Impact forces on the edges of the 3D model",
    when=_hit,
    default=False,
)
def edge_impacts(response: xr.Dataset) -> CurveFigure:
    """Draw the forces on the edges of the floors, and the main impact."""
    force = 1e-6 * struck(response)["impact_force"].transpose("edge", "time")
    colours = floor_colours(force.sizes["edge"])
    largest = abs(force).max("time").values
    whole, main = [], []
    # The largest first, so that it hides no other one.
    order = largest.argsort()[::-1]
    for k in order:
        one = force.isel(edge=k)
        whole.append(_history(one, str(one["edge"].item()), colours[k]))
        part = one.sel(time=focus(response))
        if abs(part).max() > SILENT * largest[k]:
            main.append(_history(part, "", colours[k], marker="."))
    caption = (
        f"Impact forces on the sides of building {response.attrs['building']} over time "
        f"(a), and the main impact, of {force['edge'].values[order[0]]}, at the times of the 3D "
        "model (b). Positive in compression."
    )
    label = "impact force [MN]"
    panels = [Panel("time [s]", label, curves, legend="") for curves in (whole, main)]
    size = (9.0, 3.4)
    return CurveFigure(caption, panels, size=size, above=True)


@figure(
    "force_density",
    FORCES,
    "Power spectral densities of the main impact",
    when=_hit,
    default=False,
)
def force_density(response: xr.Dataset) -> CurveFigure:
    """Draw the power spectral densities of the two upper loads of a side."""
    force = main_side(response)["impact_force"].isel(edge=slice(-2, None)).transpose("time", "edge")
    places = force["edge"].values.tolist()
    # Over the duration of the table, of all sides that are struck.
    every = struck(response)["impact_force"].transpose("time", "edge")
    spectra = force_spectra(every.values, time_step(response))
    rows = [every["edge"].values.tolist().index(place) for place in places]
    peaks = abs(force).idxmax("time").values
    forces = " and ".join(f"{p} (at {t:.3f} s)" for p, t in zip(places, peaks, strict=True))
    caption = (
        f"Power spectral densities of the main impact force on {forces}, as the mean "
        f"power over {1e3 * spectra.duration:.0f} ms."
    )
    looks = ((RED, "--"), (BLUE, "-"))[-len(places) :]
    labels = [(place, *look) for place, look in zip(places, looks, strict=True)]
    label = "PSD of the impact force [MN²/Hz]"
    panel = _density_panel(
        response, spectra.frequency, 1e-12 * spectra.density[rows], labels, label
    )
    return CurveFigure(caption, [panel], 1, (6.5, 3.8))


@figure(
    "transfer_functions",
    FORCES,
    "Transfer functions from impact force to acceleration",
    when=_has_transfer,
    default=False,
)
def transfer_functions(response: xr.Dataset, published: Mapping[str, float]) -> CurveFigure:
    """Draw acceleration over the impact force of a floor."""
    edges = of_kind(response, "edge").isel(probe=slice(-SHOWN_EDGES, None))
    loads = list(dict.fromkeys(response["transfer_load_floor"].values.tolist()))[-2:]
    wanted = []
    if edges.sizes["probe"]:
        labels = [f"edge of floor {floor}" for floor in edges["probe_floor"].values]
        colours = floor_colours(len(labels))
        wanted = [(load, edges, f"force on floor {load}", labels, colours) for load in loads]
    if of_kind(response, "line").sizes["probe"]:
        line = shown_line(response)
        labels = [f"d = {distance:.1f} m" for distance in line["distance"].values]
        what = f"force on floor {loads[-1]}, along floor {wave_floor(response)}"
        wanted.append((loads[-1], line, what, labels, ordered_colours(len(labels))))
    names = "; ".join(f"{what} ({chr(97 + k)})" for k, (_, _, what, *_) in enumerate(wanted))
    caption = (
        f"Transfer functions, acceleration along $e_{response['component'].item()}$ "
        f"over impact force: {names}. Shaded: error bound of the reduced model."
    )
    f = response["transfer_frequency"].values
    panels = []
    for load, probes, _, labels, colours in wanted:
        curves = []
        sizes, bounds = (1e6 * one.transpose("probe", ...).values for one in transfer(probes, load))
        for size, bound, label, colour in zip(sizes, bounds, labels, colours, strict=True):
            within = np.where(bound < size, bound, 0.0)
            curves.append(Curve(f, size, label, colour, band=(size - within, size + within)))
        # Published is the largest value at the edge that the force acts on.
        if probes is edges:
            name, label = f"transient.transfer.floor_{load}", f"largest at the edge of floor {load}"
            curves += published_level(published, name, f, label, 1e6)
        panels.append(
            Panel(
                "frequency [Hz]",
                "acceleration / force [10⁻⁶ kg⁻¹]",
                curves,
                log="x",
                bottom=0.0,
                room=0.1,
                hatched=_unknown(response, f[-1]),
                legend="upper left",
            )
        )
    size = (9.0, 3.2 * math.ceil(len(panels) / 2) + 0.4)
    return CurveFigure(caption, panels, size=size, alike=True)


def _spectra_words(response: xr.Dataset) -> str:
    damping, direction = response["damping"].item(), response["component"].item()
    return f"Floor response spectra ({100 * damping:g} % damping) along $e_{direction}$"


def _history(values: xr.DataArray, label: str, colour: Any, **look: Any) -> Curve:
    return Curve(values["time"].values, values.values, label, colour, **look)


def _density_panel(
    response: xr.Dataset,
    frequency: Array,
    densities: Sequence[Array] | Array,
    labels: Sequence[tuple[str, str, str]],
    ylabel: str,
) -> Panel:
    """Densities from the lowest frequency of the spectra, or that of the densities, upwards."""
    lowest = max(float(response["frequency"][0]), float(frequency[1]))
    shown_part = frequency >= min(lowest, 0.5 * frequency[-1])
    curves = [
        Curve(frequency[shown_part], density[shown_part], *look)
        for density, look in zip(densities, labels, strict=True)
    ]
    largest = float(np.max(densities))
    bottom = 10.0**-DECADES * largest if largest > 0.0 else None
    look: dict[str, Any] = {"log": "xy", "bottom": bottom, "legend": "lower left"}
    return Panel("frequency [Hz]", ylabel, curves, **look)


def _both(
    probes: xr.Dataset,
    labels: Sequence[str],
    looks: Sequence[dict[str, Any]],
    more: Sequence[Curve],
    *,
    reverse: bool = False,
) -> list[Panel]:
    """Spectral displacement and pseudo-acceleration of probes; further curves of the latter."""
    # PSa = ω² Sd, and so are their error bands.
    band = probes["psa_band"] / (2.0 * np.pi * probes["frequency"]) ** 2
    displacement, acceleration = (
        [
            _spectrum(one, label, tuple(look.values()), half)
            for one, label, look, half in zip(values, labels, looks, bands, strict=True)
        ]
        for values, bands in ((1e2 * probes["sd"], 1e2 * band), (probes["psa"], probes["psa_band"]))
    )
    return [
        _spectrum_panel(probes, "spectral displacement [cm]", displacement, legend=""),
        _spectrum_panel(probes, PSA, [*acceleration, *more], reverse=reverse),
    ]


def _spectrum(
    spectrum: xr.DataArray, label: str, look: Sequence[Any], band: xr.DataArray | None = None
) -> Curve:
    frequency, values = spectrum["frequency"].values, spectrum.values
    around = None
    if band is not None and band.any():
        around = (values - band.values, values + band.values)
    colour, dash = look
    return Curve(frequency, values, label, colour, dash, band=around)


def _with_peak(curve: Curve) -> list[Curve]:
    """A spectrum whose label says its peak, which is marked."""
    k = int(np.argmax(curve.y))
    label = f"{curve.label}: {curve.y[k]:.1f} m/s² at {curve.x[k]:.0f} Hz"
    at = slice(k, k + 1)
    return [
        Curve(curve.x[at], curve.y[at], "", curve.colour, "", marker="o"),
        replace(curve, label=label),
    ]


def _spectrum_panel(
    response: xr.Dataset, label: str, curves: Sequence[Curve], **options: Any
) -> Panel:
    hatched = unresolved(response, float(response["frequency"][-1]))
    options = {"legend": "upper left", **options}
    return Panel("frequency [Hz]", label, curves, log="x", bottom=0.0, hatched=hatched, **options)


def _unknown(response: xr.Dataset, highest: float) -> tuple[float, float] | None:
    """The frequencies above those that the reduced model is meant for, up to the highest [Hz]."""
    meant = float(response.attrs["maximum_frequency"])
    return (meant, highest) if response.attrs["solver"] != "full" and meant < highest else None


def _note(probes: xr.Dataset) -> str:
    """What band and hatching are, and where the spectra have not come to the peak acceleration."""
    good, note = known(probes), ""
    if probes.attrs["solver"] != "full":
        share = good["psa_band"] / good["psa"].where(good["psa"] > 0.0)
        by = good["psa_band"].attrs.get("note")
        note = (
            f" Shaded: error band of the reduced model{f' ({by})' if by else ''}, at most "
            f"{100 * float(share.max().fillna(0.0)):.2g} %"
        )
        note += "."
    note += hatching_note(probes, float(probes["frequency"][-1]))
    ratio = good["ends"].values
    off = np.nan_to_num(np.abs(np.log(ratio)))
    if (off > np.log(ENDED)).any():
        last, worst = float(good["frequency"][-1]), ratio[off.argmax()]
        note += f" Not ended at {last:.3g} Hz: there {worst:.2g} times the peak acceleration."
    return note
