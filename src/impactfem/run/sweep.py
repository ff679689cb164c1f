"""A sweep: a case with one key or several over their values, run into one table."""

from __future__ import annotations

import gc
import math
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from contextlib import ExitStack
from dataclasses import dataclass
from difflib import get_close_matches
from fnmatch import fnmatchcase
from pathlib import Path
from time import perf_counter
from typing import Any

from impactfem.case import Case
from impactfem.case.model import CaseFile
from impactfem.case.source import read_source
from impactfem.plot.table import Table
from impactfem.run.axis import Axis, read_axes
from impactfem.run.finished import take_over
from impactfem.run.folder import open_folder
from impactfem.run.loop import check, run
from impactfem.run.stages import asked_stages, check_stage_name
from impactfem.run.sweep_results import SHOWN, SweepResults, SweepRow, write_sweep
from impactfem.run.variant import Variant, check_variants, variants_of, write_case
from impactfem.stages.inputs import published_values
from impactfem.system import log
from impactfem.system.errors import ImpactfemError, InputError, file_errors
from impactfem.system.log import LOGGER, Steps, in_file_only, mirrored
from impactfem.system.parallel import alone, on_root, rank, start_solvers, workers, world
from impactfem.system.scalar import Scalar

VARIANTS = "variants"
LOG = "sweep.log"  # tells the folder of a sweep from any other


@dataclass(frozen=True)
class Sweep:
    """What a sweep gave.

    Args:
        folder: Its folder.
        results: The variants and their results.
        shown: Names of the results that are shown.
        files: The table and the figure.
    """

    folder: Path
    results: SweepResults
    shown: tuple[str, ...]
    files: tuple[Path, ...]

    @property
    def failed(self) -> int:
        """Number of variants that failed."""
        return sum(bool(row.error) for row in self.results.rows)

    def short_tables(self) -> Iterator[Table]:
        """The results that are shown, in tables of a few columns."""
        for first in range(0, max(1, len(self.shown)), SHOWN):
            yield self.results.table(self.shown[first : first + SHOWN])


@dataclass(frozen=True)
class _Plan:
    """A sweep before it runs: its case, axes and variants, and whether the axes run together."""

    case: Case
    axes: list[Axis]
    variants: list[Variant]
    zipped: bool


@dataclass(frozen=True)
class Job:
    """A variant to run.

    Args:
        name: Its name.
        path: Its case file.
        folder: The folder of its run.
        stage: The last stage to run; all stages when None.
    """

    name: str
    path: Path
    folder: Path
    stage: str | None


@dataclass(frozen=True)
class Outcome:
    """What became of a job.

    Args:
        scalars: Its results; none when it failed.
        error: Why it failed; "" when it did not.
        warnings: Number of its warnings.
        seconds: Its wall time [s].
    """

    scalars: list[Scalar]
    error: str
    warnings: int
    seconds: float


def sweep(
    path: Path,
    settings: Mapping[str, str | Sequence[Any]] | Sequence[str],
    *,
    zipped: bool = False,
    stage: str | None = None,
    out: Path | None = None,
    show: Sequence[str] = (),
    processes: int = 1,
) -> Sweep:
    """Run a case with one key or several over their values.

    Each variant is a case file of its own, which extends the case, in the folder `cases` of the
    sweep, and is run into a folder of its own in `runs`. Finished stages are reused, and a stage
    that another run there has finished with the same inputs is copied. A variant that fails is
    named and left behind. Collective under `mpirun`: rank 0 hands the variants out, the other ranks
    run one each at a time.

    Args:
        path: The case file.
        settings: The swept keys: texts `KEY=VALUES`, or the values by key as a text or a list. In
            a text, values are separated by commas; `start:stop:count` and `start:stop:count:log`
            are ranges. Names of files are relative to the folder of the case.
        zipped: Whether the keys run together, value by value; else each value of one meets each
            value of the others.
        stage: The last stage to run; all stages when None.
        out: The sweep's folder; ``runs/<name of the case file>_sweep`` when None.
        show: Names of the results to show, with * for any letters.
        processes: How many variants run at a time, each in a process of its own. Without meaning
            under `mpirun`.

    Raises:
        InputError: The case, a key, a value or a folder is not usable; nothing has run then.
        ImpactfemError: A file cannot be written.
    """
    folder = out if out is not None else Path("runs") / f"{path.stem}_sweep"
    with ExitStack() as opened:
        opened.enter_context(file_errors())
        plan = on_root(lambda: _prepared(path, settings, zipped, stage, folder, opened))
        jobs = [
            Job(
                variant.name,
                variant.case_file(folder),
                variant.run_folder(folder),
                stage,
            )
            for variant in plan.variants
        ]
        opened.enter_context(mirrored(folder / LOG, rank()))
        opened.enter_context(file_errors())  # within the log, which keeps what was refused
        outcomes = _outcomes(jobs, processes)
        return on_root(lambda: _written(plan, outcomes, folder, show))


def _prepared(
    path: Path,
    settings: Mapping[str, str | Sequence[Any]] | Sequence[str],
    zipped: bool,
    stage: str | None,
    folder: Path,
    opened: ExitStack,
) -> _Plan:
    """Check all that is asked for, then open the folder and write the case files.

    The folder stays open, and others out of it, until `opened` is closed.
    """
    case = check(path)
    source = read_source(path, CaseFile)
    axes, faults = read_axes(settings, source)
    try:
        check_stage_name(stage)
    except InputError as error:
        faults += error.faults
    if faults:
        raise InputError(faults)
    variants = variants_of(axes, zipped=zipped)
    check_variants(variants, source, stage)
    opened.enter_context(open_folder(folder, resume=False, log=LOG))
    for variant in variants:
        write_case(variant, source, folder)
    return _Plan(case, axes, variants, zipped)


