"""The figures of the stage `device` and their data: forces, spectra, dampings.

Figures of the force of a device on the floor over time, of the spectra at its anchor and of the
damping of the buildings are here, and of the largest forces by damping case: all analyses, and by
input: the spectra of the anchor as computed, their envelope with those of further points or over
all dampings, and spectra of a file; several supports are combined in several ways.
"""

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.ticker import MaxNLocator

from impactfem.plot.curves import (
    Curve,
    CurveFigure,
    Panel,
    hatching_note,
    published_level,
    published_point,
    unresolved,
)
from impactfem.plot.figure import figure
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED, letter, sheet, span
from impactfem.stages.device.selection import (
    ALL,
    BROADENED,
    DETAILED,
    GUPTA,
    LINDLEY_YOW,
    LOADS,
    RIGID_WORDS,
    ROTATIONS,
    WITH,
    WITHOUT,
    Load,
    direction,
    headline,
    input_variants,
    loaded,
    loads_of,
    modes_of,
    rigid_variants,
    shown_modes,
    variant,
)
from impactfem.stages.drawing import FigureData
from impactfem.stages.stores import damping_of, names_of
from impactfem.system.arrays import Array

WINDOW = (0.05, 0.15)
"""What is shown before and after the largest force [s]."""
RANGE = (0.5, 500.0)
"""Frequencies of the figure of the damping [Hz]."""
CASES = ("#56B4E9", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")
"""Okabe and Ito's colours of the damping cases in their order; the own damping is black."""
DASHES = ("-", "-", "-.", "-", "--", "--")
"""Of the damping cases: colours that are equally dark in print have different ones."""
HATCHES = ("", "", "////", "", "xxxx", "", "\\\\\\\\")
NOT_DONE = " No bar: spectrum too short."
RIGID_COLOURS = {"none": "0.75", GUPTA: "0.45", LINDLEY_YOW: "#7a4fa3"}
"""Of the bars of the demands."""
MARKERS = "os^Dvp*X"


class DeviceData(FigureData):
    """The data of the figures of the stage."""

    @cached_property
    def store(self) -> xr.Dataset:
        """`device.nc`."""
        return loaded(self.opened("device.nc"))

    @cached_property
    def building(self) -> xr.Dataset | None:
        """`building.nc`; None without it."""
        return self.optional("building.nc")

    @cached_property
    def maps(self) -> xr.Dataset | None:
        """`transient_maps.nc`; None without maps."""
        return self.optional("transient_maps.nc")

    @cached_property
    def resolved_in_maps(self) -> float | None:
        """End of the resolved band of the maps [Hz]; None without maps."""
        if self.maps is None:
            return None
        return float(self.opened("transient.nc").attrs["resolved_frequency"])

    @cached_property
    def device(self) -> list[str]:
        """Names of the devices."""
        return names_of(self.opened("device.nc"), "device")


def _looks(store: xr.Dataset) -> dict[str, tuple[str, str, float]]:
    """Colour, dashes and width of each damping case in the order in which they are drawn."""
    # The own damping, which may be one of them again, is drawn last and dashed over the others, so
    # that these are seen below it.
    own, *cases = names_of(store, "case")
    looks = {
        case: (CASES[k % len(CASES)], DASHES[k % len(DASHES)], 1.2) for k, case in enumerate(cases)
    }
    return looks | {own: ("black", "--" if cases else "-", 0.9 if cases else 1.2)}


def _named(store: xr.Dataset, case: str, apart: str = ", ") -> str:
    """A damping case with the restitution that its impacts have, if it has one of its own."""
    epsilon = float(store["epsilon"].sel(case=case))
    return case + (f"{apart}ε = {epsilon:.2f}" if np.isfinite(epsilon) else "")


def _different(store: xr.Dataset, *, restitution: bool = True) -> list[str]:
    """Damping cases; the case's own where none repeats it, to a hundredth: as printed."""
    # With `restitution` it is repeated only where the impacts have the same, too.
    own, *others = names_of(store, "case")
    frequency: Array = np.geomspace(*RANGE, 20)
    law, epsilon = damping_of(store.sel(case=own)).ratio(frequency), store["epsilon"].sel(case=own)
    for case in others:
        other = store.sel(case=case)
        same = np.allclose(damping_of(other).ratio(frequency), law, rtol=0.01, atol=0.0)
        alike = np.isclose(other["epsilon"], epsilon, rtol=0.01, equal_nan=True)
        if same and (alike or not restitution):
            return others
    return [own, *others]


@figure("device_force", ALL, "Force of the device on the floor", each="device")
def device_force(store: xr.Dataset, device: str, published: Mapping[str, float]) -> CurveFigure:
    """Draw the force without and with impacts, with the damping of the case."""
    axis, time = direction(store), store["time"].values
    caption = (
        f"Force of {device} on the floor along $e_{axis}$ over time: without impact (a) "
        "and with impacts (b), with the damping of the case. Dashed: largest value by response "
        f"spectrum analysis ({headline(store)})."
    )
    panels = []
    for impact, colour in ((WITHOUT, BLUE), (WITH, RED)):
        load = Load(store, device, impact)
        force, ends = 1e-3 * load.history.values, time[[0, -1]]
        k, level = int(np.argmax(np.abs(force))), 1e-3 * load.by_spectrum()
        peak = f"{1e-3 * load.detailed:.4g} kN at {time[k]:.3f} s"
        around = (f"±{level:.4g} kN by spectrum", "0.35", "--", 0.9)
        curves = [
            Curve(time, force, "", colour, width=0.6),
            Curve(time[k : k + 1], force[k : k + 1], peak, "black", "", marker="o"),
            Curve(ends, np.full(2, level), *around),
            Curve(ends, np.full(2, -level), "", *around[1:]),
        ]
        names = (load.scalar(f"f{axis}.{kind}") for kind in ("detailed", "rsa"))
        for name, what in zip(names, ("in detail", "by spectrum"), strict=True):
            curves += published_level(published, name, time, what, 1e-3)
        panels.append(Panel("time [s]", f"force $F_{axis}$ [kN]", curves, room=0.1 * len(curves)))
    return CurveFigure(caption, panels, size=(9.0, 3.4))


@figure("damping_cases", ALL, "Damping ratio by damping case", default=False)
def damping_cases(path: Path, store: xr.Dataset) -> None:
    """Draw the damping ratio by damping case."""
    first, *_ = names_of(store, "device")
    frequency: Array = np.asarray(np.geomspace(*RANGE, 400), dtype=np.float64)
    caption = (
        "Damping ratio of the buildings over the frequency by damping case. "
        f"Dotted: modes of {first} along $e_{direction(store)}$."
    )
    with sheet(path, (1, 1), (6.5, 3.8), caption) as (_, (panel, *_)):
        shown = _different(store, restitution=False)
        for case, (colour, dashes, width) in _looks(store).items():
            if case not in shown:
                continue
            ratio = 100.0 * damping_of(store.sel(case=case)).ratio(frequency)
            panel.loglog(frequency, ratio, label=case, color=colour, ls=dashes, lw=width)
        for mode in shown_modes(store, first)["mode_frequency"].values:
            panel.axvline(mode, color="0.5", ls=":", lw=0.9)
        panel.set(xlabel="frequency [Hz]", ylabel="damping ratio [%]")
        span(panel, frequency)
        panel.legend(loc="upper left")


@figure("anchor_spectra", ALL, "Response spectra at the anchor", each="device")
def anchor_spectra(store: xr.Dataset, device: str, published: Mapping[str, float]) -> CurveFigure:
    """Draw the spectra of the floor at the anchor, without and with impacts, by damping case."""
    ratio = 100.0 * float(modes_of(store, device)["mode_damping"][0])
    last = float(store["frequency"][-1])
    caption = (
        f"Response spectra at the anchor of {device} along $e_{direction(store)}$ "
        f"({ratio:.3g} % damping): without impact (a) and with impacts (b). Dotted: modes of the "
        "device."
        f"{hatching_note(store, last)}"
    )
    panels = []
    looks = {case: look for case, look in _looks(store).items() if case in _different(store)}
    for impact in LOADS:
        curves = []
        for case, look in looks.items():
            load = Load(store, device, impact, case)
            psa = load.psa
            peak = f"{float(psa.max()):.3g} m/s² at {float(psa.idxmax('frequency')):.3g} Hz"
            curves.append(
                Curve(psa["frequency"].values, psa.values, f"{_named(store, case)}: {peak}", *look)
            )
            names = load.scalar("frs.peak_frequency"), load.scalar("frs.peak")
            curves += published_point(published, *names, case, look[0])
        panel = Panel(
            "frequency [Hz]",
            "pseudo-acceleration [m/s²]",
            curves,
            log="x",
            bottom=0.0,
            room=0.2 + 0.12 * len(looks),  # for a line of the legend each
            marks=shown_modes(store, device)["mode_frequency"].values.tolist(),
            hatched=unresolved(store, last),
            legend="upper left",
        )
        panels.append(panel)
    return CurveFigure(caption, panels, size=(9.0, 3.6))


@figure(
    "device_force_damping",
    ALL,
    "Force of the device by damping case",
    when=lambda store: store.sizes["case"] > 1,
    each="device",
    default=False,
)
def device_force_damping(path: Path, store: xr.Dataset, device: str) -> None:
    """Draw the force without and with impacts by damping case, and around its largest value."""
    axis, time = direction(store), store["time"].values
    caption = (
        f"Force of {device} on the floor along $e_{axis}$ over time by the damping of "
        "the buildings: without impact (a) and with impacts (b), and around the largest force: "
        "without (c) and with (d)."
    )
    looks, cases = _looks(store), _different(store, restitution=False)
    # What is damped least is behind.
    behind = sorted(cases, key=lambda case: -Load(store, device, WITH, case).detailed)
    with sheet(path, (2, 2), (9.0, 6.0), caption) as (drawn, axes):
        for whole, near, impact in zip(axes[:2], axes[2:], LOADS, strict=True):
            loads = [Load(store, device, impact, case) for case in behind]
            for load in loads:
                force, (colour, dashes, _) = 1e-3 * load.history, looks[load.case]
                look: dict[str, Any] = {"color": colour, "label": load.case}
                whole.plot(time, force, lw=0.5, ls="-", **look)
                near.plot(time, force, lw=0.9, ls=dashes, **look)
            span(whole, time)
            largest = max(loads, key=lambda load: load.detailed).history
            at = float(abs(largest).idxmax("time"))
            near.set_xlim(max(time[0], at - WINDOW[0]), min(time[-1], at + WINDOW[1]))
            near.xaxis.set_major_locator(MaxNLocator(5))
            near.ticklabel_format(axis="x", useOffset=False)
            for panel in (whole, near):
                panel.set(xlabel="time [s]", ylabel=f"force $F_{axis}$ [kN]")
        handles = dict(zip(*reversed(axes[2].get_legend_handles_labels()), strict=True))
        lines = [handles[case] for case in cases]
        words = [_named(store, case) for case in cases]
        drawn.legend(lines, words, loc="outside upper center", ncols=len(cases))
        letter(axes)


@figure(
    "device_demand",
    ALL,
    "Largest forces by analysis and damping case",
    each="device",
    default=False,
)
def device_demand(path: Path, store: xr.Dataset, device: str) -> None:
    """Draw forces and their differences by damping case as bars."""
    every: list[tuple[str, str | None, str]] = [
        ("detailed", DETAILED, "black"),
        ("RSA", headline(store), BLUE),
        ("RSA, rotations", variant(store, ROTATIONS), ORANGE),
        ("RSA, broadened", variant(store, BROADENED), GREEN),
        ("RSA, rotations, broadened", variant(store, ROTATIONS, BROADENED), RED),
    ]
    kinds = [(words, name, colour) for words, name, colour in every if name is not None]
    for method, name in rigid_variants(store).items():
        kinds.append((f"RSA, {RIGID_WORDS[method]}", name, RIGID_COLOURS[method]))
    axis, cases = direction(store), names_of(store, "case")
    caption = (
        f"Largest force of {device} on the floor along $e_{axis}$ by the damping of "
        "the buildings: without impact (a), with impacts (b). Difference of response spectrum "
        "analysis, positive if unconservative (c, d)."
    )
    several = [load for load in loads_of(store) if load.device == device]
    if not all(load.was_done(analysis) for _, analysis, _ in kinds for load in several):
        caption += NOT_DONE
    width = 0.8 / len(kinds)
    most = max(several, key=lambda load: load.detailed)
    seen = (
        f"Bars for {len(cases)} dampings and {len(kinds)} analyses; the largest force in detail is "
        f"{1e-3 * most.detailed:.4g} kN ({most.case})."
    )
    with sheet(path, (2, 2), (9.0, 5.8), caption, seen) as (drawn, axes):
        for forces, differences, impact in zip(axes[:2], axes[2:], LOADS, strict=True):
            for k, (label, analysis, colour) in enumerate(kinds):
                at = np.arange(len(cases)) + (k - 0.5 * (len(kinds) - 1)) * width
                # Orange and red, green and red are equally dark in print.
                look: dict[str, Any] = {
                    "color": colour,
                    "hatch": HATCHES[k % len(HATCHES)],
                    "edgecolor": "white",
                    "lw": 0.0,
                }
                # An analysis that was not done has no bar.
                of = store.sel(device=device, impact=impact, analysis=analysis)
                force, off = of["peak_force"].sel(component=axis), of["relative_difference"]
                forces.bar(at, 1e-3 * force.values, width, label=label, **look)
                if analysis != DETAILED:
                    differences.bar(at, 100.0 * off.values, width, **look)
            forces.set_ylabel(f"force $F_{axis}$ [kN]")
            differences.set_ylabel("difference [%]")
            differences.axhline(0.0, color="black", lw=0.8)
        for panel in axes:
            panel.set_xticks(range(len(cases)), [_named(store, c, "\n") for c in cases])
            panel.grid(visible=False, axis="x")
            panel.set_axisbelow(True)
        ends = [panel.get_ylim() for panel in axes[2:]]
        for panel in axes[2:]:
            panel.set_ylim(min(low for low, _ in ends), max(high for _, high in ends))
        handles, labels = axes[0].get_legend_handles_labels()
        drawn.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4))
        letter(axes)


