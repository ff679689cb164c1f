"""A response at one time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass
class State:
    """A response at one time, on this rank: all that is needed to go on, bitwise on one rank.

    Args:
        step: Number of the time, 0 at the start.
        displacement: u, shape (n_local,) [m, rad].
        velocity: v, shape (n_local,).
        acceleration: a, shape (n_local,).
        momentum: M v, shape (n_local,).
        restoring: K u, shape (n_local,).
        damped: Energy that the damping has taken, of all ranks [J].
        input: Work of the loads, of all ranks [J].
    """

    step: int
    displacement: Array
    velocity: Array
    acceleration: Array
    momentum: Array
    restoring: Array
    damped: float = 0.0
    input: float = 0.0

    def copy(self) -> State:
        """A state of its own, which does not move when this one does."""
        return replace(
            self,
            displacement=self.displacement.copy(),
            velocity=self.velocity.copy(),
            acceleration=self.acceleration.copy(),
            momentum=self.momentum.copy(),
            restoring=self.restoring.copy(),
        )
