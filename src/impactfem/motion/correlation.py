"""Whether two components of a motion are statistically independent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from impactfem.motion.accelerogram import Accelerogram
from impactfem.system.errors import ImpactfemError

LIMIT = 0.16


@dataclass(frozen=True)
class Correlation:
    """Correlation coefficient of two components.

    Args:
        coefficient: ρ, from -1 to 1 [-].
        limit: Largest |ρ| allowed [-].
    """

    coefficient: float
    limit: float

    @property
    def accepted(self) -> bool:
        """Whether |ρ| is not above its limit."""
        return abs(self.coefficient) <= self.limit


def pair_correlation(
    first: Accelerogram, second: Accelerogram, limit: float = LIMIT
) -> Correlation:
    """Correlate two components over their whole duration.

        ρ = Σ (a - ā)(b - b̄) / √(Σ (a - ā)² Σ (b - b̄)²)

    The shorter one is at rest after its end. |ρ| <= 0.16 is what US NRC SRP 3.7.1 and ASCE 4-16
    ask; ASCE 4-98 and 43-05 have 0.3.

    Args:
        first: One component.
        second: The other, at the same time step.
        limit: Largest |ρ| allowed [-].

    Raises:
        ImpactfemError: The time steps differ, or a component does not change.
    """
    if abs(first.time_step / second.time_step - 1.0) > 1e-9:
        raise ImpactfemError(
            f"components at steps of {first.time_step:.9g} s and {second.time_step:.9g} s cannot be"
            " correlated; resample one of them"
        )
    n = max(first.acceleration.size, second.acceleration.size)
    a, b = (np.pad(x.acceleration, (0, n - x.acceleration.size)) for x in (first, second))
    a, b = a - a.mean(), b - b.mean()
    norm = float(np.sqrt((a @ a) * (b @ b)))
    if norm == 0.0:
        raise ImpactfemError("a component that does not change has no correlation")
    return Correlation(float(a @ b) / norm, limit)
