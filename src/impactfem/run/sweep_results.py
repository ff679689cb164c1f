"""What a person sees of a sweep: one table of all variants, and lines over the swept values."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from matplotlib.axes import Axes

from impactfem.plot.style import BUILDINGS, figure, letter, ordered_colours
from impactfem.plot.table import Cell, Table
from impactfem.system.files import write_json
from impactfem.system.scalar import Scalar

NAME = "sweep"
PANELS = 12
DECADE = 10.0
"""Ratio of swept values from which on their axis is logarithmic."""
SHOWN = 6
"""Number of results in a table on the screen, and of those shown when none is asked for."""


@dataclass(frozen=True)
class SweepRow:
    """A variant and what it gave.

    Args:
        name: Its name.
        values: Its value of each swept key: in SI, or words.
        scalars: Its results by name; none when it failed.
        error: Why it failed; "" when it did not.
    """

    name: str
    values: tuple[float | str, ...]
    scalars: Mapping[str, Scalar]
    error: str = ""

    def value(self, scalar: str) -> float | None:
        """A result that is there and finite, or None."""
        found = self.scalars.get(scalar)
        finite = found is not None and found.value is not None and math.isfinite(found.value)
        return found.value if found is not None and finite else None


@dataclass(frozen=True)
class SweepResults:
    """The variants of a sweep and what they gave.

    Args:
        title: Title of the case.
        keys: The swept keys, each with the SI unit of its values; "" for words.
        rows: The variants.
        published: Published values in SI by the name of the result.
        zipped: Whether the keys ran together: all variants are on one line.
    """

    title: str
    keys: tuple[tuple[str, str], ...]
    rows: tuple[SweepRow, ...]
    published: Mapping[str, float]
    zipped: bool = False

    @property
    def units(self) -> dict[str, str]:
        """Units of all results by name, in the order of the stages."""
        return {name: s.unit for row in self.rows for name, s in row.scalars.items()}

    def chosen(self, patterns: Sequence[str]) -> list[str]:
        """Names of the results to show.

        Args:
            patterns: Names, in which * stands for any letters. Without any: results that differ
                between the variants, those with a published value first.
        """
        known = list(self.units)
        if patterns:
            found = [n for pattern in patterns for n in known if fnmatchcase(n, pattern)]
            return list(dict.fromkeys(found))
        varied = [n for n in known if len({row.value(n) for row in self.rows if not row.error}) > 1]
        ranked = sorted(varied or known, key=lambda name: name not in self.published)
        return ranked[:SHOWN]

    def table(self, names: Sequence[str] | None = None) -> Table:
        """The variants with their swept values and results.

        Args:
            names: The results that are shown; None for all of them, with the names of the variants
                and why they failed.
        """
        shown = list(self.units) if names is None else names
        units = self.units
        rows: list[tuple[Cell, ...]] = []
        for row in self.rows:
            results = tuple(row.value(name) for name in shown)
            if names is None:
                rows.append((row.name, *row.values, *results, row.error or None))
            else:
                rows.append((*row.values, *results, "failed" if row.error else ""))
        columns = [*self.keys, *((name, units[name]) for name in shown)]
        if names is None:
            columns = [("variant", ""), *columns, ("error", "")]
        else:
            # Long names in several lines: narrow columns that are not cut.
            columns = [(re.sub(r"\.(?=[A-Za-z])", ".\n", key), unit) for key, unit in columns]
            columns.append(("", ""))
        return Table(NAME, f"{self.title}: {len(rows)} variants", tuple(columns), tuple(rows))


def write_sweep(folder: Path, results: SweepResults, shown: Sequence[str]) -> list[Path]:
    """Write `sweep.csv`, `sweep.json` and, where there is something to draw, `sweep.png`.

    Args:
        folder: The folder of the sweep.
        results: The variants.
        shown: Names of the results that are drawn.

    Returns:
        The files.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    files = [results.table().write_csv(folder), folder / f"{NAME}.json"]
    keys = [key for key, _ in results.keys]
    write_json(
        files[-1],
        {
            "title": results.title,
            "keys": [{"key": key, "unit": unit} for key, unit in results.keys],
            "units": results.units,
            "variants": [
                {
                    "name": row.name,
                    "values": dict(zip(keys, row.values, strict=True)),
                    "error": row.error or None,
                    "results": {name: row.value(name) for name in row.scalars},
                }
                for row in results.rows
            ],
        },
    )
    picture = folder / f"{NAME}.png"
    picture.unlink(missing_ok=True)  # of a sweep before, which may have been another one
    if draw_sweep(picture, results, shown):
        files.append(picture)
    return files


def draw_sweep(path: Path, results: SweepResults, names: Sequence[str]) -> bool:
    """Draw results over the first swept key that has numbers, a line for each value of the others.

    Args:
        path: The PNG file.
        results: The variants.
        names: Names of the results, a panel each; those without two values are left out.

    Returns:
        Whether there was something to draw.
    """
    along = _along(results)
    drawn = [name for name in names if _longest(results, along, name) > 1][:PANELS]
    if not drawn:
        return False
    key, unit = results.keys[along]
    rows, columns = math.ceil(len(drawn) / 2), min(2, len(drawn))
    dashed = " Dashed: published." if any(name in results.published for name in drawn) else ""
    caption = f"{results.title}: results over {key}.{dashed}"
    with figure(path, (rows, columns), (4.5 * columns, 2.8 * rows), caption) as (_, axes):
        for panel, name in zip(axes, drawn, strict=False):
            lines = _lines(results, along, name)
            few = len(lines) <= len(BUILDINGS)
            colours = BUILDINGS if few else ordered_colours(len(lines))
            for colour, (label, points) in zip(colours, lines.items(), strict=False):
                x, y = zip(*sorted(points), strict=True)
                panel.plot(x, y, marker="o", ms=3.5, color=colour, label=label)
                if x[0] > 0.0 and x[-1] >= DECADE * x[0]:
                    panel.set_xscale("log")
            _label(panel, (key, unit), (name, results.units[name]))
            if name in results.published:
                panel.axhline(results.published[name], color="black", lw=0.8, ls="--")
            if panel is axes[0] and any(lines):
                panel.legend()
        for panel in axes[len(drawn) :]:
            panel.set_axis_off()
        letter(axes[: len(drawn)])
    return True


def _along(results: SweepResults) -> int:
    """The first key whose values are numbers and differ, or the first of all."""
    for k, (_, unit) in enumerate(results.keys):
        if unit and len({row.values[k] for row in results.rows}) > 1:
            return k
    return 0


def _label(panel: Axes, key: tuple[str, str], result: tuple[str, str]) -> None:
    for put, (name, unit) in ((panel.set_xlabel, key), (panel.set_ylabel, result)):
        put(f"{name} [{unit}]", fontsize=8.0)


def _lines(results: SweepResults, along: int, name: str) -> dict[str, list[tuple[float, float]]]:
    """The points of each line, by the values of the other keys in words."""
    lines: dict[str, list[tuple[float, float]]] = {}
    for row in results.rows:
        x, y = row.values[along], row.value(name)
        if isinstance(x, str) or y is None:
            continue
        others = [
            f"{key} = {value:.4g} {unit}".removesuffix(" -")
            if isinstance(value, float)
            else f"{key} = {value}"
            for k, ((key, unit), value) in enumerate(zip(results.keys, row.values, strict=True))
            if k != along and not results.zipped
        ]
        lines.setdefault(", ".join(others), []).append((x, y))
    return lines


def _longest(results: SweepResults, along: int, name: str) -> int:
    return max((len(points) for points in _lines(results, along, name).values()), default=0)
