"""The Python interpreter: its version, and the packages that a run needs.

This module is imported first. It uses only Python's own modules, and syntax of Python 3.7.
"""

from __future__ import annotations

import sys
from importlib.util import find_spec

OLDEST = (3, 11)
"""The oldest Python version that can be used; `requires-python` of pyproject.toml."""
PACKAGES = {
    "numpy": "numpy",
    "scipy": "scipy",
    "numba": "numba",
    "threadpoolctl": "threadpoolctl",
    "psutil": "psutil",
    "platformdirs": "platformdirs",
    "filelock": "filelock",
    "tomli-w": "tomli_w",
    "pydantic": "pydantic",
    "pint": "pint",
    "typer": "typer",
    "rich": "rich",
    "xarray": "xarray",
    "pandas": "pandas",
    "matplotlib": "matplotlib",
    "openpyxl": "openpyxl",
    "gmsh": "gmsh",
    "pyvista": "pyvista",
    "imageio": "imageio",
    "jinja2": "jinja2",
    "pillow": "PIL",
}
"""The dependencies of pyproject.toml, and the module of each."""
STORES = ("netCDF4",)
"""Modules that every run needs, and that are no dependencies in pyproject.toml."""
FENICSX = ("basix", "dolfinx", "ffcx", "h5py", "mpi4py", "petsc4py", "slepc4py", "ufl")
"""Modules that 3D models need in addition."""
MOST_NAMES = 5
"""Largest number of missing packages that are named."""
REMEDY = (
    "Use .venv/bin/impactfem of scripts/bootstrap (Debian 12 or 13) or the container image: "
    "see docs/install.md"
)


class InterpreterError(ImportError):
    """This interpreter cannot run impactfem; the message is one line with the remedy."""


def interpreter_fault(version: tuple[int, ...], missing: list[str]) -> str | None:
    """State why an interpreter cannot be used, and the remedy; None if it can be used.

    Args:
        version: The version of Python, such as ``sys.version_info[:2]``.
        missing: The packages that the interpreter does not find.
    """
    python = f"{sys.executable} (Python {'.'.join(map(str, version))})"
    if version < OLDEST:
        oldest = ".".join(map(str, OLDEST))
        return f"impactfem requires Python {oldest} or later, this is {python}. {REMEDY}"
    if missing:
        names = ", ".join(missing[:MOST_NAMES])
        if len(missing) > MOST_NAMES:
            names += f" and {len(missing) - MOST_NAMES} more"
        return f"packages are missing in {python}: {names}. {REMEDY}"
    return None


def missing_modules(*names: str) -> list[str]:
    """Return those of some modules that this interpreter does not find. None is imported."""
    return [name for name in names if name not in sys.modules and not _exists(name)]


def _exists(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except (ImportError, ValueError):
        return False


def check_interpreter() -> None:
    """Check the version of Python and the dependencies before any of them is imported.

    If the error is not caught, Python prints its message as one line without a traceback.

    Raises:
        InterpreterError: The version is too old, or dependencies are missing.
    """
    missing = missing_modules(*PACKAGES.values())
    fault = interpreter_fault(tuple(sys.version_info[:2]), missing)
    if fault is None:
        return
    previous = sys.excepthook

    def one_line(kind, error, trace):  # type: ignore[no-untyped-def]
        if isinstance(error, InterpreterError):
            print(f"error: {error}", file=sys.stderr)
        else:
            previous(kind, error, trace)

    sys.excepthook = one_line
    raise InterpreterError(fault)
