"""Bases on soil: their motion in a response, what the soil radiates, and the modes with it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from impactfem.coupling.body import Body
from impactfem.coupling.links import Assembly
from impactfem.system.arrays import Array


@dataclass(frozen=True, eq=False)
class BaseHistory:
    """Motion of a base relative to the free field, x, y, z, rx, ry, rz, and force on its soil."""

    u: Array  #: displacement, shape (n_t, 6) [m, rad]
    v: Array  #: velocity, same shape
    a: Array  #: acceleration, same shape
    force: Array  #: of the raft on the soil, about the base, same shape [N, N m]
    radiated: Array  #: energy that the soil has radiated since step 0, shape (n_t,) [J]


def base_histories(
    assembly: Assembly, attached: Sequence[Array] | Array, time_step: float
) -> dict[str, BaseHistory]:
    """The bases on soil by the names of their bodies.

    What they radiate is that of the average acceleration rule, exact where a step of the
    integration is one of the samples.

    Args:
        assembly: The bodies.
        attached: y, ẏ and ÿ of what is attached to them, shape (n_t, N) each.
        time_step: Time between the samples [s].
    """
    found = {}
    for name, base in assembly.attached.bases.items():
        T, soil, y = base.motion, base.soil, base.rows
        u, v, a = (x[:, y] for x in attached)
        # S y of the soil alone, by the coordinates with unit mass; forces go with T⁻ᵀ.
        force = (a @ soil.M + v @ soil.C + u @ soil.K)[:, :6]
        w = v[:-1] + v[1:]
        lost = np.einsum("ti,ij,tj->t", w, soil.C - soil.material, w, optimize=True)
        radiated = np.cumsum(np.concatenate([[0.0], 0.25 * time_step * lost]))
        u, v, a = (x[:, :6] @ T.T for x in (u, v, a))
        found[name] = BaseHistory(u, v, a, force @ np.linalg.inv(T), radiated)
    return found


@dataclass(frozen=True, eq=False)
class CoupledModes:
    """Natural modes of a body on its soil, by ascending frequency."""

    frequency: Array  #: |s| / 2π of the eigenvalues s = −ξ ω ± iω√(1 − ξ²), shape (m,) [Hz]
    ratio: Array  #: ξ, of body and soil together, shape (m,) [-]
    #: |φᵀ M r|² / φᴴ M φ for ground motion along x, y, z, shape (m, 3) [kg].
    effective_mass: Array


def first_along(effective_mass: Array) -> int:
    """The lowest mode with at least a third of the largest effective mass, of shape (m,)."""
    return int(np.argmax(effective_mass >= effective_mass.max() / 3.0))


def coupled_modes(body: Body) -> CoupledModes:
    """Complex modes of a body on soil that swing.

    (s² M + s C + K) φ = 0 of all coordinates, those in the soil included.
    """
    assembly = Assembly([body])
    one, r = assembly.attached, len(assembly)
    n = len(one.rows)
    own = len(one.M) - n
    # y = E x with x the coordinates of the body and the own ones of what is attached.
    E = scipy.linalg.block_diag(one.rows, np.eye(own))
    diagonals = (assembly.mass, assembly.damping, assembly.eigenvalue)
    M, C, K = (
        np.diag(np.pad(diagonal, (0, own))) + E.T @ matrix @ E
        for diagonal, matrix in zip(diagonals, (one.M, one.C, one.K), strict=True)
    )
    # What is light, without mass, follows by its dashpots; the mass of the rest is made one.
    heavy, light = np.flatnonzero(M.any(axis=0)), np.flatnonzero(~M.any(axis=0))
    W = np.zeros((r + own, heavy.size))
    W[heavy] = np.linalg.inv(scipy.linalg.cholesky(M[np.ix_(heavy, heavy)], lower=True)).T
    # States: q with x = W q, the light ones, and q̇.
    X = np.hstack([W, np.eye(r + own)[:, light]])
    slow = np.linalg.inv(C[np.ix_(light, light)])
    creep = -slow @ np.hstack([(K @ X)[light], (C @ W)[light]])
    pull = -W.T @ np.hstack([K @ X, C @ W]) - (W.T @ C[:, light]) @ creep
    q, states = heavy.size, X.shape[1]
    first = np.hstack([np.zeros((q, states)), np.eye(q)])
    values, vectors = np.linalg.eig(np.vstack([first, creep, pull]))
    swings = values.imag > 0.0
    s, φ = values[swings], X @ vectors[:states, swings]
    order = np.argsort(np.abs(s))
    s, φ = s[order], φ[:, order]
    moved = np.abs(φ[:r].T @ assembly.ground) ** 2
    mass = np.einsum("im,ij,jm->m", φ.conj(), M, φ).real
    return CoupledModes(np.abs(s) / (2.0 * np.pi), -s.real / np.abs(s), moved / mass[:, None])
