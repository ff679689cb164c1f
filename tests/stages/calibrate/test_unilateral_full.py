"""The θ rule in full order: beside all modes, what it refuses, on several ranks."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

from impactfem.coupling.unilateral import ModalMotion, body_before_walls, unilateral_response
from impactfem.dynamics.damping import Rayleigh
from impactfem.stages.calibrate.unilateral_full import FullMotion, _advance
from impactfem.system.errors import SolutionError

STEP = 2e-4


@pytest.fixture
def motion(petsc):
    """Make the motion of dense matrices in full order."""
    made = []

    def make(K, M, *rest, **options):
        made.append(FullMotion(petsc(K), petsc(M), *rest, **options))
        return made[-1]

    yield make
    for one in made:
        one.destroy()


def wall(model):
    """Integrals of the displacement along the side x = L against hats, and their weights."""
    n = model.ny + 1
    hat = np.eye(n) + 0.25 * (np.eye(n, k=1) + np.eye(n, k=-1))
    hat[[0, -1]] *= 0.5
    G = np.zeros((len(model.K), n))
    G[-n:] = hat * 0.8 / model.ny
    return G, G.sum(axis=0)


def both(model, motion, steps, *, theta=0.5, e=0.0, **damping):
    """The same response in full order and by all modes, thrown obliquely against the wall."""
    G, weight = wall(model)
    n = len(model.K)
    probes = np.zeros((n, 3))
    probes[[n - 1, n - 5, n // 2], range(3)] = 1.0
    time = STEP * np.arange(steps + 1)
    loads = np.stack([3.0 * np.sin(90.0 * time), 5.0 * time, 0.0 * time + 0.2], axis=1)
    v = np.tile(np.linspace(0.5, 1.0, model.ny + 1), model.nx)
    u = 1e-4 * v**2
    gap = 2e-3 * weight
    full = motion(
        model.K, model.M, G, STEP, theta=theta, patterns=model.loads, probes=probes, **damping
    )
    driven = {"amplitudes": loads, "restitution": e}
    first = unilateral_response(full, gap, steps, displacement=u, velocity=v, **driven)
    lam, phi = scipy.linalg.eigh(model.K, model.M)
    modal = ModalMotion(
        body_before_walls(lam, phi.T @ G, **damping),
        STEP,
        theta=theta,
        load=phi.T @ model.loads,
        probes=phi.T @ probes,
    )
    z, w = phi.T @ model.M @ u, phi.T @ model.M @ v
    second = unilateral_response(modal, gap, steps, displacement=z, velocity=w, **driven)
    assert full.displacement == pytest.approx(phi @ modal.displacement, rel=1e-8, abs=1e-12)
    return first, second


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"damping": Rayleigh(2.0, 1e-4)},
        {"theta": 0.8, "e": 0.2, "damping": Rayleigh(beta=1e-5)},
        {"theta": 1.0},
        {"e": 0.7},
    ],
)
def test_agrees_with_all_modes(membrane, motion, options):
    full, modal = both(membrane(), motion, 600, **options)
    touching = full.impulse > 0.0
    # Not all along the edge at once, and not for one step only.
    assert np.count_nonzero(touching.any(axis=1)) > 20
    assert len({tuple(row) for row in touching}) > 5
    for name in ("impulse", "gap", "displacement", "velocity"):
        expected = getattr(modal, name)
        difference = np.abs(getattr(full, name) - expected).max()
        assert difference < 1e-8 * np.abs(expected).max(), name
    for name, expected in vars(modal.energy).items():
        scale = max(np.abs(expected).max(), 1e-6 * modal.energy.scale)
        assert np.abs(getattr(full.energy, name) - expected).max() < 1e-8 * scale, name
    for one in (full, modal):
        assert one.energy.residual < 1e-11 and one.energy.gained < 1e-14
        assert one.residual.max() < 1e-10


def test_a_free_structure(motion, chain):
    """Only the step's matrix must be definite: a free chain bounces off, and goes on."""
    n = 5
    G = np.zeros((n, 1))
    G[-1] = 1.0
    free = motion(100.0 * chain(n, first=False, last=False), np.eye(n), G, 1e-3)
    history = unilateral_response(free, 0.0105, 2000, velocity=np.ones(n))
    assert history.impulse.sum() > 5.0 and np.all(history.impulse[-500:] == 0.0)
    momentum = free.velocity.sum()
    assert momentum == pytest.approx(5.0 - history.impulse.sum(), rel=1e-9)


