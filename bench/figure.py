"""One performance figure of `impactfem bench`, and the table of them."""

from __future__ import annotations

from dataclasses import dataclass

from rich.table import Table


@dataclass(frozen=True)
class Figure:
    """One performance figure.

    Args:
        name: What is measured.
        value: The figure.
        unit: Its unit.
        target: What it should reach; None where it is only told.
        at_most: Whether the target is an upper bound.
    """

    name: str
    value: float
    unit: str
    target: float | None = None
    at_most: bool = True

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None without one."""
        if self.target is None:
            return None
        return self.value <= self.target if self.at_most else self.value >= self.target


def as_table(figures: list[Figure]) -> Table:
    """The figures for a terminal."""
    table = Table("figure", "value", "unit", "target", "")
    for figure in figures:
        sign = "≤" if figure.at_most else "≥"
        target = "" if figure.target is None else f"{sign} {figure.target:.3g}"
        verdict = {True: "met", False: "MISSED", None: ""}[figure.met]
        table.add_row(figure.name, f"{figure.value:.3g}", figure.unit, target, verdict)
    return table
