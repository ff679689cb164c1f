"""The results file of the stage `ensemble`; percentiles of every result are variables of it."""

from pathlib import Path
from typing import Any

import numpy as np

from impactfem.case import Case
from impactfem.stages.ensemble.compute import PARTS, PERCENTILES, EnsembleResult
from impactfem.stages.stores import Output, dataset
from impactfem.system.arrays import Array
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar

_SPECTRUM = "damping station direction frequency"
OUTPUTS = {
    "motion": Output("motion", "", "seed or record"),
    "scalar": Output("scalar", "", "name of a result of the pounding"),
    "unit": Output("scalar", "", "of the result", label=True),
    "value": Output("motion scalar", "as unit"),
    "percentile": Output("percentile", "%"),
    "value_percentile": Output("percentile scalar", "as unit", "over the motions with the result"),
    "station": Output("station", "", "building and floor"),
    "station_building": Output("station", label=True),
    "station_floor": Output("station", label=True),
    "elevation": Output("station", "m", label=True),
    "direction": Output("direction"),
    "frequency": Output("frequency", "Hz"),
    "damping": Output("damping", "-"),
    "psa": Output(f"motion {_SPECTRUM}", "m/s2", "pseudo-acceleration"),
    "psa_free": Output(f"motion {_SPECTRUM}", "m/s2", "the same without contact"),
    "pfa": Output("motion station direction", "m/s2", "peak floor acceleration"),
    "pfa_free": Output("motion station direction", "m/s2", "the same without contact"),
    "psa_percentile": Output(f"percentile {_SPECTRUM}", "m/s2"),
    "psa_free_percentile": Output(f"percentile {_SPECTRUM}", "m/s2", "without contact"),
    "pfa_percentile": Output("percentile station direction", "m/s2"),
    "pfa_free_percentile": Output("percentile station direction", "m/s2", "without contact"),
    "failed": Output("failed", "", "members without a result"),
    "failed_reason": Output("failed", "", "why"),
}


def write_ensemble(path: Path, case: Case, result: EnsembleResult, key: str) -> None:
    """Write `ensemble.nc`: every scalar and floor spectrum of every motion, and percentiles."""
    stations = [
        (building.name, floor.floor, elevation)
        for building in case.buildings
        for floor, elevation in zip(building.floors, building.elevations, strict=True)
    ]
    values: dict[str, Any] = {
        "motion": list(result.scalars.index),
        "scalar": list(result.scalars.columns),
        "unit": [result.units[name] for name in result.scalars.columns],
        "value": result.scalars.to_numpy(),
        "percentile": PERCENTILES,
        "value_percentile": percentiles(result.scalars.to_numpy()),
        "station": [f"{building}.floor_{floor}" for building, floor, _ in stations],
        "station_building": [building for building, *_ in stations],
        "station_floor": [floor for _, floor, _ in stations],
        "elevation": [elevation for *_, elevation in stations],
        "direction": [str(direction) for direction in result.spectra["directions"]],
        "frequency": result.spectra["frequency"],
        "damping": result.spectra["damping"],
        "failed": list(result.failed),
        "failed_reason": list(result.failed.values()),
    }
    for part in PARTS:
        values[part] = result.spectra[part]
        values[f"{part}_percentile"] = np.percentile(values[part], PERCENTILES, axis=0)
    attributes = {
        "title": case.title,
        "inputs": key,
        "case_hash": case.content_hash(),
        "studied_building": case.buildings[0].name,
        "shown_direction": case.shown_direction,
    }
    scalars = [
        Scalar("ensemble.members", float(len(result.scalars)), "-", "motions with a result"),
        Scalar("ensemble.failed", float(len(result.failed)), "-", "motions without a result"),
    ]
    write_netcdf(path, dataset(OUTPUTS, values, attributes=attributes, scalars=scalars))


def percentiles(values: Array) -> Array:
    """Percentiles over the first axis, without nan; nan where nothing is known."""
    known = np.isfinite(values).any(axis=0)
    of_each = np.full((len(PERCENTILES), values.shape[1]), np.nan)
    of_each[:, known] = np.nanpercentile(values[:, known], PERCENTILES, axis=0)
    return of_each
