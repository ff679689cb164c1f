"""Marches in pieces; what an interruption leaves is tested with the full model."""

from __future__ import annotations

import numpy as np

from impactfem.dynamics.energy import Energy
from impactfem.dynamics.history import History
from impactfem.dynamics.resumable import joined


def piece(first: int, last: int) -> History:
    step = np.arange(first, last + 1)
    energy = Energy(*(factor * step.astype(float) for factor in (1.0, 2.0, 3.0, 4.0)))
    return History(0.1 * step, {"velocity": np.column_stack([step, -step]).astype(float)}, energy)


def test_pieces_one_after_the_other() -> None:
    whole, known = joined([piece(0, 3), piece(4, 4), piece(5, 9)]), piece(0, 9)
    np.testing.assert_array_equal(whole.time, known.time)
    np.testing.assert_array_equal(whole.motion["velocity"], known.motion["velocity"])
    np.testing.assert_array_equal(whole.energy.damped, 3.0 * np.arange(10))
    np.testing.assert_array_equal(whole.energy.input, 4.0 * np.arange(10))
    # In another order it is another one.
    assert not np.array_equal(joined([piece(4, 9), piece(0, 3)]).time, known.time)
