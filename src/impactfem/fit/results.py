"""What a fit writes: its results as JSON, CSV and a page, its figures, and the fitted case."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from impactfem.fit.problem import Problem
from impactfem.plot.style import BLUE, ORANGE, sheet
from impactfem.plot.table import Cell, Table
from impactfem.system.arrays import Array
from impactfem.system.files import atomic, write_json
from impactfem.system.least_squares import BLIND, Identification, Minimum

FITTED = "fitted.toml"
HIT = 1e-3
"""Part of the range between the bounds within which a key is at one of them."""


@dataclass(frozen=True, eq=False)
class Fit:
    """The results of a fit."""

    folder: Path
    problem: Problem
    u: Array  #: the fitted keys on the scale of the fit, shape (n,)
    minima: tuple[Minimum, ...]  #: what the starts led to, the best one first
    #: The minima that fit as well as the best one, a list each solution, the best one first.
    solutions: list[list[Minimum]]
    before: Array  #: what the model gives at the first start, shape (m,)
    after: Array  #: and at the end
    shown: dict[str, float]  #: MAC of measured modes, at the end
    J: Array  #: slopes of what it gives at the end, shape (m, n)
    identification: Identification  #: what the data say about the keys, by the slopes
    #: Of keys whose slopes say nothing: standard deviations by which the data change where one
    #: alone goes to its lower and its upper bound; nan where the case has no result there.
    across: dict[int, tuple[float, float]]
    evaluations: int  #: number of evaluations, of the case and of the cheaper one
    rounds: int  #: corrections by the case itself; 0 without a cheaper one
    warnings: list[str] = field(default_factory=list)  #: what to know of it
    tables: tuple[Table, ...] = ()  #: keys, targets, and solutions where there are several
    files: tuple[Path, ...] = ()  #: what was written

    @property
    def values(self) -> Array:
        """The fitted keys in SI, shape (n,)."""
        return self.problem.values(self.u)

    @property
    def bound(self) -> Array:
        """± of each key in SI: all together are within it with 95 %; inf, nothing says it, (n,)."""
        keys = self.problem.fit.free.values()
        slopes = np.array([key.slope(float(u)) for key, u in zip(keys, self.u, strict=True)])
        # Beyond the bounds of a key its ± says nothing.
        b = self.identification.bound
        return np.where(b < 1.0, b * slopes, np.inf)

    @property
    def unseen(self) -> list[int]:
        """The keys that the data see neither by their slopes nor at a bound."""
        # A bound without a result says nothing, whatever the other one does.
        return [k for k, ends in self.across.items() if not any(end >= BLIND for end in ends)]

    @property
    def errors(self) -> tuple[Array, Array]:
        """(model − data)/deviation before and after, shape (m,) each."""
        misfit = self.problem.misfit
        return misfit.errors(self.before), misfit.errors(self.after)

    @property
    def chi_squared_of_priors(self) -> tuple[float, float]:
        """Sum of squares of (key − mean)/deviation of the priors before and after."""
        before, after = (self.problem.prior_errors(u) for u in (self.problem.start, self.u))
        return float(before @ before), float(after @ after)

    @property
    def at_bound(self) -> list[str]:
        """Which of its bounds each key is at: "lower", "upper" or "no"."""
        sides = ("lower" if u < HIT else "upper" if u > 1.0 - HIT else "no" for u in self.u)
        return list(sides)


def keys_table(result: Fit) -> Table:
    """The keys: start, fitted, ±, what the data say."""
    problem, found = result.problem, result.identification
    columns = [("key", ""), ("unit", ""), ("start", ""), ("fitted", ""), ("±", "")]
    columns += [("standard deviation", ""), ("at bound", ""), ("seen", "")]
    rows = []
    start = problem.values(problem.start)
    for k, key in enumerate(problem.keys):
        entry = problem.fit.free[key]
        deviation = found.deviation[k] * entry.slope(float(result.u[k]))
        row: list[Cell] = [key, entry.bounds[0].unit, float(start[k]), float(result.values[k])]
        row += [_known(result.bound[k]), _known(deviation), result.at_bound[k]]
        row.append("no" if k in result.unseen else "not here" if k in result.across else "yes")
        rows.append(tuple(row))
    title = "Keys; all are within their ± together with 95 %, - where the data do not say"
    return Table("fit_keys", title, tuple(columns), tuple(rows))


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def targets_table(result: Fit, whole: bool = True) -> Table:
    """The data: value, deviation, the model before and after, and the errors in deviations.

    Not the `whole`: of a shape or a spectrum one row with the root mean square of its errors.
    """
    before, after = result.errors
    width = result.problem.misfit.deviations(result.after)
    heads = ("result", "unit", "value", "deviation", "before", "after", "error before", "error")
    rows: list[tuple[Cell, ...]] = []
    for name, own in _groups(result.problem).items():
        one = result.problem.data[own[0]]
        if name == one.group and not whole:
            rms = [float(np.sqrt(np.square(errors[own]).mean())) for errors in (before, after)]
            rows.append((f"{name} ({len(own)}, rms)", one.unit, None, None, None, None, *rms))
            continue
        for k in own:
            one = result.problem.data[k]
            values = (one.value, float(width[k]), float(result.before[k]), float(result.after[k]))
            rows.append((one.name, one.unit, *values, float(before[k]), float(after[k])))
    title = "Targets; error = (model − value)/deviation, percentages of the model's value"
    return Table("fit_targets", title, tuple((head, "") for head in heads), tuple(rows))


def solutions_table(result: Fit) -> Table:
    """Return the solutions that fit equally well, a row each, with their χ² and starts."""
    problem = result.problem
    columns = [("solution", ""), ("χ²", ""), ("starts", "")]
    columns += [(f"{key} [{entry.bounds[0].unit}]", "") for key, entry in problem.fit.free.items()]
    rows: list[tuple[Cell, ...]] = []
    for number, group in enumerate(result.solutions, start=1):
        # Corrections by the case itself move the first one alone.
        values = result.values if number == 1 else problem.values(group[0].x)
        rows.append((number, 2.0 * group[0].cost, len(group), *map(float, values)))
    title = "Solutions that fit the data equally well"
    return Table("fit_solutions", title, tuple(columns), tuple(rows))


def _groups(problem: Problem) -> dict[str, list[int]]:
    """The numbers of the data by what they are shown as."""
    found: dict[str, list[int]] = {}
    for k, one in enumerate(problem.data):
        found.setdefault(one.group or one.name, []).append(k)
    return found


def write_results(result: Fit) -> Fit:
    """Write all files of a fit; the result with their names.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    folder, problem, found = result.folder, result.problem, result.identification
    keys, targets = keys_table(result), targets_table(result, whole=False)
    files = [keys.write_csv(folder), targets_table(result).write_csv(folder)]
    tables: tuple[Table, ...] = (keys, targets)
    (folder / "fit_solutions.csv").unlink(missing_ok=True)  # of an earlier fit
    if len(result.solutions) > 1:
        tables = (*tables, solutions_table(result))
        files.append(tables[-1].write_csv(folder))
    entries = [dict(zip((n for n, _ in keys.columns), row, strict=True)) for row in keys.rows]
    both, of_priors = result.errors, result.chi_squared_of_priors
    summary: dict[str, Any] = {
        "case": problem.source.path.name,
        "fit": problem.path.name,
        "level": problem.level,
        "keys": entries,
        "targets": [
            asdict(datum)
            | {"deviation": float(width), "before": float(b), "after": float(a), "error": float(e)}
            for datum, width, b, a, e in zip(
                problem.data,
                problem.misfit.deviations(result.after),
                result.before,
                result.after,
                both[1],
                strict=True,
            )
        ],
        "chi_squared": {
            "before": float(np.square(both[0]).sum()),
            "after": float(np.square(both[1]).sum()),
            "data": len(problem.data),
            "keys": len(problem.keys),
            "priors": len(problem.priors),
            "priors_before": of_priors[0],
            "priors_after": of_priors[1],
        },
        "shown": result.shown,
        "singular_values": [float(one) for one in found.singular_values],
        "directions": found.directions.tolist(),
        "reach": [float(one) for one in found.reach],
        "across": {problem.keys[k]: list(changes) for k, changes in result.across.items()},
        "correlation": [[_known(one) for one in row] for row in found.correlation],
        "minima": [
            {"keys": problem.values(one.x).tolist(), "cost": one.cost, "met": one.met}
            for one in result.minima
        ],
        "solutions": [
            {
                "keys": dict(zip(problem.keys, problem.values(group[0].x).tolist(), strict=True)),
                "chi_squared": 2.0 * group[0].cost,
                "starts": len(group),
            }
            for group in result.solutions
        ],
        "evaluations": result.evaluations,
        "corrections": result.rounds,
        "warnings": result.warnings,
    }
    files.append(folder / "fit.json")
    write_json(files[-1], summary)
    files.append(_write_case(result))
    files += _figures(result)
    files.append(folder / "fit.md")
    with atomic(files[-1]) as temporary:
        temporary.write_text(_page(result, tables), encoding="utf-8")
    return replace(result, tables=tables, files=tuple(files))


