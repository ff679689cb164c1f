"""The store of the stage `ensemble`, and its scalars by the names of `summary.json`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.case import Case
from impactfem.stages.ensemble.compute import (
    PARTS,
    PERCENTILES,
    EnsembleResult,
    each,
    failures_text,
)
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar, to_json

LABELS = {5.0: "p05", 16.0: "p16", 50.0: "median", 84.0: "p84", 95.0: "p95"}


def ensemble_scalars(result: EnsembleResult) -> list[Scalar]:
    """Percentiles of every scalar over the members, and how many members there are."""
    scalars = [
        Scalar("ensemble.members", float(len(result.members)), "-"),
        Scalar("ensemble.failed", float(len(result.failed)), "-", "; ".join(result.failed)),
    ]
    for name, unit, values in each(result):
        known = values[np.isfinite(values)]
        note = f"over {known.size} members"
        scalars += [
            Scalar(
                f"ensemble.{LABELS[q]}.{name}",
                float(np.percentile(known, q)) if known.size else None,
                unit,
                note,
            )
            for q in PERCENTILES
        ]
    return scalars


def write_ensemble(path: Path, case: Case, result: EnsembleResult, key: str) -> None:
    """Write `ensemble.nc`.

    Dimensions `motion`, `scalar`, `percentile`, and those of the floor spectra of the first
    building (`damping`, `station`, `direction`, `frequency`). `value` has every scalar of every
    motion; `psa`, `psa_free` (without contact), `pfa` and `pfa_free` every spectrum, and the same
    names with `_percentile` their percentiles over the members.

    Args:
        path: The file.
        case: The case.
        result: The ensemble.
        key: Hash of the stage's inputs.
    """
    spectrum = ("damping", "station", "direction", "frequency")
    building = case.buildings[0]
    variables: dict[str, tuple[object, ...]] = {
        "motion": ("motion", np.array(result.members, dtype=object)),
        "scalar": ("scalar", np.array(result.names, dtype=object)),
        "unit": ("scalar", np.array(result.units, dtype=object)),
        "value": (("motion", "scalar"), result.scalars),
        "percentile": ("percentile", np.array(PERCENTILES), {"units": "%"}),
        "station": (
            "station",
            np.array([f"{building.name}.floor_{f.floor}" for f in building.floors], dtype=object),
        ),
        "station_building": ("station", np.array([building.name] * len(building.floors), object)),
        "station_floor": ("station", np.array([f.floor for f in building.floors])),
        "elevation": ("station", np.array(building.elevations), {"units": "m"}),
        "direction": ("direction", np.array(result.directions, dtype=object)),
        "frequency": ("frequency", result.frequency, {"units": "Hz"}),
        "damping": ("damping", result.damping, {"units": "-"}),
    }
    for part in PARTS:
        values = getattr(result, part)
        dims = spectrum if part.startswith("psa") else ("station", "direction")
        unit = {"units": "m/s2"}
        variables[part] = (("motion", *dims), values, unit)
        percentiles = np.percentile(values, PERCENTILES, axis=0)
        variables[f"{part}_percentile"] = (("percentile", *dims), percentiles, unit)
    dataset = xr.Dataset(
        variables,
        attrs={
            "title": case.title,
            "inputs": key,
            "case_hash": case.content_hash(),
            "scalars": to_json(ensemble_scalars(result)),
            "failed": failures_text(result.failed),
            "studied_building": building.name,
            "shown_direction": case.shown_direction,
        },
    )
    write_netcdf(path, dataset)
