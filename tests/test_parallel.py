"""Threads, processes and ranks acting as one program."""

import os
import shutil
import subprocess
import sys

import pytest

from impactfem import parallel
from impactfem.errors import Fault, ImpactfemError, InputError

RANKS = """
import sys
from impactfem.errors import Fault, InputError
from impactfem.parallel import exit_code, on_root, rank, size, workers

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
    with parallel.workers() as executor:
        assert list(executor.map(abs, [-1, 2, -3])) == [1, 2, 3]
        assert list(executor.map(os.getenv, ["OMP_NUM_THREADS"])) == ["1"]
    assert os.environ["OMP_NUM_THREADS"] == "2"


@pytest.mark.parametrize("ranks", [2, 3])
def test_ranks(ranks, tmp_path):
    mpirun = shutil.which("mpirun")
    assert mpirun is not None, "Debian's python3-mpi4py brings mpirun"
    script = tmp_path / "ranks.py"
    script.write_text(RANKS, encoding="utf-8")
    environment = {
        **{k: v for k, v in os.environ.items() if not k.startswith("OMPI_COMM")},
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
        "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
        "OMP_NUM_THREADS": "1",
    }
    ended = subprocess.run(
        [mpirun, "-n", str(ranks), sys.executable, "-m", "mpi4py", str(script), str(ranks)],
        capture_output=True,
        text=True,
        env=environment,
        timeout=120,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.split("\n")[0] == "[1, 2, 3]"
