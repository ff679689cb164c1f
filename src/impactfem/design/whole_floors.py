"""Spectra over whole floors under the case's own motion, from `transient_maps.nc`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.design.floor_points import LEVEL, FloorPoints
from impactfem.errors import ImpactfemError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class WholeFloors:
    """The largest ordinates of all vertices of each floor.

    Args:
        frequency: Shape (n_f,) [Hz].
        damping: Of the oscillators [-].
        psa: Pseudo-acceleration along x, y, z, shape (n_floors, 3, n_f) [m/s2]; zero for a floor
            without a vertex.
        vertices: Number of vertices of each floor, shape (n_floors,).
        points_per_cycle: Samples of the records in a cycle of the highest frequency.
    """

    frequency: Array
    damping: float
    psa: Array
    vertices: NDArray[np.int64]
    points_per_cycle: float


def read_whole_floors(path: Path, floors: Sequence[FloorPoints]) -> WholeFloors | None:
    """Read `transient_maps.nc`.

    Args:
        path: The file.
        floors: The floors of the building.

    Returns:
        The spectra; None where the case asks for no fields, and the file is not there.

    Raises:
        ImpactfemError: The file cannot be read.
    """
    if not path.is_file():
        return None
    try:
        with xr.open_dataset(path, engine="h5netcdf") as store:
            height = store["node_position"].values[:, 2]
            on_floor = [np.abs(height - one.elevation) <= LEVEL for one in floors]
            psa = store["psa"].transpose("node", "component", "frequency").values
            return WholeFloors(
                frequency=np.asarray(store["frequency"].values, dtype=np.float64),
                damping=float(store.attrs["damping"]),
                psa=np.stack(
                    [psa[chosen].max(axis=0, initial=0.0).astype(np.float64) for chosen in on_floor]
                ),
                vertices=np.array([chosen.sum() for chosen in on_floor], dtype=np.int64),
                points_per_cycle=float(store.attrs["points_per_cycle"]),
            )
    except (OSError, ValueError, KeyError) as error:
        raise ImpactfemError(f"cannot read fields over the floors from {path}: {error}") from error
