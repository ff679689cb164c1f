"""Kills and full disks while the stage writes: what is there opens, and --resume goes on."""

import logging
import shutil
import signal

import h5py
import numpy as np
import pytest
import xarray as xr

from impactfem.run import loop
from impactfem.system.errors import ImpactfemError

from .conftest import full_disk, killed, no_pictures, write_forces

pytestmark = pytest.mark.slow
STORES = (
    "reduce.npz",
    "transient.nc",
    "transient_maps.nc",
    "transient_motion.vtkhdf",
    "transient.stage.json",
)
"""What the stage leaves, in the order in which it is written."""


@pytest.fixture(scope="module")
def case_of(begun, edited, tmp_path_factory):
    """Write a short case by both solvers into a new folder, after the previous stages."""

    def made():
        folder = tmp_path_factory.mktemp("both")
        shutil.copytree(begun, folder, dirs_exist_ok=True)
        keys = 'solver = "both"\nduration = "0.5 s"\nexport = true\nexport_duration = "20 ms"\n'
        return edited(folder / "frame.toml", ('solver = "reduced"\n', keys))

    return made


@pytest.fixture(scope="module")
def uninterrupted(case_of):
    """The folder of a run without interruption."""
    case = case_of()
    with pytest.MonkeyPatch.context() as patch:
        no_pictures(patch)
        loop.run(case, out=case.parent / "run", stage="transient", draw=False)
    return case.parent / "run"


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


def test_a_killed_run_resumes(case_of, uninterrupted):
    """The resumed run continues from the last checkpoint and has the same results."""
    case = case_of()
    folder = case.parent / "run"
    ended = killed("rank_0_400.npz", case)
    assert ended.returncode == -signal.SIGKILL, ended.stderr
    assert left(folder) == list(STORES[:1]) and (folder / "transient_checkpoints").exists()
    ended = killed("-", case, "--resume")
    assert ended.returncode == 0, ended.stderr
    assert "going on from 0.200 s" in ended.stderr and "damaged" not in ended.stderr
    assert left(folder) == list(STORES) and not (folder / "transient_checkpoints").exists()
    assert same(folder, uninterrupted)


def test_full_disks(case_of, uninterrupted, monkeypatch, caplog):
    """A file that cannot be written leaves no part; the resumed run has the same results."""
    no_pictures(monkeypatch)
    case = case_of()
    folder = case.parent / "run"
    names = ["reduce.npz", "rank_0_200.npz", "transient.nc", "transient_motion.vtkhdf"]
    for name in names:
        caplog.clear()
        message = rf"cannot write .*{name}: File too large"
        with (
            caplog.at_level(logging.INFO, "impactfem"),
            full_disk(name),
            pytest.raises(ImpactfemError, match=message),
        ):
            resume = name != names[0]
            loop.run(case, out=folder, stage="transient", resume=resume, draw=False)
        before = STORES.index(name) if name in STORES else 1
        assert left(folder) == list(STORES[:before])
        assert not list(folder.rglob(".*.part"))
        told = [record.getMessage() for record in caplog.records]
        assert not any("damaged" in line for line in told)
        # No checkpoint was whole before that; then that of the last step is.
        whole = names.index(name) > names.index("transient.nc")
        assert ("transient: going on from 0.500 s" in told) == whole
    loop.run(case, out=folder, stage="transient", resume=True, draw=False)
    assert left(folder) == list(STORES)
    assert same(folder, uninterrupted)


def test_results_of_other_forces_are_replaced(uninterrupted, tmp_path, monkeypatch):
    no_pictures(monkeypatch)
    shutil.copytree(uninterrupted.parent, tmp_path, dirs_exist_ok=True)
    write_forces(tmp_path / "forces_of_another.csv", 5e5)
    case, folder = tmp_path / "frame.toml", tmp_path / "run"
    name = "transient_motion.vtkhdf"
    with full_disk(name), pytest.raises(ImpactfemError, match=f"cannot write .*{name}"):
        loop.run(case, out=folder, stage="transient", draw=False)
    first = xr.load_dataset(folder / "transient.nc", engine="netcdf4")
    assert not (folder / name).exists()
    done = loop.run(case, out=folder, stage="transient", draw=False)
    assert done.reused == ["building", "reduce", "pounding"]
    second = xr.load_dataset(folder / "transient.nc", engine="netcdf4")
    assert first.equals(second)
    assert not same(folder, uninterrupted)
