import numpy as np
import pytest

from impactfem.dynamics.modes import modes
from impactfem.dynamics.participation import participation


def test_effective_masses_add_up(petsc, chain):
    n = 8
    mass = np.diag(np.arange(1.0, n + 1))
    r = np.random.default_rng(5).standard_normal((n, 6))
    r[:, 0] = 1.0
    found = modes(petsc(chain(n, last=False)), petsc(mass), n)
    part = participation(petsc(mass), found.shapes, r)
    assert part.factor.shape == (6, n)
    assert part.total == pytest.approx(np.diag(r.T @ mass @ r))
    assert part.total[0] == pytest.approx(36.0)
    assert part.effective_mass.sum(axis=1) == pytest.approx(part.total, rel=1e-10)
    assert part.share.sum(axis=1) == pytest.approx(np.ones(6), rel=1e-10)


def test_two_equal_storeys(petsc, chain):
    """m = k = 1: ω² = (3 ∓ √5)/2 and the golden ratio; Γ² = (1 + φ)² / (1 + φ²)."""
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    found = modes(petsc(chain(2, last=False)), petsc(np.eye(2)), 2)
    assert (2.0 * np.pi * found.frequency) ** 2 == pytest.approx([2.0 - golden, 1.0 + golden])
    part = participation(petsc(np.eye(2)), found.shapes, np.ones((2, 6)))
    first = (1.0 + golden) ** 2 / (1.0 + golden**2)
    assert part.share[2] == pytest.approx([first / 2.0, 1.0 - first / 2.0], rel=1e-12)
    # A shape that is none has other shares.
    wrong = participation(petsc(np.eye(2)), np.eye(2), np.ones((2, 6)))
    assert wrong.share[2] == pytest.approx([0.5, 0.5])
