"""Spectra at the points of the floors under the case's own motion, from `transient.nc`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.design.floor_points import FloorPoints, enveloped, floor_points
from impactfem.errors import ImpactfemError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CaseSpectra:
    """What the stage `transient` found at its probes.

    Args:
        building: Name of the building.
        names: Names of the n_p probes.
        nodes: Their nodes, shape (n_p,).
        floors: The points of each floor.
        elsewhere: Names of the probes that are on no floor.
        frequency: Shape (n_f,) [Hz].
        damping: Of the oscillators, shape (n_d,) [-].
        psa: Pseudo-acceleration along x, y, z, shape (n_d, n_p, 3, n_f) [m/s2].
        pfa: Peak acceleration, shape (n_p, 3) [m/s2].
        maximum_frequency: Up to which the 3D model is meant [Hz].
    """

    building: str
    names: tuple[str, ...]
    nodes: NDArray[np.int64]
    floors: tuple[FloorPoints, ...]
    elsewhere: tuple[str, ...]
    frequency: Array
    damping: Array
    psa: Array
    pfa: Array
    maximum_frequency: float

    @cached_property
    def floor_psa(self) -> Array:
        """Envelope over the points of each floor, shape (n_d, n_floors, 3, n_f) [m/s2]."""
        return enveloped(self.psa, self.floors, axis=1)

    @cached_property
    def floor_pfa(self) -> Array:
        """Envelope over the points of each floor, shape (n_floors, 3) [m/s2]."""
        return enveloped(self.pfa, self.floors, axis=0)


def read_case_spectra(path: Path) -> CaseSpectra:
    """Read `transient.nc`.

    Raises:
        ImpactfemError: The file cannot be read, or is no such store.
    """
    try:
        with xr.open_dataset(path, engine="h5netcdf") as store:
            names = tuple(str(name) for name in store["probe"].values)
            position = np.asarray(store["probe_position"].values, dtype=np.float64)
            floors, elsewhere = floor_points(names, position)
            order = ("damping", "probe", "component", "frequency")
            return CaseSpectra(
                building=str(store.attrs["building"]),
                names=names,
                nodes=np.asarray(store["probe_node"].values, dtype=np.int64),
                floors=floors,
                elsewhere=elsewhere,
                frequency=np.asarray(store["frequency"].values, dtype=np.float64),
                damping=np.asarray(store["damping"].values, dtype=np.float64),
                psa=np.asarray(store["psa"].transpose(*order).values, dtype=np.float64),
                pfa=np.asarray(store["pfa"].values, dtype=np.float64),
                maximum_frequency=float(store.attrs["maximum_frequency"]),
            )
    except KeyError as error:
        raise ImpactfemError(f"{path} holds no spectra of probes: {error.args[0]}") from error
    except (OSError, ValueError) as error:
        raise ImpactfemError(f"cannot read spectra of probes from {path}: {error}") from error