def _write_case(result: Fit) -> Path:
    """The case file that extends the case by the fitted values."""
    path = result.folder / FITTED
    variant = replace(result.problem, fixed=()).variant(result.u)
    text = variant.case_text(result.problem.source, result.folder)
    head = f"# Fitted to {result.problem.path.name}: fit.md\n"
    with atomic(path) as temporary:
        temporary.write_text(head + text.partition("\n")[2], encoding="utf-8")
    return path


def _page(result: Fit, tables: tuple[Table, ...]) -> str:
    """The results in Markdown."""
    before, after = (float(np.square(one).sum()) for one in result.errors)
    priors = ""
    if result.problem.priors:
        first, last = result.chi_squared_of_priors
        priors = f"of the priors: {first:.4g} before, {last:.4g} after; "
    good = "All keys are seen, none is at a bound; the data are met within their deviations."
    lines = [
        f"# Fit of {result.problem.source.path.name}",
        "",
        f"χ² of {len(result.problem.data)} data: {before:.4g} before, {after:.4g} after; "
        f"{priors}{len(result.problem.keys)} keys, {result.evaluations} evaluations, "
        f"{len(result.minima)} starts.",
        "",
        f"## {tables[0].title}",
        "",
        *_markdown(tables[0]),
        "",
        "## What to know",
        "",
        *(f"- {text}" for text in result.warnings or [good]),
    ]
    for table in reversed(tables[1:]):
        lines += ["", f"## {table.title}", "", *_markdown(table)]
    if result.shown:
        lines += ["", "## Measured modes", "", "| | |", "|---|---|"]
        lines += [f"| {name} | {value:.4g} |" for name, value in result.shown.items()]
    return "\n".join(lines) + "\n"


