"""Figure 4: the map of the study, with the stages of a run, what they found and what is missing."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patches import FancyBboxPatch

from impactfem.plot.style import BLUE, figure
from impactfem.stages.stores import open_store
from impactfem.system.scalar import scalars_of

STORES = ("motion", "building", "calibrate", "pounding", "ensemble", "transient", "device")
MAIN = "pounding.main_impact_force"
SAME = 1e-9
"""Relative difference of a value that was handed over from the one that was found."""


NAME = "figure_04_flowchart.png"
WIDTH, HEIGHT = 27.5, 17.0
COMPARED = "compared"
"""Of a box, in parts of a hundred of the figure's."""
DONE, MISSING = "#dcebf7", "white"
GREY = "0.45"
LEFT, MIDDLE, RIGHT = 14.0, 50.0, 85.0
ROWS = (91.0, 64.5, 38.0, 11.5)
LINKS = (
    ("motion", "pounding", ""),
    ("building", "sticks", "masses\nmodes"),
    ("building", "wall", ""),
    ("sticks", "pounding", ""),
    ("wall", "pounding", "ε\n$K_{Ceq}$"),
    ("motion", "ensemble", ""),
    ("pounding", "transient", "forces"),
    ("transient", "spectra", ""),
    ("spectra", "rsa", ""),
    ("transient", "detailed", ""),
    ("building", "transient", ""),
    ("rsa", "detailed", COMPARED),
)
"""What hands over to what, and what it hands over."""
BEYOND = 99.5
"""Where the line runs that goes round the boxes on the right."""


@dataclass(frozen=True, eq=False)
class Found:
    """What the stores of a run hold.

    Args:
        values: Scalars by name.
        stores: Names of the stores.
        direction: The one that is shown; "" before any stage knows it.
        devices: Names of the devices.
        stiffness: Contact stiffness of the pairs of points [N/m].
        targets: Frequencies that the sticks are fitted to [Hz].
        main_pair: Which pair has the largest impact force; "" where nothing touched.
    """

    values: Mapping[str, float]
    stores: frozenset[str]
    direction: str
    devices: tuple[str, ...]
    stiffness: tuple[float, ...] = ()
    targets: tuple[float, ...] = ()
    main_pair: str = ""

    def numbers(self, pattern: str) -> dict[str, float]:
        """Scalars whose whole name matches, by the first group of the pattern."""
        found = ((re.fullmatch(pattern, name), v) for name, v in self.values.items())
        return {match[1]: value for match, value in found if match is not None}

    def hands_over(self, start: str, end: str) -> bool:
        """Whether a step used what another one found, rather than values that the case gives."""
        if (start, end) == ("wall", "pounding"):
            ours = self.values.get("calibration.K_Ceq", math.nan)
            return any(math.isclose(ours, value, rel_tol=SAME) for value in self.stiffness)
        if (start, end) == ("building", "sticks"):
            modes = self.numbers(r"building\.frequency\.(\d+)").values()
            return any(math.isclose(a, b, rel_tol=SAME) for a in modes for b in self.targets)
        return True


def read_found(folder: Path) -> Found:
    """What the stores of a folder hold; scalars without a value are left out."""
    values: dict[str, float] = {}
    stores: set[str] = set()
    devices: tuple[str, ...] = ()
    stiffness: tuple[float, ...] = ()
    targets: tuple[float, ...] = ()
    direction = main_pair = ""
    for name in STORES:
        path = folder / f"{name}.nc"
        if not path.is_file():
            continue
        stores.add(name)
        with open_store(path) as store:
            scalars = scalars_of(store) if "result" in store.dims else []
            values |= {s.name: s.value for s in scalars if s.value is not None}
            direction = str(store.attrs.get("shown_direction", direction))
            if name == "pounding":
                main_pair = next(
                    (s.note for s in scalars if s.name == MAIN and s.value is not None), ""
                )
                stiffness, targets = (
                    _list(store, "pair_stiffness"),
                    _list(store, "target_frequency"),
                )
            if name == "device":
                devices = tuple(str(device) for device in store["device"].values)
    return Found(values, frozenset(stores), direction, devices, stiffness, targets, main_pair)


