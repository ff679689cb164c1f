import mpmath
import numpy as np
import pytest

from impactfem.verify.contact import unilateral
from impactfem.verify.contact.unilateral import (
    CONTACT,
    MASS,
    RHO,
    SPEED,
    V0,
    Impact,
    L,
    S,
    bar_matrices,
    full_bar,
    held_bar,
    impact_of,
    modal_bar,
)

# The numbers of the bar are written again in test_bar_impact.py.


@pytest.mark.parametrize("share", [*unilateral.DAMPINGS, 0.1])
def test_the_series_is_the_inverse_of_its_laplace_transform(share):
    """F̂ = ρ c S v₀ √(1 + βs)/s tanh(s L/(c √(1 + βs))): zero at the end, its integral before."""
    beta = share * CONTACT
    found = held_bar(beta)
    size = RHO * SPEED * S * V0

    def force(s):
        root = mpmath.sqrt(1 + beta * s)
        return size * root / s * mpmath.tanh(s * L / (SPEED * root))

    def inverse(transform, t):
        return float(mpmath.invertlaplace(transform, t, method="talbot", degree=40))

    assert inverse(force, 0.5 * found.duration) == pytest.approx(size, rel=0.05)
    assert abs(inverse(force, found.duration)) < 1e-6 * size
    impulse = inverse(lambda s: force(s) / s, found.duration)
    assert found.impulse == pytest.approx(impulse, rel=1e-7)


def test_the_series_of_little_damping_is_the_elastic_bar():
    found = held_bar(1e-4 * CONTACT)
    assert found.duration == pytest.approx(CONTACT, rel=2e-3)
    assert found.impulse == pytest.approx(2.0 * MASS * V0, rel=0.02)
    assert held_bar(0.05 * CONTACT).epsilon < held_bar(0.02 * CONTACT).epsilon < found.epsilon


def test_an_impact():
    one = Impact(2.0, 6.0)
    assert one.force == 3.0 and one.epsilon == pytest.approx(6.0 / (MASS * V0) - 1.0)


def test_matrices_of_the_bar():
    K, M = (A.toarray() for A in bar_matrices(7))
    x = np.linspace(0.0, L, 15)
    assert np.abs(K @ np.ones(15)).max() < 1e-5
    assert x @ K @ x == pytest.approx(unilateral.E * S * L)
    assert M.sum() == pytest.approx(MASS)
    assert x**2 @ M @ x**2 == pytest.approx(RHO * S * L**5 / 5.0)


def test_the_solvers_agree():
    one, other = modal_bar(20, 1e-6), full_bar(20, 1e-6)
    assert np.abs(one.impulse - other.impulse).max() < 1e-9 * one.impulse.max()
    assert impact_of(one).duration == pytest.approx(impact_of(other).duration, rel=1e-12)


@pytest.mark.parametrize("part", ["stiffness", "mass"])
def test_a_wrong_bar_is_seen(monkeypatch, failed, part):
    right = bar_matrices

    def wrong(elements):
        K, M = right(elements)
        return (1.03 * K, M) if part == "stiffness" else (K, 1.03 * M)

    monkeypatch.setattr(unilateral, "bar_matrices", wrong)
    for rows in (unilateral.elastic_bar(), unilateral.damped_bar()):
        found = failed(rows)
        for solver in unilateral.SOLVERS:
            assert f"force, mean of the contact, {solver}" in found
            assert f"duration, {solver}" in found


def test_a_wrong_damping_is_seen(monkeypatch, failed):
    right = modal_bar
    monkeypatch.setitem(unilateral.SOLVERS, "modal", lambda n, beta: right(n, 1.1 * beta))
    found = failed(unilateral.damped_bar())
    assert {"ε by the impulse, modal", "force, mean of the contact, modal"} <= found
    assert not any(quantity.endswith("full") for quantity in found)
