"""The loop over the stages: check the case, compute stages without results, write the run."""

import logging
import math
from collections.abc import Iterable, Mapping
from concurrent.futures import Executor, Future, wait
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from functools import partial
from itertools import takewhile
from pathlib import Path

from impactfem.case import Building3D, Case, Published, SyntheticMotion
from impactfem.case.base import nearest
from impactfem.report.console import console_lines
from impactfem.report.headlines import headlines
from impactfem.report.page import REPORT as PAGE
from impactfem.report.run_files import CASE, CHECKS, PROVENANCE, SUMMARY, VERDICTS, RunFiles
from impactfem.run.check import check_mesh, checked, warn_of_implausible
from impactfem.run.estimate import Estimate, side_by_side
from impactfem.run.folder import LOG, check_same_case, open_folder
from impactfem.run.report import remove_page, write_page
from impactfem.run.stages import OF_CASE, REPORT, STAGES, asked_stages, check_stage_name
from impactfem.stages.building.stage import BUILDING
from impactfem.stages.check import Check, log_checks
from impactfem.stages.manifest import (
    changed_file,
    digests,
    file_digest,
    is_finished,
    manifest_file,
    mark_finished,
    provenance,
    read_manifest,
    remove_drawings,
)
from impactfem.stages.stage import DRAWING, Stage, Subject, part_of
from impactfem.stages.stores import open_store, stores_kept_open
from impactfem.stages.verdict import Verdict, verdict_scalars
from impactfem.system.errors import Fault, InputError, file_errors
from impactfem.system.executor import workers
from impactfem.system.files import write_json
from impactfem.system.log import LOGGER, Steps, mirrored
from impactfem.system.memory import available_memory, forget_peak, give_back, peak_memory
from impactfem.system.parallel import (
    on_root,
    one_blas_thread,
    rank,
    size,
    start_solvers,
    threads,
    total,
    world,
)
from impactfem.system.scalar import Scalar, alone, of_building, scalars_of

LONG = 60.0
"""Estimated time [s] of a run, or of its 3D models, from which on a second process draws stages, or
computes sticks, at the same time: the process takes seconds to start."""


@dataclass
class Record:
    """The results of a run."""

    folder: Path
    scalars: list[Scalar]  #: all scalar results, in the order of the stages
    published: dict[str, Published]  #: published values by the name of the result
    #: The checks of each stage, by its label.
    checks: dict[str, list[Check]] = field(default_factory=dict)
    #: The verdicts of each stage, by its label.
    verdicts: dict[str, list[Verdict]] = field(default_factory=dict)
    #: Checks by the name of their stage that are known, and logged, before anything is computed.
    announced: dict[str, list[Check]] = field(default_factory=dict)
    #: Labels of the stages whose stores were reused.
    reused: list[str] = field(default_factory=list)
    #: Wall time of each step when it ran, by stage and step [s].
    times: dict[str, float] = field(default_factory=dict)
    #: Largest resident memory of each stage when it ran [byte], None where not known.
    memory: dict[str, float | None] = field(default_factory=dict)

    def console_lines(self) -> list[str]:
        """Return the lines with which a run ends, read from the folder of the run."""
        compared = sum(scalar.name in self.published for scalar in self.scalars)
        with stores_kept_open():
            return console_lines(RunFiles(self.folder), compared)


def _warn_of_published(case: Case, scalars: list[Scalar]) -> None:
    """Say which published values no result of a whole run has, or has in another unit."""
    units = {scalar.name: scalar.unit for scalar in scalars}
    for name, entry in case.published.items():
        # What a publication prints elsewhere: tables show it beside the result of that name.
        unit = units.get(name.removesuffix(".printed"))
        if unit is None:
            near = nearest(name, list(units))
            hint = f"; {near}" if near.startswith("did") else ""
            LOGGER.warning("warning: published value %s: no result of this run%s", name, hint)
        elif unit != entry.unit:
            text = "warning: published value %s: a unit of %s, and the result has %s"
            LOGGER.warning(text, name, entry.unit, unit)


