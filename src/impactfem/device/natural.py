"""The natural modes of a mass and a stiffness matrix of a few degrees of freedom."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.linalg
from scipy.sparse.csgraph import connected_components

Array = npt.NDArray[np.float64]

COUPLING = 1e-12
"""Entries of the equilibrated matrices below this part of the largest couple nothing."""
WITH_MASS = 1e-12
"""Modes count whose 1/ω² is above this part of the largest one of their block."""


def natural_modes(M: Array, K: Array) -> tuple[Array, Array]:
    """Circular frequencies and shapes of the modes with mass.

    Solves M φ = (1/ω²) K φ, so that motions without mass drop out. Parts that do not couple are
    solved on their own: a mixture of modes with equal frequencies along x and along y would be a
    mode as well.

    Args:
        M: Mass, symmetric and not indefinite, shape (n, n).
        K: Stiffness, symmetric and positive definite, shape (n, n).

    Returns:
        ω, ascending, shape (m,) [rad/s], and φ with φᵀ M φ = 1, shape (n, m).
    """
    # Equilibrated first: translations and rotations differ by orders of magnitude.
    scale = 1.0 / np.sqrt(np.diag(K))
    k, m = K * np.outer(scale, scale), M * np.outer(scale, scale)
    links = (np.abs(k) > COUPLING) | (np.abs(m) > COUPLING * np.max(np.abs(m)))
    count, part = connected_components(links, directed=False)
    inverse_squares, shapes = [], []
    for number in range(count):
        dofs = np.flatnonzero(part == number)
        block = np.ix_(dofs, dofs)
        values, vectors = scipy.linalg.eigh(m[block], k[block])
        keep = values > WITH_MASS * max(float(values[-1]), 0.0)
        shape = np.zeros((M.shape[0], int(keep.sum())))
        shape[dofs] = vectors[:, keep] * scale[dofs, None] / np.sqrt(values[keep])
        inverse_squares.append(values[keep])
        shapes.append(shape)
    omega = 1.0 / np.sqrt(np.concatenate(inverse_squares))
    # Rounded: the order of two equal frequencies does not depend on their last digits.
    order = np.argsort(np.round(np.log(omega), 9), kind="stable")
    return np.asarray(omega[order], dtype=np.float64), np.hstack(shapes)[:, order]
