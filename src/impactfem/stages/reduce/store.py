"""The store of the stage `reduce`: sizes and errors; the model itself is in `reduce.npz`."""

from collections.abc import Sequence
from pathlib import Path

from impactfem.reduction.reduced_basis import Accuracy
from impactfem.reduction.reduced_building import ReducedBuilding
from impactfem.stages.results import outputs, scalars, value, values
from impactfem.stages.stores import Output, dataset
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import with_scalars

MODEL = "reduce.npz"
OUTPUTS = {
    "load": Output("load", "", "load pattern of the basis"),
    "accuracy": Output("accuracy", "", "what the transfer functions are accurate for"),
    "mass_coefficient": Output("accuracy", "1/s", "α of Rayleigh damping"),
    "stiffness_coefficient": Output("accuracy", "s", "β of Rayleigh damping"),
    **outputs(Accuracy, "accuracy"),
    **outputs(ReducedBuilding),
}


def write_reduced(
    path: Path, title: str, reduced: ReducedBuilding, accuracies: Sequence[Accuracy], key: str
) -> None:
    """Write `reduce.nc`: sizes, and errors at the required accuracies."""
    results = {
        "load": list(reduced.basis.loads),
        "accuracy": [
            f"{one.damping.ratio(one.maximum_frequency):.3g} of critical at "
            f"{one.maximum_frequency:g} Hz"
            for one in accuracies
        ],
        "mass_coefficient": [one.damping.coefficients[0] for one in accuracies],
        "stiffness_coefficient": [one.damping.coefficients[1] for one in accuracies],
        **values(Accuracy, accuracies),
        **value(reduced),
    }
    store = dataset(OUTPUTS, results, attributes={"title": title, "inputs": key})
    sizes = scalars(store, "reduce.{variable}", "krylov_vectors complete_vectors")
    write_netcdf(path, with_scalars(store, sizes))
