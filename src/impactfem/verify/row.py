"""One row of the verification manual."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """A computed value against its reference.

    Args:
        name: The benchmark.
        quantity: What is compared.
        reference: The reference.
        computed: What the program computes.
        unit: Unit of both; "-" when they have none.
        tolerance: Largest error allowed: relative to the reference, or as it is with `absolute`.
        source: Where the reference comes from.
        absolute: Whether the error is the plain difference, for references that are zero or
            bounds.
        at_least: Whether the reference is a lower bound: the error is what is missing to it, the
            plain difference.
    """

    name: str
    quantity: str
    reference: float
    computed: float
    unit: str
    tolerance: float
    source: str
    absolute: bool = False
    at_least: bool = False

    @property
    def error(self) -> float:
        """Error as the tolerance counts it [-, or the row's unit when absolute or a bound]."""
        if self.at_least:
            return max(self.reference - self.computed, 0.0)
        difference = abs(self.computed - self.reference)
        return difference if self.absolute else difference / abs(self.reference)

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance; never for a value that is not finite."""
        return math.isfinite(self.computed) and self.error <= self.tolerance

    def as_dict(self) -> dict[str, str | float | bool | None]:
        """The row as `impactfem verify --json` writes it."""
        return {
            "name": self.name,
            "quantity": self.quantity,
            "reference": float(self.reference),
            "computed": float(self.computed) if math.isfinite(self.computed) else None,
            "unit": self.unit,
            "error": float(self.error) if math.isfinite(self.error) else None,
            "tolerance": self.tolerance,
            "absolute": self.absolute,
            "at_least": self.at_least,
            "passed": bool(self.passed),
            "source": self.source,
        }
