"""What floors did in front of the wall, whatever model computed it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impactfem.system.errors import ImpactfemError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class WallHistory:
    """Histories of the floors that may hit the wall, at times 0, Δt, 2 Δt, ...

    Displacements and velocities are those along n, positive towards the wall; a force pushes its
    floor away from the wall when it is positive. An impulse P over the step that ends at a time
    stands there as the force P / Δt.

    Args:
        floors: Numbers of the floors.
        mass: Their masses, shape (n_floors,) [kg].
        gap: Gap at rest [m].
        time_step: Time step Δt [s].
        displacement: Of the mass centres, shape (n_t, n_floors) [m].
        velocity: Of the mass centres, shape (n_t, n_floors) [m/s].
        force: Resultants of the contact forces on the floors, shape (n_t, n_floors) [N].
        opening: Distance of the wall from the nearest point of each floor, negative where it
            penetrates, shape (n_t, n_floors) [m]; None when it is not known.

    Raises:
        ImpactfemError: Shapes do not fit, or a value is not finite.
    """

    floors: tuple[int, ...]
    mass: Array
    gap: float
    time_step: float
    displacement: Array
    velocity: Array
    force: Array
    opening: Array | None = None

    def __post_init__(self) -> None:
        n_floors = len(self.floors)
        if self.mass.shape != (n_floors,):
            raise ImpactfemError(
                f"mass must have one value for each of {n_floors} floors, got {self.mass.shape}"
            )
        shape = (self.force.shape[0], n_floors)
        for name in ("displacement", "velocity", "force", "opening"):
            values = getattr(self, name)
            if values is None:
                continue
            if values.shape != shape:
                raise ImpactfemError(f"{name} must have shape {shape}, got {values.shape}")
            if not np.isfinite(values).all():
                row, column = np.argwhere(~np.isfinite(values))[0]
                raise ImpactfemError(
                    f"{name} of floor {self.floors[column]} is {values[row, column]} at "
                    f"t = {row * self.time_step:.6g} s"
                )

    @property
    def time(self) -> Array:
        """Times, shape (n_t,) [s]."""
        n_t = self.force.shape[0]
        return np.asarray(self.time_step * np.arange(n_t, dtype=np.float64), dtype=np.float64)

    def column(self, floor: int) -> int:
        """Index of the floor with this number.

        Raises:
            ImpactfemError: It is none of the floors that may hit.
        """
        if floor not in self.floors:
            known = ", ".join(map(str, self.floors))
            raise ImpactfemError(f"floor {floor} is none of those that may hit the wall: {known}")
        return self.floors.index(floor)