@figure(
    "device_inputs",
    ALL,
    "Largest forces by input of the response spectrum analysis",
    when=lambda store, device: len(input_variants(store, device)) > 1,
    each="device",
    default=False,
)
def device_inputs(path: Path, store: xr.Dataset, device: str) -> None:
    """Draw the force by response spectrum analysis over the detailed one, by input."""
    choices, axis = input_variants(store, device), direction(store)
    caption = (
        f"Largest force of {device} on the floor along $e_{axis}$: response spectrum analysis / "
        "time history, by input of the analysis: without impact (a) and with impacts (b)."
    )
    with sheet(path, (1, 2), (9.0, 1.5 + 0.34 * len(choices)), caption) as (drawn, axes):
        for panel, impact in zip(axes, LOADS, strict=True):
            panel.axvline(1.0, color="black", lw=0.8)
            for c, case in enumerate(names_of(store, "case")):
                load, colour = Load(store, device, impact, case), _looks(store)[case][0]
                if not load.detailed > 0.0:
                    continue
                panel.plot(
                    [load.by_spectrum(one) / load.detailed for one in choices.values()],
                    range(len(choices)),
                    ls="",
                    marker=MARKERS[c % len(MARKERS)],
                    color=colour,
                    markerfacecolor="none" if c == 0 else colour,
                    ms=8.0 if c == 0 else 5.0,
                    label=_named(store, case),
                )
            panel.set_yticks(range(len(choices)), list(choices) if impact == WITHOUT else [])
            panel.set_ylim(len(choices) - 0.5, -0.5)
            panel.set_xlim(left=0.0, right=1.08 * max(panel.get_xlim()[1], 1.0))
            panel.set_xlabel(f"force $F_{axis}$ over the detailed one [-]")
        handles, labels = axes[1].get_legend_handles_labels()
        if handles:
            drawn.legend(handles, labels, loc="outside upper center", ncols=len(labels))
        letter(axes)
