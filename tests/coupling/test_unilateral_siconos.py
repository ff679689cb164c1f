"""Against Siconos, another group's program for nonsmooth dynamics, where it is installed."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

from impactfem.coupling.unilateral import ModalMotion, body_before_walls, unilateral_response
from impactfem.dynamics.damping import Rayleigh

SCRIPT = Path(__file__).with_name("with_siconos.py")

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("siconos") is None,
    reason="siconos is not installed (Debian 12: python3-siconos; Debian 13 does not have it)",
)


@pytest.fixture
def siconos(tmp_path):
    """Step a case with Siconos."""

    def run(case):
        given, out = tmp_path / "case.npz", tmp_path / "results.npz"
        np.savez(given, **case)
        done = subprocess.run(
            [sys.executable, SCRIPT, given, out], capture_output=True, text=True, timeout=600
        )
        assert done.returncode == 0, done.stdout + done.stderr
        with np.load(out) as results:
            return dict(results)

    return run


def ours(case, damping):
    lam, phi = scipy.linalg.eigh(case["K"], case["M"])
    steps = case["steps"]
    motion = ModalMotion(
        body_before_walls(lam, phi.T @ case["G"], damping),
        case["h"],
        load=(phi.T @ case["f"])[:, None],
        probes=phi.T,
    )
    return unilateral_response(
        motion,
        case["gap"],
        steps,
        displacement=phi.T @ case["M"] @ case["u"],
        velocity=phi.T @ case["M"] @ case["v"],
        amplitudes=np.ones((steps + 1, 1)),
        restitution=case["e"],
    )


def block(e, gravity, steps=1000):
    """A plane block, thrown with rotation onto a floor below both corners and a wall beside."""
    m, a, b = 2.0, 0.5, 0.3
    return {
        "M": np.diag([m, m, m / 3.0 * (a**2 + b**2)]),
        "K": np.zeros((3, 3)),
        "G": np.array([[0.0, -1.0, -a], [0.0, -1.0, a], [1.0, 0.0, b]]).T,
        "gap": np.array([0.1, 0.1, 0.05]),
        "e": np.array(e),
        "u": np.array([0.0, 0.0, 0.05]),
        "v": np.array([0.2, -0.3, -0.1]),
        "f": np.array([0.0, -gravity * m, 0.0]),
        "h": 1e-3,
        "steps": steps,
    }


def rack(chain, e, load, steps=1500):
    """Eight masses between springs, four of them before walls."""
    n = 8
    G = np.zeros((n, 4))
    G[[1, 3, 5, 7], range(4)] = 1.0
    return {
        "M": np.diag(np.linspace(1.0, 2.0, n)),
        "K": 900.0 * chain(n),
        "G": G,
        "gap": np.array([0.02, 0.015, 0.02, 0.01]),
        "e": np.full(4, e),
        "u": np.zeros(n),
        "v": np.ones(n),
        "f": np.full(n, load),
        "h": 1e-3,
        "steps": steps,
    }


def with_damping(case, damping):
    return {**case, "C": damping.matrix(case["K"], case["M"])}


def apart(history, found):
    """Largest difference of each quantity over its largest value."""
    return {
        name: np.abs(mine - found[key]).max() / np.abs(found[key]).max()
        for name, key, mine in (
            ("displacement", "u", history.displacement),
            ("velocity", "v", history.velocity),
            ("impulse", "impulse", history.impulse),
        )
    }


def contacts(history):
    """Largest number at once, and how often it changes who is in contact."""
    touching = history.impulse > 0.0
    changes = np.count_nonzero((touching[1:] != touching[:-1]).any(axis=1))
    return touching.sum(axis=1).max(), changes


@pytest.mark.parametrize(
    ("e", "gravity"), [((0.0, 0.0, 0.0), 0.0), ((0.5, 0.5, 0.3), 0.0), ((1.0, 1.0, 1.0), 9.81)]
)
def test_a_rigid_block(siconos, e, gravity):
    case = with_damping(block(e, gravity), Rayleigh())
    history, found = ours(case, Rayleigh()), siconos(case)
    assert max(apart(history, found).values()) < 1e-8
    assert contacts(history)[1] >= 4


@pytest.mark.parametrize(
    ("e", "load", "alpha", "beta"),
    [
        (0.0, 5.0, 0.1, 0.01),
        (0.0, 5.0, 0.0, 0.03),
        (0.0, 0.0, 0.0, 0.03),
        (0.5, 0.0, 0.0, 0.0),
        (1.0, 5.0, 0.1, 1e-3),
    ],
)
def test_many_contacts(siconos, chain, e, load, alpha, beta):
    damping = Rayleigh(alpha, beta)
    case = with_damping(rack(chain, e, load), damping)
    history, found = ours(case, damping), siconos(case)
    assert max(apart(history, found).values()) < 1e-8
    at_once, changes = contacts(history)
    assert at_once >= (4 if e == 0.0 else 2) and changes >= 10
    # Another restitution is another response.
    other = ours({**case, "e": case["e"] - 0.1 if e else case["e"] + 0.1}, damping)
    assert min(apart(other, found).values()) > 1e-4


def test_where_siconos_gains_energy(siconos, chain):
    """The only difference: Siconos keeps Newton's law for what opens behind the wall."""
    case = with_damping(rack(chain, 0.0, 5.0, steps=60), Rayleigh(0.1, 1e-3))
    history, found = ours(case, Rayleigh(0.1, 1e-3)), siconos(case)
    speed = found["v"] @ case["G"]
    room = case["gap"] - found["u"] @ case["G"]
    different = np.abs(history.impulse - found["impulse"]) > 1e-8 * found["impulse"].max()
    step = int(np.flatnonzero(different.any(axis=1))[0])
    which = np.argmax(np.abs(history.impulse - found["impulse"])[step])
    assert room[step - 1, which] < 0.0 and speed[step - 1, which] < 0.0
    assert np.abs(history.displacement - found["u"])[: step - 1].max() < 1e-12
    mean = 0.5 * (speed[1:] + speed[:-1])
    gained = -np.sum(mean * found["impulse"][1:], axis=1)
    assert gained[step - 1] > 0.0 and gained.max() > 1e-8 * history.energy.scale
    assert history.energy.gained < 1e-15
