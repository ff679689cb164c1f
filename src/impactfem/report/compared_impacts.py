"""Impacts, whole floors and device forces of two runs of one building; tables and a figure."""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.style import BLUE, RED
from impactfem.plot.table import Cell, Table, heads
from impactfem.report.overview import in_3d
from impactfem.report.run_files import RunFiles
from impactfem.stages.check import QUIET
from impactfem.stages.stores import by_line, names_of
from impactfem.system.arrays import Array

IMPACTS, FLOORS, FIGURE = "comparison_impacts", "comparison_floors", "comparison_impacts"
MAPS = "transient_maps.nc"
MARGIN = 0.5
"""Part of the main impact that is shown before and after it."""
_FORCE = re.compile(
    r"device\.(?:(?P<name>.+)\.)?f(?P<axis>[xyz])\.detailed\.(?P<load>impact|no_impact)"
    r"(?:\.(?P<case>.+))?"
)
_LOW = re.compile(
    r"device\.(?:(?P<name>.+)\.)?relative_difference\.(?P<load>impact|no_impact)"
    r"(?:\.(?P<case>.+))?"
)


def what_pounds(case: Mapping[str, object]) -> str:
    """The models that pound, in words."""
    models = ", ".join(sorted(in_3d(case)))
    return f"3D models of {models}" if models else "sticks"


def impacts_table(runs: Sequence[RunFiles]) -> Table:
    """Impacts, and forces of devices along the shown direction, of a run and of the other."""
    ours, theirs = (_found(run) for run in runs)
    pairs = [name for name in theirs if name not in ours]
    rows: list[tuple[Cell, ...]] = []
    for name in (*ours, *pairs):
        one, other = ours.get(name), theirs.get(name)
        ratio = None
        if isinstance(one, float) and isinstance(other, float) and other != 0.0:
            # Of a time, or a percentage, it says nothing.
            ratio = None if name.endswith(("[s]", "[%]")) else one / other
        rows.append((name, one, other, ratio))
    title = "impacts and device forces of two runs"
    return Table(IMPACTS, title, heads("; this run; the other; ratio [-]"), tuple(rows))


def _found(run: RunFiles) -> dict[str, Cell]:
    """What was found of impacts, and forces of devices on the floor, by words with their unit."""
    with run.store("pounding.nc") as store:
        shown = str(store.attrs["shown_direction"])
        hits = store[[name for name in store if store[name].dims == ("impact",)]].load()
        required = float(store["pair_required_separation"].max()) if store.sizes["pair"] else None
        pairs = names_of(store, "pair")
    force = hits["impact_peak_force"].to_series().groupby(hits["impact_pair"].values).max()
    found: dict[str, Cell] = {"impacts": hits.sizes["impact"]}
    if hits.sizes["impact"]:
        main = hits.isel(impact=hits["impact_peak_force"].argmax("impact"))
        found["main impact"] = str(main["impact_pair"].item())
        for words, name, factor in (
            ("begins at [s]", "first_contact", 1.0),
            ("lasts [ms]", "duration", 1e3),
            ("largest force [MN]", "peak_force", 1e-6),
            ("impulse [kN s]", "impulse", 1e-3),
            ("restitution of the floors [-]", "restitution", 1.0),
            ("restitution of the buildings [-]", "building_restitution", 1.0),
        ):
            # A run of an earlier version lacks the restitution of buildings.
            value = factor * float(main.get(f"impact_{name}", np.nan))
            found[f"main impact: {words}"] = value if np.isfinite(value) else None
        # A run of an earlier version lacks the mean.
        mean = run.values.get("pounding.mean_force_5ms")
        words = "largest mean over 5 ms of the force of a pair [MN]"
        found[words] = None if mean is None else 1e-6 * mean
    found["all impacts: impulses [kN s]"] = 1e-3 * float(hits["impact_impulse"].sum())
    found["all impacts: taken by contact [kJ]"] = 1e-3 * float(hits["impact_dissipated"].sum())
    for name in reversed(pairs):
        found[f"largest force [MN], {name}"] = 1e-6 * float(force.get(name, 0.0))
    if required is not None:
        found["gap that would prevent contact [mm]"] = 1e3 * required
    # Of each device its force, and by how much response spectrum analysis is low.
    for name, value in run.values.items():
        if (one := _FORCE.fullmatch(name)) and one["axis"] == shown:
            what, number = f"force along {shown} [kN]", 1e-3 * value
        elif one := _LOW.fullmatch(name):
            what, number = "spectrum analysis low by [%]", 100.0 * value
        else:
            continue
        load = "with impacts" if one["load"] == "impact" else "without impact"
        more = f", {one['case']}" if one["case"] else ""
        building, _, device = (one["name"] or "").partition(".")
        if building in run.further:
            building = f"on {building}"
        else:
            building, device = "", one["name"]
        which = " ".join(filter(None, ("device", device, building)))
        found[f"{which} {load}{more}: {what}"] = number
    return found


