"""Floor accelerations of a 3D model against their limit."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from impactfem.case import BuildingInTime
from impactfem.stages.pounding.limits import floor_acceleration
from impactfem.stages.stores import open_store
from impactfem.stages.verdict import Verdict


def transient_verdicts(building: BuildingInTime, folder: Path) -> list[Verdict]:
    """Return the verdict of the stage, from `transient.nc` of a run's folder."""
    with open_store(folder / "transient.nc") as store:
        return verdicts_of(building, store)


def verdicts_of(building: BuildingInTime, store: xr.Dataset) -> list[Verdict]:
    """Return the verdict of a building, from results as in `transient.nc`."""
    on_floors = store["zpa"].load().isel(probe=(store["probe_floor"] > 0).values)
    if not on_floors.size:
        return []
    at = on_floors.isel(on_floors.argmax(...))
    free = store.get("zpa_free")
    place = (
        f"{store.attrs['building']}, floor {int(at['probe_floor'])}, probe "
        f"{at['probe'].item()}, direction {at['component'].item()}"
    )
    return [
        floor_acceleration(
            "transient.floor_acceleration",
            building.case,
            place,
            at,
            None if free is None else free.sel(probe=on_floors["probe"]),
            float(store.attrs["resolved_frequency"]),
        )
    ]
