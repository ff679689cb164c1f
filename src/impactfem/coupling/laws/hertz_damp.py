"""Hertz contact with the damping of Lankarani and Nikravesh."""

from __future__ import annotations

from dataclasses import dataclass

from impactfem.coupling import restitution as relations
from impactfem.coupling.laws.hertz import DampedHertz


@dataclass(frozen=True)
class HertzDamp(DampedHertz):
    """F = K p^1.5 (1 + χ v / v₀), χ = 3/4 (1 - ε²).

    Muthukumar and DesRoches 2006, Earthquake Engineering and Structural Dynamics 35, 811-828,
    after Lankarani and Nikravesh 1990.
    """

    type = "hertz-damp"

    @property
    def chi(self) -> float:
        """χ [-]."""
        if self.relation == "exact":
            return relations.exact_chi(self.restitution)
        return 0.75 * (1.0 - self.restitution**2)
