"""How the responses of modes, inputs and supports are combined."""

from __future__ import annotations

from dataclasses import dataclass

from impactfem.device.combination import Combination
from impactfem.device.directions import InputRule, SupportRule
from impactfem.device.rigid_response import RigidResponse


@dataclass(frozen=True)
class Rules:
    """How responses are combined.

    Args:
        modes: Combination of modes.
        duration: Of the strong motion, for the double sum [s].
        rigid: Rigid part of the modes; none when None.
        missing_mass: Whether (2) is added.
        maximum_frequency: Modes above it count as missing mass [Hz]; all are used when None.
        supports: Combination of the same component of several anchors: "srss" when they move
            independently, "algebraic" when they move together, or "abs".
        rotations: Combination of a rotation with the translation it comes with.
        directions: Combination of these pairs.
        displacements: Combination of the displacements of the anchors.
        whole: Combination of these with all the rest: "srss" or "abs".
    """

    modes: Combination = "cqc"
    duration: float | None = None
    rigid: RigidResponse | None = None
    missing_mass: bool = True
    maximum_frequency: float | None = None
    supports: SupportRule = "srss"
    rotations: InputRule = "srss"
    directions: InputRule = "srss"
    displacements: InputRule = "srss"
    whole: InputRule = "srss"