def _outcomes(jobs: list[Job], processes: int) -> list[Outcome]:
    """What became of the jobs, in their order; nothing on the ranks that worked for rank 0."""
    LOGGER.info("%d variants", len(jobs))
    found: dict[int, Outcome] = {}
    with ExitStack() as stack:
        steps = None  # of one process: each variant shows its own
        if world() is None and processes == 1:
            ended = _run_here(jobs)
        else:
            start_solvers()
            executor = stack.enter_context(workers(min(processes, len(jobs))))
            if executor is None:
                return []
            ended = _run_elsewhere(jobs, executor)
            steps = stack.enter_context(Steps({VARIANTS: 1.0}, "sweep"))
            stack.enter_context(steps.step(VARIANTS))
        for k, outcome in ended:
            found[k] = outcome
            count, name = f"{len(found)} of {len(jobs)}", jobs[k].name
            if outcome.error:
                LOGGER.warning("variant %s, %s: failed: %s", count, name, outcome.error)
            else:
                told = f", warnings in its log: {outcome.warnings}" if outcome.warnings else ""
                LOGGER.info("variant %s, %s: done in %.1f s%s", count, name, outcome.seconds, told)
            if steps is not None:
                steps.within(VARIANTS, len(found) / len(jobs))
    return [found[k] for k in range(len(jobs))]


def _run_here(jobs: list[Job]) -> Iterator[tuple[int, Outcome]]:
    for k, job in enumerate(jobs):
        LOGGER.info("variant %d of %d, %s: starts", k + 1, len(jobs), job.name)
        yield k, run_job(job)


def _run_elsewhere(jobs: list[Job], executor: Executor) -> Iterator[tuple[int, Outcome]]:
    futures = {executor.submit(run_alone, job): k for k, job in enumerate(jobs)}
    for future in as_completed(futures):
        try:
            yield futures[future], future.result()
        except Exception as error:
            # A process that was killed, as for want of memory: the other results are kept.
            reason = f"its process ended: {type(error).__name__}: {error}"
            yield futures[future], Outcome([], reason, 0, math.nan)


def run_alone(job: Job) -> Outcome:
    """Run a job in a process that is one of several workers; it reports to its files only."""
    log.set_up(verbose=False, rank=1)
    with alone():
        return run_job(job, bar=False)


def run_job(job: Job, *, bar: bool = True) -> Outcome:
    """Run a variant; a failure is an outcome.

    Args:
        job: The variant.
        bar: Whether a bar shows on a terminal how far its run is.
    """
    start = perf_counter()
    scalars: list[Scalar] = []
    failure = ""
    with in_file_only() as warnings:
        try:
            scalars = _run(job, bar)
        except ImpactfemError as error:
            failure = str(error)
        except Exception as error:
            # An error of the program or of a library in one variant: the others run all the same.
            LOGGER.debug("variant %s", job.name, exc_info=True)
            failure = f"{type(error).__name__}: {error}"
    gc.collect()  # matrices of a variant go before those of the next one come
    return Outcome(scalars, failure, len(warnings), perf_counter() - start)


def _run(job: Job, bar: bool) -> list[Scalar]:
    with open_folder(job.folder, resume=False), file_errors():
        case = check(job.path)
        others = sorted(other for other in job.folder.parent.iterdir() if other != job.folder)
        for stage in asked_stages(case, job.stage):
            origin = take_over(job.folder, others, stage.name, stage.key(case))
            if origin is not None:
                LOGGER.debug("stage %s: the same as in %s, copied", stage.name, origin)
    return run(job.path, out=job.folder, stage=job.stage, bar=bar).scalars


def _written(plan: _Plan, outcomes: list[Outcome], folder: Path, show: Sequence[str]) -> Sweep:
    results = _results(plan, outcomes)
    shown = results.chosen(show)
    _warn_of_unknown(show, list(results.units))
    return Sweep(folder, results, tuple(shown), tuple(write_sweep(folder, results, shown)))


def _results(plan: _Plan, outcomes: list[Outcome]) -> SweepResults:
    rows = []
    for variant, outcome in zip(plan.variants, outcomes, strict=True):
        values = tuple(a.cell(v) for a, v in zip(plan.axes, variant.values, strict=True))
        scalars = {scalar.name: scalar for scalar in outcome.scalars}
        rows.append(SweepRow(variant.name, values, scalars, outcome.error.replace("\n", "; ")))
    return SweepResults(
        title=plan.case.title,
        keys=tuple((axis.key, axis.unit) for axis in plan.axes),
        rows=tuple(rows),
        published=published_values(plan.case),
        zipped=plan.zipped,
    )


def _warn_of_unknown(show: Sequence[str], known: list[str]) -> None:
    for pattern in show:
        if known and not any(fnmatchcase(name, pattern) for name in known):
            near = get_close_matches(pattern, known, n=1)
            hint = f"; did you mean '{near[0]}'?" if near else ""
            LOGGER.warning("warning: no result is called %s%s", pattern, hint)
