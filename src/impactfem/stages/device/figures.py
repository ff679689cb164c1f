"""The figures of the stage `device` in the paper's layout and numbering: forces, spectra, dampings.

Figures of the force of a device on the floor over time (27, 30), of the spectra at its anchor (29)
and of the damping of the buildings (28) are here.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.style import BLUE, RED, figure, letter, span
from impactfem.stages.device.demand_figures import (
    case_colour,
    case_dashes,
    demand_figure,
    inputs_figure,
)
from impactfem.stages.device.model_figures import (
    drawing_of,
    elements_figure,
    model_figure,
    modes_figure,
)
from impactfem.stages.device.pictures import device_pictures, position_figure
from impactfem.stages.device.selection import (
    LOADS,
    WITH,
    WITHOUT,
    Load,
    building_damping,
    direction,
    file_stem,
    headline,
    input_variants,
    loaded,
    modes_of,
    shown_modes,
)
from impactfem.stages.stores import names_of, open_stores
from impactfem.system.parallel import meanwhile

Array = NDArray[np.float64]

WINDOW = (0.05, 0.15)
"""What is shown before and after the largest force [s]."""
RANGE = (0.5, 500.0)
"""Frequencies of figure 28 [Hz]."""


def device_figures(folder: Path) -> list[Path]:
    """Draw figures 23 to 30 and the demand by damping into `figures/`; gives the files.

    Figures 23 to 27, 29 and 30 of further devices than the first have their names in the files.
    What the stores have no data for is left out, such as the position without `building.nc`.

    Raises:
        ImpactfemError: A file cannot be written, or OpenGL is missing.
    """
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    with meanwhile(lambda: device_pictures(folder)) as pictures, open_stores(folder) as opened:
        store = loaded(opened("device.nc"))
        building = opened("building.nc") if (folder / "building.nc").is_file() else None
        drawn = [one.write_png(target) for one in _curves(store)]
        drawn.append(_damping_figure(target / "figure_28_damping.png", store))
        for device in names_of(store, "device"):
            for stem, draw in _of_device(store, device, building).items():
                path = target / f"{file_stem(store, stem, device)}.png"
                draw(path, store, device)
                drawn.append(path)
    return sorted([*drawn, *pictures()])


def device_curves(folder: Path) -> list[CurveFigure]:
    """Figures 27 and 29 of all devices, for the report; argument as above."""
    with open_stores(folder) as opened:
        return _curves(loaded(opened("device.nc")))


def _curves(store: xr.Dataset) -> list[CurveFigure]:
    makers = (_spectra_figure, _force_figure)
    return [make(store, device) for make in makers for device in names_of(store, "device")]


def _of_device(
    store: xr.Dataset, device: str, building: xr.Dataset | None
) -> dict[str, Callable[[Path, xr.Dataset, str], None]]:
    """Which figures there are of a device, by the name of the first one's file."""
    makers: dict[str, Callable[[Path, xr.Dataset, str], None]] = {"device_demand": demand_figure}
    if len(input_variants(store, device)) > 1:
        makers["device_inputs"] = inputs_figure
    if store.sizes["case"] > 1:
        makers["figure_30_shear_force_damping"] = _damping_forces_figure
    if building is not None:
        makers["figure_23_position"] = partial(position_figure, building=building)
    if drawing_of(store, device) is not None:
        makers["figure_24_elements"] = elements_figure
        makers["figure_25_modes"] = modes_figure
        makers["figure_26_model"] = model_figure
    return makers


