"""Against Siconos, another group's program for nonsmooth dynamics, where it is installed."""

import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh

from .test_unilateral import response


def ours(case, damping):
    """By all modes, from the state and under the constant load of the case."""
    return response(
        case, case["steps"], e=case["e"], load=np.ones((case["steps"] + 1, 1)), damping=damping
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


def thrown(rack, e, load, steps=1500):
    """The masses between springs, four of them before walls, of one speed and under one load."""
    case = {**rack, "e": np.full(4, e), "u": np.zeros(8), "v": np.ones(8), "f": np.full(8, load)}
    return case | {"h": 1e-3, "steps": steps}


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
    history, found = ours(case, Rayleigh()), siconos(**case)
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
def test_many_contacts(siconos, rack, e, load, alpha, beta):
    damping = Rayleigh(alpha, beta)
    case = with_damping(thrown(rack, e, load), damping)
    history, found = ours(case, damping), siconos(**case)
    assert max(apart(history, found).values()) < 1e-8
    at_once, changes = contacts(history)
    assert at_once >= (4 if e == 0.0 else 2) and changes >= 10
    # Another restitution is another response.
    other = ours({**case, "e": case["e"] - 0.1 if e else case["e"] + 0.1}, damping)
    assert min(apart(other, found).values()) > 1e-4


def test_where_siconos_gains_energy(siconos, rack):
    """The only difference: Siconos keeps Newton's law for what opens behind the wall."""
    case = with_damping(thrown(rack, 0.0, 5.0, steps=60), Rayleigh(0.1, 1e-3))
    history, found = ours(case, Rayleigh(0.1, 1e-3)), siconos(**case)
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