def _list(store: xr.Dataset, name: str) -> tuple[float, ...]:
    return tuple(float(value) for value in store[name].values) if name in store else ()


@dataclass(frozen=True)
class Box:
    """A step of the method.

    Args:
        title: What is done.
        stage: The stage that does it.
        figures: Figures of the paper that show it.
        store: The store that tells that it was done.
        x: Place of its middle, 0 to 100 from the left.
        y: The same from below.
        lines: What it found.
    """

    title: str
    stage: str
    figures: str
    store: str
    x: float
    y: float
    lines: Callable[[Found], list[str]]


def flowchart_figure(folder: Path) -> list[Path]:
    """Draw `figures/figure_04_flowchart.png` from the stores that a run's folder holds.

    Args:
        folder: The run's folder; a stage whose store is not there is shown as not run.

    Returns:
        The file.

    Raises:
        ImpactfemError: The file cannot be written.
    """
    target = folder / "figures"
    target.mkdir(parents=True, exist_ok=True)
    found = read_found(folder)
    ran = {name: box.store in found.stores for name, box in BOXES.items()}
    links = {(a, b): ran[a] and ran[b] and found.hands_over(a, b) for a, b, _ in LINKS}
    missing = "" if all(ran.values()) else " Dashed box: not part of this run."
    if any(ran[a] and ran[b] and not used for (a, b), used in links.items()):
        missing += " Dashed arrow: not used, the case gives the values."
    caption = (
        "Figure 4: The forces on a device in a building that pounds against another: how the "
        f"stages of this run hand over to one another, and what they found.{missing}"
    )
    with figure(target / NAME, (1, 1), (9.0, 6.4), caption) as (_, axes):
        panel = axes[0]
        for start, end, label in LINKS:
            _arrow(panel, start, end, label, links[start, end])
        for name, box in BOXES.items():
            _box(panel, box, box.lines(found) if ran[name] else ["not part of this run"], ran[name])
        panel.set_xlim(0.0, 100.0)
        panel.set_ylim(0.0, 100.0)
        panel.set_axis_off()
    return [target / NAME]


def _motion(found: Found) -> list[str]:
    v = found.values
    lines = []
    if "motion.pga" in v:
        lines.append(f"peak {v['motion.pga']:.3g} m/s² at {v['motion.time_of_pga']:.3g} s")
    if "motion.sa_max" in v:
        peak, at = v["motion.sa_max"], v["motion.sa_max_frequency"]
        lines.append(f"spectrum {peak:.3g} m/s² at {at:.3g} Hz")
    return lines


def _building(found: Found) -> list[str]:
    v = found.values
    modes = list(found.numbers(r"building\.frequency\.(\d+)").values())[:3]
    lines = [f"{v['building.elements']:,.0f} elements, {v['building.dofs']:,.0f} dofs"]
    if modes:
        lines.append(f"modes {', '.join(f'{f:.3g}' for f in modes)} Hz")
    return lines


def _wall(found: Found) -> list[str]:
    v = found.values
    if "calibration.epsilon" not in v:
        return ["no impact"]
    return [
        f"ε = {v['calibration.epsilon']:.3g}",
        f"$K_{{Ceq}}$ = {1e-9 * v['calibration.K_Ceq']:.3g} GN/m",
        f"impact of {1e3 * v['calibration.impact_duration']:.3g} ms",
    ]


def _sticks(found: Found) -> list[str]:
    buildings = found.numbers(r"sticks\.(.+)\.frequency\.1")
    lines = []
    for name in list(buildings)[:3]:
        modes = found.numbers(rf"sticks\.{re.escape(name)}\.frequency\.(\d+)").values()
        lines.append(f"{name}: {', '.join(f'{f:.3g}' for f in list(modes)[:3])} Hz")
    more = len(buildings) - 3
    return [*lines, f"and {more} more buildings"] if more > 0 else lines


