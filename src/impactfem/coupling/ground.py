"""The ground at the steps of a time loop, also where waves pass the buildings one after the other.

A wave that passes with the apparent velocity c reaches a place later by τ = s / c, with s the way
along its direction: the ground there moves as u_g(t − τ). Displacements are relative to the ground
under the first building, so that the one under another moves by u_g(t − τ) − u_g(t − τ₀). The
accelerogram is straight between its samples, and its integrals are those of this line.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from impactfem.records.accelerogram import Accelerogram
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError

History = tuple[int, float, Array]
"""Component (0, 1, 2 for x, y, z), time step [s] and acceleration [m/s2] of a motion."""


@dataclass(frozen=True, eq=False)
class Ground:
    """The motion of the ground along x, y, z at n_t times."""

    acceleration: Array  #: under the first building, shape (n_t, 3) [m/s2]
    #: Displacement, velocity and acceleration under buildings that the waves reach at another time,
    #: less those under the first one, shape (3, n_t, 3).
    relative: Mapping[str, Array] = field(default_factory=dict)

    @classmethod
    def under(
        cls,
        histories: Sequence[History],
        time_step: float,
        n_t: int,
        delays: Mapping[str, float] | None = None,
    ) -> "Ground":
        """The ground at n_t times of a step [s], by its motions.

        With the delay τ of each building [s]; all move alike without.
        """
        τ = delays or {}
        first = next(iter(τ.values()), 0.0)
        time = time_step * np.arange(n_t)
        moved = {delay: np.zeros((3, n_t, 3)) for delay in {first, *τ.values()}}
        for delay, motion in moved.items():
            motion[2] = interpolate_ground(histories, time_step, n_t, delay)
        for component, dt, samples in histories if len(moved) > 1 else ():
            record, a, last = Accelerogram(dt, samples), np.append(samples, 0.0), len(samples) - 1
            # Properties that are sums over all samples, once for all buildings.
            v, u = record.velocity, record.displacement
            for delay, motion in moved.items():
                # At rest before the first sample; behind the last one the velocity stays.
                at = np.maximum(time - delay, 0.0)
                k = np.minimum((at / dt).astype(np.int64), last)
                x, a_0 = at - dt * k, np.where(k < last, a[k], 0.0)
                slope = np.where(k < last, (a[k + 1] - a[k]) / dt, 0.0)
                motion[0, :, component] += u[k] + x * (v[k] + x * (a_0 / 2.0 + x * slope / 6.0))
                motion[1, :, component] += v[k] + x * (a_0 + x * slope / 2.0)
        apart = {name: moved[τ[name]] - moved[first] for name in τ if τ[name] != first}
        return cls(moved[first][2], apart)

    def opened(self, a: str, b: str | None, normal: Array) -> Array:
        """Opening of the ground from a to b along the normal, and its rate, shape (2, n_t).

        Without b it is a wall on the ground under a.
        """
        still = np.zeros((3, *self.acceleration.shape))
        far = self.relative.get(a if b is None else b, still)
        return np.asarray((far - self.relative.get(a, still))[:2] @ normal)


def as_ground(given: Array | Ground) -> Ground:
    """The ground, or one that moves alike under all buildings, by its acceleration, (n_t, 3).

    Raises:
        ImpactfemError: The acceleration has another shape.
    """
    ground = given if isinstance(given, Ground) else Ground(np.asarray(given, dtype=np.float64))
    if ground.acceleration.ndim != 2 or ground.acceleration.shape[1] != 3:
        raise ImpactfemError(f"ground must have shape (n_t, 3), got {ground.acceleration.shape}")
    return ground


def interpolate_ground(
    histories: Sequence[History], time_step: float, n_t: int, delay: float = 0.0
) -> Array:
    """Ground acceleration at n_t times of a step [s], later by a delay [s], (n_t, 3) [m/s2].

    Histories are linear between samples and zero before the first and after the last one; those of
    the same direction add.
    """
    time = time_step * np.arange(n_t) - delay
    ground = np.zeros((n_t, 3))
    for component, dt, samples in histories:
        end = dt * (samples.size - 1)
        # A time that rounding puts beyond the first or last sample still is that sample's.
        inside = np.where(np.abs(time - end) <= 1e-9 * end, end, time)
        inside = np.where(np.abs(inside) <= 1e-9 * end, 0.0, inside)
        at = dt * np.arange(samples.size)
        ground[:, component] += np.interp(inside, at, samples, left=0.0, right=0.0)
    return ground
