"""Kelvin-Voigt contact: a linear spring and a dashpot in parallel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Self

from impactfem.coupling import restitution as relations
from impactfem.coupling.law import Law
from impactfem.system.arrays import Array


@dataclass(frozen=True)
class KelvinVoigt(Law):
    """F = K p + C v with C = 2 ξ √(K m) (paper, equations 2 and 3).

    The force jumps to C v₀ at onset and, with tension as in the paper, pulls at the end.
    """

    type = "kelvin-voigt"
    jumps = True

    damping_ratio: float  #: ξ at contact [-]
    tension: bool = True  #: keep the tensile force at the end of the contact

    @classmethod
    def of_case(cls, name: str, entry: Any, mass: float) -> Self:
        """See `Law`; the damping ratio follows from the restitution if that is given."""
        if entry.stiffness == "calibrated" or entry.restitution == "calibrated":
            raise ValueError(f"the contact law {name} has values that are not calibrated yet")
        xi = entry.damping_ratio
        if xi is None:
            if entry.restitution is None:
                raise ValueError(f"the contact law {name} has no restitution and no damping_ratio")
            xi = relations.kelvin_voigt_xi(entry.restitution, tension=entry.tension)
        return cls(entry.stiffness, xi, entry.tension, mass=mass)

    @property
    def name(self) -> str:
        """Name of the law in results."""
        return self.type if self.tension else f"{self.type} without tension"

    @property
    def parameters(self) -> tuple[float, ...]:
        """K, C, and 1 with tension."""
        return self.stiffness, self.dashpot, float(self.tension)

    @staticmethod
    def force(parameters: Array, p: float, v: float, state: Array) -> tuple[float, float, float]:
        """F = K p + C v, without tension not below zero."""
        K, C = parameters[0], parameters[1]
        F = K * p + C * v
        if F <= 0.0 and parameters[2] == 0.0:
            return 0.0, 0.0, 0.0
        return F, K, C

    @property
    def dashpot(self) -> float:
        """C [N s/m]."""
        return float(2.0 * self.damping_ratio * math.sqrt(self.stiffness * self.mass))

    @property
    def xi(self) -> float:
        """Damping ratio [-]."""
        return self.damping_ratio

    @property
    def epsilon(self) -> float:
        """Restitution of two free masses [-]."""
        return relations.kelvin_voigt(self.damping_ratio, tension=self.tension)

    def duration(self, speed: float) -> float:
        """π / Ω_D until p = 0, or less until F = 0 without tension [s]; at any speed the same."""
        phase = relations.kelvin_voigt_phase(self.damping_ratio, tension=self.tension)
        return phase / math.sqrt(self.stiffness / self.mass)
