"""A sweep: a case with one key or several over their values, run into one table and drawn."""

import gc
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import as_completed
from contextlib import ExitStack
from dataclasses import dataclass
from difflib import get_close_matches
from fnmatch import fnmatchcase
from pathlib import Path
from time import perf_counter
from typing import Self

import numpy as np
import pandas as pd

from impactfem.case import Building3D, Case
from impactfem.case.model import CaseFile
from impactfem.case.source import read_source
from impactfem.plot.style import letter, sheet
from impactfem.plot.table import Table
from impactfem.report.comparison import FIRST
from impactfem.run.check import check
from impactfem.run.folder import open_folder
from impactfem.run.loop import run
from impactfem.run.stages import asked_stages, check_stage_name
from impactfem.run.variants import (
    Settings,
    Variant,
    check_variants,
    in_si,
    read_variants,
    words,
    write_case,
)
from impactfem.stages.inputs import published_values
from impactfem.stages.manifest import take_over
from impactfem.stages.reduce.stage import REDUCE, take_model
from impactfem.system.errors import Fault, ImpactfemError, InputError, file_errors
from impactfem.system.executor import workers
from impactfem.system.files import StrPath, atomic, write_json
from impactfem.system.log import LOGGER, Steps, collected_warnings, mirrored
from impactfem.system.parallel import alone, on_root, rank, start_solvers, world
from impactfem.system.scalar import Scalar

VARIANTS = "variants"
LOG = "sweep.log"  # distinguishes the folder of a sweep from any other
NAME = "sweep"
PANELS = 12
DECADE = 10.0
"""Ratio of swept values from which on their axis is logarithmic."""
SHOWN = 6
"""Number of results in a table on the screen, and of those shown when none is requested."""


@dataclass(frozen=True)
class Outcome:
    """Results of a variant, or why it failed; its number of warnings and its wall time [s]."""

    scalars: list[Scalar]
    error: str
    warnings: int
    seconds: float


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

    @classmethod
    def of(
        cls,
        title: str,
        variants: Sequence[Variant],
        outcomes: Sequence[Outcome],
        published: Mapping[str, float],
    ) -> Self:
        """Return the table of variants and their outcomes."""
        names = [variant.name for variant in variants]
        rows = [{one.name: one.value for one in outcome.scalars} for outcome in outcomes]
        units = {one.name: one.unit for outcome in outcomes for one in outcome.scalars}
        errors = [outcome.error.replace("\n", "; ") for outcome in outcomes]
        results = pd.DataFrame(rows, index=names, columns=list(units), dtype=float)
        keys, values = {}, {}
        for k, key in enumerate(variants[0].keys):
            given = [variant.values[k] for variant in variants]
            in_units = {in_si(value)[1] for value in given}
            keys[key.name] = in_units.pop() if len(in_units) == 1 else ""
            values[key.name] = [in_si(v)[0] if keys[key.name] else words(v) for v in given]
        return cls(
            title=title,
            keys=keys,
            values=pd.DataFrame(values, index=names),
            units=units,
            results=results.where(np.isfinite(results)),  # infinity is no result
            errors=pd.Series(errors, names, dtype=object),
            published=published,
        )

    def chosen(self, patterns: Sequence[str]) -> list[str]:
        """Names of the results to show: those of the patterns, in which * stands for any letters.

        Without patterns those that differ between the variants, published ones first, then those
        of `FIRST`.
        """
        known = list(self.units)
        if patterns:
            found = [n for pattern in patterns for n in known if fnmatchcase(n, pattern)]
            return list(dict.fromkeys(found))
        counts = self.results[self.errors == ""].nunique(dropna=False)
        varied = [name for name in known if counts[name] > 1]

        def later(name: str) -> tuple[bool, bool]:
            return name not in self.published, not any(fnmatchcase(name, one) for one in FIRST)

        return sorted(varied or known, key=later)[:SHOWN]

    def texts(self, names: Sequence[str], width: int) -> Iterator[str]:
        """Yield the swept values and some results as tables of a few columns each."""
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
        """Draw results over the first swept key that has numbers, a line for the other values.

        Each result has a panel; those with less than two values are left out. Gives whether there
        was something to draw.
        """
        numbers = [key for key, unit in self.keys.items() if unit]
        along = next((key for key in numbers if self.values[key].nunique() > 1), None)
        if along is None:
            return False
        others = self.values.drop(columns=along).astype(str).agg(", ".join, axis=1)
        if others.empty or others.nunique() == len(others):
            others = pd.Series("", self.values.index)
        drawn = [name for name in names if self.results[name].count() > 1][:PANELS]
        if not drawn:
            return False
        rows, columns = math.ceil(len(drawn) / 2), min(2, len(drawn))
        dashed = " Dashed: published." if self.published.keys() & set(drawn) else ""
        caption = f"{self.title}: {', '.join(drawn)} over {along}.{dashed}"
        with sheet(path, (rows, columns), (4.5 * columns, 2.8 * rows), caption) as (_, axes):
            for panel, name in zip(axes, drawn, strict=False):
                y = self.results[name].set_axis(self.values[along])
                for label, line in y.groupby(others.to_numpy(), sort=False):
                    line = line.dropna().sort_index()
                    panel.plot(line.index, line, marker="o", ms=3.5, label=str(label))
                if y.index.min() > 0.0 and y.index.max() >= DECADE * y.index.min():
                    panel.set_xscale("log")
                panel.set_xlabel(f"{along} [{self.keys[along]}]", fontsize=8.0)
                panel.set_ylabel(f"{name} [{self.units[name]}]", fontsize=8.0)
                if name in self.published:
                    panel.axhline(self.published[name], color="black", lw=0.8, ls="--")
            if others.iloc[0]:
                axes[0].legend()
            for panel in axes[len(drawn) :]:
                panel.set_axis_off()
            letter(axes[: len(drawn)])
        return True


