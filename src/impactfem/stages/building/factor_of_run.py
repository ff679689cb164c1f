"""The storey factor that a run has found."""

from __future__ import annotations

from pathlib import Path

from impactfem.stages.open_store import open_store
from impactfem.system.scalar import from_json


def storey_factor(folder: Path) -> float:
    """The factor that the stage `building` was given or fitted.

    Args:
        folder: The run's folder, with `building.nc`.
    """
    with open_store(folder / "building.nc") as store:
        scalars = {s.name: s.value for s in from_json(store.attrs["scalars"])}
    return float(scalars["building.storey_stiffness_factor"] or 1.0)