def _pounding(found: Found) -> list[str]:
    v = found.values
    if MAIN not in v:
        return ["no impact"]
    at, lasts = v["pounding.main_impact_time"], v["pounding.main_impact_duration"]
    return [
        f"{v['pounding.impacts']:.0f} impacts",
        f"largest force {1e-6 * v[MAIN]:.4g} MN",
        found.main_pair,
        f"at {at:.4g} s, for {1e3 * lasts:.3g} ms",
    ]


def _ensemble(found: Found) -> list[str]:
    v = found.values
    lines = [f"{v['ensemble.members']:.0f} motions"] if "ensemble.members" in v else []
    forces = found.numbers(r"ensemble\.median\.pounding\.peak_force\.floor_(.+)")
    if forces and max(forces.values()) > 0.0:
        floor = max(forces, key=lambda k: forces[k])
        low, high = (
            1e-6 * v[f"ensemble.{q}.pounding.peak_force.floor_{floor}"] for q in ("p05", "p95")
        )
        lines += [f"force on floor {floor}:", f"{low:.3g} to {high:.3g} MN (5 to 95 %)"]
    return lines


def _transient(found: Found) -> list[str]:
    v = found.values
    lines = []
    if "transient.basis_vectors" in v:
        lines.append(f"reduced basis of {v['transient.basis_vectors']:.0f} vectors")
    else:
        lines.append("all degrees of freedom in time")
    peaks = found.numbers(r"transient\.pfa\.floor_(\d+)")
    if peaks:
        top = max(peaks, key=int)
        lines.append(f"mass centre of floor {top}: {peaks[top]:.3g} m/s²")
        edge = f"transient.pfa.edge_{top}.max"
        if edge in v:
            lines.append(f"along its impact edge: {v[edge]:.3g} m/s²")
    return lines


def _spectra(found: Found) -> list[str]:
    lines, floor = [], ""
    for start, label in (("frs", "sticks"), ("transient.frs", "3D model")):
        peaks = found.numbers(rf"{re.escape(start)}\.floor_(\d+)\.peak")
        if peaks:
            top = max(peaks, key=int)
            at = found.values[f"{start}.floor_{top}.peak_frequency"]
            lines.append(f"{label}: {peaks[top]:.3g} m/s² at {at:.3g} Hz")
            floor = top
    return [f"mass centre of floor {floor}", *lines] if lines else []


def _force(found: Found, kind: str) -> list[str]:
    lines = []
    for impact, words in (("no_impact", "without impacts"), ("impact", "with impacts")):
        value = found.values.get(f"device.f{found.direction}.{kind}.{impact}")
        if value is not None:
            lines.append(f"{words}: {1e-3 * value:.4g} kN")
    first = f"{found.devices[0]}, " if found.devices else ""
    more = f" (and {len(found.devices) - 1} more)" if len(found.devices) > 1 else ""
    return [f"{first}force $F_{found.direction}${more}", *lines]


BOXES = {
    "motion": Box("Ground motion", "pounding", "2", "motion", LEFT, ROWS[0], _motion),
    "sticks": Box("Stick models", "pounding", "3 b and c", "pounding", MIDDLE, ROWS[0], _sticks),
    "building": Box("3D model", "building", "1, 3 a", "building", RIGHT, ROWS[0], _building),
    "ensemble": Box(
        "The same for many motions", "ensemble", "", "ensemble", LEFT, ROWS[1], _ensemble
    ),
    "pounding": Box(
        "Pounding of the sticks", "pounding", "5, 8, 9", "pounding", MIDDLE, ROWS[1], _pounding
    ),
    "wall": Box("Impact on a rigid wall", "calibrate", "6, 7", "calibrate", RIGHT, ROWS[1], _wall),
    "spectra": Box(
        "Floor response spectra",
        "pounding, transient",
        "10, 13, 15, 19",
        "pounding",
        LEFT,
        ROWS[2],
        _spectra,
    ),
    "transient": Box(
        "Impacts on the 3D model", "transient", "11 to 22", "transient", MIDDLE, ROWS[2], _transient
    ),
    "rsa": Box(
        "Response spectrum analysis",
        "device",
        "29",
        "device",
        LEFT,
        ROWS[3],
        lambda f: _force(f, "rsa"),
    ),
    "detailed": Box(
        "Device in the 3D model",
        "device",
        "23 to 30",
        "device",
        MIDDLE,
        ROWS[3],
        lambda f: _force(f, "detailed"),
    ),
}
"""The steps of the method by name."""


