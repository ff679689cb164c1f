from copy import deepcopy
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg

from impactfem.dynamics.damping import UNDAMPED, ModeRatios, RatioTable, Rayleigh
from impactfem.dynamics.history import QUANTITIES
from impactfem.dynamics.newmark import Newmark, in_full_order
from impactfem.system.errors import SolutionError

PARTS = ("displacement", "velocity", "acceleration", "momentum", "restoring")


@pytest.fixture
def system(petsc):
    """Make a system of dense matrices."""
    made = []

    def make(K, M, dt, patterns, *, C=None, **damping):
        extra = None if C is None else petsc(C)
        made.append(Newmark(petsc(K), petsc(M), dt, patterns, C=extra, **damping))
        return made[-1]

    yield make
    for one in made:
        one.destroy()


@pytest.fixture
def building(chain):
    """Eight masses with two load patterns, damped, and a damper at one of them."""
    n = 8
    K, M = 900.0 * chain(n, last=False), np.diag(np.linspace(1.0, 2.0, n))
    patterns = np.zeros((n, 2))
    patterns[:, 0], patterns[5, 1] = -np.diag(M), 1.0
    C = np.zeros((n, n))
    C[2, 2] = 3.0
    time = 0.01 * np.arange(351)
    amplitudes = np.stack([np.sin(9.0 * time), 50.0 * (abs(time - 1.0) < 0.05)], axis=1)
    return {"K": K, "M": M, "patterns": patterns, "C": C, "dt": 0.01, "amplitudes": amplitudes}


def of(system, building, **changes):
    values = {**building, "damping": Rayleigh(0.3, 2e-3), **changes}
    amplitudes = values.pop("amplitudes")
    dt, patterns = values.pop("dt"), values.pop("patterns")
    return system(values.pop("K"), values.pop("M"), dt, patterns, **values), amplitudes


def textbook(K, M, C, dt, f, u, v):
    """Newmark with β = 1/4, γ = 1/2 as in the books: solve for the displacement."""
    a = np.linalg.solve(M, f[0] - C @ v - K @ u)
    rows = [(u, v, a)]
    for load in f[1:]:
        right = load + M @ (4 / dt**2 * u + 4 / dt * v + a) + C @ (2 / dt * u + v)
        new = np.linalg.solve(4 / dt**2 * M + 2 / dt * C + K, right)
        u, v, a = new, 2 / dt * (new - u) - v, 4 / dt**2 * (new - u) - 4 / dt * v - a
        rows.append((u, v, a))
    return np.array(rows).transpose(1, 0, 2)


def slope(steps, errors):
    return np.polyfit(np.log(steps), np.log(errors), 1)[0]


