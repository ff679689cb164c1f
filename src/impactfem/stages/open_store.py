"""Stores of a run, opened to be read."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import xarray as xr

from impactfem.system.errors import ImpactfemError

# What xarray and HDF5 raise for a file that is missing, of another kind, or damaged.
DAMAGE = (OSError, ValueError, KeyError, RuntimeError, TypeError, AttributeError)


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
