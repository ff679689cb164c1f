"""Stores of a run, opened to be read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import xarray as xr

from impactfem.errors import ImpactfemError


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
    except OSError as error:
        raise ImpactfemError(f"cannot read {path}: {error}") from error
    with store:
        yield store
