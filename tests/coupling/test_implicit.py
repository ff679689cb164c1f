import numpy as np
import pytest
import scipy.optimize

from impactfem.coupling import implicit
from impactfem.coupling.impacts import impacts
from impactfem.coupling.laws import HertzDamp, HuntCrossley, Jankowski, KelvinVoigt
from impactfem.coupling.link_forces import Laws, LinkTrial, contact_forces, pair_force
from impactfem.coupling.pounding import End, Pair, System, simulate
from impactfem.sticks.stick import mass_on_spring
from impactfem.system.errors import SolutionError
from impactfem.verify.contact import Y

H = 1.5e-4
K, C = 1e11, 1.3e8
M = 1.5e6


def linear(k, c, *, tension=True):
    """A law of Kelvin-Voigt with these constants."""
    return KelvinVoigt(k, 0.5 * c / np.sqrt(k * M), tension, mass=M)


LINEAR, NO_TENSION = linear(K, C), linear(K, C, tension=False)


@pytest.mark.parametrize("update", ["implicit", "lagged"])
def test_the_interpreted_loop_gives_the_numbers_of_the_compiled_one(row, update, monkeypatch):
    system = row(0.0, x=1.5)
    ground = np.cumsum(np.random.default_rng(5).standard_normal((60, 3)), axis=0)
    compiled = simulate(system, ground, 1e-3, update=update)
    monkeypatch.setattr(implicit, "march", implicit.march.py_func)
    interpreted = simulate(system, ground, 1e-3, update=update)
    for name in ("u", "v", "force"):
        ours, theirs = getattr(compiled, name), getattr(interpreted, name)
        assert np.abs(ours).max() > 0.0
        assert np.abs(ours - theirs).max() < 1e-10 * np.abs(ours).max()


def coupled(seed, m):
    """W of pairs that share masses, and gaps that are mostly closed."""
    rng = np.random.default_rng(seed)
    J = rng.standard_normal((m, 6))
    W = H * J @ np.diag(1.0 / rng.uniform(5e5, 3e6, 6)) @ J.T
    return W, -rng.uniform(1e-4, 1e-3, m), rng.uniform(-0.3, 0.3, m)


def forces(W, delta, rate, laws, v0=None):
    """Whether the forces agree, and they."""
    m = delta.size
    table = Laws.of(laws)
    table.state[:, 0] = 0.0 if v0 is None else v0
    F, touches = np.zeros(m), np.zeros(m, dtype=np.bool_)
    return contact_forces(H, W, table, LinkTrial(delta, rate, F, touches)), F


def solve(W, delta, rate, *, law=LINEAR):
    return forces(W, delta, rate, [law] * delta.size)


def pair(law, p, v, v0, h, W):
    table = Laws.of([law])
    table.state[0, 0] = v0
    return pair_force(table, 0, p, v, h, W)


@pytest.mark.parametrize("seed", range(5))
def test_forces_of_two_coupled_pairs_satisfy_their_law(seed):
    W, delta, rate = coupled(seed, 2)
    agreed, F = solve(W, delta, rate)
    assert agreed
    p, v = -(delta + H * W @ F), -(rate + W @ F)
    size = K * np.abs(p) + C * np.abs(v)
    assert np.all(np.abs(F - K * p - C * v) <= 1e-12 * size.max())
    # The linear equations solved at once; and without the coupling it is another force.
    direct = np.linalg.solve(np.eye(2) + W * (H * K + C), -K * delta - C * rate)
    assert pytest.approx(direct, abs=1e-11 * size.max()) == F
    alone = solve(np.diag(np.diag(W)), delta, rate)[1]
    assert np.abs(alone - F).max() > 1e-6 * np.abs(F).max()


def test_forces_without_tension_are_a_complementary_pair():
    for seed in range(20):
        W, delta, rate = coupled(seed, 3)
        agreed, F = solve(W, delta, rate, law=NO_TENSION)
        assert agreed and np.all(F >= 0.0)
        p, v = -(delta + H * W @ F), -(rate + W @ F)
        size = (K * np.abs(p) + C * np.abs(v)).max()
        assert np.abs(F - np.maximum(K * p + C * v, 0.0)).max() <= 1e-11 * size


@pytest.mark.parametrize("make", [HertzDamp, HuntCrossley, Jankowski])
@pytest.mark.parametrize("m", [2, 5])
def test_forces_of_coupled_pairs_of_a_law_that_is_not_linear(make, m):
    law = make(3e12, 0.4, mass=1e6)
    for seed in range(10):
        W, delta, rate = coupled(seed, m)
        v0 = np.abs(rate)
        agreed, F = forces(W, delta, -v0, [law] * m, v0)
        assert agreed
        p, v = -(delta + H * W @ F), v0 - W @ F
        expected = [law.at(p[k], v[k], v0[k : k + 1])[0] for k in range(m)]
        assert pytest.approx(np.array(expected), abs=1e-9 * F.max()) == F
        assert F.max() > 0.0


def test_an_open_pair_has_no_force():
    W, delta, rate = coupled(1, 2)
    agreed, F = solve(W, np.array([1e-3, delta[1]]), rate)
    # The force of the closed pair may close the other one within the step, but not here.
    assert agreed and F[0] == 0.0 != F[1]


