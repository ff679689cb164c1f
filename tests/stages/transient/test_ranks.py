"""Responses and checkpoints of the frame do not depend on the number of ranks."""

from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from .conftest import STOREY_FACTOR
from .on_ranks import responses

pytestmark = pytest.mark.slow
SCRIPT = Path(__file__).with_name("on_ranks.py")


@pytest.fixture(scope="module")
def runs(frame, on_ranks, tmp_path_factory):
    """Results by number of ranks; two ranks find the checkpoints of one."""
    folder = tmp_path_factory.mktemp("ranks")
    given = {
        "parts": frame.parts,
        "storey_factor": STOREY_FACTOR,
        "loads": frame.loads(2e-3, 60),
        "nodes": frame.nodes,
        "damping": frame.damping,
    }
    one = responses(MPI.COMM_SELF, given, folder / "1")
    (folder / "2").mkdir()
    (folder / "1" / "left for others").rename(folder / "2" / "left")
    return {1: one, 2: on_ranks(SCRIPT, given=given, folder=folder / "2")(2)}


def difference(a, b):
    """Largest difference of any history relative to the peak of the history."""
    names = [name for name, value in a.items() if np.ndim(value)]
    assert len(names) >= 2
    return max(float(np.abs(a[name] - b[name]).max() / np.abs(b[name]).max()) for name in names)


def test_two_ranks_agree_with_one(runs):
    """By the full solver; the chain on two ranks has the reduced one."""
    assert 0.0 < difference(runs[2]["full"], runs[1]["full"]) < 1e-8
    assert runs[2]["full"]["residual"] < 1e-9


def test_interrupted_run_resumes(runs):
    run = runs[2]
    assert run["log of the resumed"] == ["transient: going on from 0.050 s"]
    assert difference(run["resumed"], run["full"]) <= 1e-10


def test_damage_on_one_rank_restarts_all(runs):
    run = runs[2]
    (line,) = run["log of the damaged"]
    assert "rank_1_25.npz" in line
    assert difference(run["again"], run["full"]) <= 1e-10


def test_checkpoint_of_another_number_of_ranks_is_not_used(runs):
    assert runs[2]["log of what was left"] == []