def _markdown(table: Table) -> list[str]:
    def words(cell: Cell) -> str:
        return "-" if cell is None else f"{cell:.5g}" if isinstance(cell, float) else str(cell)

    heads = [name for name, _ in table.columns]
    rows = [f"| {' | '.join(words(cell) for cell in row)} |" for row in table.rows]
    return [f"| {' | '.join(heads)} |", f"|{'---|' * len(heads)}", *rows]


def _figures(result: Fit) -> list[Path]:
    """Draw the errors before and after the fit, and the correlation of the keys."""
    problem, n, groups = result.problem, len(result.problem.keys), _groups(result.problem)
    files = [result.folder / "fit_errors.svg"]
    caption = (
        "Errors of the targets, (model − value)/deviation, before the fit (circles) and after it "
        "(dots); of a shape or a spectrum one for each sensor or ordinate. Shaded: two standard "
        "deviations."
    )
    before, after = result.errors
    worst = problem.data[int(np.argmax(np.abs(after)))].name
    seen = (
        f"{len(after)} targets. Largest error before {np.abs(before).max():.3g}, after "
        f"{np.abs(after).max():.3g} standard deviations ({worst})."
    )
    size = (7.0, 0.22 * len(groups) + 0.9)
    with sheet(files[0], (1, 1), size, caption, seen) as (_, (panel,)):
        y = np.empty(len(after))
        for row, own in enumerate(groups.values()):
            y[own] = row
        panel.axvspan(-2.0, 2.0, color="0.9", lw=0.0)
        panel.axvline(0.0, color="black", lw=0.8)
        panel.plot(before, y, "o", ms=4.0, mfc="none", mec=ORANGE, label="before")
        panel.plot(after, y, "o", ms=3.5, color=BLUE, label="after")
        panel.set_xscale("symlog", linthresh=3.0)
        panel.xaxis.set_major_formatter("{x:g}")
        panel.set_xlabel("error [standard deviations]")
        panel.set_yticks(np.arange(len(groups)), list(groups), fontsize=7.0)
        panel.set_ylim(len(groups) - 0.5, -0.5)
        panel.legend()
    if n > 1:
        files.append(result.folder / "fit_correlation.svg")
        caption = "Correlation of the fitted keys, by the linearised fit; empty: not determined."
        C = result.identification.correlation
        pairs = [(abs(C[i, j]), i, j) for i in range(n) for j in range(i) if np.isfinite(C[i, j])]
        _, i, j = max(pairs, default=(0.0, 0, 0))
        seen = f"{n} keys."
        if pairs:
            seen += f" Most correlated, {C[i, j]:.2f}: {problem.keys[i]} and {problem.keys[j]}."
        short = [_short(key, problem.keys) for key in problem.keys]
        label = 0.07 * max(len(name) for name in short)
        size = (0.6 * n + label + 0.6, 0.6 * n + 0.6 * label + 0.5)
        with sheet(files[-1], (1, 1), size, caption, seen) as (_, (panel,)):
            panel.pcolormesh(C, cmap="RdBu_r", vmin=-1.0, vmax=1.0, edgecolors="white")
            for a in range(n):
                for b in range(n):
                    if np.isfinite(C[a, b]):
                        colour = "white" if abs(C[a, b]) > 0.6 else "black"
                        text = f"{C[a, b]:.2f}"
                        panel.text(b + 0.5, a + 0.5, text, ha="center", va="center", color=colour)
            ticks = np.arange(n) + 0.5
            panel.set_xticks(ticks, short, rotation=30, ha="right", fontsize=7.0)
            panel.set_yticks(ticks, short, fontsize=7.0)
            panel.invert_yaxis()
            panel.grid(False)
    return files


def _short(key: str, keys: list[str]) -> str:
    """As many of the last parts of a key as tell it from the others."""
    parts = key.split(".")
    ends = (".".join(parts[-count:]) for count in range(1, len(parts)))
    return next((end for end in ends if sum(one.endswith(end) for one in keys) == 1), key)