def test_forces_that_are_not_numbers_are_refused():
    W, delta, _ = coupled(0, 2)
    agreed, _ = solve(W, delta, np.array([np.nan, 0.0]))
    assert not agreed
    law = KelvinVoigt(np.nan, 0.0, mass=1e3)
    with pytest.raises(SolutionError, match=r"converge at t = 0\.0003 s"):
        # The gap closes in the third step.
        collision_at(law, 1e-4, phase=2.5)


def collision_at(law, dt, phase):
    """As `collision`, which takes the number of steps from the duration of a healthy law."""
    ends = [End(name, 0, (0.0, 0.0, 0.0), 1) for name in "12"]
    sticks = tuple(mass_on_spring(name, 1e3, 0.0) for name in "12")
    system = System(sticks, (Pair("1-2", *ends, Y, 0.3 * dt * phase, law),))
    v0 = np.zeros(12)
    v0[1] = 0.3
    return simulate(system, np.zeros((10, 3)), dt, v0=v0)


@pytest.mark.parametrize("tension", [True, False])
def test_pair_force_where_the_force_passes_through_zero(tension):
    # K p and C v cancel to the last digits: what is left is rounding, and no reason to give up.
    rng = np.random.default_rng(11)
    W = H / 1.5e6
    for p in rng.uniform(1e-5, 1e-2, 2000):
        for digits in (0.0, 1e-16, -1e-15, 1e-13):
            v = -K * p / C * (1.0 + digits)
            F, size = pair(linear(K, C, tension=tension), p, v, 0.0, H, W)
            assert size == pytest.approx(2 * K * p, rel=1.0)
            assert abs(F) <= 1e-12 * 2 * K * p


def test_pair_force_by_hand():
    W, p, v = H / 1.5e6, 2e-4, 0.1
    expected = (K * p + C * v) / (1 + W * (H * K + C))
    F, size = pair(LINEAR, p, v, 0.0, H, W)
    assert pytest.approx(expected, rel=1e-13) == F
    assert size >= abs(F)
    assert pair(LINEAR, p, v, 0.0, H, 0.0)[0] == pytest.approx(K * p + C * v)
    # Its own force makes a difference.
    assert abs(K * p + C * v - F) > 1e-3 * F


@pytest.mark.parametrize("tension", [True, False])
@pytest.mark.parametrize("stiff", [1.0, 1e2, 1e4, 1e6])
def test_pair_force_of_a_barely_closed_gap_with_a_coarse_step(tension, stiff):
    # h W K = stiff: with the spring in its slope, Newton's method would creep.
    m, v = 1.5e6, 0.1
    h = np.sqrt(stiff * m / K)
    W = h / m
    for xi in (0.0, 0.05, 0.7):
        c = 2.0 * xi * np.sqrt(K * m)
        for p in (1e-12, 1e-9, 1e-6):
            F, size = pair(linear(K, c, tension=tension), p, v, v, h, W)
            inside = (K * p + c * v) / (1.0 + W * (h * K + c))
            expected = inside if p > h * W * inside else c * v / (1.0 + W * c)
            assert pytest.approx(expected, rel=1e-9, abs=1e-12 * K * p) == F
            assert size >= abs(F)
    # A step that leaves them in contact has the spring in it.
    F, _ = pair(linear(K, 0.0, tension=tension), 1e-3, v, v, h, W)
    assert pytest.approx(K * 1e-3 / (1.0 + stiff)) == F


@pytest.mark.parametrize("make", [HertzDamp, HuntCrossley, Jankowski])
def test_pair_force_of_a_law_that_is_not_linear(make):
    # F = law(p - h W F, v - W F), found by bisection as well; also where a gap is barely closed.
    m = 1.5e6
    law, W = make(1.4e12, 0.5, mass=m), H / m
    rng = np.random.default_rng(7)
    some = [(rng.uniform(1e-3, 1e-2), rng.uniform(0.1, 1.0)) for _ in range(200)]
    states = [(p, rng.uniform(-0.9, 1.0) * v0, v0) for p, v0 in some]
    states += [(p, 0.1, 0.1) for p in (1e-12, 1e-9, 1e-6, 1e-4)]
    for p, v, v0 in states:

        def excess(F, p=p, v=v, v0=v0):
            return law.at(p - H * W * F, v - W * F, (v0,))[0] - F

        F, size = pair(law, p, v, v0, H, W)
        assert size >= F > 0.0
        assert pytest.approx(scipy.optimize.brentq(excess, 0.0, p / (H * W)), rel=1e-9) == F
        assert excess(0.99 * F) > 0.0 > excess(1.01 * F)


def test_the_loop_remembers_the_speed_of_approach():
    # Every contact of a mass that bounces between two walls begins with its own speed.
    law = HertzDamp(1e9, 0.6, mass=1e3, relation="exact")
    pairs = tuple(
        Pair(name, End("m", 0, (0.0, 0.0, 0.0), 1), None, sign * Y, 0.05, law)
        for name, sign in (("right", 1.0), ("left", -1.0))
    )
    v0 = np.zeros(6)
    v0[1] = 1.0
    response = simulate(
        System((mass_on_spring("m", 1e3, 0.0),), pairs), np.zeros((60000, 3)), 1e-5, v0=v0
    )
    found = impacts(response)
    assert [impact.pair.name for impact in found[:3]] == ["right", "left", "right"]
    assert [impact.approach for impact in found[:3]] == pytest.approx([1.0, 0.6, 0.36], rel=2e-3)
    assert [impact.restitution for impact in found[:3]] == pytest.approx([0.6] * 3, abs=2e-3)
