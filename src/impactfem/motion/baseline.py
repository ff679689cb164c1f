"""A smooth correction that brings a ground motion to rest at its end."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from impactfem.system.errors import ImpactfemError

FloatArray = npt.NDArray[np.float64]


class BaselineCorrection:
    """Takes c_1 φ_1 + c_2 φ_2 from an acceleration so that it ends at rest and without offset.

    With τ = t/T from 0 to 1,

        φ_1 = sin²(πτ),    φ_2 = sin²(πτ) cos(πτ)

    begin and end smoothly at zero and hold nothing much above 1.5/T Hz (0.09 Hz for the 16.79 s
    of the paper): an oscillator well above that follows them statically, so that a spectrum
    ordinate changes by no more than the correction itself, about 2 v(T)/T. φ_1 changes the end
    velocity, φ_2 only the end displacement; c_1, c_2 follow from the end values

        v(T) = ∫ a dt,    d(T) = ∫ (T - t) a dt

    which are linear in the samples and exact for acceleration that is linear between them.

    Args:
        n: Number of samples, at least 4.
        time_step: Step h [s].

    Raises:
        ImpactfemError: There are fewer than 4 samples.
    """

    def __init__(self, n: int, time_step: float) -> None:
        if n < 4:
            raise ImpactfemError(f"a baseline correction needs at least 4 samples, got {n}")
        h = time_step
        tau = np.linspace(0.0, 1.0, n)
        bell = np.sin(np.pi * tau) ** 2
        self._shapes = np.array([bell, bell * np.cos(np.pi * tau)])
        velocity = np.full(n, h)
        velocity[[0, -1]] = 0.5 * h
        displacement = h**2 * np.arange(n - 1, -1, -1, dtype=np.float64)
        displacement[0] = h**2 * ((n - 1) / 2.0 - 1.0 / 6.0)
        displacement[-1] = h**2 / 6.0
        self._ends = np.array([velocity, displacement])
        self._inverse = np.linalg.inv(self._ends @ self._shapes.T)

    def __call__(self, acceleration: FloatArray) -> FloatArray:
        """Correct an acceleration.

        Args:
            acceleration: Shape (n,) [m/s2].

        Returns:
            Shape (n,) [m/s2]; its end velocity and displacement are zero to round-off.
        """
        coefficients = self._inverse @ (self._ends @ acceleration)
        return np.asarray(acceleration - coefficients @ self._shapes)