def test_free_vibration_is_that_of_the_scheme(system):
    """Undamped, the scheme turns by 2 atan(ωΔt/2) a step, without decay."""
    omega, dt, n = 7.0, 0.05, 400
    one = system([[omega**2]], [[1.0]], dt, np.ones((1, 1)))
    history = one.march(one.start([0.0], [2.0]), np.zeros((n + 1, 1)), probes=[0])
    angle = 2.0 * np.arctan(omega * dt / 2.0) * np.arange(n + 1)
    u, v = 2.0 * np.cos(angle), -2.0 * omega * np.sin(angle)
    assert history.motion["displacement"][:, 0] == pytest.approx(u, abs=1e-11)
    assert history.motion["velocity"][:, 0] == pytest.approx(v, abs=1e-10)
    total = history.energy.kinetic + history.energy.elastic
    assert total == pytest.approx(np.full(n + 1, 2.0 * omega**2), rel=1e-12)
    assert np.all(history.energy.damped == 0.0) and np.all(history.energy.input == 0.0)


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_second_order_of_many_masses(system, chain, quantity):
    """A chain let go in a mixture of its modes, with Rayleigh damping, mode by mode."""
    n, alpha, beta, end = 6, 0.2, 4e-3, 4.0
    K, M = 50.0 * chain(n), np.diag([2.0] * n)
    w2, phi = np.linalg.eigh(K / 2.0)
    xi_w = (alpha + beta * w2) / 2.0
    wd = np.sqrt(w2 - xi_w**2)
    q0 = np.array([1.0, -0.5, 0.3, 0.2, -0.1, 0.05])
    order = QUANTITIES.index(quantity)
    t = np.linspace(0.0, end, 41)[:, None]
    # q = q0 Re[(1 - i ξω/ω_d) e^{st}], s = -ξω + i ω_d, and its derivatives.
    s = -xi_w + 1j * wd
    exact = (q0 * ((1.0 - 1j * xi_w / wd) * s**order * np.exp(s * t)).real) @ phi.T
    steps = np.array([400, 800, 1600, 3200])
    errors = []
    for count in steps:
        many = system(K, M, end / count, np.zeros((n, 1)), damping=Rayleigh(alpha, beta))
        start = many.start([0.0], phi @ q0)
        history = many.march(start, np.zeros((count + 1, 1)), probes=range(n), record=[quantity])
        errors.append(np.abs(history.motion[quantity][:: count // 40] - exact).max())
    assert slope(end / steps, errors) == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize("extra", [False, True])
def test_agrees_with_the_textbook(system, building, extra):
    many, amplitudes = of(system, building, **({} if extra else {"C": None}))
    rng = np.random.default_rng(6)
    u, v = rng.standard_normal((2, 8))
    history = many.march(many.start(amplitudes[0], u, v), amplitudes, probes=[7, 2, 2], chunk=32)
    C = 0.3 * building["M"] + 2e-3 * building["K"] + extra * building["C"]
    loads = amplitudes @ building["patterns"].T
    expected = textbook(building["K"], building["M"], C, 0.01, loads, u, v)
    for name, values in zip(QUANTITIES, expected, strict=True):
        scale = np.abs(values).max()
        assert np.abs(history.motion[name] - values[:, [7, 2, 2]]).max() < 1e-10 * scale, name
    assert history.time.tolist() == (0.01 * np.arange(351)).tolist()
    assert history.energy.residual < 1e-12


def test_energies(system, building):
    many, amplitudes = of(system, building)
    state = many.start(amplitudes[0])
    history = many.march(state, amplitudes, probes=range(8))
    u, v = history.motion["displacement"], history.motion["velocity"]
    energy = history.energy
    elastic = 0.5 * np.sum(u * (u @ building["K"]), 1)
    assert energy.elastic == pytest.approx(elastic, rel=1e-9, abs=1e-12)
    assert energy.kinetic == pytest.approx(0.5 * np.sum(v * (v @ building["M"]), 1), rel=1e-10)
    w = v[1:] + v[:-1]
    f = (amplitudes[1:] + amplitudes[:-1]) @ building["patterns"].T
    assert np.diff(energy.input) == pytest.approx(0.01 / 4 * np.sum(w * f, 1), rel=1e-9, abs=1e-12)
    assert np.all(np.diff(energy.damped) >= 0.0) and energy.damped[-1] > 0.1 * energy.input.max()
    assert energy.residual < 1e-12
    # The products that are carried along are still those of the motion.
    assert state.restoring == pytest.approx(building["K"] @ state.displacement, rel=1e-10)
    assert state.momentum == pytest.approx(building["M"] @ state.velocity, rel=1e-10)
    # Undamped, nothing is lost; the balance does not depend on it.
    free, _ = of(system, building, damping=UNDAMPED, C=None)
    history = free.march(free.start(amplitudes[0]), amplitudes)
    assert np.all(history.energy.damped == 0.0) and history.energy.residual < 1e-12


@pytest.mark.parametrize(
    ("law", "highest"),
    [
        (ModeRatios((0.02, 0.3, 0.1), Rayleigh(0.3, 2e-3)), 6.0),
        (RatioTable((0.1, 20.0), (0.01, 0.2)), 6.0),
        (RatioTable.constant(0.05), 1e-3),
    ],
)
def test_a_law_in_full_order(system, building, petsc, law, highest):
    """With the factor of α M + β K alone, as the textbook with C of all modes; C₊ is added."""
    K, M = building["K"], building["M"]
    eigenvalue, shapes = scipy.linalg.eigh(K, M)
    base, modal = in_full_order(law, petsc(K), petsc(M), highest)
    d = law.modal(eigenvalue)
    # Above the highest frequency, β K through the law there.
    above = eigenvalue > (2.0 * np.pi * highest) ** 2
    d[above] = base.modal(eigenvalue[above])
    image = M @ shapes
    C = image * d @ image.T + building["C"]
    many, amplitudes = of(system, building, damping=base, modal=modal)
    f, start = amplitudes @ building["patterns"].T, np.linspace(1.0, -1.0, 8)
    history = many.march(many.start(amplitudes[0], 0.0 * start, start), amplitudes, probes=range(8))
    exact = textbook(K, M, C, building["dt"], f, 0.0 * start, start)
    for name, truth in zip(QUANTITIES, exact, strict=True):
        assert np.abs(history.motion[name] - truth).max() < 1e-10 * np.abs(truth).max()
    assert history.energy.residual < 1e-12
    if np.all(above):
        assert modal is None and base.alpha == 0.0
        assert base.ratio(highest) == pytest.approx(0.05)


def test_the_start_is_in_equilibrium(system, building):
    many, amplitudes = of(system, building)
    u, v = np.linspace(0.0, 1.0, 8), np.linspace(1.0, -1.0, 8)
    state = many.start(amplitudes[100], u, v)
    C = 0.3 * building["M"] + 2e-3 * building["K"] + building["C"]
    forces = building["M"] @ state.acceleration + C @ v + building["K"] @ u
    assert forces == pytest.approx(building["patterns"] @ amplitudes[100], rel=1e-10, abs=1e-9)
    rest = many.start(0.0 * amplitudes[0])
    assert all(np.all(getattr(rest, name) == 0.0) for name in PARTS)


def test_a_static_start_stays(system, building):
    many, amplitudes = of(system, building)
    constant = np.tile(amplitudes[100], (200, 1))
    state = many.static(constant[0])
    u = np.linalg.solve(building["K"], building["patterns"] @ constant[0])
    assert state.displacement == pytest.approx(u, rel=1e-12)
    history = many.march(state, constant, probes=range(8))
    assert np.abs(history.motion["displacement"] - u).max() < 1e-10 * np.abs(u).max()
    assert history.energy.kinetic.max() < 1e-18 * history.energy.elastic[0]
    # Let go, it moves.
    moved = many.march(many.static(constant[0]), 0.0 * constant)
    assert moved.energy.kinetic.max() > 0.1 * moved.energy.elastic[0]


@pytest.mark.parametrize("stop", [1, 100, 137, 350])
def test_goes_on_bitwise(system, building, stop):
    many, amplitudes = of(system, building)
    state = many.start(amplitudes[0])
    whole = many.march(state, amplitudes, probes=[7])
    again, _ = of(system, building)
    checkpoint = again.start(amplitudes[0])
    first = again.march(checkpoint, amplitudes, last=stop, probes=[7])
    kept = deepcopy(checkpoint)
    # The checkpoint is a copy: what the state does later is no matter of its.
    again.march(checkpoint, amplitudes)
    third, _ = of(system, building)
    second = third.march(kept, amplitudes, probes=[7])
    assert second.time.tolist() == (0.01 * np.arange(stop, 351)).tolist() and kept.step == 350
    for name in PARTS:
        assert np.array_equal(getattr(kept, name), getattr(state, name)), name
    for name in QUANTITIES:
        joined = np.concatenate([first.motion[name], second.motion[name][1:]])
        assert np.array_equal(joined, whole.motion[name]), name
    assert (kept.damped, kept.input) == (state.damped, state.input)
    assert second.energy.input[0] == first.energy.input[-1]


def test_hooks(system, building):
    many, amplitudes = of(system, building)
    seen, parts = [], []
    history = many.march(
        many.start(amplitudes[0]),
        amplitudes,
        probes=[3],
        record=["velocity"],
        chunk=60,
        each_step=lambda state: seen.append((state.step, state.velocity[3])),
        each_chunk=lambda state, part: parts.append((state.step, state.damped, part)),
    )
    assert list(history.motion) == ["velocity"]
    assert [step for step, _ in seen] == list(range(1, 351))
    assert np.array_equal([v for _, v in seen], history.motion["velocity"][1:, 0])
    assert [step for step, _, _ in parts] == [60, 120, 180, 240, 300, 350]
    assert np.array_equal(np.concatenate([p.time for _, _, p in parts]), 0.01 * np.arange(1, 351))
    assert all(part.energy.damped[-1] == damped for _, damped, part in parts)
    assert all(b >= a for (_, a, _), (_, b, _) in pairwise(parts))


def test_what_is_refused(system, building):
    with pytest.raises(SolutionError, match=r"a time step of 0\.0 s"):
        of(system, building, dt=0.0)
    many, amplitudes = of(system, building)
    state = many.start(amplitudes[0])
    with pytest.raises(SolutionError, match="step 0 to step 351"):
        many.march(state, amplitudes, last=351)
    state.step = 5
    with pytest.raises(SolutionError, match="step 5 to step 4"):
        many.march(state, amplitudes, last=4)
    state.step = 0
    amplitudes[123, 1] = np.nan
    with pytest.raises(SolutionError, match="finite before step 200"):
        many.march(state, amplitudes)
    with pytest.raises(SolutionError, match="positive definite"):
        of(system, building, damping=SimpleNamespace(alpha=0.3, beta=-1.0))[0].factorise()


def test_one_factor_for_all_steps(system, building):
    with of(system, building)[0] as many:
        assert many.factorise() is many.factorise()
