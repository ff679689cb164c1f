"""Processes for members of ensembles, second stages, figures, gmsh and VTK: one kind of pool.

All processes are those of `concurrent.futures`, started anew (spawn): a fork of a process with open
threads and HDF5 files may hang. gmsh and VTK need a process without PETSc and MPI. The wheel of
gmsh brings a second MPI and a second PETSc, which clash with those of Debian and would take the
variables of `mpirun` for their own. The wheel of VTK crashes together with dolfinx where both use
the regular expressions of the C++ library, and without a usable OpenGL.
"""

import ctypes
import logging
import multiprocessing
import os
import pickle
import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from logging.handlers import QueueHandler, QueueListener
from multiprocessing.context import SpawnContext, SpawnProcess
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from impactfem.system.errors import Fault, ImpactfemError, InputError, file_errors
from impactfem.system.log import LOGGER
from impactfem.system.parallel import THREADS, acts_alone, threads, world

T = TypeVar("T")
PR_SET_PDEATHSIG = 1  # of linux/prctl.h
# Variables that Open MPI, PRRTE, PMIx and MPICH set for a rank.
LAUNCHER_PREFIXES = ("OMPI_", "PMI_", "PMIX_", "PRTE_", "MPI_LOCAL", "HYDRA_", "PMI2_")


class OwnProcessError(ImpactfemError):
    """The process ended without a result."""


@contextmanager
def workers(count: int | None = None, *, logs: bool = False) -> Iterator[Executor | None]:
    """Yield an executor over all ranks, or over processes of this computer. Collective.

    Rank 0 gets the executor. The other ranks work inside this call until rank 0 leaves the block,
    and get None: `mpirun -n 3` keeps two cores busy. In `alone` the executor is a thread. Where the
    block fails, running work is stopped.

    Args:
        count: Number of processes without ranks; `threads` when None.
        logs: Whether the processes log into the log of this process.
    """
    comm = world()
    if acts_alone():
        with ThreadPoolExecutor(1) as thread:
            yield thread
    elif comm is not None:
        from mpi4py.futures import MPICommExecutor

        with MPICommExecutor(comm, root=0) as executor:
            yield executor
    else:
        with _pool(count or threads(), _Context(), logs) as pool:
            yield pool


def in_own_process(function: Callable[..., T], *arguments: Any) -> T:
    """Run a function in a new Python process and return its result. Not collective.

    Args:
        function: A function of a module that can be imported; it may import gmsh or VTK.
        arguments: Its arguments; they and the result must be picklable.

    Raises:
        OwnProcessError: The process ended without a result, as when a library crashes.
        Exception: Any error of the function.
    """
    with _pool(1, _OwnContext(), logs=False) as pool:
        try:
            future: Future[T] = pool.submit(_call, pickle.dumps((function, arguments)))
            return future.result()
        except BrokenProcessPool as error:
            name = f"{function.__module__}.{getattr(function, '__name__', '')}"
            raise OwnProcessError(f"the process of {name} crashed or was ended") from error


def read_in_own_process(read: Callable[[Path], T], path: Path, what: str) -> T:
    """Run `in_own_process(read, path)` for a library that a damaged file may crash.

    InputError of `read`, or where the library failed: `what` was expected of the file.
    """
    try:
        return in_own_process(read, path)
    except ImpactfemError as error:
        if not isinstance(error, OwnProcessError):
            raise
        reason = str(error)
    except Exception as error:  # of the library
        reason = f"{type(error).__name__}: {error}"
    raise InputError([Fault(path, "", None, f"{reason}; expected {what}")])


@contextmanager
def _pool(count: int, context: SpawnContext, logs: bool) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of processes that end with this one, and at once where the block fails."""
    others = set(multiprocessing.active_children())
    # The first queue starts a process, too.
    with _environment({"PYTHONSAFEPATH": "1"}):
        records = context.Queue() if logs else None
        pool = ProcessPoolExecutor(
            count, mp_context=context, initializer=_initialise, initargs=(os.getpid(), records)
        )
    calls = pool._call_queue  # type: ignore[attr-defined]
    listener = None if records is None else QueueListener(records, _Forwarding())
    try:
        if listener is not None:
            listener.start()
        with pool:
            try:
                yield pool
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                for process in set(multiprocessing.active_children()) - others:
                    process.terminate()
                # Python 3.11 waits at its end for the thread that writes large arguments into a
                # pipe (CPython issue 94777). Without a reader this thread fails, and ends.
                calls._reader.close()
                raise
    finally:
        if listener is not None:
            listener.stop()


class _Process(SpawnProcess):
    """A process whose libraries have one thread, and which imports no module of the folder."""

    def start(self) -> None:
        """Start the process with its environment."""
        with _environment({THREADS: "1", "PYTHONSAFEPATH": "1"}):
            super().start()


class _Context(SpawnContext):
    Process = _Process


class _OwnProcess(SpawnProcess):
    """A process that is no rank, and does not import the script of the user."""

    def start(self) -> None:
        """Start the process without the variables of `mpirun`."""
        launcher = [name for name in os.environ if name.startswith(LAUNCHER_PREFIXES)]
        main = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            with _environment({"PYTHONSAFEPATH": "1", **dict.fromkeys(launcher)}):
                super().start()
        finally:
            sys.modules["__main__"] = main


class _OwnContext(SpawnContext):
    Process = _OwnProcess


@contextmanager
def _environment(variables: dict[str, str | None]) -> Iterator[None]:
    """Set environment variables of the processes that the block starts; None removes one."""
    before = {name: os.environ.get(name) for name in variables}
    try:
        _set(variables)
        yield
    finally:
        _set(before)


def _set(variables: dict[str, str | None]) -> None:
    for name, value in variables.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value


def _initialise(parent: int, records: Any) -> None:
    """Prepare a process of a pool: the parent alone answers Ctrl-C, and its end is the end here.

    The kernel kills the process as soon as the thread that started it ends. A thread that watches
    could not: it waits for Python's lock, which a library may hold for seconds.

    Args:
        parent: Number of the process that started this one.
        records: Queue of the log of the parent, or None.
    """
    ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, int(signal.SIGKILL), 0, 0, 0)
    if os.getppid() != parent:  # the parent ended before
        os._exit(1)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if records is not None:
        LOGGER.setLevel(logging.DEBUG)
        LOGGER.propagate = False
        LOGGER.handlers[:] = [QueueHandler(records)]


class _Forwarding(logging.Handler):
    """Hands the records of a process to the logger of their name in this one."""

    def emit(self, record: logging.LogRecord) -> None:
        logger = logging.getLogger(record.name)
        if logger.isEnabledFor(record.levelno):
            logger.handle(record)


def _call(content: bytes) -> Any:
    """Call a pickled function with its arguments, without the lines that gmsh and VTK print."""
    with Path(os.devnull).open("w") as sink:
        os.dup2(sink.fileno(), 1)
        os.dup2(sink.fileno(), 2)
    with file_errors():
        function, arguments = pickle.loads(content)  # imports the module of the function
        return function(*arguments)
