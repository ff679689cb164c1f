"""Threads and ranks: how many there are, and how they act as one program."""

import logging
import os
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager
from typing import Any, NoReturn, TypeVar

from impactfem.system.errors import ImpactfemError, InputError

T = TypeVar("T")
_LOGGER = logging.getLogger("impactfem")  # as in `impactfem.system.log`
THREADS = "OMP_NUM_THREADS"
OPENBLAS_THREADS = ("OPENBLAS_NUM_THREADS", "GOTO_NUM_THREADS", THREADS)  # in its order
IDLE = "OPENBLAS_THREAD_TIMEOUT"
PATIENCE = 5.0  # time that a rank that failed waits for the others to fail, too [s]
# Number of ranks by the launchers of Open MPI and MPICH.
LAUNCHERS = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE")
# Of a step of Slurm or a job of Flux: by them MPI takes a process for one of the step's ranks.
STEP_PREFIXES = ("SLURM_STEPID", "SLURM_STEP_ID", "PMI_", "PMI2_", "PMIX_", "FLUX_")
# For a program of one process Open MPI starts a daemon, which it does not need here, and ends the
# program where the daemon has no network, not even the loopback.
os.environ.setdefault("OMPI_MCA_ess_singleton_isolated", "1")
# PETSc would answer signals by its own report and exit code 59, also that of an output that is
# closed (`| head`), which Python ignores.
if "-no_signal_handler" not in (petsc := os.environ.get("PETSC_OPTIONS", "")):
    os.environ["PETSC_OPTIONS"] = f"-no_signal_handler {petsc}".strip()
_alone = False  # whether this process acts as a program of one


@contextmanager
def alone() -> Iterator[None]:
    """Act as the only rank while the block runs, under `mpirun` too. Not collective."""
    global _alone
    before, _alone = _alone, True
    try:
        yield
    finally:
        _alone = before


def acts_alone() -> bool:
    """Return whether this process is in a block of `alone`."""
    return _alone


class OtherRankError(ImpactfemError):
    """An error on the other ranks where rank 0 failed; it has no message."""

    def __init__(self, exit_code: int) -> None:
        super().__init__("")
        self.exit_code = exit_code


def settle_threads() -> None:
    """Set how the threads of OpenBLAS wait, and how many a rank has, unless the user has set it.

    OpenBLAS reads both when it is loaded, and it is loaded twice: by NumPy's wheel, and by PETSc
    and SciPy from Debian. An idle thread polls for 2^26 cycles, 26 ms, and those of the two copies
    hand one core to each other, millions of times a minute. After 2^4 cycles, the least that
    OpenBLAS takes, it sleeps. Call it before NumPy is imported.
    """
    if IDLE not in os.environ:
        os.environ[IDLE] = "4"
        if "numpy" in sys.modules:
            _polling.update(copy.filepath for copy in openblas())
    if launched() > 1 and not any(name in os.environ for name in OPENBLAS_THREADS):
        os.environ[THREADS] = "1"


_polling: set[str] = set()  # files of the OpenBLAS that were loaded before IDLE was set


def _number(*names: str) -> int:
    """Return the first of these variables that holds a number; 1 where none does."""
    sizes = [os.environ.get(name, "") for name in names]
    return next((int(size) for size in sizes if size.isdigit()), 1)


def _in_shell() -> bool:
    """Return whether this process runs in a shell of `srun --pty`."""
    return "SLURM_PTY_PORT" in os.environ


def launched() -> int:
    """Return the number of ranks by the environment of the launcher, without MPI."""
    sizes = [_number(name) for name in LAUNCHERS]
    # Slurm sets the number of tasks for a script of one process, too.
    if "PMIX_RANK" in os.environ and not _in_shell():
        sizes.append(_number("SLURM_STEP_NUM_TASKS", "SLURM_NTASKS"))
    return max(sizes)


def act_alone_in_a_step() -> None:
    """Hide the step of Slurm or Flux, in which this process is no rank, from MPI.

    In a shell of `srun --pty bash` there is no server of ranks: Open MPI 4 would end the process,
    and Open MPI 5 would crash. Call it before MPI is started.
    """
    if launched() == 1 and "OMPI_COMM_WORLD_SIZE" not in os.environ:
        for name in [name for name in os.environ if name.startswith(STEP_PREFIXES)]:
            del os.environ[name]


def warn_of_separate_tasks() -> None:
    """Warn where `srun` started several tasks that MPI does not connect."""
    tasks = _number("SLURM_STEP_NUM_TASKS")
    first = os.environ.get("SLURM_PROCID", "0") == "0"
    if tasks > 1 and first and launched() == 1 and not _in_shell():
        _LOGGER.warning(
            "warning: srun started %d tasks, and MPI connects none of them. Each task runs alone: "
            "together they do not compute faster, and one folder of results takes one task. For "
            "one run over %d ranks type 'srun --mpi=pmix' or 'mpirun -n %d'",
            tasks,
            tasks,
            tasks,
        )


