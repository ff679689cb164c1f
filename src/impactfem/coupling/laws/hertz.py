"""Hertz's elastic contact, and the damped laws with the same elastic force."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from impactfem.coupling import restitution as relations
from impactfem.coupling.law import Law
from impactfem.system.arrays import Array


@dataclass(frozen=True)
class Hertz(Law):
    """F = K p^1.5 (Hertz 1881; Goldsmith 1960, Impact)."""

    type = "hertz"
    stiffness_unit = "N/m^1.5"

    @staticmethod
    def force(parameters: Array, p: float, v: float, state: Array) -> tuple[float, float, float]:
        """F = K p^1.5."""
        K = parameters[0]
        return K * p * np.sqrt(p), 1.5 * K * np.sqrt(p), 0.0

    @property
    def epsilon(self) -> float:
        """The contact is elastic."""
        return 1.0

    def duration(self, speed: float) -> float:
        """2.9433 p_max / v₀ of the elastic impact, p_max = (5 m v₀² / (4 K))^(2/5), in [s].

        Goldsmith 1960, section 4.2. Hertz-damp and Hunt-Crossley last up to 1.5 times as long at
        ε = 0.1, Jankowski up to 2 % less.
        """
        if speed <= 0.0:
            return math.inf
        return float(2.94328 * (1.25 * self.mass / self.stiffness) ** 0.4 * speed**-0.2)


@dataclass(frozen=True)
class DampedHertz(Hertz):
    """F = K p^1.5 (1 + χ v / v₀), with χ from the restitution ε.

    χ equates the loss of energy to that of ε, with the elastic path (published relation, good for ε
    near 1), or exactly.
    """

    restitution: float  #: ε requested, 0 < ε <= 1 [-]
    relation: str = "published"  #: relation of χ and ε: "published" or "exact"
    #: Lower limit of v₀ in the damping, which is unbounded for a contact that begins at rest [m/s].
    slowest_approach: float = 1e-3

    @property
    def chi(self) -> float:
        """χ [-]."""
        raise NotImplementedError

    @property
    def parameters(self) -> tuple[float, ...]:
        """K, χ and the lower limit of v₀."""
        return self.stiffness, self.chi, self.slowest_approach

    @staticmethod
    def force(parameters: Array, p: float, v: float, state: Array) -> tuple[float, float, float]:
        """F = max(0, K p^1.5 (1 + χ v / v₀))."""
        K, chi = parameters[0], parameters[1]
        elastic = K * p * np.sqrt(p)
        mu = chi / max(state[0], parameters[2])
        factor = 1.0 + mu * v
        if factor <= 0.0:
            return 0.0, 0.0, 0.0
        return elastic * factor, 1.5 * K * np.sqrt(p) * factor, elastic * mu

    @property
    def epsilon(self) -> float:
        """Restitution of two free masses [-]."""
        return relations.damped_hertz(self.chi)

    @property
    def target_restitution(self) -> float:
        """Restitution that is requested [-]."""
        return self.restitution
