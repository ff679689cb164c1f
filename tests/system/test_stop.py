"""A stop by a signal: in one process and of one rank of several."""

import signal
import subprocess
import sys
import time
from contextlib import suppress

import psutil
import pytest

from impactfem.run.folder import open_folder
from impactfem.system.errors import InputError

SETTING = """
import os, signal, sys, time
from impactfem import (cli)
from impactfem.system.log import (Steps)

class Importing:
    def find_spec(self, name, path, target=None):
        if name == "impactfem.run.check":
            os.kill(os.getpid(), signal.SIGTERM)

class Going:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGTERM)  # what is raised here, Python leaves out

def lost(*_, **__):
    Going()
    with Steps({"a": 1.0}) as steps, steps.step("a"):
        time.sleep(600.0)

def wrapped(*_, **__):
    try:
        os.kill(os.getpid(), signal.SIGTERM)
    except BaseException as stop:
        raise ValueError("of a library") from stop

"""


def ended(*words):
    """A program that has ended: exit code, standard output and standard error."""
    done = subprocess.run([*words], capture_output=True, text=True, check=False, timeout=500)
    return done.returncode, done.stdout, done.stderr


IMPORTING = "sys.meta_path.insert(0, Importing())\n"
IN_CHECK = "from impactfem.run import check; check.checked = {function}\n"


@pytest.mark.parametrize(
    "how",
    [IMPORTING, IN_CHECK.format(function="lost"), IN_CHECK.format(function="wrapped")],
    ids=["in an import", "lost in a destructor", "made another error"],
)
def test_a_signal_that_a_library_loses_stops_the_next_step(tmp_path, how):
    script = tmp_path / "script.py"
    script.write_text(f"{SETTING}{how}cli.main()\n", encoding="utf-8")
    code, out, errors = ended(sys.executable, script, "check", "case.toml")
    assert (code, out) == (128 + signal.SIGTERM, "")
    assert errors.endswith("terminated\n")


PIPE = """
{library}
status = open("/proc/self/status").read()
print(int(status.partition("SigIgn:")[2].split()[0], 16) >> 12 & 1)
"""


@pytest.mark.parametrize(
    ("library", "ignored"),
    [("import impactfem.dynamics.modes", 1), ("from petsc4py import PETSc", 0)],
    ids=["with PETSc", "PETSc alone"],
)
def test_an_output_that_is_closed_is_no_crash(monkeypatch, library, ignored):
    """`impactfem check CASE.toml | head -1`: Python ignores SIGPIPE, and PETSc would abort."""
    monkeypatch.delenv("PETSC_OPTIONS", raising=False)
    assert ended(sys.executable, "-c", PIPE.format(library=library)) == (0, f"{ignored}\n", "")


BACKGROUND = """
def interrupted(*_, **__):
    os.kill(os.getpid(), signal.SIGINT)
    print("not interrupted", flush=True)
    os.kill(os.getpid(), signal.SIGTERM)
"""


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize(
    ("trap", "expected"),
    [
        ("", (128 + signal.SIGINT, "", "interrupted\n")),
        ("trap '' INT;", (128 + signal.SIGTERM, "not interrupted\n", "terminated\n")),
    ],
    ids=["foreground", "background"],
)
def test_a_job_in_the_background_is_not_interrupted(tmp_path, trap, expected):
    """A shell has it ignore SIGINT, so that a Ctrl-C at another program of the terminal spares it.

    SIGTERM, which is meant for it, still ends it.
    """
    script = tmp_path / "script.py"
    how = IN_CHECK.format(function="interrupted")
    script.write_text(f"{SETTING}{BACKGROUND}{how}cli.main()\n", encoding="utf-8")
    shell = "/bin/sh", "-c", f'{trap} exec "$@"', "sh"
    assert ended(*shell, sys.executable, script, "check", "case.toml") == expected


STOPPING = """
import os, signal, sys, time
from impactfem.system.stop import signals_answered

with signals_answered():
    os.kill(os.getpid(), signal.Signals[sys.argv[1]])
    print("not stopped", flush=True)
    os.kill(os.getpid(), signal.SIGTERM)
"""
OTHERS = ["SIGHUP", "SIGXCPU"]


