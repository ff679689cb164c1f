import mpmath
import numpy as np
import pytest
from scipy.special import erf

from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.newmark import Newmark
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.modal_response import STEPS, modal_response
from impactfem.reduction.reduced import ReducedModel, reduced_model
from impactfem.system.errors import SolutionError

SHIFT = (2.0 * np.pi * 60.0) ** 2
RATIOS = (0.0, 1e-6, 0.02, 0.7, 1.0 - 1e-6, 1.0 - 1e-13, 1.0, 1.0 + 1e-13, 1.0 + 1e-6, 1.5, 1e4)


def modes_alone(*eigenvalues):
    """Modes that are loaded with 1 each by a pattern of its own."""
    n = len(eigenvalues)
    return ReducedModel(np.array(eigenvalues), np.eye(n), np.eye(n), 1.0, np.zeros((0, n)))


def integrated(eigenvalue, damping, dt):
    """D and G by the matrix exponential with 60 digits."""
    with mpmath.workdps(60):
        B = mpmath.zeros(4)
        B[0, 1] = B[1, 2] = 1
        B[1, 0], B[1, 1] = -mpmath.mpf(eigenvalue), -mpmath.mpf(damping)
        B[2, 3] = 1 / mpmath.mpf(dt)
        # Halved until it is small, and squared as often.
        size = mpmath.mnorm(B * dt, 1)
        halvings = max(0, int(mpmath.ceil(mpmath.log(size, 2))) + 4)
        E, term = mpmath.eye(4), mpmath.eye(4)
        for k in range(1, 40):
            term = term * (B * dt / mpmath.mpf(2) ** halvings) / k
            E += term
        for _ in range(halvings):
            E = E * E
        E = np.array(E.tolist(), dtype=np.float64)
    return E[:2, :2], np.column_stack([E[:2, 2] - E[:2, 3], E[:2, 3]])


@pytest.mark.parametrize("dt", [1e-3, 1e-4])
@pytest.mark.parametrize("eigenvalue", [0.0, 1.0, 1e4, 0.9e6, 1.1e6, 1e8, 1e10, 1e14])
def test_the_exact_step(eigenvalue, dt):
    omega = np.sqrt(eigenvalue)
    damping = np.array(
        [0.0, 0.3 / dt, 50.0 / dt] if omega == 0.0 else 2.0 * omega * np.array(RATIOS)
    )
    D, G = STEPS["exact"](np.full(len(damping), eigenvalue), damping, dt)
    apart = 0.0
    for k, c in enumerate(damping):
        exact_D, exact_G = integrated(eigenvalue, c, dt)
        # In the state (z max(ω, 1/Δt), ż), whose parts are alike.
        scale = np.array([max(omega, 1.0 / dt), 1.0])
        error = (D[k] - exact_D) * scale[:, None] / scale
        assert np.abs(error).max() < 2e-12, c
        for row in (0, 1):
            assert np.abs(G[k, row] - exact_G[row]).max() < 1e-11 * np.abs(exact_G[row]).max(), c
        # z̈ under a load that rises to 1.
        p = np.array([0.0, 1.0])
        found, exact = (p - c * g[1] - eigenvalue * g[0] for g in (G[k], exact_G))
        assert np.abs(found - exact).max() < 1e-12, c
        newmark = STEPS["newmark"](np.array([eigenvalue]), np.array([c]), dt)[0][0]
        apart = max(apart, np.abs((newmark - exact_D) * scale[:, None] / scale).max())
    if omega * dt > 0.05:
        assert apart > 1e-4


def test_decay_to_the_static_displacement():
    """Under a constant load λ, which begins with the first sample."""
    model = modes_alone(400.0, 1e10)
    n, dt, alpha = 500, 1e-3, 2.0
    found = modal_response(model, np.tile(model.eigenvalue, (n + 1, 1)), dt, Rayleigh(alpha))
    time = dt * np.arange(n + 1)
    for k, omega in enumerate(np.sqrt(model.eigenvalue)):
        damped = np.sqrt(omega**2 - 1.0)
        decay = np.exp(-time) * (np.cos(damped * time) + np.sin(damped * time) / damped)
        assert found.displacement[k] == pytest.approx(1.0 - decay, abs=1e-10)
    assert found.acceleration[:, 0] == pytest.approx(model.eigenvalue, rel=1e-13)


