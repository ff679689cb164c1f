"""Hertz contact with the damping of Hunt and Crossley."""

from __future__ import annotations

from dataclasses import dataclass

from impactfem.coupling import restitution as relations
from impactfem.coupling.laws.hertz import DampedHertz


@dataclass(frozen=True)
class HuntCrossley(DampedHertz):
    """F = K p^1.5 (1 + χ v / v₀), χ = 3/2 (1 - ε).

    Hunt and Crossley 1975, Journal of Applied Mechanics 42, 440-445. With the exact relation it is
    the same law as `HertzDamp`.
    """

    type = "hunt-crossley"

    @property
    def chi(self) -> float:
        """χ [-]."""
        if self.relation == "exact":
            return relations.exact_chi(self.restitution)
        return 1.5 * (1.0 - self.restitution)
