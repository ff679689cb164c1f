"""Jankowski's contact law: damped while approaching, elastic while separating."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from impactfem.coupling import restitution as relations
from impactfem.coupling.laws.hertz import Hertz
from impactfem.system.arrays import Array


@dataclass(frozen=True)
class Jankowski(Hertz):
    """F = β p^1.5 + c v while approaching, F = β p^1.5 while separating.

    c = 2 ξ √(β √p m) with ξ = 9 √5 / 2 (1 - ε²) / (ε (ε (9π - 16) + 16)), or ξ by the exact
    relation (Jankowski 2005 and 2006, Earthquake Engineering and Structural Dynamics 34, 595-611,
    and 35, 517-524).
    """

    type = "jankowski"

    restitution: float  #: ε requested, 0 < ε <= 1 [-]
    relation: str = "published"  #: relation of ξ and ε: "published" or "exact"

    @property
    def xi(self) -> float:
        """Damping ratio ξ [-]."""
        e = self.restitution
        if self.relation == "exact":
            return relations.exact_jankowski_xi(e)
        lost = 4.5 * math.sqrt(5.0) * (1.0 - e**2)
        return float(lost / (e * (e * (9.0 * math.pi - 16.0) + 16.0)))

    @property
    def parameters(self) -> tuple[float, ...]:
        """β and 2 ξ √(β m)."""
        return self.stiffness, 2.0 * self.xi * math.sqrt(self.stiffness * self.mass)

    @staticmethod
    def force(parameters: Array, p: float, v: float, state: Array) -> tuple[float, float, float]:
        """F = β p^1.5 + 2 ξ √(β m) p^0.25 v while v > 0, else β p^1.5."""
        beta, c = parameters[0], parameters[1]
        F, k = beta * p * np.sqrt(p), 1.5 * beta * np.sqrt(p)
        if v <= 0.0:
            return F, k, 0.0
        root = np.sqrt(np.sqrt(p))
        return F + c * root * v, k + 0.25 * c * root / p * v, c * root

    @property
    def epsilon(self) -> float:
        """Restitution of two free masses [-]."""
        return relations.jankowski(self.xi)

    @property
    def target_restitution(self) -> float:
        """Restitution that is requested [-]."""
        return self.restitution
