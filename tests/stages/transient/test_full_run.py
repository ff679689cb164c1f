"""The full model: its checkpoints, its energies, and what goes in and comes out at the edges."""

import logging
from dataclasses import fields, replace

import numpy as np
import pytest

from impactfem.building.floor import edge_load, linear
from impactfem.dynamics.checkpoints import Checkpoints, remove_checkpoints
from impactfem.dynamics.energy import Energy

STEPS = 420
EVERY = 125  # no multiple of the most steps between two reports


class KilledError(Exception):
    """The end of a run, from outside."""


@pytest.fixture(scope="module")
def short(frame):
    """Both impacts, at 1 ms."""
    return frame.loads(1e-3, STEPS)


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "checkpoints"


@pytest.fixture
def run(frame, short, folder):
    def running(until=2.0, told=None, loads=short, damping=frame.damping, **changes):
        def progress(part):
            if told is not None:
                told.append(part)
            if part > until:
                raise KilledError

        asked = {"key": "key", "every": EVERY, "progress": progress} | changes
        return frame.full(loads, damping, folder, **asked)

    return running


@pytest.fixture(scope="module")
def whole(frame, short, tmp_path_factory):
    """Without interruption."""
    return frame.full(short, frame.damping, tmp_path_factory.mktemp("whole"))


def same(one, other):
    """To the last bit."""
    values = [(getattr(one.energy, f.name), getattr(other.energy, f.name)) for f in fields(Energy)]
    values.append((one.response.displacement, other.response.displacement))
    values.append((one.response.acceleration, other.response.acceleration))
    return all(np.array_equal(a, b) for a, b in values)


def test_interrupted_run_goes_on_with_the_same_numbers(run, whole, folder, caplog):
    with caplog.at_level(logging.INFO, "impactfem"):
        for until, step in ((0.5, 124), (0.8, 248)):
            with pytest.raises(KilledError):
                run(until)
            assert (folder / f"rank_0_{step}.npz").is_file()
        again = run()
    told = [record.getMessage() for record in caplog.records]
    assert told == [f"transient: going on from 0.{step} s" for step in (124, 248)]
    assert same(again, whole)
    assert again.response.displacement.shape == (STEPS + 1, again.response.acceleration.shape[1], 3)
    assert len(again.energy.input) == STEPS + 1


def test_finished_run_is_not_repeated_until_it_is_removed(run, whole, folder, monkeypatch):
    """What comes after it may fail: its results are still there."""
    assert same(run(), whole)
    with monkeypatch.context() as patch:
        patch.setattr("impactfem.dynamics.newmark.Newmark.march", None)
        again = run()
    assert same(again, whole)
    remove_checkpoints(folder)
    with monkeypatch.context() as patch, pytest.raises(TypeError):
        patch.setattr("impactfem.dynamics.newmark.Newmark.march", None)
        run()


@pytest.mark.parametrize("change", ["key", "damping", "nodes", "loads", "step"])
def test_another_run_starts_anew(run, frame, short, folder, caplog, change):
    other = {
        "key": "another",
        "damping": frame.light,
        "nodes": frame.nodes[:4],
        "loads": replace(short, force=1.001 * short.force),
        "step": replace(short, time_step=1.1e-3),
    }[change]
    with pytest.raises(KilledError):
        run(0.5)
    with caplog.at_level(logging.INFO, "impactfem"), pytest.raises(KilledError):
        run(0.2, **{"loads" if change == "step" else change: other})
    assert caplog.records == [] and not folder.exists()


@pytest.mark.parametrize(
    ("every", "steps"),
    [
        (60, [60, 120, 180, 240, 300, 360, 420]),
        (100, [100, 200, 300, 400, 420]),
        (101, [100, 200, 300, 400, 420]),
        (250, [249, 420]),
        (10**6, [420]),
    ],
)
def test_checkpoints_come_as_often_as_asked(run, monkeypatch, every, steps):
    """Two of them are never farther apart, whatever the most steps between two reports."""
    written, told = [], []
    monkeypatch.setattr(Checkpoints, "write", lambda self, state, _: written.append(state.step))
    run(every=every, told=told)
    assert written == steps and told == sorted(told) and told[-1] == 1.0


def test_energies_balance(whole):
    assert whole.energy.residual < 1e-9
    assert whole.energy.input[-1] > 0.0 and np.all(np.diff(whole.energy.damped) >= 0.0)
    # A thousandth of the damping missing would be seen.
    other = replace(whole.energy, damped=0.999 * whole.energy.damped)
    assert other.residual > 1e-5


def test_probe_on_the_base_moves_with_the_ground(run, frame, short, whole):
    clamped, free = frame.parts.mesh.base[0], frame.nodes
    found = run(nodes=np.array([free[0], clamped, free[1], free[0]])).response
    assert not found.displacement[:, 1].any()
    assert np.array_equal(found.acceleration[:, 1], short.ground)
    assert np.array_equal(
        found.acceleration[:, [0, 2, 3]], whole.response.acceleration[:, [0, 1, 0]]
    )
    alone = run(nodes=np.array([clamped])).response
    assert np.array_equal(alone.acceleration[:, 0], short.ground)


def test_reciprocity_of_the_edges(frame, short, tmp_path):
    """The same force on either edge, the acceleration at the other weighed as the force is."""
    edges = [edge_load(frame.parts.mesh, floor, line=linear(0.0, 6.0, 3.3)) for floor in (2, 1)]
    pulse = short.force[:, 0]
    weighed = []
    for k in range(2):
        force = np.zeros_like(short.force)
        force[:, k] = pulse
        alone = replace(short, ground=np.zeros_like(short.ground), force=force)
        other = edges[1 - k]
        found = frame.full(alone, frame.damping, tmp_path / str(k), nodes=other.nodes).response
        weighed.append(found.acceleration[:, :, 1] @ other.forces)
        unweighed = found.acceleration[:, :, 1].mean(axis=1)
        assert np.abs(unweighed - weighed[-1]).max() > 1e-3 * np.abs(weighed[-1]).max()
    there, back = weighed
    assert there == pytest.approx(back, abs=1e-9 * np.abs(back).max())
