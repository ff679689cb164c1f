import numpy as np
import pytest

from impactfem.device.body import Body
from impactfem.device.interface import MountedDevice, interface_of
from impactfem.device.mounted_march import march

STEP, SAMPLES, SUBSTEPS = 2e-3, 60, 3


def system(pump, rank):
    """Twenty modes, two devices; anchors that move in `rank` ways only."""
    rng = np.random.default_rng(2)
    eigenvalue = (2.0 * np.pi * np.geomspace(1.5, 4000.0, 20)) ** 2
    shapes = 0.02 * rng.standard_normal((12, rank)) @ rng.standard_normal((rank, 20))
    body = Body.at_height(700.0, 0.3, 30.0, 40.0, 50.0)
    devices = [
        MountedDevice("pump", pump(z=8e8), shapes[:6], drag=True),
        MountedDevice("body", body, shapes[6:]),
    ]
    ground = rng.standard_normal((SAMPLES, 3))
    loads = rng.standard_normal((SAMPLES, 20))
    return eigenvalue, 0.6 + 2e-4 * eigenvalue, loads, interface_of(devices), ground


def dense(eigenvalue, damping, loads, interface, ground):
    """The same rule with one matrix of everything; y and F at the samples."""
    r, n = len(eigenvalue), len(interface.M)
    B = np.eye(len(interface.shapes), n).T @ interface.shapes
    B = np.hstack([B, np.eye(n)[:, len(interface.shapes) :]])
    n_all = B.shape[1]

    def whole(own, matrix):
        out = B.T @ matrix @ B
        out[:r, :r] += np.diag(own)
        return out

    M, C, K = (
        whole(own, matrix)
        for own, matrix in (
            (np.ones(r), interface.M),
            (damping, interface.C),
            (eigenvalue, interface.K),
        )
    )
    h = STEP / SUBSTEPS
    fine = np.linspace(0.0, SAMPLES - 1.0, SUBSTEPS * (SAMPLES - 1) + 1)
    at = np.arange(SAMPLES)
    p, g = (np.column_stack([np.interp(fine, at, q) for q in of.T]) for of in (loads, ground))
    f = -g @ (B.T @ interface.M @ interface.R).T
    f[:, :r] += p
    u, v = np.zeros(n_all), np.zeros(n_all)
    a = np.linalg.solve(M, f[0])
    S = M + 0.5 * h * C + 0.25 * h**2 * K
    states = [(u, v, a)]
    for load in f[1:]:
        u_star, v_star = u + h * v + 0.25 * h**2 * a, v + 0.5 * h * a
        a = np.linalg.solve(S, load - C @ v_star - K @ u_star)
        u, v = u_star + 0.25 * h**2 * a, v_star + 0.5 * h * a
        states.append((u, v, a))
    u, v, a = (np.array(part)[::SUBSTEPS] @ B.T for part in zip(*states, strict=True))
    inertia = (a + ground @ interface.R.T) @ interface.M
    F = -(inertia + v @ interface.C + u @ interface.K)[:, : len(interface.shapes)]
    return u.T, v.T, a.T, F.T


@pytest.mark.parametrize("rank", [20, 3])
def test_against_one_matrix_of_everything(pump, rank):
    given = system(pump, rank)
    found = march(*given, STEP / SUBSTEPS, SUBSTEPS)
    wanted = dense(*given)
    for value, exact in zip(
        (found.displacement, found.velocity, found.acceleration, found.force), wanted, strict=True
    ):
        assert value == pytest.approx(exact, abs=1e-10 * np.abs(exact).max())
    assert found.energy.residual < 1e-12
    other = march(*given, STEP / SUBSTEPS, SUBSTEPS - 1)
    assert np.abs(other.force - found.force).max() > 1e-3 * np.abs(found.force).max()


def test_nothing_moves_without_loads(pump):
    eigenvalue, damping, loads, interface, ground = system(pump, 20)
    found = march(eigenvalue, damping, 0.0 * loads, interface, 0.0 * ground, STEP, 1)
    assert not found.acceleration.any() and not found.force.any()
    assert found.energy.residual == 0.0
    pushed = march(eigenvalue, damping, 0.0 * loads, interface, ground, STEP, 1)
    assert pushed.force.any()
