"""One row of the verification manual, and the table of a benchmark."""

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Concatenate, ParamSpec

import numpy as np
from numpy.typing import ArrayLike

Parameters = ParamSpec("Parameters")


@dataclass(frozen=True)
class Row:
    """A computed value against its reference."""

    name: str  #: the benchmark
    quantity: str  #: the compared quantity
    reference: float
    computed: float  #: value of the program
    unit: str  #: unit of both; "-" when they have none
    #: Largest error allowed: relative to the reference, or as it is with `absolute`.
    tolerance: float
    source: str  #: where the reference comes from
    #: Whether the error is the plain difference, for references that are zero or bounds.
    absolute: bool = False
    #: Whether the reference is a lower bound: the error is what is missing to it, the plain
    #: difference.
    at_least: bool = False
    #: Of an order of convergence: sizes of elements or steps, and the error with each.
    convergence: tuple[tuple[float, float], ...] = ()

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

    def as_dict(self) -> dict[str, Any]:
        """Return the row as `impactfem verify --json` writes it."""
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
            "convergence": self.convergence,
        }


class Rows(list[Row]):
    """The table of a benchmark, written line by line or column by column.

    Name and source are those of lines that say no other; `where` ends the quantity of the lines
    that follow, after a comma.
    """

    def __init__(self, name: str = "", source: str = "") -> None:
        super().__init__()
        self.name, self.source, self.where = name, source, ""

    def add(
        self,
        quantity: str | Sequence[str],
        reference: ArrayLike,
        computed: ArrayLike,
        unit: str | Sequence[str],
        tolerance: ArrayLike,
        source: str | Sequence[str] | None = None,
        *,
        absolute: bool = False,
    ) -> None:
        """Write a line, or one for each entry of the arguments of `Row`, which broadcast.

        The error of a zero is absolute.
        """
        values = quantity, reference, computed, unit, tolerance, source or self.source
        columns = (column.ravel().tolist() for column in np.broadcast_arrays(*values))
        for what, wanted, found, measure, allowed, origin in zip(*columns, strict=True):
            what = f"{what}, {self.where}" if self.where else what
            numbers = float(wanted), float(found), measure, float(allowed)
            self.append(Row(self.name, what, *numbers, origin, absolute or wanted == 0.0))

    def order(
        self,
        quantity: str,
        bound: float,
        sizes: ArrayLike,
        errors: ArrayLike,
        source: str,
        margin: float = 0.1,
    ) -> None:
        """Write a line of a fitted order of convergence against a lower bound from theory.

        The errors of a quantity are those with steps or elements of these sizes, the source is that
        of the bound, and the margin what may be missing to it in a fit over these sizes.
        """
        quantity = f"fitted order of {quantity}, at least {bound:g}"
        order = fitted_order(sizes, errors)
        self.append(Row(self.name, quantity, bound, order, "-", margin, source, at_least=True))
        self.fitted_to(sizes, errors)

    def fitted_to(self, sizes: ArrayLike, errors: ArrayLike) -> None:
        """Keep what the order in the last line was fitted to: errors with sizes."""
        pairs = np.column_stack([sizes, errors]).astype(float).tolist()
        self[-1] = replace(self[-1], convergence=tuple((h, error) for h, error in pairs))


def fitted_order(sizes: ArrayLike, errors: ArrayLike) -> float:
    """Slope of log(error) over log(size)."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


REGISTERED: list[Callable[..., Rows]] = []
HEAVY: list[Callable[..., Rows]] = []
"""Benchmarks of more than a few seconds, run on request only."""


def benchmark(
    name: str = "", source: str = "", *, heavy: bool = False
) -> Callable[[Callable[Concatenate[Rows, Parameters], None]], Callable[Parameters, Rows]]:
    """Register a function that writes rows: called, it gives the table of this name and source."""

    def register(
        write: Callable[Concatenate[Rows, Parameters], None],
    ) -> Callable[Parameters, Rows]:
        @functools.wraps(write)
        def run(*arguments: Parameters.args, **options: Parameters.kwargs) -> Rows:
            rows = Rows(name, source)
            write(rows, *arguments, **options)
            return rows

        (HEAVY if heavy else REGISTERED).append(run)
        return run

    return register