@dataclass(frozen=True)
class Sweep:
    """The results of a sweep."""

    folder: Path
    table: SweepTable  #: the variants with their values and results
    shown: tuple[str, ...]  #: names of the results that are shown
    files: tuple[Path, ...]  #: the table and the figure

    @property
    def failed(self) -> int:
        """Number of variants that failed."""
        return int((self.table.errors != "").sum())


def sweep(
    path: StrPath,
    settings: Settings = (),
    *,
    variants: StrPath | None = None,
    stage: str | None = None,
    out: StrPath | None = None,
    show: Sequence[str] = (),
    draw: bool = True,
    processes: int = 1,
) -> Sweep:
    """Run a case with one key or several over their values.

    Each variant is a case file of its own, which extends the case, in the folder `cases` of the
    sweep, and is run into a folder of its own in `runs`. Finished stages are reused, and a stage
    that another run there has finished with the same inputs is copied. A variant that fails is
    named, and the others run. Collective under `mpirun`: rank 0 hands the variants out, the other
    ranks run one each at a time.

    Args:
        path: The case file.
        settings: The swept keys: texts `KEY=VALUE,VALUE`, or the values by key as a list or a text.
            Each value of one key meets each value of the others. Names of files are relative to the
            folder of the case.
        variants: A table (CSV) in place of the settings: its first line has the keys, each further
            line the values of a variant.
        stage: The last stage to run; all stages when None.
        out: The sweep's folder; ``runs/<name of the case file>_sweep`` when None.
        show: Names of the results to show, with * for any letters.
        draw: Whether tables, figures and the page of each variant are made, as of `run`.
        processes: How many variants run at a time, each in a process of its own. Without meaning
            under `mpirun`.

    Raises:
        InputError: The case, a key, a value or a folder is not usable; nothing has run then.
        ImpactfemError: A file cannot be written.
    """
    path = Path(path)
    folder = Path(out) if out is not None else Path("runs") / f"{path.stem}_sweep"

    def prepare() -> tuple[Case, list[Variant]]:
        case = check(path)
        source = read_source(path, CaseFile)
        faults, made = list[Fault](), list[Variant]()
        try:
            check_stage_name(stage)
        except InputError as error:
            faults += error.faults
        try:
            made = read_variants(settings, None if variants is None else Path(variants), source)
        except InputError as error:
            faults = [*error.faults, *faults]
        if faults:
            raise InputError(faults)
        check_variants(made, source, stage)
        opened.enter_context(open_folder(folder, resume=False, log=LOG))
        for variant in made:
            write_case(variant, source, folder)
        return case, made

    with ExitStack() as opened:
        opened.enter_context(file_errors())
        case, every = on_root(prepare)
        opened.enter_context(mirrored(folder / LOG, rank()))
        opened.enter_context(file_errors())  # within the log, which keeps what was refused
        outcomes = _outcomes(every, folder, stage, draw, processes)

        def write() -> Sweep:
            published = published_values(case)
            table = SweepTable.of(case.title, every, outcomes, published)
            known = list(table.units)
            for pattern in show:
                if known and not any(fnmatchcase(name, pattern) for name in known):
                    near = get_close_matches(pattern, known, n=1)
                    hint = f"; did you mean '{near[0]}'?" if near else ""
                    LOGGER.warning("warning: no result is called %s%s", pattern, hint)
            shown = table.chosen(show)
            return Sweep(folder, table, tuple(shown), tuple(table.write(folder, shown)))

        return on_root(write)


