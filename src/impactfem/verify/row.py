"""One row of the verification manual, and the table of a benchmark."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import SupportsFloat

import numpy as np
from numpy.typing import NDArray


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


class Rows(list[Row]):
    """The table of a benchmark, written line by line.

    Args:
        name: The benchmark, in lines that say no other.
        source: Where the reference comes from, in lines that say no other.

    Attributes:
        where: Ends the quantity of the lines that follow, after a comma.
    """

    def __init__(self, name: str, source: str = "") -> None:
        super().__init__()
        self.name, self.source, self.where = name, source, ""

    def add(
        self,
        quantity: str,
        reference: SupportsFloat,
        computed: SupportsFloat,
        unit: str,
        tolerance: float,
        source: str | None = None,
        *,
        name: str | None = None,
        absolute: bool = False,
    ) -> None:
        """Write a line, with the arguments of `Row`; the error of a zero is absolute."""
        name, source = name or self.name, source or self.source
        quantity = f"{quantity}, {self.where}" if self.where else quantity
        wanted, found = float(reference), float(computed)
        absolute = absolute or wanted == 0.0
        self.append(Row(name, quantity, wanted, found, unit, tolerance, source, absolute))

    def order(
        self,
        quantity: str,
        bound: float,
        sizes: NDArray[np.float64],
        errors: NDArray[np.float64],
        source: str,
        margin: float = 0.1,
        *,
        name: str | None = None,
    ) -> None:
        """Write a line of a fitted order of convergence against a lower bound from theory.

        Args:
            quantity: What the errors are of.
            bound: Least order.
            sizes: Steps or sizes of elements.
            errors: Errors with them.
            source: Where the bound comes from.
            margin: What may be missing to the bound in a fit over these sizes.
            name: The benchmark, where it is another one.
        """
        quantity = f"fitted order of {quantity}, at least {bound:g}"
        order = fitted_order(sizes, errors)
        row = Row(name or self.name, quantity, bound, order, "-", margin, source, at_least=True)
        self.append(row)


def fitted_order(sizes: NDArray[np.float64], errors: NDArray[np.float64]) -> float:
    """Slope of log(error) over log(size)."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])