@pytest.mark.parametrize("name", OTHERS)
def test_other_signals_stop_the_program(name):
    """Of a terminal that is closed, and of batch schedulers."""
    code, out, errors = ended(sys.executable, "-c", STOPPING, name)
    assert (code, out) == (128 + signal.Signals[name], "")
    assert errors.count("\n") == 1 and name in errors


@pytest.mark.parametrize("name", OTHERS)
def test_an_ignored_signal_stays_ignored(name):
    """`nohup` has SIGHUP ignored."""
    shell = "/bin/sh", "-c", f"trap '' {name.removeprefix('SIG')}; exec \"$@\"", "sh"
    found = ended(*shell, sys.executable, "-c", STOPPING, name)
    assert found == (128 + signal.SIGTERM, "not stopped\n", "terminated\n")


RANKS = """
import os, signal, sys, threading, time
from contextlib import ExitStack
from mpi4py import MPI
from petsc4py import PETSc
from impactfem import (cli)
from impactfem.run import loop
from impactfem.system.log import (LOGGER, mirrored)
from impactfem.run.folder import (open_folder)

comm = MPI.COMM_WORLD
stopped, name, out = sys.argv[1:]

def run(case, out, **_):
    vector = PETSc.Vec().createMPI(4, comm=comm)
    with ExitStack() as opened:
        if comm.rank == 0:
            opened.enter_context(open_folder(out, False))
        opened.enter_context(mirrored(out / "run.log", comm.rank))
        LOGGER.info("begun")
        comm.Barrier()
        try:
            if str(comm.rank) in stopped:
                os.kill(os.getpid(), signal.Signals[name])
            comm.Barrier()  # for a rank that never comes
        finally:
            vector.norm()  # on all ranks together, as a factorisation goes; no thread runs then

loop.run = run
sys.argv[1:] = ["run", "case.toml", "--out", out]
cli.main()
"""


def wait_until_free(folder, patience=300.0):
    """Open MPI 5 may end before rank 0, and a busy machine has it killed before its lock goes."""
    last = time.monotonic() + patience
    while True:
        try:
            with open_folder(folder, True):
                return
        except InputError:
            if time.monotonic() > last:
                raise
        time.sleep(0.1)


def test_a_signal_ends_all_ranks(under_mpirun, tmp_path):
    """Rank 0 reports the stop; `mpirun` ends rank 1, which waits for rank 0."""
    script, out = tmp_path / "script.py", tmp_path / "run"
    script.write_text(RANKS, encoding="utf-8")
    done = under_mpirun(2, sys.executable, script, "0", "SIGTERM", out)
    assert done.returncode == 128 + signal.SIGTERM
    assert done.stderr.count("terminated; run again with --resume to go on\n") == 1
    assert "Traceback" not in done.stderr and "ignored" not in done.stderr
    assert {path.name for path in out.iterdir()} <= {"run.log", ".lock"}
    wait_until_free(out)
    assert [path.name for path in out.iterdir()] == ["run.log"]
    assert (out / "run.log").read_text(encoding="utf-8").splitlines()[0].endswith(" begun")


BESIDE = """
import multiprocessing, os, signal, sys, threading, time
from impactfem.system.executor import in_own_process
from impactfem.system.parallel import meanwhile
from impactfem.system.stop import signals_answered

with signals_answered():
    try:
        with meanwhile(lambda: in_own_process(time.sleep, 600.0)) as slept:
            while not (children := multiprocessing.active_children()):
                time.sleep(0.01)
            print(children[0].pid, flush=True)
            if sys.argv[1] == "in the block":
                os.kill(os.getpid(), signal.SIGTERM)
            threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGTERM)).start()
        slept()
    finally:
        print("unwound", flush=True)
"""


@pytest.mark.parametrize("when", ["in the block", "at its end"])
def test_a_process_that_a_thread_waits_for_is_ended(tmp_path, monkeypatch, when):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    script = tmp_path / "script.py"
    script.write_text(BESIDE, encoding="utf-8")
    code, out, errors = ended(sys.executable, script, when)
    assert (code, errors) == (128 + signal.SIGTERM, "terminated\n")
    child, word = out.split()
    assert word == "unwound"
    # What is killed may take a moment to go, and stays a zombie where nobody waits for it.
    last = time.monotonic() + 60.0
    with suppress(psutil.NoSuchProcess):
        while psutil.Process(int(child)).status() not in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD):
            assert time.monotonic() < last
            time.sleep(0.05)
