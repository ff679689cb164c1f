"""Threads, processes and ranks acting as one program."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import psutil
import pytest

from impactfem.system import parallel
from impactfem.system.errors import Fault, ImpactfemError, InputError
from impactfem.system.executor import workers

RANKS = """
import sys
from impactfem.system.errors import (Fault, InputError)
from impactfem.system.executor import (workers)
from impactfem.system.parallel import (exit_code, on_root, rank, size)

assert on_root(lambda: 40 + rank()) == 40 and size() == int(sys.argv[1])
try:
    on_root(lambda: (_ for _ in ()).throw(InputError([Fault("file", "key", 1, "two")])))
except Exception as error:
    assert exit_code(error) == 2 and (str(error) != "") == (rank() == 0)
else:
    raise SystemExit(3)
with workers() as executor:
    if executor is not None:
        print(sorted(executor.map(abs, [-3, 1, -2])))
"""


def test_threads(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    assert parallel.threads() == 3
    monkeypatch.setenv("OMP_NUM_THREADS", "many")
    assert parallel.threads() == len(os.sched_getaffinity(0))


@pytest.mark.parametrize("count", [1, 2])
def test_work_meanwhile(monkeypatch, count):
    monkeypatch.setenv("OMP_NUM_THREADS", str(count))
    with parallel.meanwhile(threading.current_thread) as thread:
        here = threading.current_thread()
    assert (thread() is here) == (count == 1)


def test_a_signal_while_it_waits_for_work(monkeypatch):
    """The work is done before what it uses is freed, though the wait for it is left."""
    monkeypatch.setattr(parallel, "threads", lambda: 2)
    done, ended = [], []

    class Stop(BaseException):
        pass

    def stop(*_):
        ended.append(list(done))
        raise Stop

    def work():
        time.sleep(0.2)  # so that the main thread waits
        signal.pthread_kill(threading.main_thread().ident, signal.SIGUSR1)
        time.sleep(0.2)
        done.append(True)

    before = signal.signal(signal.SIGUSR1, stop)
    try:
        with pytest.raises(Stop), parallel.meanwhile(work):
            pass
        assert (ended, done) == ([[]], [True])
    finally:
        signal.signal(signal.SIGUSR1, before)


def test_an_error_meanwhile(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    with parallel.meanwhile(lambda: 1 // 0) as result:
        pass
    with pytest.raises(ZeroDivisionError):
        result()


SETTLED = """
import json, os, sys
{first}
import impactfem
early = "numpy" in sys.modules
import scipy.linalg
from impactfem.system.parallel import (all_blas_threads, one_blas_thread, openblas)

def counts():
    copies = sorted(openblas(), key=lambda copy: "numpy.libs" not in copy.filepath)
    return [copy.num_threads for copy in copies]

found = [counts()]
with all_blas_threads():
    found.append(counts())
with one_blas_thread():
    found.append(counts())
    with all_blas_threads(), one_blas_thread():
        found.append(counts())
    found.append(counts())
found.append(counts())
names = ("OPENBLAS_THREAD_TIMEOUT", "OMP_NUM_THREADS")
print(json.dumps([early, [os.environ.get(name) for name in names], found]))
"""


def settled(first="", **environment):
    """What a process finds that imports the package: see `SETTLED`."""
    taken = ("OMP_", "OPENBLAS_", "GOTO_", "OMPI_COMM", "PMI", "SLURM_")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(taken)}
    words = sys.executable, "-c", SETTLED.format(first=first)
    ended = subprocess.run(words, capture_output=True, text=True, env=kept | environment)
    assert ended.returncode == 0, ended.stderr
    return json.loads(ended.stdout)


def test_idle_threads_sleep():
    """OpenBLAS reads it when it is loaded, and the package loads none. The user's value stays."""
    assert settled()[:2] == [False, ["4", None]]


