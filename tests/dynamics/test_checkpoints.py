import logging
from dataclasses import fields

import numpy as np
import pytest
from mpi4py import MPI

from impactfem.dynamics.checkpoints import Checkpoints, remove_checkpoints
from impactfem.dynamics.energy import Energy
from impactfem.dynamics.history import History, State
from impactfem.system.errors import ImpactfemError


def at(step):
    rng = np.random.default_rng(step)
    state = State(step, *rng.standard_normal((5, 12)), damped=rng.random(), input=rng.random())
    motion = {name: rng.standard_normal((step + 1, 3)) for name in ("displacement", "acceleration")}
    return state, History(0.1 * np.arange(step + 1), motion, Energy(*rng.random((4, step + 1))))


def same(found, step):
    if found is None:
        return False
    (state, history), (known, recorded) = found, at(step)
    values = [(getattr(state, f.name), getattr(known, f.name)) for f in fields(State)]
    values += [
        (getattr(history.energy, f.name), getattr(recorded.energy, f.name)) for f in fields(Energy)
    ]
    values += [(history.time, recorded.time), (list(history.motion), list(recorded.motion))]
    values += [(history.motion[name], recorded.motion[name]) for name in recorded.motion]
    return all(np.array_equal(a, b) for a, b in values)


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "checkpoints"


def checkpoints(folder, key="key"):
    return Checkpoints(MPI.COMM_SELF, folder, key)


def test_the_last_one_counts_and_those_before_go(folder):
    store = checkpoints(folder)
    assert store.read() is None and not folder.exists()
    for step in (10, 20):
        store.write(*at(step))
        assert same(checkpoints(folder).read(), step)
    assert not same(checkpoints(folder).read(), 10)
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["rank_0_20.npz"]


def test_of_another_run(folder, caplog):
    """It is no damage, so nothing is told; and it may not be mixed up later."""
    checkpoints(folder).write(*at(10))
    assert checkpoints(folder, "other").read() is None
    assert not folder.exists() and caplog.records == []


@pytest.mark.parametrize("size", [0, 40, -30])
def test_damaged(folder, size, caplog):
    checkpoints(folder).write(*at(10))
    path = folder / "rank_0_10.npz"
    path.write_bytes(path.read_bytes()[:size])
    with caplog.at_level(logging.WARNING, "impactfem"):
        assert checkpoints(folder).read() is None
    (record,) = caplog.records
    assert f"{path.name} is damaged" in record.getMessage()
    assert not folder.exists()


def test_kill_while_one_is_written(folder, monkeypatch):
    """The one before is still there, whichever file was the last."""
    checkpoints(folder).write(*at(10))

    def killed(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("impactfem.dynamics.checkpoints.write_archive", killed)
        with pytest.raises(KeyboardInterrupt):
            checkpoints(folder).write(*at(20))
    (folder / ".rank_0_20.npz.1.part").write_bytes(b"half")
    assert same(checkpoints(folder).read(), 10)
    checkpoints(folder).write(*at(30))
    assert same(checkpoints(folder).read(), 30)
    assert not list(folder.glob("*_20.npz"))


def test_remove(folder):
    checkpoints(folder).write(*at(10))
    (folder / ".rank_0_20.npz.1.part").write_bytes(b"half")
    remove_checkpoints(folder)
    assert not folder.exists()
    remove_checkpoints(folder)


def test_no_place(folder):
    folder.mkdir()
    (folder / "rank_0_10.npz").mkdir()
    with pytest.raises(ImpactfemError, match=r"cannot write .*rank_0_10\.npz"):
        checkpoints(folder).write(*at(10))
