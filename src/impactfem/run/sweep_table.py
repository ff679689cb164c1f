"""The table of a sweep: its variants with their values and results, written and drawn."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
import pandas as pd

from impactfem.plot.style import BUILDINGS, figure, letter, ordered_colours
from impactfem.plot.table import Table
from impactfem.run.variants import Axis, Variant
from impactfem.system.files import atomic, write_json
from impactfem.system.scalar import Scalar

NAME = "sweep"
PANELS = 12
DECADE = 10.0
"""Ratio of swept values from which on their axis is logarithmic."""
SHOWN = 6
"""Number of results in a table on the screen, and of those shown when none is requested."""


@dataclass(frozen=True, eq=False)
class SweepTable:
    """The variants of a sweep and their results; rows of all tables are named by the variants."""

    title: str  #: title of the case
    keys: Mapping[str, str]  #: SI unit of the values of each swept key; "" for words
    values: pd.DataFrame  #: the swept values, a column a key: in SI, or words
    units: Mapping[str, str]  #: unit of each result
    results: pd.DataFrame  #: the results in SI, a column each; nan where there is none
    errors: pd.Series  #: why a variant failed; "" when it did not
    published: Mapping[str, float]  #: published values in SI by the name of the result
    zipped: bool = False  #: whether the keys ran together: all variants are on one line

    @classmethod
    def of(
        cls,
        title: str,
        axes: Sequence[Axis],
        variants: Sequence[Variant],
        found: Iterable[tuple[Sequence[Scalar], str]],
        published: Mapping[str, float],
        zipped: bool,
    ) -> SweepTable:
        """The table of variants, of which each has found results or why it failed."""
        names = [variant.name for variant in variants]
        scalars, errors = zip(*found, strict=True)
        rows = [{one.name: one.value for one in given} for given in scalars]
        units = {one.name: one.unit for given in scalars for one in given}
        results = pd.DataFrame(rows, index=names, columns=list(units), dtype=float)
        values = {
            axis.key: [axis.cell(variant.values[k]) for variant in variants]
            for k, axis in enumerate(axes)
        }
        return cls(
            title=title,
            keys={axis.key: axis.unit for axis in axes},
            values=pd.DataFrame(values, index=names),
            units=units,
            results=results.where(np.isfinite(results)),  # infinity is no result
            errors=pd.Series([error.replace("\n", "; ") for error in errors], names, dtype=object),
            published=published,
            zipped=zipped,
        )

    def chosen(self, patterns: Sequence[str]) -> list[str]:
        """Names of the results to show: those of the patterns, in which * stands for any letters.

        Without patterns those that differ between the variants, published ones first.
        """
        known = list(self.units)
        if patterns:
            found = [n for pattern in patterns for n in known if fnmatchcase(n, pattern)]
            return list(dict.fromkeys(found))
        counts = self.results[self.errors == ""].nunique(dropna=False)
        varied = [name for name in known if counts[name] > 1]
        return sorted(varied or known, key=lambda name: name not in self.published)[:SHOWN]

    def texts(self, names: Sequence[str], width: int) -> Iterator[str]:
        """The swept values and some results, as tables of a few columns each."""
        failed = ["failed" if error else "" for error in self.errors]
        for first in range(0, max(1, len(names)), SHOWN):
            shown = names[first : first + SHOWN]
            heads = [*self.keys.items(), *((name, self.units[name]) for name in shown)]
            # Long names in several lines: narrow columns that are not cut.
            heads = [(re.sub(r"\.(?=[A-Za-z])", ".\n", name), unit) for name, unit in heads]
            cells = self.results[list(shown)].astype(object)
            cells = pd.concat([self.values, cells.where(cells.notna(), None)], axis=1)
            rows = cells.assign(**{"": failed}).itertuples(index=False, name=None)
            title = f"{self.title}: {len(failed)} variants"
            yield Table(NAME, title, (*heads, ("", "")), tuple(rows)).as_text(width)

    def write(self, folder: Path, shown: Sequence[str]) -> list[Path]:
        """Write `sweep.csv`, `sweep.json` and, where results can be shown, `sweep.svg`.

        ImpactfemError where a file cannot be written.

        Returns:
            The files.
        """
        files = [folder / f"{NAME}.{ending}" for ending in ("csv", "json", "svg")]
        units = {**self.keys, **self.units}
        whole = pd.concat([self.values, self.results], axis=1)
        whole.columns = [f"{name} [{units[name]}]" if units[name] else name for name in whole]
        with atomic(files[0]) as temporary:
            whole.assign(error=self.errors).to_csv(temporary, index_label="variant")
        # Not by `to_json` of pandas, which rounds to ten decimals.
        values = self.results.astype(object).where(self.results.notna(), None)
        variants = [
            {
                "name": name,
                "values": self.values.loc[name].to_dict(),
                "error": error or None,
                "results": {} if error else values.loc[name].to_dict(),
            }
            for name, error in self.errors.items()
        ]
        keys = [{"key": key, "unit": unit} for key, unit in self.keys.items()]
        head = {"title": self.title, "keys": keys, "units": self.units}
        write_json(files[1], {**head, "variants": variants})
        files[2].unlink(missing_ok=True)  # of a sweep before, which may have been another one
        return files if self.draw(files[2], shown) else files[:2]

    def draw(self, path: Path, names: Sequence[str]) -> bool:
        """Draw results over the first swept key that has numbers, a line a value of the others.

        Each has a panel; those without two values are left out.

        Returns:
            Whether there was something to draw.
        """
        numbers = [key for key, unit in self.keys.items() if unit]
        along = next((key for key in numbers if self.values[key].nunique() > 1), None)
        lines = {name: self._lines(along, name) for name in names if along is not None}
        drawn = [
            name for name, found in lines.items() if any(len(one) > 1 for one in found.values())
        ]
        drawn = drawn[:PANELS]
        if along is None or not drawn:
            return False
        rows, columns = math.ceil(len(drawn) / 2), min(2, len(drawn))
        dashed = " Dashed: published." if any(name in self.published for name in drawn) else ""
        caption = f"{self.title}: results over {along}.{dashed}"
        with figure(path, (rows, columns), (4.5 * columns, 2.8 * rows), caption) as (_, axes):
            for panel, name in zip(axes, drawn, strict=False):
                many = len(lines[name]) > len(BUILDINGS)
                colours = ordered_colours(len(lines[name])) if many else BUILDINGS
                for colour, (label, y) in zip(colours, lines[name].items(), strict=False):
                    panel.plot(y.index, y, marker="o", ms=3.5, color=colour, label=label)
                    if y.index[0] > 0.0 and y.index[-1] >= DECADE * y.index[0]:
                        panel.set_xscale("log")
                panel.set_xlabel(f"{along} [{self.keys[along]}]", fontsize=8.0)
                panel.set_ylabel(f"{name} [{self.units[name]}]", fontsize=8.0)
                if name in self.published:
                    panel.axhline(self.published[name], color="black", lw=0.8, ls="--")
            if any(lines[drawn[0]]):
                axes[0].legend()
            for panel in axes[len(drawn) :]:
                panel.set_axis_off()
            letter(axes[: len(drawn)])
        return True

    def _lines(self, along: str, name: str) -> dict[str, pd.Series]:
        """A result over a key, for each choice of the other keys in words."""
        others = [key for key in self.values if key != along and not self.zipped]
        label = pd.Series("", self.values.index)
        for key in others:
            label += ", " if key != others[0] else ""
            unit = self.keys[key].removesuffix("-")
            for row, value in self.values[key].items():
                words = f"{value:.4g} {unit}" if isinstance(value, float) else value
                label[row] += f"{key} = {words}".rstrip()
        y = self.results[name].set_axis(self.values[along])
        found = y.groupby(label.to_numpy(), sort=False)
        return {str(text): line.dropna().sort_index() for text, line in found if line.notna().any()}
