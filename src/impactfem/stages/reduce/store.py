"""The store of the stage `reduce`: sizes and errors; the model itself is in `reduce.npz`."""

from collections.abc import Sequence
from pathlib import Path

from impactfem.reduction.reduced_basis import Accuracy
from impactfem.reduction.reduced_building import ReducedBuilding
from impactfem.stages.results import scalars
from impactfem.stages.stores import Output, dataset
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import with_scalars

MODEL = "reduce.npz"
OUTPUTS = {
    "load": Output("load", "", "load pattern of the basis"),
    "accuracy": Output("accuracy", "", "what the transfer functions are accurate for"),
    "mass_coefficient": Output("accuracy", "1/s", "α of Rayleigh damping"),
    "stiffness_coefficient": Output("accuracy", "s", "β of Rayleigh damping"),
    "maximum_frequency": Output("accuracy", "Hz", "up to which they are accurate"),
    "tolerance": Output("accuracy", "-", "largest error that is allowed"),
    "error": Output("accuracy", "-", "estimated error, by nested models"),
    "vectors": Output("", "", "basis vectors for the first accuracy"),
    "krylov_vectors": Output("", "", "vectors of the largest Krylov basis"),
    "complete_vectors": Output("", "", "basis vectors with those of contacts and anchors"),
}


def write_reduced(
    path: Path, title: str, reduced: ReducedBuilding, accuracies: Sequence[Accuracy], key: str
) -> None:
    """Write `reduce.nc`: sizes, and errors at the required accuracies."""
    basis = reduced.basis
    values = {
        "load": list(basis.loads),
        "accuracy": [
            f"{one.damping.ratio(one.maximum_frequency):.3g} of critical at "
            f"{one.maximum_frequency:g} Hz"
            for one in accuracies
        ],
        "mass_coefficient": [one.damping.coefficients[0] for one in accuracies],
        "stiffness_coefficient": [one.damping.coefficients[1] for one in accuracies],
        "maximum_frequency": [one.maximum_frequency for one in accuracies],
        "tolerance": [one.tolerance for one in accuracies],
        "error": reduced.errors,
        "vectors": len(basis.model.eigenvalue),
        "krylov_vectors": len(reduced.fine.models[0].eigenvalue),
        "complete_vectors": len(reduced.complete.eigenvalue),
    }
    store = dataset(OUTPUTS, values, attributes={"title": title, "inputs": key})
    sizes = scalars(store, "reduce.{variable}", "krylov_vectors complete_vectors")
    write_netcdf(path, with_scalars(store, sizes))
