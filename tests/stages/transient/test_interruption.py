"""Kills and full disks while the stage writes: what is there opens, and --resume goes on."""

import logging
import resource
import shutil
import signal
from contextlib import contextmanager

import h5py
import numpy as np
import pytest
import xarray as xr

from impactfem.run import loop
from impactfem.stages.transient import export
from impactfem.system import files
from impactfem.system.errors import ImpactfemError
from impactfem.system.files import atomic

from .conftest import EARLY, SHORT, command, killed, no_pictures, write_forces

pytestmark = pytest.mark.slow
STORES = (
    "reduce.npz",
    "transient.nc",
    "transient_maps.nc",
    "transient_motion.vtkhdf",
    "transient.stage.json",
)
"""What the stage leaves, in the order in which it is written."""
CHECKPOINTS = ("rank_0_200.npz",)
"""The first of two before the last step."""


@pytest.fixture(scope="module")
def case_of(begun, edited, tmp_path_factory):
    """A short case by some solver, in a folder of its own, after the stages before."""

    def made(solver):
        folder = tmp_path_factory.mktemp(solver)
        shutil.copytree(begun, folder, dirs_exist_ok=True)
        if solver == "full":
            write_forces(folder / "forces_of_another.csv", starts=EARLY)
            asked = f'solver = "full"\nduration = "{SHORT}"\n'
        else:
            asked = f'solver = "{solver}"\nduration = "0.5 s"\n'
            asked += 'export = true\nexport_duration = "20 ms"\n'
        return edited(folder / "frame.toml", ('solver = "reduced"\n', asked))

    return made


@pytest.fixture(scope="module")
def uninterrupted(case_of):
    """The folder of a run by some solver that nothing has ended."""
    done = {}

    def made(solver):
        if solver not in done:
            case = case_of(solver)
            with pytest.MonkeyPatch.context() as patch:
                no_pictures(patch)
                loop.run(case, out=case.parent / "run", stage="transient")
            done[solver] = case.parent / "run"
        return done[solver]

    return made


@contextmanager
def full_disk(name):
    """No file of this name can be written while the block runs."""

    @contextmanager
    def limited(path):
        if path.name == name:
            resource.setrlimit(resource.RLIMIT_FSIZE, (20, resource.RLIM_INFINITY))
        try:
            with atomic(path) as temporary:
                yield temporary
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY,) * 2)

    with pytest.MonkeyPatch.context() as patch:
        for module in (files, export):
            patch.setattr(module, "atomic", limited)
        yield


def opens(path):
    """Whether a store is whole."""
    if path.suffix == ".nc":
        with xr.open_dataset(path, engine="netcdf4") as opened:
            return bool(opened.load().sizes)
    if path.suffix == ".npz":
        with np.load(path) as opened:
            return all(opened[name] is not None for name in opened)
    if path.suffix == ".vtkhdf":
        with h5py.File(path) as opened:
            return bool(opened["VTKHDF/PointData/acceleration"][...].any())
    return path.stat().st_size > 0


def same(one, other):
    """To the last bit; stores may differ in what they say of themselves."""
    for name in ("transient.nc", "transient_maps.nc", "transient_motion.vtkhdf"):
        first, second = one / name, other / name
        if first.exists() != second.exists():
            return False
        if not first.exists():
            continue
        if first.suffix == ".nc":
            left_one, right_one = (xr.load_dataset(k, engine="netcdf4") for k in (first, second))
            equal = left_one.equals(right_one)
        else:
            equal = first.read_bytes() == second.read_bytes()
        if not equal:
            return False
    return True


def left(folder):
    """The stores that are there; each of them opens."""
    found = [name for name in STORES if (folder / name).exists()]
    assert all(opens(folder / name) for name in found)
    return found