def openblas() -> list[Any]:
    """Return the copies of OpenBLAS in this process: of NumPy, and of SciPy and PETSc."""
    from threadpoolctl import ThreadpoolController

    copies: list[Any] = ThreadpoolController().select(internal_api="openblas").lib_controllers
    return copies


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let OpenBLAS compute with one thread while the block runs, but in `all_blas_threads`.

    Most of a run is many small products, for which a second thread gains nothing, or loses where
    another program keeps its core busy.
    """
    if _held:
        yield
        return
    import scipy.linalg.blas  # noqa: F401 - loads both copies; PETSc may come later

    copies = openblas()
    before = [copy.get_num_threads() for copy in copies]
    # A copy that was loaded before `settle_threads`, as NumPy's in a notebook, would poll.
    _held.extend(
        (copy, 1 if copy.filepath in _polling else count)
        for copy, count in zip(copies, before, strict=True)
    )
    try:
        with _blas_threads([(copy, 1) for copy in copies]):
            yield
    finally:
        _held.clear()


@contextmanager
def all_blas_threads() -> Iterator[None]:
    """Give OpenBLAS all threads again within a block of `one_blas_thread`.

    With two cores a factorisation gains a seventh of its time, the orthogonalisation of a block of
    vectors a quarter, the product of large full matrices a half.
    """
    with _blas_threads(_held):
        yield


_held: list[tuple[Any, int]] = []  # copies that `one_blas_thread` holds, and their full number


@contextmanager
def _blas_threads(counts: list[tuple[Any, int]]) -> Iterator[None]:
    before = [(copy, copy.get_num_threads()) for copy, _ in counts]
    try:
        for copy, count in counts:
            copy.set_num_threads(count)
        yield
    finally:
        for copy, count in before:
            copy.set_num_threads(count)


def threads() -> int:
    """Return OMP_NUM_THREADS where it is a number, else the processors of this process."""
    count = os.environ.get(THREADS, "")
    return max(1, int(count)) if count.isdigit() else len(os.sched_getaffinity(0))


def world() -> Any | None:
    """Return the communicator of all ranks under `mpirun`; None in one process."""
    if _alone or launched() == 1:
        return None
    from mpi4py import MPI

    return MPI.COMM_WORLD if MPI.COMM_WORLD.size > 1 else None


def communicator() -> Any:
    """Return the communicator of all ranks under `mpirun`, else of this process alone."""
    from mpi4py import MPI

    return world() or MPI.COMM_SELF


def start_solvers() -> None:
    """Start PETSc and SLEPc on all ranks together, before one works alone. Collective."""
    if world() is not None:
        from slepc4py import SLEPc  # noqa: F401


def rank() -> int:
    """Return the rank of this process; 0 in a program of one process."""
    comm = world()
    return 0 if comm is None else int(comm.rank)


def size() -> int:
    """Return the number of ranks."""
    comm = world()
    return 1 if comm is None else int(comm.size)


def on_root(action: Callable[[], T]) -> T:
    """Run an action on rank 0 and return its result, pickled, on all ranks. Collective.

    ImpactfemError of the action on rank 0; `OtherRankError` on the others.
    """
    comm = world()
    if comm is None:
        return action()
    failure: BaseException | None = None
    result: Any = None
    if comm.rank == 0:
        try:
            result = action()
        except ImpactfemError as error:
            failure = error
    code = comm.bcast(None if failure is None else exit_code(failure), root=0)
    if failure is not None:
        raise failure
    if code is not None:
        raise OtherRankError(code)
    return comm.bcast(result, root=0)  # type: ignore[no-any-return]


def total(amount: float | None) -> float | None:
    """Sum an amount over all ranks; None when one of them has None. Collective."""
    comm = world()
    amounts = [amount] if comm is None else comm.allgather(amount)
    return None if None in amounts else float(sum(amounts))


def all_stop() -> bool:
    """Wait for all ranks, up to `PATIENCE`; they all come where all have the same error."""
    comm = world()
    if comm is None:
        return True
    arrived = comm.Ibarrier()
    last = time.monotonic() + PATIENCE
    while not arrived.Test():
        if time.monotonic() > last:
            return False
        time.sleep(0.05)
    return True


def abort(code: int) -> NoReturn:
    """End all ranks at once: others may wait for this one in a collective call for ever."""
    sys.stdout.flush()
    sys.stderr.flush()
    comm = world()
    if comm is not None:
        comm.Abort(code)
    raise SystemExit(code)


def exit_code(error: BaseException) -> int:
    """Return the exit code of a failure: 2 for an invalid input, else 1."""
    if isinstance(error, OtherRankError):
        return error.exit_code
    return 2 if isinstance(error, InputError) else 1


@contextmanager
def meanwhile(work: Callable[[], T]) -> Iterator[Callable[[], T]]:
    """Work in a second thread while the block runs, where a second core is for this process.

    Where there is none, and on several ranks, the work is done before: MPI may be used by one
    thread alone, so the block is not to use it on one rank either. The work holds Python's lock
    rarely. Yields a function that waits for the work, and returns its result or raises its error.
    """
    if world() is not None or threads() == 1:
        result = work()
        yield lambda: result
    else:
        with ThreadPoolExecutor(1) as thread:
            future = thread.submit(work)
            try:
                yield future.result
                wait([future])
            finally:
                # Once more where a signal stops the program while it waits: on its way out the
                # program frees what the work uses.
                wait([future])
