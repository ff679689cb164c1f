"""A response between constraints does not depend on the number of ranks."""

import pickle
import sys
from pathlib import Path

import numpy as np
import pytest

SCRIPT = Path(__file__).with_name("unilateral_on_ranks.py")


@pytest.fixture(scope="module")
def of_ranks(under_mpirun, tmp_path_factory, membrane):
    folder, made = tmp_path_factory.mktemp("unilateral"), {}
    model, steps, h = membrane(), 400, 2e-4
    n, edge = len(model.K), model.ny + 1
    G, probes = np.zeros((n, edge + 2)), np.zeros((n, 2))
    G[-edge:, :edge] = np.diag(np.linspace(0.03, 0.08, edge))
    # A constraint on the rows of two ranks.
    G[[10, n - 30], edge] = 0.5, 1.0
    G[3, edge + 1] = 1.0
    probes[[n - 1, n // 4], [0, 1]] = 1.0
    time = h * np.arange(steps + 1)
    case = {
        "K": model.K,
        "M": model.M,
        "G": G,
        "gap": 1e-3 * G.sum(axis=0),
        "h": h,
        "alpha": 1.0,
        "beta": 2e-5,
        "patterns": model.loads,
        "probes": probes,
        "loads": np.stack([np.sin(50.0 * time), time, 2.0 + 0.0 * time], axis=1),
        "v": np.tile(np.linspace(0.5, 1.0, edge), model.nx),
    }
    (folder / "given").write_bytes(pickle.dumps(case))

    def run(ranks):
        if ranks not in made:
            out = folder / str(ranks)
            ended = under_mpirun(ranks, sys.executable, SCRIPT, folder / "given", out)
            assert ended.returncode == 0, ended.stderr
            made[ranks] = pickle.loads(out.read_bytes())
        return made[ranks]

    return run


@pytest.mark.parametrize("ranks", [2, 3])
def test_ranks(of_ranks, ranks):
    one, many = of_ranks(1), of_ranks(ranks)
    touching = one["impulse"] > 0.0
    assert touching.any(axis=1).sum() > 20 and touching[:, -2:].any(axis=0).all()
    for name in ("impulse", "gap", "displacement", "velocity", "end"):
        assert np.abs(many[name] - one[name]).max() < 1e-9 * np.abs(one[name]).max(), name
    for name, values in one["energy"].items():
        difference = np.abs(many["energy"][name] - values).max()
        assert difference < 1e-9 * max(np.abs(values).max(), 1e-12), name
    assert many["residual"].max() < 1e-11 and many["of energy"] < 1e-12
    # Each rank has the same numbers, bit by bit: they decide alike.
    assert many["same"]
    assert many["refused"] == one["refused"] and "violated at the start" in one["refused"]
