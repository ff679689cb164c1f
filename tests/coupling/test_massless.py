"""Contact points without mass: the flexibility, the limit of the force, energies, symmetry."""

import numpy as np
import pytest

from impactfem.coupling.body import reduced_body
from impactfem.coupling.links import Assembly, Link
from impactfem.coupling.massless import RESOLVED, MasslessPoints, massless_response
from impactfem.coupling.modal_motion import ModalMotion
from impactfem.coupling.unilateral import unilateral_response
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import SolutionError
from impactfem.verify.massless import EXACT, FIRST, massless_strips, strips


def test_static_flexibility_is_that_of_the_body():
    """With and without mass both parts add up; modes far below the corner keep their rows."""
    assembly, shifts, _ = strips(40)
    points = MasslessPoints.of(assembly, shifts)
    elastic = assembly.eigenvalue > 0.0
    λ, Γ, kept = (
        x[..., elastic] for x in (assembly.eigenvalue, assembly.gamma, points.assembly.gamma)
    )
    rigid = assembly.gamma[:, ~elastic]
    loose = (rigid @ rigid.T) / FIRST.shift(40)
    whole = points.flexibility - loose + (kept / λ) @ kept.T
    assert whole == pytest.approx((Γ / λ) @ Γ.T, rel=1e-12)
    # The first mode of 15.6 m, far below the corner, moves the point almost as before.
    assert kept[0, 0] == pytest.approx(Γ[0, 0], rel=0.005)
    assert np.abs(kept[0]).min() < 0.5 * np.abs(Γ[0]).max()


@pytest.mark.parametrize("step", [0.336e-3, 0.042e-3])
def test_the_force_has_a_limit(step):
    history = massless_strips(16, step)
    assert history.largest.max() == pytest.approx(1.294 * EXACT, rel=0.01)
    assert history.energy.residual < 1e-12 and history.residual.max() < 1e-12


def test_the_force_of_moreau_has_none():
    """It grows as the step shrinks, where that of points without mass does not."""
    assembly, _, velocity = strips(16)
    peaks = []
    for step in (0.336e-3, 0.084e-3, 0.021e-3):
        motion = ModalMotion(assembly, step)
        run = unilateral_response(motion, assembly.gaps, round(0.01 / step), velocity=velocity)
        peaks.append(run.force.max())
    assert peaks[1] > 1.2 * peaks[0] and peaks[2] > 1.5 * peaks[1]


def test_work_in_the_gap_is_of_second_order():
    lost = []
    for parts in (1, 4):
        assembly, shifts, velocity = strips(16)
        points = MasslessPoints.of(assembly, shifts)
        step = RESOLVED / points.corner / parts
        run = massless_response(
            points, ModalMotion(points.assembly, step), round(0.03 / step), velocity=velocity
        )
        assert run.work[-1].sum() == pytest.approx(run.energy.contact[-1], rel=1e-9)
        lost.append(np.abs(run.energy.contact).max() / run.energy.scale)
    assert lost[1] < 0.25 * lost[0] < 1e-3


def pair(gap=0.0, flipped=False, compliance=0.0, **options):
    """Two masses on springs, two points each, that approach each other; their history."""
    shapes = {
        "a": np.array([[0.02, 0.01], [0.02, -0.01]]),
        "b": np.array([[0.01, 0.02], [0.01, 0.005]]),
    }
    λ = {"a": np.array([900.0, 2500.0]), "b": np.array([1600.0, 4900.0])}
    order = ("b", "a") if flipped else ("a", "b")
    bodies = [reduced_body(k, λ[k], Rayleigh(0.1, 1e-4), {"edge": shapes[k]}) for k in order]
    sign = -1.0 if flipped else 1.0
    ends = [(k, "edge") for k in order]
    links = [Link(str(k), *ends, n, gap) for k, n in enumerate(np.eye(2))]
    points = MasslessPoints.of(Assembly(bodies, links), {"a": 200.0**2, "b": 300.0**2})
    v = {"a": np.array([sign * 20.0, 0.0]), "b": np.zeros(2)}
    start = np.concatenate([v[k] for k in order])
    own = {"compliance": np.full(2, compliance), "velocity": start} | options
    return massless_response(points, ModalMotion(points.assembly, 2e-3), 200, **own)


def test_exchanged_bodies():
    first, second = pair(1e-3), pair(1e-3, flipped=True)
    assert np.count_nonzero(first.impulse) > 5
    assert np.abs(first.impulse - second.impulse).max() < 1e-10 * first.impulse.max()


def test_complementarity_and_energy_with_a_compliance_and_walls_that_move():
    t = 2e-3 * np.arange(201)
    opened = np.array([np.outer(2e-3 * (np.cos(30.0 * t) - 1.0), [1.0, 0.5])] * 2)
    opened[1] = np.outer(-0.06 * np.sin(30.0 * t), [1.0, 0.5])
    one = pair(1e-2, compliance=1e-9, opened=opened)
    soft = pair(1e-2, compliance=1e-6, opened=opened)
    for history in (one, soft):
        assert history.force.max() > 0.0 and history.impulse.min() >= 0.0
        assert history.gap.min() > -1e-15
        assert history.residual.max() < 1e-12 and history.energy.residual < 1e-12
    assert soft.largest.max() < 0.9 * one.largest.max()


def test_largest_force_of_a_group():
    alone, joined = pair(), pair(groups=np.ones((2, 1)))
    assert joined.largest.shape == (201, 1)
    assert (
        alone.largest.max(axis=1).max() <= joined.largest.max() <= alone.largest.sum(axis=1).max()
    )
    # Not below the largest mean of a step.
    assert joined.largest.max() >= joined.force.sum(axis=1).max()


def test_momentum_of_free_strips():
    assembly, shifts, velocity = strips(8)
    points = MasslessPoints.of(assembly, shifts)
    motion = ModalMotion(points.assembly, 0.3e-3)
    history = massless_response(points, motion, 100, velocity=velocity)
    rigid = assembly.eigenvalue == 0.0
    momentum = assembly.gamma[0, rigid] ** -1.0
    taken = (motion.velocity - velocity)[rigid] * momentum
    assert taken == pytest.approx(np.full(2, history.impulse.sum()), rel=1e-10)


def test_faults():
    with pytest.raises(SolutionError, match="violated at the start"):
        pair(displacement=np.array([1.0, 0.0, 0.0, 0.0]))
    assembly, _, _ = strips(8)
    for shifts in ({}, {"first": 0.0}):
        with pytest.raises(SolutionError, match="expected a positive one"):
            MasslessPoints.of(assembly, shifts)
    points = MasslessPoints.of(assembly, {"first": 1e6})
    with pytest.raises(SolutionError, match="at least one"):
        massless_response(points, ModalMotion(points.assembly, 1e-3), 0)