def _box(panel: Axes, box: Box, lines: list[str], done: bool) -> None:
    panel.add_patch(
        FancyBboxPatch(
            (box.x - 0.5 * WIDTH, box.y - 0.5 * HEIGHT),
            WIDTH,
            HEIGHT,
            boxstyle="round,pad=0,rounding_size=1.2",
            facecolor=DONE if done else MISSING,
            edgecolor=BLUE if done else GREY,
            linestyle="-" if done else "--",
            zorder=2,
        )
    )
    colour = "black" if done else GREY
    top = box.y + 0.5 * HEIGHT
    panel.text(
        box.x,
        top - 1.4,
        box.title,
        ha="center",
        va="top",
        fontsize=8.5,
        color=colour,
        weight="bold",
        zorder=3,
    )
    figures = f", figure{'s' * (len(box.figures) > 2)} {box.figures}" if box.figures else ""
    panel.text(
        box.x,
        top - 4.6,
        f"stage {box.stage}{figures}",
        ha="center",
        va="top",
        fontsize=6.5,
        color=GREY,
        zorder=3,
    )
    panel.text(
        box.x,
        top - 7.6,
        "\n".join(lines),
        ha="center",
        va="top",
        fontsize=7.5,
        color=colour,
        linespacing=1.25,
        zorder=3,
    )


def _arrow(panel: Axes, start: str, end: str, label: str, done: bool) -> None:
    """From the edge of a box to that of the next one, with what goes there beside it."""
    a, b = BOXES[start], BOXES[end]
    (x0, y0), (x1, y1) = _edge(a, b), _edge(b, a)
    look: dict[str, Any] = {"color": "black" if done else GREY, "linestyle": "-" if done else "--"}
    if (start, end) == ("building", "transient"):
        # Round the box that is between them.
        panel.plot([a.x + 0.5 * WIDTH, BEYOND, BEYOND], [a.y, a.y, b.y], lw=1.0, **look)
        (x0, y0), (x1, y1) = (BEYOND, b.y), (b.x + 0.5 * WIDTH, b.y)
    panel.annotate(
        "",
        (x1, y1),
        xytext=(x0, y0),
        arrowprops={
            **look,
            "arrowstyle": "<|-|>" if label == COMPARED else "-|>",
            "shrinkA": 0.0,
            "shrinkB": 0.0,
        },
    )
    if label:
        level = abs(y1 - y0) < abs(x1 - x0)
        panel.annotate(
            label,
            (0.5 * (x0 + x1), 0.5 * (y0 + y1)),
            xytext=(0, 4) if level else (4, 0),
            textcoords="offset points",
            ha="center" if level else "left",
            va="bottom" if level else "center",
            fontsize=6.5,
            color=look["color"],
        )


def _edge(box: Box, other: Box) -> tuple[float, float]:
    """Where the line from the middle of a box to that of another leaves it."""
    dx, dy = other.x - box.x, other.y - box.y
    share = min(
        0.5 * WIDTH / abs(dx) if dx else float("inf"),
        0.5 * HEIGHT / abs(dy) if dy else float("inf"),
    )
    return box.x + share * dx, box.y + share * dy
