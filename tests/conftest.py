"""A small case, a finished run of it, and what keeps one test out of another."""

import fcntl
import logging
import os
import pickle
import runpy
import shutil
import signal
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from impactfem.case.template import write_new_case
from impactfem.run import loop
from kept_meshes import keep_meshes, start_gmsh
from no_pictures import no_pictures

RANKS = Path(__file__).with_name("ranks.py")
ASLEEP = """
#include <time.h>
int sched_yield(void) { return nanosleep(&(struct timespec){0, 20000}, 0); }
"""
"""In place of the C library's: a rank that waits sleeps for 20 µs and does not yield."""
# The template, shorter and coarser, with strong motion and hard impacts: one lasts some 20 steps.
SMALL = (
    ('pga = "1.2 m/s2"', 'pga = "3 m/s2"'),
    ('ground_acceleration = "1.2 m/s2"', 'ground_acceleration = "3 m/s2"'),
    (
        'type = "hunt-crossley"\nstiffness = "2.75e9 N/m^1.5"',
        'type = "kelvin-voigt"\nstiffness = "1.2e10 N/m"',
    ),
    ('relation = "exact"', '# relation = "exact"'),
    ('title = "Two three-storey buildings, 2 cm apart"', 'title = "Deux bâtiments, 2 cm"'),
    ("# published = ", "published = "),
    ("# compressive_strength", "compressive_strength"),
    ("# bearing_area", "bearing_area"),
    ('duration = "10 s"\ntime_step = "5 ms"', 'duration = "3 s"\ntime_step = "5 ms"'),
    ('strong_phase = ["2 s", "6 s"]', 'strong_phase = ["0.5 s", "2.5 s"]'),
    ('time_step = "0.25 ms"', 'time_step = "0.5 ms"'),
    ('damping = ["2 %", "5 %"]', 'damping = ["5 %"]'),
    ('maximum = "200 Hz", per_decade = 50', 'maximum = "50 Hz", per_decade = 10'),
)
PUBLISHED = (
    "name,value,unit,source\nmotion.pga,300,cm/s2,nowhere\nfrs.floor_3.pfa,40,m/s2,nowhere\n"
)


# pytest's `caplog` listens to the root logger.
logging.getLogger("impactfem").propagate = True
# No test may depend on how fast the machine is.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")


def pytest_configure(config):
    # Debian's h5py and netCDF4 on the NumPy 1.26 of the virtual environment.
    config.addinivalue_line("filterwarnings", "ignore:`product` is deprecated:DeprecationWarning")
    config.addinivalue_line("filterwarnings", "ignore:numpy.ndarray size changed:RuntimeWarning")


def pytest_collection_modifyitems(items):
    """Files with slow tests last; of these those first that take longest.

    They are those that start `mpirun`, and then those with many slow tests, or with slower ones,
    `slow(10)`: a worker that is at one of them when no others are left keeps everybody waiting.
    """
    slow = Counter[Path]()
    for item in items:
        if (marker := item.get_closest_marker("slow")) is not None:
            slow[item.path] += next(iter(marker.args), 1)
    on_ranks = {item.path for item in items if "under_mpirun" in item.fixturenames}
    items.sort(key=lambda item: (item.path in slow, item.path not in on_ranks, -slow[item.path]))


@dataclass(frozen=True)
class Finished:
    """A run that is not to be changed."""

    case: Path
    run: loop.Record

    @property
    def folder(self):
        return self.run.folder


@pytest.fixture(scope="session")
def edited():
    """Replace texts in a file; a text that is not there is an error of the test."""

    def edit(path, *changes):
        text = path.read_text(encoding="utf-8")
        for old, new in changes:
            if old not in text:
                raise ValueError(f"{old!r} is not in {path.name}: the test does not test")
            text = text.replace(old, new)
        path.write_text(text, encoding="utf-8")
        return path

    return edit


@pytest.fixture(scope="session")
def new_case(edited):
    """Write the small case into a folder, with texts replaced, and give its path."""

    def make(folder, *changes, name="small"):
        path, _ = write_new_case(folder / name)
        (folder / f"{name}_published.csv").write_text(PUBLISHED, encoding="utf-8")
        return edited(path, *SMALL, *changes)

    return make


@pytest.fixture(scope="session")
def with_record(new_case):
    """As `new_case`, with the record `record.csv` beside it in place of the synthetic motion."""

    def make(folder, record, options="", **names):
        path = new_case(folder, **names)
        content = record.encode() if isinstance(record, str) else record
        (folder / "record.csv").write_bytes(content)
        text = path.read_text(encoding="utf-8")
        start, end = text.index("[[motions]]"), text.index("# Laws of")
        motion = '[[motions]]\ndirection = "y"\ntype = "record"\nfile = "record.csv"\n'
        path.write_text(f"{text[:start]}{motion}{options}\n{text[end:]}", encoding="utf-8")
        return path

    return make


