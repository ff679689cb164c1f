"""`provenance.json`: the origin of a run, so that it can be made again."""

from __future__ import annotations

import platform
import sys
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from pydantic import BaseModel, ConfigDict, FiniteFloat

import impactfem

PACKAGES = (
    "numpy",
    "scipy",
    "numba",
    "xarray",
    "h5netcdf",
    "pydantic",
    "pint",
    "matplotlib",
    "fenics-dolfinx",
    "petsc4py",
    "slepc4py",
    "mpi4py",
    "gmsh",
    "pyvista",
)


class Provenance(BaseModel):
    """The origin of a run.

    Args:
        impactfem: Version of the program.
        python: Version of Python.
        system: Name, release and processor of the system.
        command: The command with its arguments.
        packages: Version of each package that the program stands on.
        case: Name of the case file.
        case_hash: Hash of the case and all files that it names.
        inputs: Hash of the inputs of each stage, in the order of the stages.
        needs: Names of the stages that each stage needs directly.
        seeds: Seeds of motions, calibration and ensemble by their keys in the case.
        started: When the run began.
        reused: Names of the stages that had finished before.
        seconds: Wall time of each step by stage and step [s].
        peak_memory: Largest memory of each stage [byte], None where not known.
        ranks: Number of processes.
        files: Hash of each file that says what all stages found, by its name.
    """

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    impactfem: str
    python: str
    system: str
    command: list[str]
    packages: dict[str, str]
    case: str
    case_hash: str
    inputs: dict[str, str]
    needs: dict[str, list[str]] = {}
    seeds: dict[str, int]
    started: str
    reused: list[str]
    seconds: dict[str, FiniteFloat]
    peak_memory: dict[str, FiniteFloat | None]
    ranks: int
    files: dict[str, str]


def provenance(**facts: Any) -> dict[str, Any]:
    """Versions of the program and what it stands on, with the facts of the run.

    Args:
        facts: What the run adds: case, hashes, seeds, times, ranks; together those of `Provenance`.
    """
    versions = {}
    for name in PACKAGES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = "unknown"
    return {
        "impactfem": impactfem.__version__,
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "command": ["impactfem", *sys.argv[1:]],
        "packages": versions,
        **facts,
    }
