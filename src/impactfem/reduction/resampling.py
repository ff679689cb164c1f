"""From the time step of the sticks to that of the 3D model, with nothing lost of an impulse."""

from __future__ import annotations

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

Array = NDArray[np.float64]


def project(time: Array, values: Array, time_step: float, n_steps: int) -> Array:
    """The piecewise-linear function on a new grid that is nearest to one on another grid.

    Nearest in the mean square over the whole time: with the hat functions h_i of the new grid,
    Σ_j ∫h_i h_j dt p_j = ∫h_i f dt. As the hats add up to 1 and to t, the impulse ∫f dt and its
    moment ∫t f dt are kept exactly. Linear interpolation keeps neither.

    Args:
        time: Times of the given function, ascending, shape (n,) [s]. Outside it is zero.
        values: Its values, straight between, shape (n, m).
        time_step: Step of the new grid [s].
        n_steps: Number of its steps, from time 0 on.

    Returns:
        Values on the new grid, shape (n_steps + 1, m).
    """
    end = time_step * n_steps
    grid = time_step * np.arange(n_steps + 1)
    # Between two neighbours of both grids together everything is a polynomial of degree 2.
    cuts = np.unique(np.concatenate([grid, time[(time > 0.0) & (time < end)]]))
    right = np.zeros((n_steps + 1, values.shape[1]))
    middle = 0.5 * (cuts[1:] + cuts[:-1])
    cell = np.clip((middle / time_step).astype(np.int64), 0, n_steps - 1)
    length = np.diff(cuts)
    # Gauss's rule of two points is exact for cubics.
    for node in (-1.0 / np.sqrt(3.0), 1.0 / np.sqrt(3.0)):
        at = middle + 0.5 * node * length
        f = np.empty((len(at), values.shape[1]))
        for j, column in enumerate(values.T):
            f[:, j] = np.interp(at, time, column, 0.0, 0.0)
        f *= 0.5 * length[:, None]
        share = (at / time_step - cell)[:, None]
        np.add.at(right, cell, f * (1.0 - share))
        np.add.at(right, cell + 1, f * share)
    band = np.zeros((2, n_steps + 1))
    band[0, 1:] = time_step / 6.0
    band[1] = 2.0 / 3.0 * time_step
    band[1, [0, -1]] = time_step / 3.0
    return np.asarray(scipy.linalg.solveh_banded(band, right), dtype=np.float64)