def run(
    path: Path,
    *,
    out: Path | None = None,
    stage: str | None = None,
    resume: bool = False,
    fresh: bool = False,
    draw: bool = True,
    bar: bool = True,
) -> Record:
    """Run a case up to a stage and write its folder.

    A finished stage with the same inputs is reused; a changed input recomputes from there on.
    Collective under `mpirun`: every rank calls it with the same arguments.

    Args:
        path: The case file.
        out: The run's folder; ``runs/<name of the case file>`` when None.
        stage: The last stage to run; all stages when None. Others that had finished before with
            the same inputs stay in the record of the run.
        resume: Go on with the run in the folder; it must hold one, of the same case.
        fresh: Compute everything again.
        draw: Whether tables, figures and the page are made; else the next run that does makes them.
        bar: Whether a bar shows on a terminal how far the run is; lines do where there is none.

    Raises:
        InputError: The case is not usable, or the folder is not, as when another run works in it;
            nothing is written then.
        ImpactfemError: A computation or a file failed.
    """
    folder = out if out is not None else Path("runs") / path.stem
    with ExitStack() as opened:
        opened.enter_context(file_errors())
        opened.enter_context(one_blas_thread())
        start_solvers()  # the checks of rank 0 may be the first to need them

        def prepare() -> tuple[Case, Estimate]:
            check_stage_name(stage)
            if resume and fresh:
                expected = "expected without --fresh, which computes everything again"
                raise InputError([Fault("command line", "--resume", None, expected)])
            case, estimate = checked(path, stage=stage)
            opened.enter_context(open_folder(folder, resume))
            if resume:
                check_same_case(folder, case)
            return case, estimate

        case, estimate = on_root(prepare)
        opened.enter_context(mirrored(folder / LOG, rank()))
        opened.enter_context(file_errors())  # within the log, which keeps what was refused
        result = Record(folder, [], dict(case.published))
        started = datetime.now(UTC).isoformat(timespec="seconds")
        LOGGER.info("%s -> %s", case.title, folder)
        LOGGER.debug("case %s, hash %s", case.path.name, case.content_hash())  # as in CASE_LINE
        LOGGER.debug("%s", estimate.line)
        warn_of_implausible(case, estimate.longest)
        requested = asked_stages(case, stage)
        result.announced = {one.name: one.announces(case) for one in requested}
        for name, checks in result.announced.items():
            log_checks(name, checks)  # before the first stage takes its time
        second = None
        if estimate.seconds > LONG and world() is None and threads() > 1:
            second = opened.enter_context(workers(1, logs=True))
        context = _Context(case, estimate, result, requested, fresh, draw, bar, second)
        context.compute_ahead()
        done = [work for one in asked_stages(case, None) for work in context.run_stage(one)]
        context.wait_for_drawings()
        changed = on_root(lambda: _write_results(case, result, done, started))
        if stage in (None, REPORT):
            on_root(lambda: _warn_of_published(case, result.scalars))
        if draw and stage in (None, REPORT):
            on_root(lambda: write_page(folder, bar=bar))
        elif changed and on_root((folder / PAGE).is_file):
            LOGGER.info("removed outdated %s", PAGE)
            parts = [one.part for one in case.modelled.values() if one.part]
            on_root(lambda: remove_page(folder, parts))
    return result


