"""A table of results: columns with units, written as CSV or shown as text."""

from __future__ import annotations

import io
import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd
import xarray as xr
from rich import box
from rich.console import Console
from rich.table import Table as RichTable

from impactfem.system.files import atomic
from impactfem.system.log import LOGGER
from impactfem.system.scalar import Scalar

Cell = str | float | int | None

FACTORS = {
    "kN": 1e-3,
    "kN m": 1e-3,
    "kN s": 1e-3,
    "kJ": 1e-3,
    "kPa": 1e-3,
    "MJ": 1e-6,
    "t": 1e-3,
    "MN": 1e-6,
    "MN m": 1e-6,
    "MPa": 1e-6,
    "GPa": 1e-9,
    "cm": 1e2,
    "%": 1e2,
    "mm": 1e3,
    "ms": 1e3,
}
"""Units in which tables show what stores have in SI, and the factors to them."""


def beside_published(
    name: str, title: str, scalars: Iterable[Scalar], published: Mapping[str, float]
) -> Table:
    """Scalars beside their published values, in SI by the name of the result, as far as known."""
    rows: list[tuple[Cell, ...]] = []
    for scalar in scalars:
        theirs = published.get(scalar.name)
        ratio = scalar.value / theirs if scalar.value is not None and theirs else None
        rows.append((scalar.name, scalar.value, theirs, ratio, scalar.unit, scalar.note))
    columns = heads("name; value; published; over published; unit; note")
    return Table(name, title, columns, tuple(rows)).comparing(
        {"published", "over published"}, ", beside the published values"
    )


@dataclass(frozen=True)
class Table:
    """A table."""

    name: str  #: file name without ending
    title: str  #: what it shows
    columns: tuple[tuple[str, str], ...]  #: name and unit of each column; "" for a column of words
    rows: tuple[tuple[Cell, ...], ...]  #: the cells; None where there is no value

    def comparing(self, names: Collection[str], words: str = "") -> Table:
        """The table without these columns where all of them are empty, as published values may be.

        Else with these words in its title.
        """
        places = [k for k, (name, _) in enumerate(self.columns) if name in names]
        if any(row[k] is not None for row in self.rows for k in places):
            return replace(self, title=f"{self.title}{words}")
        kept = [k for k in range(len(self.columns)) if k not in places]
        return replace(
            self,
            columns=tuple(self.columns[k] for k in kept),
            rows=tuple(tuple(row[k] for k in kept) for row in self.rows),
        )

    @property
    def frame(self) -> pd.DataFrame:
        """The table with its units in the header."""
        header = [f"{name} [{unit}]" if unit else name for name, unit in self.columns]
        return pd.DataFrame(list(self.rows), columns=header, dtype=object)

    def write_csv(self, folder: Path) -> Path:
        """Write the table as CSV with units in its header; returns the file."""
        path = folder / f"{self.name}.csv"
        with atomic(path) as temporary:
            self.frame.to_csv(temporary, index=False, lineterminator="\r\n")
        return path

    def as_text(self, width: int = 140) -> str:
        """The table as text of at most so many characters a line."""
        table = RichTable(title=self.title, box=box.SIMPLE, title_justify="left")
        for name, unit in self.columns:
            table.add_column(
                f"{name}\n[{unit}]" if unit else name, justify="right", overflow="fold"
            )
        for row in self.rows:
            known = ("-" if one is None else one for one in row)
            table.add_row(*(f"{one:.4g}" if isinstance(one, float) else str(one) for one in known))
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


def cell(value: float) -> float | None:
    """A number of a table with six significant digits; None where it is not finite."""
    return float(f"{value:.6g}") if math.isfinite(value) else None


def heads(text: str) -> tuple[tuple[str, str], ...]:
    """Names and units of columns from a line like "pair; force [MN]; steps"."""
    parts = (head.strip().rstrip("]").partition(" [") for head in text.split(";"))
    return tuple((name, unit) for name, _, unit in parts)


def variables(text: str) -> list[tuple[str, str, str]]:
    """Return the columns of `columns_of` from a line like "force [N]; case as damping"."""
    parts = (part.strip().partition(" as ") for part in text.split(";"))
    columns = []
    for variable, _, heading in parts:
        ((name, unit),) = heads(heading or variable)
        columns.append((variable.partition(" [")[0], name, unit))
    return columns


def columns_of(
    store: xr.Dataset, name: str, title: str, columns: Iterable[str | tuple[str, str, str]]
) -> Table:
    """A table of variables of a store that share one dimension.

    A column is a variable with the heading and unit of its declaration; or a variable, its heading,
    and the unit in which it is shown: one of `FACTORS`, or that of the store.
    """
    chosen = [(one, *declared(store[one])) if isinstance(one, str) else one for one in columns]
    cells: list[list[Cell]] = []
    for variable, _, unit in chosen:
        values, factor = store[variable].values, FACTORS.get(unit, 1.0)
        kind, column = values.dtype.kind, values.tolist()
        if kind == "f":
            column = [value * factor if math.isfinite(value) else None for value in column]
        elif kind == "b":
            column = ["yes" if value else "no" for value in column]
        elif kind not in "iu":
            column = [str(value) for value in column]
        cells.append(column)
    header = tuple((heading, unit) for _, heading, unit in chosen)
    return Table(name, title, header, tuple(zip(*cells, strict=True)))


def declared(variable: xr.DataArray) -> tuple[str, str]:
    """Heading and unit of a column, from the declaration of a variable."""
    heading = variable.attrs.get("long_name", str(variable.name)).partition(",")[0]
    return heading, variable.attrs.get("shown", variable.attrs.get("units", ""))


def write_tables(folder: Path, tables: Iterable[Table]) -> list[Path]:
    """Write tables into `tables/` of a run's folder, and into its log; returns the files."""
    target = folder / "tables"
    target.mkdir(exist_ok=True)
    files = []
    for table in tables:
        LOGGER.debug("\n%s", table.as_text())
        files.append(table.write_csv(target))
    return files
