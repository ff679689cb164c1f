"""A table of results: columns with units, written as CSV or shown as text."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table as RichTable

from impactfem.files import atomic

Cell = str | float | int | None


@dataclass(frozen=True)
class Table:
    """A table.

    Args:
        name: File name without ending.
        title: What it shows.
        columns: Name and unit of each column; "" for a column of words.
        rows: The cells; None where there is no value.
    """

    name: str
    title: str
    columns: tuple[tuple[str, str], ...]
    rows: tuple[tuple[Cell, ...], ...]

    def write_csv(self, folder: Path) -> Path:
        """Write the table as CSV with units in its header; returns the file."""
        path = folder / f"{self.name}.csv"
        with atomic(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(f"{name} [{unit}]" if unit else name for name, unit in self.columns)
            for row in self.rows:
                writer.writerow("" if cell is None else cell for cell in row)
        return path

    def as_text(self, width: int = 140) -> str:
        """The table as text of at most so many characters a line."""
        table = RichTable(title=self.title, box=box.SIMPLE, title_justify="left")
        for name, unit in self.columns:
            table.add_column(f"{name}\n[{unit}]" if unit else name, justify="right")
        for row in self.rows:
            table.add_row(*(_text(cell) for cell in row))
        stream = io.StringIO()
        # Plain text: in a notebook rich would show the table there, or colour it.
        console = Console(
            file=stream,
            width=width,
            markup=False,
            highlight=False,
            force_jupyter=False,
            force_terminal=False,
        )
        console.print(table)
        return stream.getvalue().rstrip()


def _text(cell: Cell) -> str:
    if cell is None:
        return "-"
    return f"{cell:.4g}" if isinstance(cell, float) else str(cell)
