"""Floors of both buildings at three times of the main impact, where 3D models pound."""

from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.plot.floor_field import (
    SIGNED,
    TopFloor,
    colour_bar,
    plan_layout,
    round_factor,
    signed_limits,
)
from impactfem.plot.style import figure, letter
from impactfem.stages.stores import of_run, open_store, open_stores
from impactfem.stages.transient.selection import (
    line_ends,
    main_impact,
    of_kind,
    shown,
    wave_floor,
)
from impactfem.system.arrays import Array

MAPS = "transient_maps.nc"
PICTURE = "both_main_impact.png"
WIDE = 0.06
"""Gap of the picture of both buildings over the smaller side of a floor, at most."""
CUT = 0.03
"""Part of its values that is drawn in the last colours."""


@dataclass(frozen=True, eq=False)
class Filmed:
    """A floor of the picture."""

    response: xr.Dataset  #: what `shown` gives
    maps: xr.Dataset  #: the open `transient_maps.nc`
    shift: Array = field(default_factory=lambda: np.zeros(2))  #: where it is drawn, in plan [m]


def both_figures(folder: Path) -> list[Path]:
    """Draw the floors of both buildings of the main impact into `figures/` of the second one.

    `folder` is that of a building. Nothing is drawn where its neighbour was not computed before it,
    where a stick pounds, where the main impact of one is not that of the other, or where the pair's
    normal is along neither x nor y.
    """
    with ExitStack() as stores:
        found = _pair(folder, stores)
        if found is None:
            return []
        floors, moved, normal, gap = found
        target = folder / "figures"
        target.mkdir(exist_ok=True)
        factor = round_factor(gap, WIDE * float(TopFloor(floors[0].maps).size.min()))
        apart = (factor - 1.0) * gap * normal
        placed = [
            Filmed(one.response, one.maps, one.shift + share * apart)
            for one, share in zip(floors, (0.0, 1.0), strict=True)
        ]
        _picture(target / PICTURE, placed, moved, factor)
        return [target / PICTURE]


def _pair(folder: Path, stores: ExitStack) -> tuple[list[Filmed], list[Array], Array, float] | None:
    """Floors of the main impact at rest, their displacements, unit vector from a to b, gap.

    Displacements in plan at the times of the snapshots, relative to the ground under the first
    building. The stores of both stay open until the stack ends; None as of `both_figures`.
    """
    run = of_run(folder, "pounding.nc").parent
    if run == folder or not (folder / MAPS).is_file():
        return None
    with open_store(run / "forces.nc") as forces, open_store(run / "pounding.nc") as pounding:
        hit = pounding["impact_peak_force"]
        if "hat_a" not in forces or not hit.sizes["impact"]:
            return None
        name = pounding["impact_pair"].values[int(hit.values.argmax())]
        line = forces.isel(pair=(forces["line"] == name).values)
        if line.sizes["pair"] < 2:
            return None
        axes = pounding["building_axis"].load()
        ends = [str(line[f"building_{side}"].values[0]) for side in "ab"]
        ground = pounding["ground_apart"].load() if "ground_apart" in pounding else None
        normal = line["normal"].transpose("pair", "axis").values[0, :2]
        gap = float(line["gap"].values.min())
        hats = [line[f"hat_{side}"].values for side in "ab"]
        offsets = [line[f"offset_{side}"].transpose("pair", "axis").values[:, :2] for side in "ab"]
    folders = [folder if name == folder.name else run / name for name in ends]
    folders = [one if (one / MAPS).is_file() else run for one in folders]
    along = int(np.argmin(np.abs(normal)))
    square = float(np.abs(normal).min()) < 1e-9 and gap > 0.0
    if folder not in folders or not square or not all((one / MAPS).is_file() for one in folders):
        return None
    floors, moved = [], []
    for name, place, hat, offset in zip(ends, folders, hats, offsets, strict=True):
        opened = stores.enter_context(open_stores(place))
        response, maps = shown(opened("transient.nc")), opened(MAPS)
        usable = response.attrs["building"] == name and np.isfinite(hat).all()
        if not usable or of_kind(response, "line").sizes["probe"] < 2 or not maps.sizes["frame"]:
            return None
        slab = TopFloor(maps).position[:, :2]
        # The middle of the first hat is at its offset from the axis; a hat is counted from the
        # corner where its side begins.
        middle = hat.mean(axis=1)
        forwards = (middle[-1] - middle[0]) * (offset[-1, along] - offset[0, along]) > 0.0
        here = np.empty(2)
        here[along] = slab[:, along].min() + middle[0]
        if not forwards:
            here[along] = slab[:, along].max() - middle[0]
        here[1 - along] = line_ends(response)[0, 1 - along]
        floors.append(Filmed(response, maps, axes.sel(building=name).values + offset[0] - here))
        moved.append(maps["wave_displacement"].values[..., :2])
        if ground is not None:
            under = ground.sel(building=name).interp(time=maps["snapshot"].values)
            moved[-1] = moved[-1] + under.transpose("time", "axis").values[:, None, :2]
    a, b = (one.maps["frame"].values for one in floors)
    return (floors, moved, normal, gap) if np.array_equal(a, b) else None


def _picture(path: Path, floors: list[Filmed], moved: list[Array], factor: float) -> None:
    """The floors of both buildings at the times of the snapshots, as they stand to each other."""
    response = floors[0].response
    d, times = response["component"].item(), floors[0].maps["snapshot"].values
    slabs = [TopFloor(one.maps) for one in floors]
    # What both do together is left out.
    middle = 0.5 * sum(one.mean(axis=1, keepdims=True) for one in moved)
    values = [one.maps["wave_acceleration"].sel(component=d).values for one in floors]
    every = np.abs(np.concatenate(values, axis=1))
    # The struck edges at the first contact would take the colours for themselves.
    low, high = signed_limits(float(np.quantile(every, 1.0 - CUT)))
    names = " and ".join(str(one.response.attrs["building"]) for one in floors)
    impact = main_impact(response)
    start = 0.0 if impact is None else impact[0]
    caption = (
        f"Acceleration along $e_{d}$ of floor {wave_floor(response)} of {names} in the main "
        f"impact, {', '.join(f'{1e3 * (t - start):.1f}' for t in times)} ms after it began. "
        f"Displacements in plan and gap amplified by {factor:g}, without what both do together. "
        f"Largest value: {every.max():.3g} m/s²."
    )
    label = f"acceleration $\\ddot u_{d}$ [m/s²]"
    wide = slabs[0].wide
    colours: dict[str, Any] = {"cmap": SIGNED, "vmin": low, "vmax": high}
    layout, size = ((1, len(times)), (9.0, 2.8)) if wide else ((len(times), 1), (6.5, 9.0))
    with figure(path, layout, size, caption) as (drawn, axes):
        plan_layout(drawn)
        for k, panel in enumerate(axes):
            for one, slab, u, v in zip(floors, slabs, moved, values, strict=True):
                mesh = slab.split(one.shift + factor * (u[k] - middle[k]))
                mappable = panel.tripcolor(mesh, v[k], shading="gouraud", **colours)
                panel.text(mesh.x.mean(), mesh.y.mean(), one.response.attrs["building"])
            panel.set_title(f"{1e3 * (times[k] - start):.1f} ms", fontsize=9.0, loc="right")
            panel.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")
            panel.grid(False)
        colour_bar(drawn, mappable, axes, label)
        letter(axes)
