"""Models that a reduced model is nested in, on the membrane."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.error_band import by_third_octave
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.larger_models import SAFETY, SHARES, larger_models
from impactfem.reduction.reduced import reduced_model

SHIFT = (2.0 * np.pi * 60.0) ** 2
OMEGA = 2.0 * np.pi * np.geomspace(2.0, 100.0, 160)
DAMPING = Rayleigh(1.5, 8e-4)


@pytest.fixture
def basis(membrane: Any, petsc: Any) -> Callable[[int], KrylovBasis]:
    """Make a basis of some block steps of the membrane, with three loads."""

    def make(steps: int) -> KrylovBasis:
        model = membrane()
        made = KrylovBasis(petsc(model.K), petsc(model.M), SHIFT)
        made.add(model.loads)
        made.grow(steps - 1)
        return made

    return make


def test_sizes(basis: Callable[[int], KrylovBasis]) -> None:
    """The shares of 30 vectors, in whole block steps of three; the model itself stays."""
    made = basis(10)
    used = reduced_model(made)
    larger = larger_models(made, made.size)
    assert SHARES == (1.1, 1.15, 1.2)
    assert [len(model.coordinates) for model in larger] == [33, 36]  # 34.5 takes 36, too
    again = reduced_model(made, made.sizes[9])
    assert np.allclose(again.eigenvalue, used.eigenvalue, rtol=1e-12)
    # From 60 vectors 66, 69 and 72 are asked for.
    made = basis(20)
    assert [len(model.coordinates) for model in larger_models(made, made.size)] == [
        66,
        69,
        72,
    ]


def test_space_that_holds_all(basis: Callable[[int], KrylovBasis]) -> None:
    """It cannot grow: the larger models are the model, and its error is nothing."""
    made = basis(80)
    used, rows = reduced_model(made), made.rows(np.arange(4))
    response = used.transfer(rows, OMEGA, DAMPING)
    for model in larger_models(made, made.size):
        assert np.array_equal(model.transfer(rows, OMEGA, DAMPING), response)


@pytest.mark.parametrize("steps", [8, 12, 16])
def test_they_tell_the_error(
    membrane: Any, basis: Callable[[int], KrylovBasis], steps: int
) -> None:
    """Of transfer functions, against direct solutions: held by the factor, and seldom without."""
    made = basis(steps)
    used = reduced_model(made)
    larger = larger_models(made, made.size)
    rows = made.rows(np.arange(168))
    response = used.transfer(rows, OMEGA, DAMPING)
    model = membrane()
    truth = model.transfer(OMEGA, DAMPING, model.loads)
    error = by_third_octave(OMEGA, np.abs(response - truth))
    apart = by_third_octave(
        OMEGA,
        np.max([np.abs(response - m.transfer(rows, OMEGA, DAMPING)) for m in larger], axis=0),
    )
    matters = error > 1e-4 * by_third_octave(OMEGA, np.abs(truth))
    assert matters.sum() > 1000
    ratio = SAFETY * apart[matters] / error[matters]
    assert np.mean(ratio >= 1.0) > 0.95
    assert np.mean((ratio >= 1.0) & (ratio <= 10.0)) > 0.95
    assert np.mean(ratio >= SAFETY) < 0.8
