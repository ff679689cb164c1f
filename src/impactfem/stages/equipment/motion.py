"""The motion of the floor at the items of an equipment list."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr

from impactfem.case.equipment import Equipment
from impactfem.spectra.resolved import band_limited
from impactfem.spectra.response_spectrum import upsample, upsampling_factor
from impactfem.stages.stores import time_step
from impactfem.system.arrays import Array

POINTS = 20.0
"""Samples in a cycle at the end of the resolved band: oscillators take the motion as straight lines
between them."""


@dataclass(frozen=True, eq=False)
class ItemMotion:
    """Absolute acceleration of the floor at one item, in the resolved band."""

    time_step: float  #: [s]
    acceleration: Array  #: along x, y and z, shape (3, n_t) [m/s2]

    @classmethod
    def of(cls, samples: Array, step: float, end: float) -> ItemMotion:
        """Limit samples (3, n_t) [m/s2] to the resolved band that ends at a frequency [Hz]."""
        limited = band_limited(samples.T, step, end).T
        factor = upsampling_factor(step, end, POINTS)
        return cls(step / factor, upsample(np.ascontiguousarray(limited), factor))

    @property
    def time(self) -> Array:
        """Of the samples, shape (n_t,) [s]."""
        return self.time_step * np.arange(self.acceleration.shape[1])


@dataclass(frozen=True, eq=False)
class FloorMotions:
    """The motion of the floors of a building, with and without impacts."""

    model: str  #: "stick" or "structure"
    end: float  #: of the resolved band [Hz]
    mass: dict[int, float]  #: of the floors by number [kg]
    step: float  #: of the samples [s]
    #: Returns samples at an item with impacts or without, shape (3, n_t) [m/s2].
    samples: Callable[[Equipment, bool], Array]

    def at(self, item: Equipment, *, impacts: bool) -> ItemMotion:
        """Return the motion at an item."""
        return ItemMotion.of(self.samples(item, impacts), self.step, self.end)


def stick_motions(store: xr.Dataset, building: str) -> FloorMotions:
    """Return the motions of the rigid floors of a stick from `pounding.nc`.

    At the distance r = (dx, dy) from the axis, a = a_0 + α × r.
    """
    names = ["acceleration", "acceleration_free", "floor_mass", "building_axis"]
    own = store[names].isel(station=(store["station_building"] == building).values).load()
    floors = own["station_floor"].values
    axis = own["building_axis"].sel(building=building).values
    moved = list(own["component"].values)

    def samples(item: Equipment, impacts: bool) -> Array:
        name = "acceleration" if impacts else "acceleration_free"
        floor = own[name].isel(station=int(np.flatnonzero(floors == item.floor)[0]))
        a = {c: floor.sel(component=c).values for c in moved}
        zero = np.zeros(own.sizes["time"])
        x, y, z, rx, ry, rz = (a.get(c, zero) for c in ("x", "y", "z", "rx", "ry", "rz"))
        dx, dy = item.x - axis[0], item.y - axis[1]
        return np.stack([x - rz * dy, y + rz * dx, z + rx * dy - ry * dx])

    masses = own["floor_mass"].values
    return FloorMotions(
        model="stick",
        end=float(store.attrs["resolved_frequency"]),
        mass={int(k): float(m) for k, m in zip(floors, masses, strict=True)},
        step=time_step(store),
        samples=samples,
    )
