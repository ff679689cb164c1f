"""A separate process for libraries that do not go with PETSc and MPI in one.

gmsh's wheel brings an MPI and a PETSc of its own: in a process with Debian's they print errors, and
under `mpirun` they would take the launcher's variables for theirs. VTK's wheel crashes beside
dolfinx where both use the C++ library's regular expressions, and without a usable OpenGL.
"""

import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from impactfem.system.errors import Fault, ImpactfemError, InputError, file_errors
from impactfem.system.log import LOGGER
from impactfem.system.parallel import end_with_parent
from impactfem.system.stop import CHILDREN

T = TypeVar("T")
# Variables that Open MPI, PRRTE, PMIx and MPICH set for a rank.
LAUNCHER_PREFIXES = ("OMPI_", "PMI_", "PMIX_", "PRTE_", "MPI_LOCAL", "HYDRA_", "PMI2_")


class OwnProcessError(ImpactfemError):
    """The process ended without a result; the message has its exit code and last line."""


def read_in_own_process(read: Callable[[Path], T], path: Path, what: str) -> T:
    """As `in_own_process(read, path)`, for a library that a damaged file may crash.

    InputError of `read`, or where the process crashed: `what` was expected of the file.
    """
    try:
        return in_own_process(read, path)
    except OwnProcessError as error:
        raise InputError([Fault(path, "", None, f"{error}; expected {what}")]) from error


def in_own_process(function: Callable[..., T], *arguments: Any) -> T:
    """Run a function in a new Python process and give its result. Not collective.

    The function is of a module that can be imported; it may import gmsh or pyvista. Its arguments
    and result must be picklable. An ImpactfemError of it is raised here, `InputError` with all its
    faults; OwnProcessError where the process ended without a result, as when a library crashes.
    """
    # -P: a file gmsh.py or numpy.py in the working folder is not taken for the package.
    with subprocess.Popen(
        [sys.executable, "-P", "-m", __name__, str(os.getpid())],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={k: v for k, v in os.environ.items() if not k.startswith(LAUNCHER_PREFIXES)},
    ) as process:
        CHILDREN.add(process)
        try:
            out, errors = process.communicate(pickle.dumps((function, arguments)))
        except BaseException:
            process.kill()
            raise
        finally:
            CHILDREN.discard(process)
    if process.returncode != 0:
        words = errors.decode(errors="replace").strip()
        LOGGER.debug("%s", words)
        last = words.rpartition("\n")[2][-500:]  # the error below a traceback
        raise OwnProcessError(
            f"the process that runs {function.__module__} ended with exit code {process.returncode}"
            + (f": {last}" if last else "")
        )
    result, failure = pickle.loads(out)
    if failure is not None:
        raise failure
    return result  # type: ignore[no-any-return]


if __name__ == "__main__":
    # The function comes by standard input, the result goes to standard output; what is printed
    # goes to standard error. The parent's thread that started this process waits for it.
    end_with_parent(int(sys.argv[1]))
    out = os.dup(1)
    os.dup2(2, 1)
    result, failure = None, None
    try:
        with file_errors():  # also of the import of the function's module
            function, arguments = pickle.loads(sys.stdin.buffer.read())
            result = function(*arguments)
    except ImpactfemError as error:
        failure = error
    with os.fdopen(out, "wb") as stream:
        pickle.dump((result, failure), stream, protocol=pickle.HIGHEST_PROTOCOL)
