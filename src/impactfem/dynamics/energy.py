"""Energies of a response, and how well they balance."""

from dataclasses import dataclass, field

import numpy as np

from impactfem.system.arrays import Array


@dataclass(frozen=True)
class Energy:
    """Energies relative to the ground at each time, shape (n_t,) each [J].

    The θ rule satisfies exactly, step by step, with v_θ = (1 − θ) v₀ + θ v₁ and the same for u and
    the forces f of loads and F of links,

        Δ(½ vᵀ M v) + Δ(½ uᵀ K u) + Δt v_θᵀ C v_θ + (θ − ½) (Δvᵀ M Δv + Δuᵀ K Δu)
            = Δt v_θᵀ f_θ + Δδᵀ F_θ,    Δu = Δt v_θ.

    The average acceleration rule is the one with θ = ½.
    """

    kinetic: Array  #: ½ vᵀ M v.
    elastic: Array  #: ½ uᵀ K u.
    damped: Array  #: Energy dissipated by damping since step 0, without radiation into the soil.
    input: Array  #: Work of the loads since step 0.
    #: Work of the links on the bodies; negative when they take energy.
    contact: Array = field(default_factory=lambda: np.zeros(0))
    #: Numerical dissipation, zero for θ = ½.
    numerical: Array = field(default_factory=lambda: np.zeros(0))
    #: Energy radiated into the soil under rafts since step 0.
    radiated: Array = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        for name in ("contact", "numerical", "radiated"):
            if not getattr(self, name).size:
                object.__setattr__(self, name, np.zeros_like(self.kinetic))

    @property
    def scale(self) -> float:
        """Largest energy that is there or came in [J]."""
        stored = float(np.max(self.kinetic + self.elastic))
        return max(stored, float(np.max(np.abs(self.input))))

    @property
    def residual(self) -> float:
        """Largest violation of the identity over the largest energy that came in [-]."""
        balance = self.kinetic + self.elastic + self.damped + self.numerical + self.radiated
        balance = balance - self.input - self.contact
        return float(np.max(np.abs(balance - balance[0])) / self.scale) if self.scale > 0.0 else 0.0

    @property
    def gained(self) -> float:
        """Largest work that the links put in within a step, over the largest energy [-]."""
        most = float(np.max(np.diff(self.contact), initial=0.0))
        return most / self.scale if self.scale > 0.0 else 0.0