@pytest.mark.parametrize("damping", [Rayleigh(), Rayleigh(0.5, 1e-4), Rayleigh(1.5, 8e-4)])
def test_newmark_as_of_the_full_model(membrane, petsc, damping):
    model = membrane()
    K, M, dt, n = petsc(model.K), petsc(model.M), 1e-3, 300
    loads = np.random.default_rng(4).standard_normal((n + 1, 3))
    probes = np.array([0, 40, 167])
    with Newmark(K, M, dt, model.loads, damping=damping) as full:
        expected = full.march(full.start(loads[0]), loads, probes=probes)
    with KrylovBasis(K, M, SHIFT) as basis:
        basis.add(model.loads)
        basis.grow(100)
    reduced = reduced_model(basis)
    assert len(reduced.eigenvalue) == 168
    shapes = reduced.shapes(basis.rows(probes))
    found = modal_response(reduced, loads, dt, damping, scheme="newmark")
    exact = modal_response(reduced, loads, dt, damping)
    for name in ("displacement", "velocity", "acceleration"):
        history = expected.motion[name].T
        scale = np.abs(history).max()
        assert np.abs(shapes @ getattr(found, name) - history).max() < 1e-9 * scale, name
        assert np.abs(shapes @ getattr(exact, name) - history).max() > 1e-2 * scale, name


def test_refused():
    model = modes_alone(1.0)
    with pytest.raises(SolutionError, match="scheme verlet: there"):
        modal_response(model, np.ones((3, 1)), 0.1, Rayleigh(0.0, 0.0), scheme="verlet")
    for step in (0.0, -0.1, np.nan):
        with pytest.raises(SolutionError, match="must be positive"):
            modal_response(model, np.ones((3, 1)), step, Rayleigh(0.0, 0.0))


@pytest.mark.parametrize("time_step", [1e-3, 0.5e-3, 0.25e-3])
def test_a_force_that_jumps_on_the_end_of_a_damped_bar(time_step):
    """The acceleration of the end has no limit as the step goes to 0: it grows as 1/√Δt.

    With internal damping β the step p₀ on a bar of the impedance Z = m'c gives its end the
    acceleration p₀ exp(−t/β)/(Z √(πβt)) (Laplace transform, until the wave is back), and a ramp
    over one step its mean over that step, p₀ erf(√(Δt/β))/(Z Δt). Docs: time-step-study.md.
    """
    beta, speed, length, mass = 1.06e-3, 1915.0, 15.6, 170.1e3  # floor 8 of the paper's building
    impedance, steps = mass * speed, round(4e-3 / time_step)
    n = np.arange(6000)
    shape = np.sqrt(np.where(n == 0, 1.0, 2.0) / (mass * length))[:, None]
    bar = ReducedModel(
        (n * np.pi * speed / length) ** 2, shape, np.zeros((0, len(n))), 1.0, np.zeros((0, len(n)))
    )
    jump, ramp = np.ones((steps + 1, 1)), np.ones((steps + 1, 1))
    ramp[0] = 0.0
    found = [
        shape[:, 0] @ modal_response(bar, load, time_step, Rayleigh(beta=beta)).acceleration
        for load in (jump, ramp)
    ]
    time = time_step * np.arange(1, steps + 1)
    exact = np.exp(-time / beta) / (impedance * np.sqrt(np.pi * beta * time))
    np.testing.assert_allclose(found[0][1:], exact, rtol=2e-3)
    mean = erf(np.sqrt(time_step / beta)) / (impedance * time_step)
    assert found[1].max() == pytest.approx(mean, rel=1e-3)