@pytest.fixture(scope="session")
def sine():
    """A record: 2 s of 3 m/s2 at 1.5 Hz."""
    time = 0.01 * np.arange(201)
    rows = zip(time, 3.0 * np.sin(3.0 * np.pi * time), strict=True)
    return "time [s],acceleration [m/s2]\n" + "".join(f"{t:.2f},{a:.6f}\n" for t, a in rows)


@pytest.fixture(scope="session")
def finished(new_case, tmp_path_factory):
    """The small case, run with everything; not to be changed."""
    folder = tmp_path_factory.mktemp("finished")
    case = new_case(folder)
    return Finished(case, loop.run(case, out=folder / "run"))


@pytest.fixture
def copied(finished, tmp_path):
    """A copy of the finished case in `tmp_path`, its run in `run` beside it; gives the case."""
    shutil.copytree(finished.case.parent, tmp_path, dirs_exist_ok=True)
    return tmp_path / finished.case.name


@pytest.fixture
def no_figures(monkeypatch):
    """Runs without figures, which take most of the time."""
    no_pictures(monkeypatch)


@pytest.fixture(scope="session", autouse=True)
def _meshes_kept():
    with pytest.MonkeyPatch.context() as patch:
        keep_meshes(patch)
        yield


@pytest.fixture
def gmsh_each_time(monkeypatch):
    """Meshes are generated and read anew, for tests of gmsh itself."""
    start_gmsh(monkeypatch)


@pytest.fixture(scope="session")
def under_mpirun(tmp_path_factory):
    """Run a command on some ranks, which may be more than there are processors.

    One at a time, whatever the other workers do: Open MPI 4 loses the output of every tenth job, or
    more, where several `mpirun` start at once. Ranks are not bound to cores, as another worker may
    use theirs. Where there are more ranks and other workers than cores, a rank that waits sleeps:
    after yielding to a busy process, it would wait long for its next turn. Fewer ranks poll, which
    is faster.
    """
    mpirun = shutil.which("mpirun")
    if mpirun is None:
        raise FileNotFoundError("mpirun: Debian's python3-mpi4py brings it")
    lock = tmp_path_factory.getbasetemp().parent / "mpirun.lock"  # of all workers
    asleep = tmp_path_factory.mktemp("mpirun") / "asleep.so"
    compile_it = ["cc", "-shared", "-fPIC", "-x", "c", "-", "-o", str(asleep)]  # FEniCSx needs cc
    subprocess.run(compile_it, input=ASLEEP, text=True, check=True)
    environment = {
        # A process that has started MPI by itself leaves there what keeps `mpirun` from starting.
        **{k: v for k, v in os.environ.items() if not k.startswith(("OMPI_", "ORTE_", "PMIX_"))},
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
        "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
        "OMPI_MCA_hwloc_base_binding_policy": "none",
        "PRTE_MCA_hwloc_default_binding_policy": "none",
        "OMP_NUM_THREADS": "1",
    }

    def run(ranks, *words):
        command = [mpirun, "-n", str(ranks), *map(str, words)]
        others = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")) - 1
        crowded = ranks + others > len(os.sched_getaffinity(0))
        waiting = {"LD_PRELOAD": str(asleep)} if crowded else {}
        with lock.open("w") as held:
            fcntl.flock(held, fcntl.LOCK_EX)
            return subprocess.run(
                command,
                capture_output=True,
                text=True,
                env=environment | waiting,
                timeout=600,
                check=False,
            )

    return run


@pytest.fixture(scope="session")
def on_ranks(under_mpirun, tmp_path_factory):
    """`results(**given)` of a script by number of ranks, each called once; see ranks.py.

    One rank is this process: MPI and dolfinx need no second start.
    """

    def of(script, **given):
        folder, made = tmp_path_factory.mktemp("ranks"), {}
        content = pickle.dumps(given)
        (folder / "given").write_bytes(content)

        def run(ranks):
            if ranks == 1 and ranks not in made:
                made[ranks] = runpy.run_path(str(script))["results"](**pickle.loads(content))
            elif ranks not in made:
                files = folder / "given", folder / str(ranks)
                ended = under_mpirun(ranks, sys.executable, RANKS, script, *files)
                assert ended.returncode == 0, ended.stderr
                made[ranks] = pickle.loads(files[1].read_bytes())
            return made[ranks]

        return run

    return of


@pytest.fixture
def interruptible():
    """Ctrl-C counts, here and in new processes: a shell has jobs in the background ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(autouse=True)
def _log_left_alone():
    """Put the program's logger back as it was."""
    logger = logging.getLogger("impactfem")
    handlers, level, propagate = list(logger.handlers), logger.level, logger.propagate
    yield
    for handler in logger.handlers:
        if handler not in handlers:
            handler.close()
    logger.handlers[:] = handlers
    logger.setLevel(level)
    logger.propagate = propagate
