"""The checks of the stage `reduce` in words."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from impactfem.stages.check import Check
from impactfem.stages.stores import open_store


def reduce_checks(folder: Path) -> list[Check]:
    """Whether the transfer functions are as accurate as asked, in words."""
    with open_store(folder / "reduce.nc") as store:
        return [_check(store.isel(accuracy=k)) for k in range(store.sizes["accuracy"])]


def _check(at: xr.Dataset) -> Check:
    error, tolerance = float(at.error), float(at.tolerance)
    return (
        error <= tolerance,
        f"reduce: transfer functions within {100.0 * error:.2g} % up to "
        f"{float(at.maximum_frequency):g} Hz with a damping of {at.accuracy.item()}, "
        f"{100.0 * tolerance:g} % asked",
    )