@dataclass
class _Context:
    """A run at work: its case, its options, and what its second process does."""

    case: Case
    estimate: Estimate
    result: Record
    requested: list[Stage]  #: Others that finished before with the same inputs are kept.
    fresh: bool
    draw: bool
    bar: bool
    #: Process that computes what needs no 3D model and draws, while this one computes 3D models.
    second: Executor | None
    ahead: dict[str, Future[None]] = field(default_factory=dict)  #: by the label of the stage
    drawings: list[Future[dict[str, float]]] = field(default_factory=list)

    @property
    def folder(self) -> Path:
        """The folder of the run."""
        return self.result.folder

    def compute_ahead(self) -> None:
        """Start in the second process what needs no 3D model, while 3D models are computed.

        These are stages that take less time on one core than the 3D models before them, where
        there is memory for both.
        """
        ahead: list[Stage] = []
        for stage in self.requested:
            if stage in OF_CASE and set(stage.needs(self.case)) <= set(ahead):
                ahead.append(stage)
        if self.second is None or not (work := self._unfinished(ahead)):
            return
        before = self._unfinished(takewhile(lambda stage: stage not in ahead, self.requested))
        costs = {one.name: one for one in self.estimate.stages}
        own, rest = ([costs[label] for label in some if label in costs] for some in (work, before))
        time = sum(one.seconds for one in rest)
        memory = sum(max((one.memory for one in some), default=0.0) for some in (own, rest))
        if time >= max(LONG, threads() * sum(one.seconds for one in own)) and (
            memory <= available_memory()
        ):
            for label, (stage, subject, key) in work.items():
                self.ahead[label] = self.second.submit(
                    _compute_named, stage.name, subject, key, self.folder, quiet=True
                )

    def _unfinished(self, stages: Iterable[Stage]) -> dict[str, tuple[Stage, Subject, str]]:
        """Stages with their subjects and keys, by their labels, that are not finished."""
        every = [
            (one, subject, one.key(subject)) for one in stages for subject in one.of(self.case)
        ]
        return {
            stage.label(subject): (stage, subject, key)
            for stage, subject, key in every
            if self.fresh or not is_finished(self.folder, stage.label(subject), key)
        }

    def run_stage(self, stage: Stage) -> list[tuple[Stage, Subject]]:
        """Run a stage for the case, or for each building in its folder. Collective.

        A stage that was not requested is kept, without a message, where it and all that it needs
        are finished: the record of the run in the folder stays whole. Returns what the run has.
        """
        requested = stage in self.requested
        todo, kept = dict[str, tuple[Subject, str]](), list[Subject]()
        computed = set[str]()
        for subject in stage.of(self.case):
            label, key = stage.label(subject), on_root(partial(stage.key, subject))
            if label in self.ahead:
                if not self.ahead[label].done():
                    LOGGER.info("stage %s: still running in a second process", label)
                self.ahead[label].result()
                kept.append(subject)
                computed.add(label)
            elif on_root(partial(self._reusable, stage, subject, key, requested)):
                kept.append(subject)
                self.result.reused += [label] if requested else []
            elif requested:
                kept.append(subject)
                todo[label] = subject, key
        computed |= self._compute_side_by_side(stage, todo)
        for subject in kept:
            label = stage.label(subject)
            if label in todo and label not in computed:
                _compute(stage, *todo[label], self.folder, self.bar)
            reused = label not in todo and label not in computed
            self._finish_stage(stage, subject, requested, reused)
        return [(stage, subject) for subject in kept]

    def _reusable(self, stage: Stage, subject: Subject, key: str, requested: bool) -> bool:
        if requested:
            return not self.fresh and is_finished(self.folder, stage.label(subject), key)
        needed = {name for one in stage.needs(subject) for name in one.labels(subject)}
        known = needed <= set(self.result.checks)
        return known and is_finished(self.folder, stage.label(subject), key)

    def _compute_side_by_side(
        self, stage: Stage, todo: Mapping[str, tuple[Subject, str]]
    ) -> set[str]:
        """Compute buildings in parallel, if `side_by_side`; returns their labels. Collective."""
        if not side_by_side([one for one in self.estimate.stages if one.name in todo]):
            return set()
        with workers(min(len(todo), threads()), logs=True) as executor:
            futures = [
                executor.submit(_compute_named, stage.name, subject, key, self.folder)
                for subject, key in todo.values()
                if executor is not None  # it is None on other ranks alone
            ]
            wait(futures)  # what one building has is kept where another fails
            for future in futures:
                future.result()
        return set(todo)

    def _finish_stage(self, stage: Stage, subject: Subject, requested: bool, reused: bool) -> None:
        """Draw the results of a stage if needed, check and read them. Collective."""
        folder, label, result = self.folder, stage.label(subject), self.result
        own = folder / (part := part_of(subject))
        drawing = on_root(lambda: stage.drawing_key(subject))

        def finish() -> tuple[list[Scalar], dict[str, float]]:
            manifest = read_manifest(folder, label)
            whole = reused and changed_file(folder, manifest.drawings) is None
            if requested and self.draw and (not whole or manifest.drawn_from != drawing):
                self._draw(stage, subject, drawing, reused)
                manifest = read_manifest(folder, label)
            checks = result.checks[label] = stage.checks(subject, own)
            result.verdicts[label] = stage.verdicts(subject, own)
            if requested:
                announced = result.announced.get(stage.name, ())
                log_checks(label, (check for check in checks if check not in announced))
            result.memory[label] = manifest.peak_memory
            with open_store(own / stage.store) as store:
                every = scalars_of(store)
            scalars = [replace(one, name=of_building(one.name, part)) for one in every]
            return scalars, manifest.seconds

        with stores_kept_open():
            scalars, seconds = on_root(finish)
        result.scalars += scalars
        result.times |= seconds
        if requested and rank() == 0:
            _log_result(stage, subject, result, sum(seconds.values()))
        if not reused and stage is BUILDING and isinstance(subject, Building3D):
            on_root(lambda: _refuse_mesh(subject, own))

    def _draw(self, stage: Stage, subject: Subject, drawing: str, reused: bool) -> None:
        """Draw a stage: at once, or in the second process before `wait_for_drawings` returns."""
        if reused:
            LOGGER.info("stage %s: tables and figures are drawn again", stage.label(subject))
        if reused or self.second is None:
            _draw_named(stage.name, subject, self.folder, drawing, quiet=False, bar=self.bar)
        else:
            work = self.second.submit(_draw_named, stage.name, subject, self.folder, drawing)
            self.drawings.append(work)

    def wait_for_drawings(self) -> None:
        """Wait for the second process, and add the times of its drawings [s]."""
        for work in self.drawings:
            self.result.times |= work.result()


