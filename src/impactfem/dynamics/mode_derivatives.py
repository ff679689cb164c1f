"""Derivatives of natural modes by what changes stiffness and mass, from the modes themselves."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from impactfem.dynamics.columns import inner, product, summed
from impactfem.dynamics.factorisation import Factorisation
from impactfem.dynamics.modes import Modes
from impactfem.system.arrays import Array
from impactfem.system.errors import SolutionError

TOLERANCE = 1e-8  # relative error of the derivative of a shape, in the norm of K − λ M
MOST_STEPS = 200
EQUAL = 1e-6  # relative distance of eigenvalues below which modes have no derivatives of their own


def mode_derivatives(
    K: Any, M: Any, found: Modes, numbers: Sequence[int], changes: Sequence[tuple[Array, Array]]
) -> tuple[Array, Array]:
    """Derivatives of the eigenvalues λ = ω² and of the shapes φ, φᵀ M φ = 1. Collective.

    With dK and dM the derivatives of the matrices,

        dλ = φᵀ (dK − λ dM) φ,    (K − λ M) dφ = −(dK − dλ M − λ dM) φ,    φᵀ M dφ = −½ φᵀ dM φ

    (Fox and Kapoor 1968). dφ is a sum over all modes φ_j that are known, with the factors
    φ_jᵀ(λ dM − dK)φ/(λ_j − λ), and a rest, which is M-orthogonal to them: conjugate gradients find
    it, preconditioned by K⁻¹, as K − λ M is positive definite there.

    Args:
        K: Stiffness (AIJ).
        M: Mass (AIJ).
        found: Its lowest modes.
        numbers: Which of them, from 0.
        changes: dK φ and dM φ of these modes for each parameter, shape (n_local, k) each.

    Gives dλ, shape (n_changes, k), and dφ, shape (n_changes, n_local, k). SolutionError where a
    mode has the frequency of another one, or the rest is not found.
    """
    count, every = len(numbers), found.shapes
    if not len(changes) or not count:
        return np.zeros((len(changes), count)), np.zeros((len(changes), len(every), count))
    λ_all = (2.0 * np.pi * found.frequency) ** 2
    λ = λ_all[list(numbers)]
    apart = λ_all[:, None] - λ
    apart[list(numbers), range(count)] = np.inf
    if np.abs(apart / λ).min() < EQUAL:
        where = found.frequency[numbers[int(np.argmin(np.abs(apart / λ).min(axis=0)))]]
        raise SolutionError(f"two modes at {where:.6g} Hz have no derivatives of their own")
    MΦ = product(M, every)
    dλ = np.empty((len(changes), count))
    known, loads = [], []
    for p, (dKφ, dMφ) in enumerate(changes):
        f = dMφ * λ - dKφ
        S = inner(M, every, f)  # φ_jᵀ (λ dM − dK) φ
        own = S[list(numbers), range(count)]
        dλ[p] = -own
        C = S / apart
        C[list(numbers), range(count)] = -0.5 * summed(
            M, np.einsum("ni,ni->i", every[:, list(numbers)], dMφ)
        )
        known.append(every @ C)
        loads.append(f)
    λ = np.tile(λ, len(changes))
    r = np.hstack(loads)
    x = np.zeros_like(r)

    def dots(a: Array, b: Array) -> Array:
        return summed(M, np.einsum("ni,ni->i", a, b))

    with Factorisation(K, name="the stiffness matrix") as factor:
        whole = dots(r, factor.solve_block(r))
        before, direction = np.ones_like(whole), x
        for _ in range(MOST_STEPS):
            # What rounding puts into the space of the known modes would grow.
            r -= MΦ @ inner(M, every, r)
            z = factor.solve_block(r)
            z -= every @ inner(M, MΦ, z)
            rz = dots(r, z)
            if np.all(rz <= TOLERANCE**2 * whole):
                break
            direction = z + direction * (rz / before)
            load = product(K, direction) - product(M, direction) * λ
            step = rz / np.maximum(dots(direction, load), 1e-300)
            x += step * direction
            r -= step * load
            before = np.maximum(rz, 1e-300)
        else:
            raise SolutionError("the derivatives of the modes were not found: compute more modes")
    parts = np.hsplit(x, len(changes))
    return dλ, np.array([a + b for a, b in zip(known, parts, strict=True)])