def _force_figure(store: xr.Dataset, device: str) -> CurveFigure:
    """Figure 27: the force without and with impacts, with the buildings' own damping."""
    axis, time = direction(store), store["time"].values
    caption = (
        f"Figure 27: Force of {device} on the floor along $e_{axis}$ over time: without impact (a) "
        "and with impacts (b), with the building's own damping. Dashed: largest value by response "
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
        panels.append(Panel("time [s]", f"force $F_{axis}$ [kN]", curves, room=0.3))
    stem = file_stem(store, "figure_27_shear_force", device)
    return CurveFigure(stem, caption, panels, size=(9.0, 3.4))


def _looks(store: xr.Dataset) -> dict[str, tuple[str, str, float]]:
    """Colour, dashes and width of each damping case in the order in which they are drawn.

    The own damping, which may be one of them again, is drawn last and dashed over the others, so
    that these are seen below it.
    """
    own, *cases = names_of(store, "case")
    looks = {case: (case_colour(k), case_dashes(k), 1.2) for k, case in enumerate(cases, 1)}
    return looks | {own: (case_colour(0), "--" if cases else "-", 0.9 if cases else 1.2)}


def _damping_figure(path: Path, store: xr.Dataset) -> Path:
    """Figure 28: Rayleigh's damping ratio by damping case."""
    first, *_ = names_of(store, "device")
    frequency: Array = np.asarray(np.geomspace(*RANGE, 400), dtype=np.float64)
    caption = (
        "Figure 28: Rayleigh damping ratio of the buildings over the frequency by damping case. "
        f"Dotted: modes of {first} along $e_{direction(store)}$."
    )
    with figure(path, (1, 1), (6.5, 3.8), caption) as (_, (panel, *_)):
        for case, (colour, dashes, width) in _looks(store).items():
            ratio = 100.0 * building_damping(store, case).ratio(frequency)
            panel.loglog(frequency, ratio, label=case, color=colour, ls=dashes, lw=width)
        for mode in shown_modes(store, first)["mode_frequency"].values:
            panel.axvline(mode, color="0.5", ls=":", lw=0.9)
        panel.set_xlabel("frequency [Hz]")
        panel.set_ylabel("damping ratio [%]")
        panel.xaxis.set_major_formatter("{x:g}")
        panel.yaxis.set_major_formatter("{x:g}")
        span(panel, frequency)
        panel.legend(loc="upper left")
    return path


def _spectra_figure(store: xr.Dataset, device: str) -> CurveFigure:
    """Figure 29: spectra of the floor at the anchor, without and with impacts, by damping case."""
    ratio = 100.0 * float(modes_of(store, device)["mode_damping"][0])
    caption = (
        f"Figure 29: Pseudo-acceleration response spectra at the anchor of {device} along "
        f"$e_{direction(store)}$ at {ratio:.3g} % damping, without the device, by the damping of "
        "the buildings: without impact (a) and with impacts (b). Dotted: modes of the device."
    )
    panels = []
    for impact in LOADS:
        curves = []
        for case, look in _looks(store).items():
            psa = Load(store, device, impact, case).psa
            peak = f"{float(psa.max()):.3g} m/s² at {float(psa.idxmax('frequency')):.3g} Hz"
            curves.append(Curve(psa["frequency"].values, psa.values, f"{case}: {peak}", *look))
        panel = Panel(
            "frequency [Hz]",
            "pseudo-acceleration [m/s²]",
            curves,
            log="x",
            bottom=0.0,
            room=0.15 + 0.11 * store.sizes["case"],  # for a line of the legend each
            marks=shown_modes(store, device)["mode_frequency"].values.tolist(),
            legend="upper left",
        )
        panels.append(panel)
    name = file_stem(store, "figure_29_anchor_spectra", device)
    return CurveFigure(name, caption, panels, size=(9.0, 3.6))


def _damping_forces_figure(path: Path, store: xr.Dataset, device: str) -> None:
    """Figure 30: the force without and with impacts by damping case, and around its largest."""
    axis, time = direction(store), store["time"].values
    caption = (
        f"Figure 30: Force of {device} on the floor along $e_{axis}$ over time by the damping of "
        "the buildings: without impact (a) and with impacts (b), and around the largest force: "
        "without (c) and with (d)."
    )
    cases = names_of(store, "case")
    number = {case: k for k, case in enumerate(cases)}
    # The buildings' own damping is drawn where no case repeats it, to a hundredth: as printed.
    both = store[["mass_coefficient", "stiffness_coefficient"]].to_array().transpose("case", ...)
    if np.isclose(both[1:], both[0], rtol=0.01, atol=0.0).all(axis=1).any():
        del cases[0]
    # What is damped least is behind.
    behind = sorted(cases, key=lambda case: -Load(store, device, WITH, case).detailed)
    with figure(path, (2, 2), (9.0, 6.0), caption) as (drawn, axes):
        for whole, near, impact in zip(axes[:2], axes[2:], LOADS, strict=True):
            loads = [Load(store, device, impact, case) for case in behind]
            for load in loads:
                force, k = 1e-3 * load.history, number[load.case]
                look: dict[str, Any] = {"color": case_colour(k), "label": load.case}
                whole.plot(time, force, lw=0.5, ls="-", **look)
                near.plot(time, force, lw=0.9, ls=case_dashes(k), **look)
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
        drawn.legend(lines, cases, loc="outside upper center", ncols=len(cases))
        letter(axes)
