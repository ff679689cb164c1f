"""Sticks on soil: against dense matrices and the clamped base; closed forms are benchmarks."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from impactfem.coupling.base import coupled_modes, first_along
from impactfem.coupling.laws import KelvinVoigt
from impactfem.coupling.links import Assembly, Link
from impactfem.coupling.modal_motion import ModalMotion
from impactfem.coupling.pounding import System, simulate
from impactfem.coupling.unilateral import unilateral_response
from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.soil import HalfSpace, raft_mass, soil_of

from ..sticks.conftest import damped_stick
from .test_links import newmark

DT, STEPS = 2e-3, 1500
NONE = np.zeros((6, 6))


def half_space(speed, ratio=0.0):
    """Soil about the top of a raft of 10 m x 8 m x 1 m."""
    components, curves = HalfSpace(speed, 2000.0, 0.3).rectangle(10.0, 8.0)
    soil = soil_of(components, NONE, curves, ratio)
    T = np.eye(6)
    T[0, 4], T[1, 3] = -1.0, 1.0
    return replace(soil.moved(T), raft=raft_mass(2e5, 1.0, (64 / 12, 100 / 12)))


@pytest.fixture(scope="module")
def shaken():
    """Two seconds of shaking along x, y and z, and a second of rest."""
    ground = np.cumsum(np.random.default_rng(2).standard_normal((STEPS, 3)), axis=0)
    ground -= ground.mean(axis=0)
    return ground * np.sin(np.pi * np.minimum(np.arange(STEPS) / 1000.0, 1.0))[:, None]


def dense(stick):
    """Matrices of the masters relative to the base, of the base, and of the soil."""
    R, M, soil = stick.rigid_body(), stick.M, stick.soil
    n, k = stick.n, len(soil)
    matrices = [np.zeros((n + k, n + k)) for _ in range(3)]
    for whole, own, below in zip(
        matrices, (M, stick.C, stick.K), (soil.M, soil.C, soil.K), strict=True
    ):
        whole[:n, :n] = own
        whole[n:, n:] = below
    matrices[0][:n, n : n + 6] = M @ R
    matrices[0][n : n + 6, :n] = R.T @ M
    matrices[0][n : n + 6, n : n + 6] += R.T @ M @ R + soil.raft
    return matrices, R


@pytest.mark.parametrize("ratio", [0.0, 0.05])
def test_against_dense_matrices(floors, shaken, ratio):
    """Shaken, with degrees of freedom in the soil, also those without mass; and at rest again."""
    stick = damped_stick("a", floors(3), damping=Rayleigh(0.6, 8e-4), soil=half_space(200.0, ratio))
    response = simulate(System((stick,), ()), shaken, DT)
    (M, C, K), R = dense(stick)
    n = stick.n
    # The free-field motion loads masters and raft, not the soil.
    f = -shaken @ M[:, n : n + 3].T
    f[:, n + 6 :] = 0.0
    u, _ = newmark(M, C, K, f, DT)
    expected = u[:, :n] + u[:, n : n + 6] @ R.T
    assert np.abs(response.u - expected).max() < 1e-8 * np.abs(expected).max()
    base = response.bases["a"]
    assert base.u[-1] == pytest.approx(u[-1, n : n + 6], abs=1e-8 * np.abs(base.u).max())
    # Equilibrium: soil holds what the masses push, and the energies balance at every step.
    total = stick.M @ response.absolute_acceleration[700] @ R
    raft = stick.soil.raft @ (base.a[700] + np.pad(shaken[700], (0, 3)))
    assert base.force[700] == pytest.approx(
        -(total + raft), rel=1e-6, abs=1e-6 * np.abs(total).max()
    )
    energy = response.energy
    assert energy.residual < 1e-9  # rounding: 2e-10 without AVX-512, less with it
    assert (np.diff(energy.radiated) >= 0.0).all() and energy.radiated[-1] > 0.01 * energy.scale


def test_nothing_drifts(floors, shaken):
    """What is left of the motion when the ground rests goes away, of the soil as well."""
    stick = damped_stick("a", floors(2), damping=Rayleigh(0.6, 2e-3), soil=half_space(150.0, 0.02))
    ground = np.pad(shaken, ((0, 4 * STEPS), (0, 0)))
    response = simulate(System((stick,), ()), ground, DT)
    for u in (response.bases["a"].u, response.u):
        assert np.abs(u[-100:]).max() < 5e-4 * np.abs(u).max()


def test_very_stiff_soil_is_a_clamped_base(row, shaken):
    """To 1e-6 of displacements at 1e6 m/s, and of forces and accelerations at 1e7 m/s."""
    clamped = row(0.005)
    reference = simulate(clamped, shaken[:800], DT / 4)
    assert reference.force.max() > 0.0

    def off(speed):
        sticks = tuple(replace(stick, soil=half_space(speed)) for stick in clamped.sticks)
        found = simulate(replace(clamped, sticks=sticks), shaken[:800], DT / 4)
        names = ("u", "force", "absolute_acceleration")
        return [
            np.abs(getattr(found, k) - getattr(reference, k)).max()
            / np.abs(getattr(reference, k)).max()
            for k in names
        ]

    assert off(1e6)[0] < 1e-6
    assert max(off(1e7)) < 1e-6
    assert off(1e4)[0] > 1e-4


def test_damping_of_the_modes_is_the_decay(floors):
    """A stick pulled along y and let go loses exp(−2πξ) a cycle, its soil included."""
    stick = damped_stick("a", floors(1), soil=half_space(400.0))
    system = System((stick,), ())
    body = system.modes[0][1]
    modes = coupled_modes(body)
    k = first_along(modes.effective_mass[:, 1])
    f, ξ = modes.frequency[k], modes.ratio[k]
    u0 = np.linalg.solve(stick.K, stick.M @ stick.rigid_body()[:, 1]) * 1e-2
    dt = 1.0 / f / 400.0
    u = simulate(system, np.zeros((4000, 3)), dt, u0=u0).u[:, 1]
    peaks = np.flatnonzero((u[1:-1] > u[:-2]) & (u[1:-1] > u[2:])) + 1
    decay = np.log(u[peaks[3]] / u[peaks[8]]) / 5.0
    assert decay == pytest.approx(2.0 * np.pi * ξ / np.sqrt(1.0 - ξ**2), rel=5e-3)


def test_the_first_mode_is_followed_down_to_mud(floors):
    """Softer soil never shortens the first period, however much it damps."""
    found = []
    for speed in (10.0, 20.0, 60.0, 200.0, 1e3, 1e5):
        body = System((damped_stick("a", floors(3), soil=half_space(speed)),), ()).modes[0][1]
        modes = coupled_modes(body)
        found.append([modes.frequency[first_along(modes.effective_mass[:, k])] for k in range(2)])
    assert np.all(np.diff(found, axis=0) > 0.0)
    clamped = np.sqrt(body.eigenvalue) / (2.0 * np.pi)
    for k in range(2):
        bends = first_along(body.participation[:, k] ** 2)
        assert found[-1][k] == pytest.approx(clamped[bends], rel=1e-3)


def test_unilateral_links_of_a_stick_on_soil(floors):
    """Before a rigid wall by Moreau's rule: the energies balance, the wall holds."""
    stick = damped_stick("a", floors(2), damping=Rayleigh(0.6, 8e-4), soil=half_space(200.0))
    (_, body), *_ = System((stick,), ()).modes
    wall = Link("wall", ("a", "floor 2"), None, np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0]), 0.002)
    assembly = Assembly([body], [wall])
    motion = ModalMotion(assembly, 5e-4, load=assembly.ground)
    pulse = np.zeros((2001, 3))
    pulse[:400, 1] = -5.0
    history = unilateral_response(motion, assembly.gaps, 2000, amplitudes=pulse)
    assert history.impulse.max() > 0.0
    assert history.energy.residual < 1e-9
    assert history.penetration.max() < 1e-4


def test_two_sticks_on_soil_pound(row, shaken):
    """With a contact law: larger motions than on clamped bases, and the energies balance."""
    clamped = row(0.004, law=KelvinVoigt(1e9, 0.1, mass=1.2e5))
    soil = half_space(150.0)
    soft = replace(clamped, sticks=tuple(replace(stick, soil=soil) for stick in clamped.sticks))
    found, fixed = (simulate(system, shaken[:1000], DT / 4) for system in (soft, clamped))
    assert found.force.any() and fixed.force.any()
    assert found.energy.residual < 1e-8
    assert scipy.linalg.norm(found.u) > scipy.linalg.norm(fixed.u)
    # Forces in the storeys are those of the deformation, without the motion of the base.
    assert np.abs(found.deformation("u")).max() < np.abs(found.u).max()
