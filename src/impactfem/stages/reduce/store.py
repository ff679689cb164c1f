"""The store of the stage `reduce`: sizes and errors; the model itself is in `reduce.npz`."""

from collections.abc import Sequence
from pathlib import Path

from impactfem.reduction.reduced_basis import Accuracy
from impactfem.reduction.reduced_building import ReducedBuilding
from impactfem.stages.stores import Output, dataset
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar

MODEL = "reduce.npz"
OUTPUTS = {
    "load": Output("load", "", "load pattern of the basis"),
    "accuracy": Output("accuracy", "", "what the transfer functions are accurate for"),
    "mass_coefficient": Output("accuracy", "1/s", "α of Rayleigh damping"),
    "stiffness_coefficient": Output("accuracy", "s", "β of Rayleigh damping"),
    "maximum_frequency": Output("accuracy", "Hz", "up to which they are accurate"),
    "tolerance": Output("accuracy", "-", "largest error that is allowed"),
    "error": Output("accuracy", "-", "estimated error, by nested models"),
}


def write_reduced(
    path: Path, title: str, reduced: ReducedBuilding, accuracies: Sequence[Accuracy], key: str
) -> None:
    """Write `reduce.nc`: sizes, and errors at the accuracies that it was made for."""
    basis, complete = reduced.basis, reduced.complete
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
    }
    scalars = [
        Scalar("reduce.vectors", float(len(basis.model.eigenvalue)), "-", "of the first accuracy"),
        Scalar("reduce.krylov_vectors", float(len(reduced.fine.models[0].eigenvalue)), "-"),
        Scalar("reduce.complete_vectors", float(len(complete.eigenvalue)), "-", "with contacts"),
        Scalar("reduce.error", basis.difference, "-", "of the transfer functions, estimated"),
    ]
    attributes = {"title": title, "inputs": key}
    write_netcdf(path, dataset(OUTPUTS, values, attributes=attributes, scalars=scalars))
