import numpy as np
import pytest
import scipy.linalg
from scipy.optimize import nnls

from impactfem.coupling import contact_loop
from impactfem.coupling.modal_motion import ModalMotion, body_before_walls
from impactfem.coupling.unilateral import unilateral_response
from impactfem.dynamics.damping import UNDAMPED, Rayleigh
from impactfem.system.errors import SolutionError


def mass(h, *, m=2.0, k=0.0, alpha=0.0, theta=0.5):
    """One mass on a spring before a wall; the probe is its position."""
    root = np.sqrt(m)
    one = np.array([[1.0 / root]])
    return ModalMotion(
        body_before_walls(np.array([k / m]), one, Rayleigh(alpha)),
        h,
        theta=theta,
        load=one.copy(),
        probes=one.copy(),
    )


def meets_wall(h, gap, steps, *, e=0.0, v0=1.0, load=0.0, **options):
    return unilateral_response(
        mass(h, **options),
        gap,
        steps,
        velocity=np.array([np.sqrt(options.get("m", 2.0)) * v0]),
        amplitudes=np.full((steps + 1, 1), load),
        restitution=e,
    )


def response(rack, steps, *, e=0.0, theta=0.5, load=None, damping=UNDAMPED):
    """By all modes; the probes are all masses, and all are loaded alike, or as the case says."""
    lam, phi = scipy.linalg.eigh(rack["K"], rack["M"])
    motion = ModalMotion(
        body_before_walls(lam, phi.T @ rack["G"], damping),
        rack["h"],
        theta=theta,
        load=(phi.T @ rack.get("f", np.ones(len(lam))))[:, None],
        probes=phi.T,
    )
    u = rack.get("u", np.zeros(len(lam)))
    return unilateral_response(
        motion,
        rack["gap"],
        steps,
        displacement=phi.T @ rack["M"] @ u,
        velocity=phi.T @ rack["M"] @ rack["v"],
        amplitudes=load,
        restitution=e,
    )


def plain(rack, steps, *, e=0.0, theta=0.5, load=None, damping=UNDAMPED, opening="neutral"):
    """The same step as in the books, with dense matrices and nonnegative least squares.

    `opening` says which restitution constraints have that are behind the wall and open.
    """
    K, M, G, h = rack["K"], rack["M"], rack["G"], rack["h"]
    C = damping.matrix(K, M)
    hat = M + theta * h * C + (theta * h) ** 2 * K
    W = G.T @ np.linalg.solve(hat, G)
    n, m = G.shape
    e, law = np.broadcast_to(e, m), np.zeros(m)
    load = np.zeros((steps + 1, 1)) if load is None else load
    u, v, rows = np.zeros(n), rack["v"].copy(), []
    rows.append((u, v, np.zeros(m)))
    for k in range(steps):
        f = ((1.0 - theta) * load[k] + theta * load[k + 1]) * np.ones(n)
        jump = np.linalg.solve(hat, h * (f - C @ v - K @ (u + theta * h * v)))
        s, P = G.T @ v, np.zeros(m)
        law = np.where(s >= 0.0, e, (1.0 - theta) / theta) if opening == "neutral" else e
        near = np.flatnonzero(rack["gap"] - G.T @ u <= (1.0 - theta) * h * s)
        if near.size:
            U = np.linalg.cholesky(W[np.ix_(near, near)]).T
            q = -(G.T @ (v + jump) + law * s)[near]
            P[near] = nnls(U, -scipy.linalg.solve_triangular(U, q, trans=1))[0]
        new = v + jump - np.linalg.solve(hat, G @ P)
        u, v = u + h * ((1.0 - theta) * v + theta * new), new
        rows.append((u, v, P))
    return [np.array(part) for part in zip(*rows, strict=True)]


def work(rack, u, P):
    """What the contact impulses put in, step by step, over the energy at the start."""
    mean = np.diff(u, axis=0) / rack["h"]
    return -np.sum((mean @ rack["G"]) * P[1:], axis=1) / (0.5 * rack["v"] @ rack["M"] @ rack["v"])


