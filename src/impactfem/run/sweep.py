"""A sweep: a case with one key or several over their values, run into one table."""

from __future__ import annotations

import gc
import math
from collections.abc import Sequence
from concurrent.futures import as_completed
from contextlib import ExitStack
from dataclasses import dataclass
from difflib import get_close_matches
from fnmatch import fnmatchcase
from pathlib import Path
from time import perf_counter

from impactfem.case import Case
from impactfem.case.model import CaseFile
from impactfem.case.source import read_source
from impactfem.run.check import check
from impactfem.run.folder import open_folder
from impactfem.run.loop import run
from impactfem.run.stages import asked_stages, check_stage_name, works
from impactfem.run.sweep_table import SweepTable
from impactfem.run.variants import (
    Axis,
    Settings,
    Variant,
    check_variants,
    read_axes,
    variants_of,
    write_case,
)
from impactfem.stages.inputs import published_values
from impactfem.stages.manifest import take_over
from impactfem.stages.reduce.stage import REDUCE, take_model
from impactfem.system import log
from impactfem.system.errors import ImpactfemError, InputError, file_errors
from impactfem.system.log import LOGGER, Steps, in_file_only, mirrored
from impactfem.system.parallel import alone, on_root, rank, start_solvers, workers, world
from impactfem.system.scalar import Scalar

VARIANTS = "variants"
LOG = "sweep.log"  # distinguishes the folder of a sweep from any other


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


@dataclass(frozen=True)
class Outcome:
    """Results of a variant, or why it failed; its number of warnings and its wall time [s]."""

    scalars: list[Scalar]
    error: str
    warnings: int
    seconds: float


def sweep(
    path: Path,
    settings: Settings,
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
    named, and the others run. Collective under `mpirun`: rank 0 hands the variants out, the other
    ranks run one each at a time.

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

    def prepare() -> tuple[Case, list[Axis], list[Variant]]:
        case = check(path)
        source = read_source(path, CaseFile)
        axes, faults = read_axes(settings, source, zipped=zipped)
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
        return case, axes, variants

    with ExitStack() as opened:
        opened.enter_context(file_errors())
        case, axes, variants = on_root(prepare)
        opened.enter_context(mirrored(folder / LOG, rank()))
        opened.enter_context(file_errors())  # within the log, which keeps what was refused
        outcomes = _outcomes(variants, folder, stage, processes)

        def write() -> Sweep:
            found = [(outcome.scalars, outcome.error) for outcome in outcomes]
            table = SweepTable.of(case.title, axes, variants, found, published_values(case), zipped)
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
    variants: list[Variant], folder: Path, stage: str | None, processes: int
) -> list[Outcome]:
    """The outcomes of the variants, in their order; none on the ranks that worked for rank 0."""
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
            ended(k, run_variant(variant, folder, stage))
        return list(found.values())
    start_solvers()
    with workers(min(processes, len(variants))) as executor:
        if executor is None:
            return []
        futures = {
            executor.submit(run_variant, variant, folder, stage, apart=True): k
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
    variant: Variant, folder: Path, stage: str | None, *, apart: bool = False
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
            log.set_up(verbose=False, rank=1)
            held.enter_context(alone())
        warnings = held.enter_context(in_file_only())
        try:
            with open_folder(target, resume=False), file_errors():
                case = check(path)
                others = sorted(other for other in target.parent.iterdir() if other != target)
                for one, of in works(asked_stages(case, stage), case):
                    label = one.label(of)
                    origin = take_over(target, others, label, one.key(of))
                    if origin is not None:
                        LOGGER.debug("stage %s: the same as in %s, copied", label, origin)
                    elif one is REDUCE:
                        origin = take_model(of, target, others)
                        if origin is not None:
                            LOGGER.debug(
                                "stage %s: the reduced building of %s copied", label, origin
                            )
            scalars = run(path, out=target, stage=stage, bar=not apart).scalars
        except ImpactfemError as error:
            failure = str(error)
        except Exception as error:
            # An error of the program or of a library in one variant: the others run all the same.
            LOGGER.debug("variant %s", variant.name, exc_info=True)
            failure = f"{type(error).__name__}: {error}"
    gc.collect()  # matrices of a variant go before those of the next one come
    return Outcome(scalars, failure, len(warnings), perf_counter() - start)