def test_the_delassus_operator(membrane, motion):
    """More constraints than are solved at once; sparse or not."""
    model = membrane(6, 39)
    G, _ = wall(model)
    assert G.shape[1] == 40
    alpha, beta, theta = 3.0, 1e-4, 0.7
    C = alpha * model.M + beta * model.K
    hat = model.M + theta * STEP * C + (theta * STEP) ** 2 * model.K
    expected = G.T @ np.linalg.solve(hat, G)
    for contact in (G, sp.csc_matrix(G)):
        one = motion(model.K, model.M, contact, STEP, theta=theta, damping=Rayleigh(alpha, beta))
        assert one.delassus() == pytest.approx(expected, rel=1e-9, abs=1e-13 * expected.max())
        assert one.constraints == 40 and one.patterns == 0


def test_constraints_that_depend_on_each_other(membrane, motion):
    model = membrane()
    G, _ = wall(model)
    twice = motion(model.K, model.M, np.hstack([G, G[:, :1] + G[:, 1:2]]), STEP)
    with pytest.raises(SolutionError, match="row 12 of 13 is a combination of those before it"):
        unilateral_response(twice, 1.0, 5)


def test_what_is_refused(petsc):
    K, M, one = petsc(np.eye(3)), petsc(np.eye(3)), np.ones((3, 1))
    with pytest.raises(SolutionError, match=r"a time step of 0\.0 s"):
        FullMotion(K, M, one, 0.0)
    with pytest.raises(SolutionError, match=r"θ = 0\.4: it must be from 0\.5 to 1"):
        FullMotion(K, M, one, 0.1, theta=0.4)
    for name, options in (
        ("constraints", {"contact": np.ones((2, 1))}),
        ("loads", {"patterns": np.ones((4, 1))}),
        ("probes", {"probes": np.ones((1, 2))}),
    ):
        with pytest.raises(SolutionError, match=f"{name} of shape .* for 3 rows of this rank"):
            FullMotion(K, M, options.pop("contact", one), 0.1, **options)
    with pytest.raises(SolutionError, match="the matrix of the time step is not positive def"):
        FullMotion(K, M, one, 0.1, damping=SimpleNamespace(alpha=0.0, beta=-1000.0))
    with (
        FullMotion(K, M, one, 0.1) as motion,
        pytest.raises(SolutionError, match=r"a state of shape \(4,\) for 3 rows of this rank"),
    ):
        unilateral_response(motion, 1.0, 5, velocity=np.zeros(4))


def test_kernel_is_its_python():
    rng = np.random.default_rng(8)
    arrays = rng.standard_normal((8, 1300))
    compiled, plain = arrays.copy(), arrays.copy()
    numbers = (0.01, 0.6, 0.3, 2e-3, 1.2, 0.4)
    found, expected = _advance(*numbers, *compiled), _advance.py_func(*numbers, *plain)
    assert found == pytest.approx(expected, rel=1e-10)
    assert compiled == pytest.approx(plain, rel=1e-12)


SCRIPT = Path(__file__).with_name("unilateral_on_ranks.py")


@pytest.fixture(scope="module")
def of_ranks(on_ranks, membrane):
    model, steps, h = membrane(), 120, 2e-4
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
    return on_ranks(SCRIPT, **case)


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