@pytest.mark.parametrize(
    ("environment", "expected"),
    [
        ({"OMPI_COMM_WORLD_SIZE": "2"}, "1"),
        ({"PMI_SIZE": "4"}, "1"),
        ({"SLURM_NTASKS": "2", "PMIX_RANK": "0"}, "1"),
        ({"SLURM_NTASKS": "2"}, None),
        ({"OMPI_COMM_WORLD_SIZE": "1"}, None),
        ({"OMPI_COMM_WORLD_SIZE": "2", "OMP_NUM_THREADS": "3"}, "3"),
        ({"OMPI_COMM_WORLD_SIZE": "2", "OPENBLAS_NUM_THREADS": "3"}, None),
    ],
)
def test_a_rank_of_several_has_one_thread(monkeypatch, environment, expected):
    slurm = "SLURM_NTASKS", "SLURM_STEP_NUM_TASKS", "SLURM_PTY_PORT", "PMIX_RANK"
    for name in (*parallel.LAUNCHERS, *parallel.OPENBLAS_THREADS, *slurm):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    parallel.settle_threads()
    assert os.environ.get("OMP_NUM_THREADS") == expected


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one core: one thread everywhere")
@pytest.mark.parametrize("late", [False, True], ids=["NumPy later", "NumPy first"])
def test_threads_of_both_copies(late):
    """NumPy's wheel brings one copy, Debian another; Debian's own NumPy takes Debian's.

    What is loaded too early has one thread.
    """
    copies = 2 if Path(np.__file__).parents[1].joinpath("numpy.libs").is_dir() else 1
    one, two = [1] * copies, [2] * copies
    found = settled("import numpy" if late else "", OMP_NUM_THREADS="2")[2]
    gained = [1, 2][:copies] if late else two
    assert found == [two, two, one, gained, one, two]


STEP = {
    "SLURM_JOBID": "7",
    "SLURM_JOB_ID": "7",
    "SLURM_PROCID": "0",
    "SLURM_LOCALID": "0",
    "SLURM_NODELIST": "localhost",
    "SLURM_JOB_NODELIST": "localhost",
    "SLURM_NNODES": "1",
    "SLURM_STEPID": "0",
    "SLURM_STEP_ID": "0",
    "SLURM_STEP_NUM_TASKS": "1",
    "SLURM_NTASKS": "1",
    "SLURM_TASKS_PER_NODE": "1",
}
SHELL = {"SLURM_STEP_NUM_TASKS": "4", "SLURM_NTASKS": "4", "SLURM_PTY_PORT": "4242"}
PMIX = {
    "PMIX_RANK": "0",
    "PMIX_NAMESPACE": "slurm.pmix.7.0",
    "PMIX_GDS_MODULE": "ds21,ds12,hash",
    "PMIX_SERVER_URI2": "pmix-server.1;tcp4://127.0.0.1:9",
}
FLUX = {
    "FLUX_JOB_ID": "f7",
    "FLUX_URI": "local:///none",
    "FLUX_PMI_LIBRARY_PATH": "/none/libpmi.so",
    "PMI_RANK": "0",
    "PMI_SIZE": "1",
    "PMI_FD": "8",
}
SIZE = "from impactfem.system.parallel import communicator as c, size; print(size(), c().size)"


@pytest.mark.parametrize(
    "environment",
    [STEP | SHELL | PMIX, FLUX],
    ids=["srun --pty -n 4, PMIx", "Flux"],
)
def test_one_process_in_a_step(environment):
    """MPI would take it for a rank, and end it, or wait for others."""
    of_launchers = ("OMPI_", "PMI", "SLURM_", "FLUX_")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(of_launchers)}
    words = [sys.executable, "-c", SIZE]
    ended = subprocess.run(words, capture_output=True, text=True, env=kept | environment)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "1 1\n", "")


@pytest.fixture
def launcher(monkeypatch):
    """Set variables of a launcher, and no other ones of launchers."""

    def launched_by(**environment):
        for name in os.environ:
            if name.startswith(("OMPI_COMM", *parallel.STEP_PREFIXES, "SLURM_")):
                monkeypatch.delenv(name)
        for name, value in environment.items():
            monkeypatch.setenv(name, value)

    return launched_by


@pytest.mark.parametrize(
    ("environment", "count"),
    [
        (STEP | PMIX | {"SLURM_STEP_NUM_TASKS": "4", "SLURM_NTASKS": "4"}, 4),
        (STEP | PMIX | {"SLURM_NTASKS": "8"}, 1),
        (STEP | {"OMPI_COMM_WORLD_SIZE": "2", "PMIX_RANK": "1"}, 2),
        (STEP | SHELL | PMIX, 1),
        ({"PMI_SIZE": "3", "PMI_RANK": "0", "PMI_FD": "8"}, 3),
    ],
    ids=["srun --mpi=pmix -n 4", "srun -n 1 in a job", "mpirun in a job", "shell", "Hydra"],
)
def test_ranks_of_a_launcher(launcher, environment, count):
    """Ranks keep the variables by which MPI connects them."""
    launcher(**environment)
    assert parallel.launched() == count
    parallel.act_alone_in_a_step()
    assert parallel.launched() == count
    if count > 1:
        assert all(os.environ[name] == value for name, value in environment.items())


