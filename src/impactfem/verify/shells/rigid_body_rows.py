"""Rows on the rigid-body motions of a free model."""

from __future__ import annotations

import numpy as np
import scipy.linalg
import scipy.sparse.linalg

from impactfem.building.rigid_body import rigid_body
from impactfem.building.shell_model import ShellModel
from impactfem.verify.row import Row

ZERO = 1e-11
"""An eigenvalue below this part of the largest one is zero; the next ones are above 1e-9."""


def rigid_body_rows(benchmark: str, label: str, model: ShellModel) -> list[Row]:
    """|rᵀ K r| over the norm of K for unit rigid motions r, and the zero eigenvalues of K.

    Args:
        benchmark: Name of the benchmark.
        label: What the model is.
        model: A model that nothing holds.
    """
    r = rigid_body(model.nodes, model.nodes.mean(axis=0))
    r /= np.linalg.norm(r, axis=0)
    energy = np.abs(r.T @ (model.K @ r)).max() / scipy.sparse.linalg.norm(model.K)
    values = scipy.linalg.eigvalsh(model.K.toarray())
    return [
        Row(
            benchmark,
            f"largest energy over the norm of K, {label}",
            0.0,
            float(energy),
            "-",
            1e-15,
            "rigid motions strain nothing",
            absolute=True,
        ),
        Row(
            benchmark,
            f"zero eigenvalues, {label}",
            6.0,
            float(np.count_nonzero(np.abs(values) < ZERO * values[-1])),
            "-",
            0.0,
            "a free body has six",
        ),
    ]