def test_a_mass_stops():
    h, gap = 1e-3, 0.0503
    far = meets_wall(h, 0.2, 100)
    assert np.all(far.impulse == 0.0) and np.all(far.penetration == 0.0)
    history = meets_wall(h, gap, 100)
    impulse = history.impulse[:, 0]
    # In one step, with all of its momentum; then nothing.
    assert np.flatnonzero(impulse).tolist() == [51]
    assert impulse[51] == pytest.approx(2.0, rel=1e-14)
    assert history.force[51, 0] == pytest.approx(2000.0, rel=1e-11)
    assert history.velocity[:51, 0] == pytest.approx(np.ones(51), rel=1e-14)
    assert np.abs(history.velocity[51:, 0]).max() < 1e-15
    # It stops within half of a step of the wall, and stays where it stops.
    assert history.displacement[:51, 0] == pytest.approx(h * np.arange(51))
    assert history.penetration == pytest.approx(0.0505 - gap, rel=1e-9)
    assert np.ptp(history.displacement[51:]) < 1e-16
    assert history.gap[:, 0] == pytest.approx(gap - history.displacement[:, 0], abs=1e-16)
    assert history.energy.contact[-1] == pytest.approx(-1.0, rel=1e-13)
    assert history.time == pytest.approx(h * np.arange(101)) and history.residual.max() < 1e-15


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.5, 0.75, 1.0])
def test_it_stops_at_the_wall_or_behind_it(phase):
    """Never before it, where it would be let go again and shake."""
    h = 1e-3
    for theta in (0.5, 0.75, 1.0):
        history = meets_wall(h, (50 + phase) * h, 100, load=300.0, theta=theta)
        pushed = np.flatnonzero(history.impulse[:, 0])
        assert np.array_equal(pushed, np.arange(pushed[0], 101))
        assert 0.0 <= history.penetration[0] <= 2.0 * h


@pytest.mark.parametrize("e", [0.3, 0.8, 1.0])
def test_a_mass_bounces(e):
    history = meets_wall(1e-3, 0.0503, 100, e=e)
    assert history.impulse.sum() == pytest.approx(2.0 * (1.0 + e), rel=1e-13)
    assert history.velocity[-1, 0] == pytest.approx(-e, rel=1e-13)
    assert history.energy.contact[-1] == pytest.approx(e**2 - 1.0, rel=1e-12, abs=1e-14)
    assert history.energy.kinetic[-1] == pytest.approx(e**2, rel=1e-12)


@pytest.mark.parametrize(("e", "gap"), [(0.0, 0.3), (0.6, 0.303), (0.6, 0.306), (0.6, 0.309)])
def test_a_wall_that_moves_is_one_at_rest_in_another_frame(e, gap):
    """A wall that goes by w(t) = c t + a t²/2 is met as one at rest by a mass with -m a more."""
    h, m, load, c, a = 0.0123, 2.0, 4.0, -3.0, 1.5
    still = meets_wall(h, gap, 200, e=e, load=load, m=m)
    t = h * np.arange(201)
    wall = np.array([c * t + 0.5 * a * t**2, c + a * t])
    found = unilateral_response(
        mass(h, m=m),
        gap,
        200,
        velocity=np.array([np.sqrt(m) * (1.0 + c)]),
        amplitudes=np.full((201, 1), load + m * a),
        restitution=e,
        opened=wall[:, :, None],
    )
    assert np.count_nonzero(still.impulse) > 2 and not still.impulse[:20].any()
    assert found.impulse == pytest.approx(still.impulse, abs=1e-9)
    assert found.gap == pytest.approx(still.gap, abs=1e-9)
    assert found.velocity[:, 0] - wall[1] == pytest.approx(still.velocity[:, 0], abs=1e-9)
    assert found.residual.max() < 1e-9 and found.energy.residual < 1e-12


def test_a_mass_at_rest_carries_its_load():
    """The wall gives what the load has, also while it changes, and lets go when it pulls."""
    h = 1e-3
    load = np.linspace(5.0, -1.0, 601)[:, None]
    history = unilateral_response(mass(h), 0.0, 600, amplitudes=load)
    mean = 0.5 * (load[1:, 0] + load[:-1, 0])
    assert history.force[1:, 0] == pytest.approx(np.maximum(mean, 0.0), abs=1e-12)
    assert np.all(history.displacement[:500] == pytest.approx(0.0, abs=1e-16))
    # Then x'' = -10 t/(0.6 · 2) / s: the mass leaves.
    assert history.displacement[-1, 0] == pytest.approx(-5.0 / 6.0 * 0.1**3, rel=1e-3)


@pytest.mark.parametrize("together", [1, 7, 500])
def test_steps_that_are_looked_at_together(rack, monkeypatch, together):
    """No contact is missed, and energies and probes are those of one step after the other."""
    load = np.sin(0.02 * np.arange(1201))[:, None]
    options = {"e": 0.3, "theta": 0.6, "load": load, "damping": Rayleigh(0.2, 1e-4)}
    with monkeypatch.context() as patch:
        patch.setattr(ModalMotion, "coast", lambda *_: None)
        expected = response(rack, 1200, **options)
    kept = []
    keep = ModalMotion.keep
    monkeypatch.setattr(ModalMotion, "keep", lambda s, n: (kept.append(n), keep(s, n)))
    monkeypatch.setattr(contact_loop, "COAST", together)
    found = response(rack, 1200, **options)
    assert sum(kept) > 300 and max(kept) <= together
    assert np.count_nonzero(expected.impulse) > 20
    for name in ("impulse", "gap", "displacement", "velocity"):
        one, other = getattr(found, name), getattr(expected, name)
        assert np.abs(one - other).max() < 1e-9 * np.abs(other).max(), name
    for name in ("kinetic", "elastic", "damped", "input", "contact", "numerical"):
        one, other = getattr(found.energy, name), getattr(expected.energy, name)
        assert np.abs(one - other).max() < 1e-9 * expected.energy.scale, name