def floors_table(runs: Sequence[RunFiles], highest: float) -> Table | None:
    """Spectra over all vertices of each floor up to a frequency [Hz]; None without fields of both.

    Of each floor and direction in which it moves the largest ordinate of its vertices, and the mean
    of the largest ordinates of each.
    """
    if not all(run.has(MAPS) for run in runs):
        return None
    ours, theirs = (dict(_of_floors(run, highest)) for run in runs)
    rows: list[tuple[Cell, ...]] = []
    for place in sorted(ours.keys() & theirs.keys(), reverse=True):
        of_each = [value for pair in zip(ours[place], theirs[place], strict=True) for value in pair]
        rows.append((*place, *of_each, ours[place][0] / theirs[place][0]))
    header = heads(
        "floor; along; largest ordinate [m/s2]; of the other [m/s2]; at [Hz]; of the other [Hz]; "
        "mean over the floor [m/s2]; of the other [m/s2]; ratio of the largest [-]"
    )
    title = f"floor response spectra over whole floors of two runs, up to {highest:g} Hz"
    return Table(FLOORS, title, header, tuple(rows))


def _of_floors(
    run: RunFiles, highest: float
) -> Iterator[tuple[tuple[int, str], tuple[float, float, float]]]:
    """Largest ordinate, its frequency and the mean, by floor and direction."""
    with run.store(MAPS) as maps:
        here = maps["frequency"].values <= highest * (1.0 + 1e-9)
        frequency, axes = maps["frequency"].values[here], names_of(maps, "component")
        psa = maps["psa"].transpose("node", "component", "frequency").values[..., here]
        floors, cells = (maps[f"floor_triangle_{n}"].values for n in ("floor", "node"))
    for floor in np.unique(floors):
        of_floor = psa[np.unique(cells[floors == floor])]
        for c, axis in enumerate(axes):
            one = of_floor[:, c]
            if one.max() > QUIET * psa.max():
                at = frequency[int(one.max(axis=0).argmax())]
                peaks = one.max(axis=1)
                yield (int(floor), axis), (float(peaks.max()), float(at), float(peaks.mean()))


def impacts_figure(target: Path, runs: Sequence[RunFiles]) -> list[Path]:
    """Draw the forces of both runs in the main impact; no file where one has no impact."""
    panels: list[list[Curve]] = [[], []]
    starts, pairs = [], list[str]()
    for run, colour, dash, label in zip(
        runs, (BLUE, RED), ("-", "--"), ("this run", "the other"), strict=True
    ):
        with run.store("pounding.nc") as store, run.store("forces.nc") as points:
            if not store.sizes["impact"]:
                return []
            main = store.isel(impact=store["impact_peak_force"].argmax("impact"))
            start, end = float(main["impact_first_contact"]), float(main["impact_end"])
            forces, margin = by_line(points), MARGIN * (end - start)
            time = forces["time"].values
            near = (time >= start - margin) & (time <= end + margin)
            shown = 1e-6 * forces["force"].transpose("pair", "time").isel(time=near)
            if not pairs:
                order = shown.max("time").values.argsort()[::-1]
                pairs = [str(shown["pair"].values[k]) for k in order[:2]]
            starts.append(f"{start:.4g} s")
            t: Array = 1e3 * (time[near] - start)
            for curves, pair in zip(panels, pairs, strict=False):
                if pair in shown["pair"].values:
                    curves.append(Curve(t, shown.sel(pair=pair).values, label, colour, dash))
    words = " and ".join(name.replace("-", " with ") for name in pairs)
    caption = (
        f"Forces of the pairs with the largest ones in the main impact, {words}, of this run "
        f"({what_pounds(runs[0].case)}, from {starts[0]}) and of the other "
        f"({what_pounds(runs[1].case)}, from {starts[1]})."
    )
    drawn = [Panel("time from the first contact [ms]", "force [MN]", c) for c in panels if c]
    return [CurveFigure(FIGURE, caption, drawn, alike=True).write(target)]
