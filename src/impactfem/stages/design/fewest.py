"""The fewest curves whose envelope is near that of all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MISSED = 0.02
"""Part of the envelope of all that the envelope of the chosen ones may lack anywhere."""
MOST = 24
"""The most that are chosen, of one floor along one direction."""


def fewest(curves: Array, *, missed: float = MISSED, most: int = MOST) -> list[int]:
    """Choose curves until their envelope is near that of all curves everywhere.

    A greedy choice: next is the curve that comes near the envelope e_j = max_i c_ij at most of the
    places j that no chosen one comes near to, near meaning c_ij ≥ (1 − m) e_j. The fewest in the
    strict sense take a search that grows exponentially; the greedy choice has at most about
    1 + ln n times as many for n places (V. Chvátal, Math. Oper. Res. 4 (1979) 233-235).

    Args:
        curves: c, not negative, shape (n_curves, n_places).
        missed: m.
        most: The most curves.

    Returns:
        Their numbers, in the order of the choice; places where all curves are zero ask for none.
    """
    envelope = curves.max(axis=0, initial=0.0)
    near = (curves >= (1.0 - missed) * envelope) & (envelope > 0.0)
    open_places = envelope > 0.0
    chosen: list[int] = []
    while open_places.any() and len(chosen) < most:
        chosen.append(int(np.argmax(near[:, open_places].sum(axis=1))))
        open_places &= ~near[chosen[-1]]
    return chosen