@pytest.mark.parametrize(
    ("environment", "count"),
    [
        (STEP | {"SLURM_STEP_NUM_TASKS": "4"}, 1),
        (STEP | {"SLURM_STEP_NUM_TASKS": "4", "SLURM_PROCID": "2"}, 0),
        (STEP, 0),
        (STEP | SHELL, 0),
        (STEP | PMIX | {"SLURM_STEP_NUM_TASKS": "4"}, 0),
        (STEP | {"SLURM_STEP_NUM_TASKS": "4", "OMPI_COMM_WORLD_SIZE": "4"}, 0),
    ],
    ids=["tasks", "another task", "one task", "shell", "PMIx", "mpirun"],
)
def test_tasks_that_nothing_connects_are_told(launcher, caplog, environment, count):
    launcher(**environment)
    parallel.warn_of_separate_tasks()
    assert caplog.text.count("srun started 4 tasks") == count


def test_one_process(monkeypatch):
    for name in parallel.LAUNCHERS:
        monkeypatch.delenv(name, raising=False)
    assert parallel.world() is None and parallel.rank() == 0 and parallel.size() == 1
    assert parallel.on_root(lambda: 7) == 7
    with pytest.raises(ImpactfemError, match="said here"):
        parallel.on_root(lambda: (_ for _ in ()).throw(ImpactfemError("said here")))


def test_exit_codes():
    assert parallel.exit_code(InputError([Fault("f", "k", 1, "x")])) == 2
    assert parallel.exit_code(ImpactfemError("x")) == 1
    assert parallel.exit_code(parallel.OtherRankError(2)) == 2


