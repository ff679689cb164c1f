"""Motions that no stiffness holds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from impactfem.system.errors import ImpactfemError

Array = npt.NDArray[np.float64]

MECHANISM = 1e-12
"""Smallest eigenvalue of the equilibrated stiffness, whose diagonal is 1, that holds a motion."""
NAMED = 0.1
"""Motions are named that have this part of the largest one in the mechanism."""


def refuse_mechanism(name: str, K: Array, motions: Sequence[str]) -> None:
    """Refuse a stiffness that is not positive definite.

    Args:
        name: Name of the device.
        K: Symmetric stiffness, shape (n, n).
        motions: Names of its rows.

    Raises:
        ImpactfemError: A motion has no stiffness, or several together have none; they are named.
    """
    diagonal = np.diag(K)
    if np.any(diagonal <= 0.0):
        loose = [motions[i] for i in np.flatnonzero(diagonal <= 0.0)]
    else:
        scale = 1.0 / np.sqrt(diagonal)
        values, vectors = np.linalg.eigh(K * np.outer(scale, scale))
        if values[0] > MECHANISM:
            return
        shape = np.abs(vectors[:, 0])
        loose = [m for m, s in zip(motions, shape, strict=True) if s > NAMED * np.max(shape)]
    raise ImpactfemError(
        f"device {name}: a mechanism, no stiffness holds the motion {' with '.join(loose)};"
        " expected a positive definite stiffness (a motion is blocked by an infinite one)"
    )
