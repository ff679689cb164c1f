"""Unilateral contact: edges that do not penetrate, whatever force that takes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Self

from impactfem.coupling.law import Law


@dataclass(frozen=True)
class Unilateral(Law):
    """Contact without penetration, by `massless` or `unilateral`; it has no force law."""

    type = "unilateral"
    stiffness_unit = ""
    unilateral = True

    stiffness: float = math.nan

    @classmethod
    def of_case(cls, name: str, entry: Any, mass: float) -> Self:
        """See `Law`; there are no keys."""
        return cls(mass=mass)

    @property
    def epsilon(self) -> float:
        """Restitution is a result of the waves in the buildings."""
        return math.nan

    def duration(self, speed: float) -> float:
        """No law determines the duration."""
        return math.nan

    def onset_force(self, speed: float) -> float:
        """No law determines the force."""
        return math.nan

    def part(self, share: float) -> Self:
        """Return the law itself."""
        return self

    def describe(self) -> str:
        """Return the name."""
        return self.name
