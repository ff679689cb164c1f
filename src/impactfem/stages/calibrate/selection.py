"""What figures, tables and checks select from `calibrate.nc`: histories, impacts, damping cases."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.dynamics.damping import Rayleigh
from impactfem.stages.calibrate.experiment import WallHistory
from impactfem.stages.calibrate.impact import FloorImpacts, floor_impacts
from impactfem.stages.stores import time_step

Array = NDArray[np.float64]
MODEL, STICK = "", "stick_"
"""What the names of the histories of the 3D model and of the stick begin with."""


def history_of(store: xr.Dataset, which: str) -> WallHistory:
    """Histories of the 3D model, or of the stick."""
    names = ("displacement", "velocity", "force", "opening")
    histories = {name: store[f"{which}{name}"].transpose("time", "floor").values for name in names}
    return WallHistory(
        floors=tuple(store["floor"].values.tolist()),
        mass=store["floor_mass"].values,
        gap=float(store.attrs["gap"]),
        time_step=time_step(store),
        **histories,
    )


def impacts_of(store: xr.Dataset, which: str) -> list[FloorImpacts]:
    """Impacts of the 3D model or of the stick by floor, bottom to top.

    The top one of the floors that may hit, which gives the parameters, has one that ends in the
    window: the stage writes no other store.
    """
    history, separation = history_of(store, which), float(store.attrs["separation"])
    return [floor_impacts(history, floor, separation=separation) for floor in history.floors]


def focus(store: xr.Dataset) -> tuple[float, float]:
    """Start and end of what is shown of the first impact of all floors that hit [s]."""
    found, time = impacts_of(store, MODEL), store["time"].values
    latest = found[-1].first_complete().end + float(store.attrs["separation"])
    firsts = [floor.impacts[0] for floor in found if floor.impacts]
    near = [impact for impact in firsts if impact.start < latest]
    start, end = min(i.start for i in near), max(i.end for i in near)
    margin = 0.4 * (end - start)
    return max(time[0], start - margin), min(time[-1], end + margin)


def half_wave(store: xr.Dataset) -> float:
    """Frequency whose half wave lasts as long as the first impact, 1 / (2 Δt_c) [Hz]."""
    return 0.5 / float(store["impact_duration"][0])


def damping_ratios(store: xr.Dataset, frequency: float) -> xr.DataArray:
    """The building's damping ratio at a frequency [Hz] in each damping case [-]."""
    both = (store[f"{name}_coefficient"].values for name in ("mass", "stiffness"))
    ratios = [Rayleigh(*pair).ratio(frequency) for pair in zip(*both, strict=True)]
    return xr.DataArray(ratios, coords={"case": store["case"]}, dims="case")


def running_impulse(history: WallHistory, floor: int) -> Array:
    """∫ F dt of a floor from the start on, by the trapezoidal rule, shape (n_t,) [N s]."""
    F = history.force[:, history.column(floor)]
    steps = 0.5 * history.time_step * (F[:-1] + F[1:])
    return np.concatenate([np.zeros(1), np.cumsum(steps)])
