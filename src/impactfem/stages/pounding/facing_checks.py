"""The check of the floors that face each other and are in no contact pair."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from impactfem.case import Case
from impactfem.case.facing import facing_floors, unknown_lines
from impactfem.stages.check import Check
from impactfem.stages.open_store import open_store


def facing_checks(folder: Path, case: Case) -> list[Check]:
    """Whether floors in no pair stay apart, and which ones cannot be told.

    Args:
        folder: The run's folder, with `pounding.nc`.
        case: The case.

    Returns:
        The checks; none where all floors that face each other are in pairs.
    """
    with open_store(folder / "pounding.nc") as store:
        approach = [_approach(store)] if "facing" in store.dims else []
    return [*approach, *((None, line) for line in unknown_lines(facing_floors(case)))]


def _approach(store: xr.Dataset) -> Check:
    distances = store["facing_distance_min"].values
    k = int(distances.argmin())
    names = f"{store['facing_a'].values[k]} and {store['facing_b'].values[k]}"
    nearest, at = f"{1e3 * abs(distances[k]):.4g} mm", f"{store['facing_time'].values[k]:.4g} s"
    count = int((distances < 0.0).sum())
    if count:
        more = f", and {count - 1} more do" if count > 1 else ""
        return False, (
            f"facing floors: {names} overlap by {nearest} at {at} and are in no pair{more} "
            "(tables/facing_floors.csv); list them in [[contacts]]"
        )
    return True, (
        f"facing floors: {len(distances)} in no pair keep apart; the nearest, {names}, by "
        f"{nearest} at {at}"
    )