def _outcomes(
    variants: list[Variant], folder: Path, stage: str | None, draw: bool, processes: int
) -> list[Outcome]:
    """Run the variants and return their outcomes in order; none on the ranks other than 0."""
    LOGGER.info("%d variants", len(variants))
    found: dict[int, Outcome] = {}

    def ended(k: int, outcome: Outcome) -> None:
        found[k] = outcome
        count, name = f"{len(found)} of {len(variants)}", variants[k].name
        if outcome.error:
            LOGGER.warning("variant %s, %s: failed: %s", count, name, outcome.error)
        else:
            more = f", warnings in its log: {outcome.warnings}" if outcome.warnings else ""
            LOGGER.info("variant %s, %s: done in %.1f s%s", count, name, outcome.seconds, more)

    if world() is None and processes == 1:
        for k, variant in enumerate(variants):
            LOGGER.info("variant %d of %d, %s: starts", k + 1, len(variants), variant.name)
            ended(k, run_variant(variant, folder, stage, draw=draw))
        return list(found.values())
    start_solvers()
    with workers(min(processes, len(variants))) as executor:
        if executor is None:
            return []
        futures = {
            executor.submit(run_variant, variant, folder, stage, draw=draw, apart=True): k
            for k, variant in enumerate(variants)
        }
        with Steps({VARIANTS: 1.0}, "sweep") as steps, steps.step(VARIANTS):
            for future in as_completed(futures):
                try:
                    outcome = future.result()
                except Exception as error:
                    # A process that was killed, as for want of memory: the other results are kept.
                    reason = f"its process ended: {type(error).__name__}: {error}"
                    outcome = Outcome([], reason, 0, math.nan)
                ended(futures[future], outcome)
                steps.within(VARIANTS, len(found) / len(variants))
    return [found[k] for k in range(len(variants))]


def run_variant(
    variant: Variant, folder: Path, stage: str | None, *, draw: bool = True, apart: bool = False
) -> Outcome:
    """Run a variant, whose case file is in the folder of the sweep; a failure is an outcome.

    In one of several workers, `apart`, it reports to its files only.
    """
    start = perf_counter()
    scalars: list[Scalar] = []
    failure = ""
    path, target = variant.case_file(folder), variant.run_folder(folder)
    with ExitStack() as held:
        if apart:
            held.enter_context(alone())
        warnings = held.enter_context(collected_warnings("nothing" if apart else "progress"))
        try:
            with open_folder(target, resume=False), file_errors():
                case = check(path)
                others = sorted(other for other in target.parent.iterdir() if other != target)
                stages = asked_stages(case, stage)
                for one, of in ((k, subject) for k in stages for subject in k.of(case)):
                    label = one.label(of)
                    origin = take_over(target, others, label, one.key(of))
                    if origin is not None:
                        LOGGER.debug("stage %s: the same as in %s, copied", label, origin)
                    elif one is REDUCE and isinstance(of, Building3D):
                        origin = take_model(of, target, others)
                        if origin is not None:
                            LOGGER.debug(
                                "stage %s: the reduced building of %s copied", label, origin
                            )
            scalars = run(path, out=target, stage=stage, draw=draw, bar=not apart).scalars
        except ImpactfemError as error:
            failure = str(error)
        except Exception as error:
            # An error of the program or of a library in one variant: the others run all the same.
            LOGGER.debug("variant %s", variant.name, exc_info=True)
            failure = f"{type(error).__name__}: {error}"
    gc.collect()  # matrices of a variant go before those of the next one come
    return Outcome(scalars, failure, len(warnings), perf_counter() - start)