@pytest.mark.parametrize("theta", [0.5, 0.6, 1.0])
def test_without_walls_it_is_the_theta_rule(theta):
    """One damped oscillator: (v, u) of a step are linear in those before."""
    m, k, alpha, h = 2.0, 50.0, 0.7, 0.02
    history = meets_wall(h, 100.0, 50, k=k, alpha=alpha, theta=theta, load=3.0)
    # Rows: m Δv + h (C v_θ + K u_θ) = h f, Δu - h v_θ = 0, for (u, v) after and before.
    after = np.array([[theta * h * k, m + theta * h * alpha * m], [1.0, -theta * h]])
    rest = 1.0 - theta
    before = np.array([[-rest * h * k, m - rest * h * alpha * m], [1.0, rest * h]])
    x = np.array([0.0, 1.0])
    for k_step in range(51):
        assert history.displacement[k_step, 0] == pytest.approx(x[0], rel=1e-11, abs=1e-14)
        assert history.velocity[k_step, 0] == pytest.approx(x[1], rel=1e-11, abs=1e-14)
        x = np.linalg.solve(after, before @ x + np.array([h * 3.0, 0.0]))
    assert history.energy.residual < 1e-13
    taken = history.energy.numerical[-1]
    assert taken == 0.0 if theta == 0.5 else taken > 1e-3


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"e": 0.5},
        {"e": 1.0},
        {"e": np.array([0.0, 0.3, 0.6, 0.9])},
        {"damping": Rayleigh(0.3, 1e-3)},
        {"theta": 0.7, "e": 0.2},
        {"theta": 1.0, "damping": Rayleigh(beta=2e-3)},
        {"load": 30.0 * np.sin(np.linspace(0.0, 40.0, 601))[:, None]},
        {"load": 8.0 * np.ones((601, 1)), "theta": 0.55},
    ],
)
def test_agrees_with_the_books(rack, options):
    history, (u, v, P) = response(rack, 600, **options), plain(rack, 600, **options)
    assert np.count_nonzero(P) > 20
    assert np.abs(history.displacement - u).max() < 1e-9 * np.abs(u).max()
    assert np.abs(history.velocity - v).max() < 1e-9 * np.abs(v).max()
    assert np.abs(history.impulse - P).max() < 1e-9 * P.max()
    energy = history.energy
    assert energy.kinetic == pytest.approx(0.5 * np.sum(v * (v @ rack["M"]), 1), rel=1e-9)
    assert energy.elastic == pytest.approx(
        0.5 * np.sum(u * (u @ rack["K"]), 1), rel=1e-9, abs=1e-12
    )
    assert energy.residual < 1e-12 and energy.gained < 1e-14
    assert history.residual.max() < 1e-12
    assert np.diff(energy.contact) / (0.5 * rack["v"] @ rack["M"] @ rack["v"]) == pytest.approx(
        work(rack, u, P), abs=1e-10
    )


@pytest.mark.parametrize("theta", [0.5, 0.75])
@pytest.mark.parametrize("e", [0.0, 0.3])
def test_energy_is_never_gained(rack, theta, e):
    history = response(rack, 4000, theta=theta, e=e)
    energy = history.energy
    total = energy.kinetic + energy.elastic
    assert np.all(np.diff(total) <= 1e-13 * total[0]) and np.any(history.impulse[500:])
    assert np.all(np.diff(energy.contact) <= 1e-14 * total[0])
    assert np.all(energy.damped == 0.0) and np.all(np.diff(energy.numerical) >= 0.0)
    assert total[0] - total[-1] == pytest.approx(energy.numerical[-1] - energy.contact[-1])


def test_newtons_law_alone_gains_energy(rack):
    """With e = 0 also for what opens behind the wall, as Newton's law alone would have it."""
    u, _, P = plain(rack, 2000, opening="newton")
    assert work(rack, u, P).max() > 1e-6
    u, _, P = plain(rack, 2000)
    assert work(rack, u, P).max() < 1e-14