def test_kills(case_of, uninterrupted):
    """Each run gets farther than the one before it, and goes on from what is there."""
    case = case_of("both")
    folder = case.parent / "run"
    # The folder holds stages of a case without a solver: that one is not gone on with.
    options = ()
    for name, before, going_on in (
        ("reduce.npz", 0, ""),
        ("rank_0_200.npz", 1, ""),
        ("rank_0_400.npz", 1, ""),
        ("transient.nc", 1, "going on from 0.200 s"),
        ("transient_motion.vtkhdf", 3, "going on from 0.500 s"),
    ):
        ended = killed(name, case, *options)
        options = ("--resume",)
        assert ended.returncode == -signal.SIGKILL, (name, ended.stderr)
        assert left(folder) == list(STORES[:before]), name
        assert going_on in ended.stderr and "damaged" not in ended.stderr, name
        assert going_on or "going on" not in ended.stderr, name
        assert (folder / "transient_checkpoints").exists() == (before > 0), name
    ended = killed("-", case, "--resume")
    assert ended.returncode == 0, ended.stderr
    assert left(folder) == list(STORES) and not (folder / "transient_checkpoints").exists()
    assert same(folder, uninterrupted("both"))


def test_full_disks(case_of, uninterrupted, monkeypatch, caplog):
    """The same, with every file in turn; nothing of it stays."""
    no_pictures(monkeypatch)
    case = case_of("both")
    folder = case.parent / "run"
    names = [STORES[0], *CHECKPOINTS, *STORES[1:]]
    for name in names:
        caplog.clear()
        message = rf"cannot write .*{name}: File too large"
        with (
            caplog.at_level(logging.INFO, "impactfem"),
            full_disk(name),
            pytest.raises(ImpactfemError, match=message),
        ):
            loop.run(case, out=folder, stage="transient", resume=name != names[0])
        before = STORES.index(name) if name in STORES else 1
        assert left(folder) == list(STORES[:before])
        assert not list(folder.rglob(".*.part"))
        told = [record.getMessage() for record in caplog.records]
        assert not any("damaged" in line for line in told)
        # No checkpoint was whole before that; then that of the last step is.
        whole = names.index(name) > names.index("transient.nc")
        assert ("transient: going on from 0.500 s" in told) == whole
    loop.run(case, out=folder, stage="transient", resume=True)
    assert left(folder) == list(STORES)
    assert same(folder, uninterrupted("both"))


@pytest.mark.parametrize("name", ["transient.nc", "transient_motion.vtkhdf"])
def test_results_before(uninterrupted, tmp_path, monkeypatch, name):
    """Those of other forces are not taken for those of these, and are replaced."""
    no_pictures(monkeypatch)
    shutil.copytree(uninterrupted("both").parent, tmp_path, dirs_exist_ok=True)
    write_forces(tmp_path / "forces_of_another.csv", 5e5)
    case, folder = tmp_path / "frame.toml", tmp_path / "run"
    with full_disk(name), pytest.raises(ImpactfemError, match=f"cannot write .*{name}"):
        loop.run(case, out=folder, stage="transient")
    first = xr.load_dataset(folder / "transient.nc", engine="netcdf4")
    assert not (folder / "transient_motion.vtkhdf").exists()
    done = loop.run(case, out=folder, stage="transient")
    assert done.reused == ["building", "reduce", "pounding"]
    second = xr.load_dataset(folder / "transient.nc", engine="netcdf4")
    assert first.equals(second) == (name != "transient.nc")
    assert not same(folder, uninterrupted("both"))


def test_full_solver_goes_on_after_a_kill_of_one_rank(case_of, uninterrupted, under_mpirun):
    """On two ranks to 1e-9 of an uninterrupted run on two: MUMPS rounds differently each time."""
    cases = {name: case_of("full") for name in ("killed", "whole")}
    ended = under_mpirun(2, *command("rank_0_250.npz", cases["killed"]))
    assert ended.returncode != 0 and not (cases["killed"].parent / "run" / "transient.nc").exists()
    found = {}
    for name, case in cases.items():
        ended = under_mpirun(2, *command("-", case, *["--resume"][: name == "killed"]))
        assert ended.returncode == 0, ended.stderr
        assert ("going on from 0.200 s" in ended.stderr) == (name == "killed")
        found[name] = xr.load_dataset(case.parent / "run" / "transient.nc", engine="netcdf4")
    one = xr.load_dataset(uninterrupted("full") / "transient.nc", engine="netcdf4")
    for variable in ("displacement", "acceleration", "psa"):
        whole = found["whole"][variable]
        largest = float(np.abs(whole).max())
        assert float(np.abs(found["killed"][variable] - whole).max()) <= 1e-9 * largest
        assert 0.0 < float(np.abs(one[variable] - whole).max()) <= 1e-8 * largest