def _draw_named(
    name: str,
    subject: Subject,
    folder: Path,
    drawing: str,
    *,
    quiet: bool = True,
    bar: bool = False,
) -> dict[str, float]:
    """Draw the stage of this name and record it in its manifest. Not collective.

    Args:
        name: The stage, with its results in the folder.
        subject: The case, or one of its buildings.
        folder: The folder of the run.
        drawing: Key of the drawing.
        quiet: As of `Steps`.
        bar: As of `Steps`.

    Returns:
        The time [s] by its step.
    """
    stage = next(one for one in STAGES if one.name == name)
    label = stage.label(subject)
    with (
        file_errors(),
        stores_kept_open(),
        Steps({DRAWING: 1.0}, f"stage {label}", quiet=quiet, bar=bar) as steps,
        steps.step(DRAWING),
    ):
        pictures = stage.draw(subject, folder / part_of(subject))
    took = {f"{label}: {DRAWING}": round(steps.times[DRAWING], 3)}
    manifest = read_manifest(folder, label)
    drawings = digests(folder, pictures)
    for name in manifest.drawings.keys() - drawings.keys():  # no longer requested
        (folder / name).unlink(missing_ok=True)
    update: dict[str, object] = {"drawn_from": drawing, "drawings": drawings}
    update["seconds"] = manifest.seconds | took
    write_json(manifest_file(folder, label), manifest.model_copy(update=update).model_dump())
    return took


def _compute(
    stage: Stage, subject: Subject, key: str, folder: Path, bar: bool, quiet: bool = False
) -> None:
    """Compute a stage for the case or a building, and write its stores. Collective.

    `bar` and `quiet` are those of `Steps`.
    """
    label, own = stage.label(subject), folder / part_of(subject)
    LOGGER.log(logging.DEBUG if quiet else logging.INFO, "stage %s: starts", label)
    give_back()  # memory of the stage before
    forget_peak()
    on_root(lambda: own.mkdir(exist_ok=True))
    names = {name: share for name, share in stage.steps.items() if name != DRAWING}
    with Steps(names, f"stage {label}", quiet=quiet or rank() != 0, bar=bar) as steps:
        compute = partial(stage.compute, subject, own, key, steps)
        files = compute() if stage.collective else on_root(compute)
        times = {f"{label}: {name}": round(t, 3) for name, t in steps.times.items()}
        memory = total(peak_memory())
        on_root(lambda: remove_drawings(folder, label))  # they show the results before
        on_root(lambda: mark_finished(folder, label, key, files, times, memory))


