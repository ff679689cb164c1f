"""`provenance.json`: what made a run, so that it can be made again."""

from __future__ import annotations

import platform
import sys
from importlib.metadata import PackageNotFoundError, version
from typing import Any

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


def provenance(**facts: Any) -> dict[str, Any]:
    """Versions of the program and what it stands on, with the facts of the run.

    Args:
        facts: What the run adds: case, hashes, seeds, times, ranks.
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