def test_workers_of_one_process(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    with workers() as executor:
        assert list(executor.map(abs, [-1, 2, -3])) == [1, 2, 3]
        assert list(executor.map(os.getenv, ["OMP_NUM_THREADS"])) == ["1"]
        assert os.environ["OMP_NUM_THREADS"] == "2"  # this process may use both
    with workers(1) as executor:
        assert len(set(executor.map(eval, ["__import__('os').getpid()"] * 4))) == 1


def test_a_failed_block_leaves_no_thread_that_writes_arguments():
    arguments = bytes(10**7)  # more than a pipe holds
    with pytest.raises(InputError), workers(1) as pool:
        pool.submit(time.sleep, 60)
        for _ in range(3):
            pool.submit(len, arguments)
        time.sleep(1)
        raise InputError([])
    writers = [one for one in threading.enumerate() if one.name == "QueueFeederThread"]
    for one in writers:
        one.join(30)
    assert not any(one.is_alive() for one in writers)


def test_ranks(under_mpirun, tmp_path):
    script = tmp_path / "ranks.py"
    script.write_text(RANKS, encoding="utf-8")
    ended = under_mpirun(2, sys.executable, "-m", "mpi4py", script, 2)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.split("\n")[0] == "[1, 2, 3]"


WORK = """
from impactfem.system.executor import (workers)
from impactfem.system.parallel import (alone, communicator, on_root, rank, size, world)

def work(value):
    from petsc4py import PETSc
    with alone():
        comm = communicator()
        vector = PETSc.Vec().createMPI(3, comm=comm)
        vector.set(value)
        with workers() as executor:
            inner = list(executor.map(abs, [-1.0]))
        found = (world() is None, rank(), size(), comm.size, on_root(lambda: vector.sum()), inner)
    return *found, size()
"""
ALONE_EACH = """
from impactfem.system.executor import (workers)
from impactfem.system.parallel import (start_solvers)
from work import work

start_solvers()
with workers() as executor:
    if executor is not None:
        print(list(executor.map(work, [1.0, 2.0])))
"""


def test_ranks_that_act_alone(under_mpirun, tmp_path):
    """PETSc starts on all of three ranks; then each of two works with a communicator of its own."""
    (tmp_path / "work.py").write_text(WORK, encoding="utf-8")
    script = tmp_path / "each.py"
    script.write_text(ALONE_EACH, encoding="utf-8")
    ended = under_mpirun(3, sys.executable, "-m", "mpi4py", script)
    assert ended.returncode == 0, ended.stderr
    rows = [(True, 0, 1, 1, 3.0 * value, [1.0], 3) for value in (1.0, 2.0)]
    assert ended.stdout.split("\n")[0] == str(rows)


def test_alone_in_one_process(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "3")  # not asked in the block
    with parallel.alone():
        with parallel.alone():
            assert parallel.world() is None
        assert parallel.world() is None and parallel.size() == 1
        with workers() as executor:
            assert list(executor.map(lambda value: (value, os.getpid()), [5])) == [(5, os.getpid())]


ALONE = """
import sys
from mpi4py import MPI
from petsc4py import PETSc
from impactfem import (cli)
from impactfem.run import loop
from impactfem.system import parallel
from impactfem.system.errors import (SolutionError)

def run(*_, **__):
    if MPI.COMM_WORLD.rank == 1:
        raise SolutionError("here")
    MPI.COMM_WORLD.barrier()

loop.run, parallel.PATIENCE = run, 1.0
sys.argv = ["impactfem", "run", "any.toml"]
cli.main()
"""


def test_a_rank_that_fails_ends_the_others(under_mpirun, tmp_path):
    """Rank 0 waits in a barrier and would wait for ever without an abort."""
    script = tmp_path / "alone.py"
    script.write_text(ALONE, encoding="utf-8")
    ended = under_mpirun(2, sys.executable, script)
    assert ended.returncode == 1 and ended.stderr.count("error: here") == 1


WORKER = """
import ctypes, os, sys, time
from impactfem.system.executor import (in_own_process, workers)

def work(kind):
    print(os.getpid(), flush=True)
    if kind == "below":
        in_own_process(work, "busy")
    elif kind == "busy":
        ctypes.PyDLL(None).sleep(10000)  # keeps Python's lock, as a library may
    else:
        time.sleep(10000.0)

if __name__ == "__main__":
    with workers(1) as executor:
        for _ in range(3):
            waiting = executor.submit(work, sys.argv[1])
        waiting.result()
"""


@pytest.fixture
def parent(request, tmp_path, interruptible):
    """A program that waits for a worker, and the number of that worker."""
    (tmp_path / "program.py").write_text(WORKER, encoding="utf-8")
    with subprocess.Popen(
        [sys.executable, "program.py", request.param],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as program:
        yield program, int(program.stdout.readline())


def ends(process):
    """Wait until a process has ended; its parent, which is gone, does not wait for it."""
    last = time.monotonic() + 300.0
    with suppress(psutil.NoSuchProcess):
        while psutil.Process(process).status() not in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD):
            assert time.monotonic() < last
            time.sleep(0.05)


@pytest.mark.parametrize("parent", ["busy", "below"], indirect=True)
def test_a_worker_ends_with_its_parent(parent):
    """It would write into a folder that another run may use by then."""
    program, worker = parent
    below = [child.pid for child in psutil.Process(worker).children(recursive=True)]
    program.kill()
    program.wait(timeout=600)
    for process in (worker, *below):
        ends(process)


@pytest.mark.parametrize("parent", ["idle"], indirect=True)
def test_an_interrupted_program_waits_for_no_worker(parent):
    program, worker = parent
    os.killpg(program.pid, signal.SIGINT)  # as Ctrl-C does: the worker gets it, too
    said = program.communicate(timeout=600)[1]
    assert program.returncode == -signal.SIGINT
    assert said.count("Traceback") == 1 and said.endswith("KeyboardInterrupt\n")
    with pytest.raises(ProcessLookupError):
        os.kill(worker, 0)


def test_one_process_needs_no_network():
    """Not even the loopback, which a new network namespace has down."""
    code = "from impactfem.system.parallel import communicator; print(communicator().size)"
    apart = ["unshare", "--net"]
    if subprocess.run([*apart, "true"], capture_output=True).returncode != 0:
        pytest.skip("no network namespace may be made here")
    words = [*apart, sys.executable, "-c", code]
    ended = subprocess.run(words, capture_output=True, text=True)
    assert (ended.returncode, ended.stdout) == (0, "1\n"), ended.stderr
