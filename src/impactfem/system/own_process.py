"""A process of its own for libraries that do not go with PETSc and MPI in one.

gmsh's wheel brings an MPI and a PETSc of its own: in a process with Debian's they print errors, and
under `mpirun` they would take the launcher's variables for theirs. VTK's wheel crashes beside
dolfinx where both use the C++ library's regular expressions, and without a usable OpenGL.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from impactfem.system.errors import Fault, ImpactfemError, InputError, file_errors
from impactfem.system.log import LOGGER

T = TypeVar("T")
# What Open MPI, PRRTE, PMIx and MPICH put into the environment of a rank.
LAUNCHER_PREFIXES = ("OMPI_", "PMI_", "PMIX_", "PRTE_", "MPI_LOCAL", "HYDRA_", "PMI2_")


class OwnProcessError(ImpactfemError):
    """A process of its own ended without a result; the message has its exit code and last words."""


def read_in_own_process(read: Callable[[Path], T], path: Path, what: str) -> T:
    """Read a file with a library that a damaged one may crash. Not collective.

    Args:
        read: As for `in_own_process`; it takes the path.
        path: The file.
        what: What the file is to be, for the message.

    Raises:
        InputError: What the function raised; or the library came to no result, which is the file's
            fault then.
    """
    try:
        return in_own_process(read, path)
    except OwnProcessError as error:
        raise InputError([Fault(path, "", None, f"{error}; expected {what}")]) from error


def in_own_process(function: Callable[..., T], *arguments: Any) -> T:
    """Run a function in a new Python process and give its result. Not collective.

    Args:
        function: A function of a module that can be imported; it may import gmsh or pyvista.
        arguments: Its arguments; they and the result must be picklable.

    Raises:
        ImpactfemError: What the function raised, `InputError` with all its faults.
        OwnProcessError: The process ended without a result, as when a library crashes.
    """
    # -P: a file gmsh.py or numpy.py in the working folder is not taken for the package.
    process = subprocess.run(
        [sys.executable, "-P", "-m", __name__],
        input=pickle.dumps((function, arguments)),
        capture_output=True,
        env=clean_environment(os.environ),
        check=False,
    )
    if process.returncode != 0:
        words = process.stderr.decode(errors="replace").strip()
        LOGGER.debug("%s", words)
        last = words.rpartition("\n")[2][-500:]  # of a traceback what happened
        raise OwnProcessError(
            f"the process that runs {function.__module__} ended with exit code {process.returncode}"
            + (f": {last}" if last else "")
        )
    result, failure = pickle.loads(process.stdout)
    if failure is not None:
        raise failure
    return result  # type: ignore[no-any-return]


def clean_environment(environment: Mapping[str, str]) -> dict[str, str]:
    """The environment without what a launcher of MPI has put there."""
    return {
        name: value for name, value in environment.items() if not name.startswith(LAUNCHER_PREFIXES)
    }


def _serve() -> None:
    """Run what comes by standard input; the result goes to standard output.

    What is printed goes to standard error.
    """
    out = os.dup(1)
    os.dup2(2, 1)
    function, arguments = pickle.loads(sys.stdin.buffer.read())
    result, failure = None, None
    try:
        with file_errors():
            result = function(*arguments)
    except ImpactfemError as error:
        failure = error
    with os.fdopen(out, "wb") as stream:
        pickle.dump((result, failure), stream, protocol=pickle.HIGHEST_PROTOCOL)


if __name__ == "__main__":
    _serve()