def test_penetration_goes_with_the_step(rack):
    deepest = []
    for count in (500, 1000, 2000, 4000):
        rack["h"] = 1.0 / count
        history = response(rack, count, load=8.0 * np.ones((count + 1, 1)))
        fastest = np.abs(np.diff(history.gap, axis=0)).max() * count
        deepest.append(history.penetration.max())
        # About one step at the largest speed, also after many contacts.
        assert 0.0 < deepest[-1] < 2.0 * fastest / count
    assert deepest[-1] < 0.3 * deepest[0]


def test_columns_of_any_weight(rack):
    """A constraint that is an integral, as its gap is: its impulse is per weight."""
    one = response(rack, 600)
    weight = np.array([1e-3, 7.0, 0.2, 1e3])
    rack["G"], rack["gap"] = rack["G"] * weight, rack["gap"] * weight
    other = response(rack, 600)
    assert other.displacement == pytest.approx(one.displacement, rel=1e-9, abs=1e-12)
    assert other.impulse * weight == pytest.approx(one.impulse, rel=1e-8, abs=1e-9)
    assert other.gap == pytest.approx(one.gap * weight, abs=1e-9)
    assert other.residual.max() < 1e-13


def test_a_constraint_of_two_masses(rack):
    """Their mean position is held, not each one."""
    G = np.zeros((8, 1))
    G[[6, 7], 0] = 0.5
    rack["G"], rack["gap"] = G, np.array([0.01])
    history = response(rack, 400)
    behind = history.displacement[:, [6, 7]] - 0.01
    assert history.penetration[0] < 4e-3 < behind.max()
    assert history.gap[:, 0] == pytest.approx(-behind.mean(axis=1), abs=1e-14)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"steps": 0}, "0 steps: at least one is needed"),
        ({"gap": -0.1}, "1 of 1 constraints are violated at the start: constraint 0 by 0.1"),
        ({"gap": [0.1, 0.2]}, r"gaps of shape \(2,\): 1 finite numbers, or one, are needed"),
        ({"gap": np.nan}, r"gaps of shape \(\): 1 finite numbers"),
        ({"restitution": [0.0, 0.0]}, r"restitutions of shape \(2,\)"),
        ({"restitution": 1.01}, r"from 1\.01 to 1\.01: with θ = 0\.5 they must be from 0 to 1"),
        ({"restitution": -0.1}, r"from -0\.1 to -0\.1"),
        ({"amplitudes": np.zeros((5, 1))}, r"loads of shape \(5, 1\), not \(11, 1\)"),
        ({"amplitudes": np.full((11, 1), np.nan)}, "the response is not finite in step 1"),
        ({"displacement": np.array([1.0])}, "constraint 0 by 0.2"),
        ({"displacement": np.zeros(2)}, r"a state of shape \(2,\) for 1 modes"),
    ],
)
def test_what_is_refused(changes, words):
    values = {"gap": 0.5, "steps": 10, **changes}
    with pytest.raises(SolutionError, match=words):
        unilateral_response(mass(1e-3), values.pop("gap"), values.pop("steps"), **values)


@pytest.mark.parametrize("theta", [0.6, 1.0])
def test_the_largest_restitution_goes_with_theta(theta):
    most = (1.0 - theta) / theta
    meets_wall(1e-3, 0.01, 20, theta=theta, e=most)
    with pytest.raises(SolutionError, match=f"with θ = {theta:g} they must be from 0 to {most:g}"):
        meets_wall(1e-3, 0.01, 20, theta=theta, e=most + 0.01)


def test_motions_that_are_refused():
    one = np.ones((3, 1))
    for h in (0.0, -1.0, np.nan):
        with pytest.raises(SolutionError, match="must be positive"):
            ModalMotion(body_before_walls(np.ones(3), one), h)
    for theta in (0.49, 1.01, np.nan):
        with pytest.raises(SolutionError, match=r"from 0\.5 to 1"):
            ModalMotion(body_before_walls(np.ones(3), one), 0.1, theta=theta)
    for name, given in (
        ("constraints", {"contact": np.ones((2, 1))}),
        ("loads", {"contact": one, "load": np.ones(3)}),
        ("probes", {"contact": one, "probes": np.ones((4, 2))}),
    ):
        with pytest.raises(SolutionError, match=f"{name} of shape .* for 3 modes"):
            ModalMotion(body_before_walls(np.ones(3), given.pop("contact")), 0.1, **given)
    none = ModalMotion(body_before_walls(np.ones(3), np.empty((3, 0))), 0.1)
    with pytest.raises(SolutionError, match="are no constraints"):
        unilateral_response(none, 0.1, 10)
    twice = ModalMotion(body_before_walls(np.ones(3), np.hstack([one, 2.0 * one])), 0.1)
    with pytest.raises(SolutionError, match="Delassus operator"):
        unilateral_response(twice, 0.1, 10)
