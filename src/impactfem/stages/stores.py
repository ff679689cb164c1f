"""Stores of a run, opened to be read, and what readers of them share."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import ImpactfemError
from impactfem.system.scalar import Scalar, from_json

# What xarray and HDF5 raise for a file that is missing, of another kind, or damaged.
DAMAGE = (OSError, ValueError, KeyError, RuntimeError, TypeError, AttributeError)


Array = NDArray[np.float64]


@contextmanager
def open_store(path: Path) -> Iterator[xr.Dataset]:
    """Give a store, open until the block ends.

    Args:
        path: The NetCDF file.

    Raises:
        ImpactfemError: It is missing or cannot be read.
    """
    try:
        store = xr.open_dataset(path, engine="h5netcdf")
    except DAMAGE as error:
        raise ImpactfemError(f"cannot read {path}: {error}") from error
    with store:
        yield store


@contextmanager
def open_stores(folder: Path) -> Iterator[Callable[[str], xr.Dataset]]:
    """Give a function that opens a store of a folder by its file name, until the block ends.

    Args:
        folder: The run's folder.

    Raises:
        ImpactfemError: By the function: the store is missing or cannot be read.
    """
    with ExitStack() as stores:
        yield lambda name: stores.enter_context(open_store(folder / name))


class StoreView:
    """A store of a stage of the 3D building.

    Args:
        store: The open store.
    """

    def __init__(self, store: xr.Dataset) -> None:
        self.store = store
        self.building = str(store.attrs["building"])

    @cached_property
    def time(self) -> Array:
        """Shape (n_t,) [s]."""
        return self._values("time")

    @property
    def time_step(self) -> float:
        """Δt [s]."""
        return float(self.time[1] - self.time[0])

    @cached_property
    def frequency(self) -> Array:
        """Frequencies of the spectra, shape (n_f,) [Hz]."""
        return self._values("frequency")

    @cached_property
    def scalars(self) -> list[Scalar]:
        """The scalars of the stage."""
        return from_json(self.store.attrs["scalars"])

    @property
    def values(self) -> dict[str, float]:
        """Those of them that have a value, by name."""
        return {s.name: s.value for s in self.scalars if s.value is not None}

    def _values(self, name: str) -> Array:
        return np.asarray(self.store[name].values, dtype=np.float64)


class CasesView(StoreView):
    """A store with results for one damping of the building after the other.

    Args:
        store: The open store.
    """

    def __init__(self, store: xr.Dataset) -> None:
        super().__init__(store)
        self.cases = [str(name) for name in store["case"].values]

    def damping(self, case: int) -> Rayleigh:
        """The damping of a damping case, by its number from 0."""
        return Rayleigh(
            float(self.store["mass_coefficient"].values[case]),
            float(self.store["stiffness_coefficient"].values[case]),
        )
