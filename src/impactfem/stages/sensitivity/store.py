"""The results file of the stage `sensitivity`."""

from pathlib import Path

import xarray as xr

from impactfem.case import Case
from impactfem.stages.results import outputs, value, values
from impactfem.stages.sensitivity.compute import Demand, SensitivityResult
from impactfem.stages.sensitivity.variations import Variation
from impactfem.stages.stores import Output, dataset
from impactfem.system.files import write_netcdf

OUTPUTS = {
    "demand": Output("demand", "", "verdict and place"),
    **outputs(Demand, "demand"),
    "variation": Output("variation", "", "changed parameter and setting"),
    **outputs(Variation, "variation"),
    **outputs(SensitivityResult),
    "unknown": Output("unknown", "", "parameters whose variation is not known"),
    "unknown_reason": Output("unknown", "", "reason"),
    "failed": Output("failed", "", "variations without a result"),
    "failed_reason": Output("failed", "", "reason"),
}


def write_sensitivity(path: Path, case: Case, result: SensitivityResult, key: str) -> None:
    """Write `sensitivity.nc`, with the hash of the inputs of the stage."""
    attributes = {"title": case.title, "inputs": key, "case_hash": case.content_hash()}
    store = results_of(result).assign_attrs(attributes)
    write_netcdf(path, store)


def results_of(result: SensitivityResult) -> xr.Dataset:
    """Return all results of the stage; it has no scalars."""
    content = {
        "demand": [f"{one.id}: {one.place}" for one in result.demands],
        **values(Demand, result.demands),
        "variation": [one.label for one in result.variations],
        **values(Variation, result.variations),
        **value(result),
        "unknown": [one.parameter for one in result.unknown],
        "unknown_reason": [one.reason for one in result.unknown],
        "failed": list(result.failed),
        "failed_reason": list(result.failed.values()),
    }
    return dataset(OUTPUTS, content, attributes={}, scalars=[])
