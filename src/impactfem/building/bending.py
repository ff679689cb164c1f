"""Which modes of a 3D model are its bending modes, those that a stick model has too."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]

LEAST_SHARE = 0.01
"""Share of the total mass that a bending mode moves at least. Modes of single slabs, of which a
building has about ten in each hertz, move less."""


def bending_modes(effective_mass: Array, total: float, least_share: float = LEAST_SHARE) -> Index:
    """Indices of the bending modes along a direction, in ascending frequency.

    A bending mode about e_x moves most of its mass along y. Where a slab's mode of nearly the same
    frequency shares the motion, the one with the larger mass is taken as the bending mode only if
    both pass; both are then returned.

    Args:
        effective_mass: Effective masses of the modes along the direction, shape (n_modes,) [kg].
        total: Mass of the building [kg].
        least_share: Smallest share of the mass of a bending mode.
    """
    return np.flatnonzero(effective_mass >= least_share * total)