def _compute_named(
    name: str, subject: Subject, key: str, folder: Path, quiet: bool = False
) -> None:
    """Compute the stage of this name in a worker, whose details name the stage."""
    stage = next(one for one in STAGES if one.name == name)

    def labelled(record: logging.LogRecord) -> bool:
        if record.levelno != logging.INFO:  # those begin with it
            record.msg = f"{stage.label(subject)}: {record.msg}"
        return True

    for handler in LOGGER.handlers:
        handler.addFilter(labelled)
    try:
        with file_errors(), one_blas_thread():
            _compute(stage, subject, key, folder, bar=False, quiet=quiet)
    finally:
        for handler in LOGGER.handlers:
            handler.removeFilter(labelled)


def _refuse_mesh(building: Building3D, own: Path) -> None:
    """Raise the errors of a mesh that later stages would find minutes later."""
    from impactfem.stages.building.compute import mesh_of_run

    faults: list[Fault] = []
    check_mesh(building, mesh_of_run(building, own), faults)
    if faults:
        raise InputError(faults)


def _log_result(stage: Stage, subject: Subject, result: Record, seconds: float) -> None:
    """Log one line of a finished stage: its time, its results, checks passed and failed."""
    label = stage.label(subject)
    words = ["reused" if label in result.reused else f"done in {seconds:.1f} s"]
    own = [
        asdict(one) | {"name": name}
        for one in result.scalars
        if (name := alone(one.name, part_of(subject)))
    ]
    words += headlines(stage, own)
    passed = [check.passed for check in result.checks[label]]
    if count := passed.count(True):
        words.append(f"{count} check{'s' if count > 1 else ''} passed")
    if count := passed.count(False):
        words.append(f"{count} failed, see above")
    LOGGER.info("stage %s: %s", label, ", ".join(words))


def _write_results(
    case: Case, result: Record, done: list[tuple[Stage, Subject]], started: str
) -> bool:
    """Write the case, the checks of all stages, the scalars, and their provenance.

    Returns whether the scalars differ from those before.
    """
    folder = result.folder
    before = (folder / SUMMARY).read_bytes() if (folder / SUMMARY).is_file() else b""
    write_json(folder / CASE, case.model_dump(mode="json", exclude={"path"}))
    rows = [check.row(stage) for stage, checks in result.checks.items() for check in checks]
    write_json(folder / CHECKS, rows)
    verdicts = result.verdicts.items()
    write_json(folder / VERDICTS, [one.row(stage) for stage, some in verdicts for one in some])
    result.scalars += verdict_scalars([one for _, some in verdicts for one in some])
    write_summary(folder / SUMMARY, result.scalars, case.published)
    seeds = {
        f"motions[{k}].seed": motion.seed
        for k, motion in enumerate(case.motions)
        if isinstance(motion, SyntheticMotion)
    }
    if case.calibration is not None and case.calibration.mode == "fit":
        seeds["calibration.seed"] = case.calibration.seed
    if case.ensemble is not None and case.ensemble.records is None:
        seeds["ensemble.first_seed"] = case.ensemble.first_seed
    made = provenance(
        case=case.path.name,
        case_hash=case.content_hash(),
        input_files=case.input_files,
        inputs={one.label(of): one.key(of) for one, of in done},
        needs={
            one.label(of): [label for needed in one.needs(of) for label in needed.labels(of)]
            for one, of in done
        },
        seeds=seeds,
        started=started,
        reused=result.reused,
        seconds=result.times,
        peak_memory=result.memory,
        ranks=size(),
        files={name: file_digest(folder / name) for name in (CASE, CHECKS, SUMMARY, VERDICTS)},
    )
    write_json(folder / PROVENANCE, made)
    return (folder / SUMMARY).read_bytes() != before


def write_summary(
    path: Path, scalars: Iterable[Scalar], published: Mapping[str, Published]
) -> None:
    """Write a list of results; `paper`, `relation` and `kind` are null without a published value.

    Values are in SI units, null where they do not exist. Details are listed only if they have a
    published value.
    """
    entries = []
    for scalar in scalars:
        if scalar.detail and scalar.name not in published:
            continue
        value, theirs = scalar.value, published.get(scalar.name)
        entries.append(
            {
                "name": scalar.name,
                "value": value if value is not None and math.isfinite(value) else None,
                "unit": scalar.unit,
                "paper": getattr(theirs, "value", None),
                "relation": getattr(theirs, "relation", None),
                "kind": getattr(theirs, "kind", None),
                "note": scalar.note,
            }
        )
    write_json(path, entries)
