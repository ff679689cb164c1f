"""The loop over the stages: checks the case, computes what may not be reused, writes it down."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import xarray as xr

from impactfem.case import Case, Published, SyntheticMotion
from impactfem.case.facing import facing_floors, facing_lines, unknown_lines
from impactfem.case.leaf import nearest
from impactfem.case.load import read_case
from impactfem.case.pair_distance import pair_distance
from impactfem.case.plausibility import implausible
from impactfem.report.run_files import CASE, CHECKS, PROVENANCE, SUMMARY
from impactfem.run.estimate import DAY, Estimate, duration
from impactfem.run.finished import (
    is_drawn,
    is_finished,
    mark_drawn,
    mark_finished,
    memory_of,
    seconds_of,
)
from impactfem.run.folder import LOG, check_same_case, log_case, open_folder
from impactfem.run.further_checks import further_checks, mesh_faults
from impactfem.run.report import write_findings, write_page
from impactfem.run.stages import RENAMED, REPORT, STAGES, asked_stages, check_stage_name
from impactfem.run.summary import write_summary
from impactfem.stages.building.stage import BUILDING
from impactfem.stages.check import Check, log_checks
from impactfem.stages.inputs import published_values
from impactfem.stages.manifest import file_digest, manifest_file
from impactfem.stages.pounding.checks import distance_check
from impactfem.stages.provenance import provenance
from impactfem.stages.stage import DRAWING, Stage
from impactfem.system.errors import Fault, InputError, file_errors
from impactfem.system.files import write_json
from impactfem.system.log import LOGGER, Steps, mirrored
from impactfem.system.memory import forget_peak, give_back, peak_memory
from impactfem.system.parallel import on_root, one_blas_thread, rank, size, total, world
from impactfem.system.scalar import Scalar, scalars_of


@dataclass
class Run:
    """What a run did.

    Args:
        folder: Its folder.
        scalars: All scalar results, in the order of the stages.
        published: Published values in SI by the name of the result.
        beside: The same with what the publication says of them and what ours are beside them.
        checks: The checks of each stage: whether it is met, and what it says.
        reused: Names of the stages whose stores were reused.
        times: Wall time of each step when it ran, by stage and step [s].
        memory: Largest resident memory of each stage when it ran [byte], None where not known.
    """

    folder: Path
    scalars: list[Scalar]
    published: dict[str, float]
    beside: dict[str, Published] = field(default_factory=dict)
    checks: dict[str, list[Check]] = field(default_factory=dict)
    reused: list[str] = field(default_factory=list)
    times: dict[str, float] = field(default_factory=dict)
    memory: dict[str, float | None] = field(default_factory=dict)


def check(path: Path, *, mesh: bool = False) -> Case:
    """Read a case file and everything it names; nothing is computed.

    Args:
        path: The case file.
        mesh: Whether the mesh of the case is read, or made, too, which takes some seconds, and
            warnings are given that a run gives itself: gaps beside axes and offsets, floors that
            face each other and are in no pair, and what is hardly meant.

    Raises:
        InputError: With every fault found; also where the run would not fit this machine.
        ImpactfemError: A file cannot be read.
    """
    return checked(path, mesh=mesh)[0]


def checked(path: Path, *, mesh: bool = False, stage: str | None = None) -> tuple[Case, Estimate]:
    """As `check`, for a run up to a stage, or of all; gives what the run will take, too."""
    with file_errors():
        case, faults, left_out = read_case(path)
        further = None
        if case is not None:
            stages = {one.name for one in asked_stages(case, stage)} if not faults else set()
            further = further_checks(case, left_out, stages, mesh=mesh)
            faults += further.faults
        if faults or case is None or further is None or further.estimate is None:
            raise InputError(faults)
        if mesh:
            _warn_of_gaps(case)
            _warn_of_facing_floors(case)
            _warn_of_implausible(case, further.estimate)
        if further.estimate.seconds > DAY:
            LOGGER.warning(
                "warning: a run of this case takes about %s: see the numbers of time steps, vectors"
                " and members",
                duration(further.estimate.seconds),
            )
        for one in STAGES:
            one.freeze()
    return case, further.estimate


def _warn_of_gaps(case: Case) -> None:
    pairs = case.contacts
    found = distance_check(
        [pair.name for pair in pairs],
        [pair.gap for pair in pairs],
        [pair_distance(pair, case) for pair in pairs],
    )
    log_checks(one for one in found if one[0] is False)


def _warn_of_facing_floors(case: Case) -> None:
    found = facing_floors(case)
    for line in facing_lines(found):
        LOGGER.warning("warning: %s: %s", case.path, line)
    for line in unknown_lines(found):
        LOGGER.info("%s: %s", case.path, line)


def _announce(case: Case, estimate: Estimate) -> None:
    for line in estimate.lines():
        LOGGER.debug("estimate: %s", line)
    _warn_of_implausible(case, estimate)


def _warn_of_implausible(case: Case, estimate: Estimate) -> None:
    for one in implausible(case, estimate.longest):
        LOGGER.warning("warning: %s", one)


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


def _seeds(case: Case) -> dict[str, int]:
    """The seeds of a case by their keys."""
    seeds = {
        f"motions[{k}].seed": motion.seed
        for k, motion in enumerate(case.motions)
        if isinstance(motion, SyntheticMotion)
    }
    if case.calibration is not None and case.calibration.mode == "fit":
        seeds["calibration.seed"] = case.calibration.seed
    if case.ensemble is not None and case.ensemble.records is None:
        seeds["ensemble.first_seed"] = case.ensemble.first_seed
    return seeds


def run(
    path: Path,
    *,
    out: Path | None = None,
    stage: str | None = None,
    resume: bool = False,
    fresh: bool = False,
    bar: bool = True,
) -> Run:
    """Run a case up to a stage and write its folder.

    A finished stage with the same inputs is reused; a changed input recomputes from there on.
    Collective under `mpirun`: every rank calls it with the same arguments.

    Args:
        path: The case file.
        out: The run's folder; ``runs/<name of the case file>`` when None.
        stage: The last stage to run; all stages when None.
        resume: Go on with the run in the folder; it must hold one, of the same case.
        fresh: Compute everything again.
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
        if world() is not None:
            # It starts on all ranks together: the checks of rank 0 may be the first to need it.
            import petsc4py.PETSc  # noqa: F401
        estimates: list[Estimate] = []

        def prepare() -> Case:
            check_stage_name(stage)
            if resume and fresh:
                expected = "expected without --fresh, which computes everything again"
                raise InputError([Fault("command line", "--resume", None, expected)])
            case, found = checked(path, stage=stage)
            estimates.append(found)
            opened.enter_context(open_folder(folder, resume))
            if resume:
                check_same_case(folder, case)
            for name in RENAMED:
                # Of an earlier version: its files are those of the stage with the new name now.
                manifest_file(folder, name).unlink(missing_ok=True)
            return case

        case = on_root(prepare)
        opened.enter_context(mirrored(folder / LOG, rank()))
        opened.enter_context(file_errors())  # within the log, which keeps what was refused
        result = Run(folder, [], published_values(case), dict(case.published))
        started = datetime.now(UTC).isoformat(timespec="seconds")
        LOGGER.info("%s -> %s", case.title, folder)
        log_case(case)
        on_root(lambda: _announce(case, estimates[0]))
        stages = asked_stages(case, stage)
        for one in stages:
            _run_stage(one, case, result, fresh, bar)
            if one.name == BUILDING.name and one.name not in result.reused:
                on_root(lambda: _check_mesh(case, folder))
        on_root(lambda: _write_results(case, result, stages, started))
        if stage in (None, REPORT):
            on_root(lambda: _warn_of_published(case, result.scalars))
            on_root(lambda: write_page(folder, bar=bar))
    return result


def _check_mesh(case: Case, folder: Path) -> None:
    """Refuse what the stages after `building` would refuse of its mesh, minutes later."""
    from impactfem.stages.building.compute import mesh_of_run

    faults = mesh_faults(case, mesh_of_run(case, folder))
    if faults:
        raise InputError(faults)


def _run_stage(stage: Stage, case: Case, result: Run, fresh: bool, bar: bool) -> None:
    folder = result.folder
    key = on_root(lambda: stage.key(case))
    reused = on_root(lambda: not fresh and is_finished(folder, stage.name, key))
    words = "finished before with the same inputs, reused" if reused else "starts"
    LOGGER.info("stage %s: %s", stage.name, words)
    on_root(lambda: stage.announces(case))
    if reused:
        result.reused.append(stage.name)
    else:
        _compute(stage, case, folder, key, bar)
    drawing = on_root(lambda: stage.drawing_key(case))
    if not on_root(lambda: reused and is_drawn(folder, stage.name, drawing)):
        if reused:
            LOGGER.info("stage %s: tables and figures are drawn again", stage.name)
        on_root(lambda: _draw(stage, case, folder, drawing, bar))

    def finish() -> tuple[list[Scalar], dict[str, float]]:
        checks = stage.checks(case, folder)
        log_checks(checks)
        result.checks[stage.name] = checks
        seconds = seconds_of(folder, stage.name)
        result.memory[stage.name] = memory_of(folder, stage.name)
        with xr.open_dataset(folder / stage.store, engine="h5netcdf") as store:
            scalars = scalars_of(store)
        return scalars + stage.derived(folder), seconds

    scalars, seconds = on_root(finish)
    result.scalars += scalars
    result.times |= seconds
    if not reused:
        LOGGER.info("stage %s: done in %.1f s", stage.name, sum(seconds.values()))


def _compute(stage: Stage, case: Case, folder: Path, key: str, bar: bool) -> None:
    give_back()  # what the stage before had
    forget_peak()
    names = {name: share for name, share in stage.steps.items() if name != DRAWING}
    with Steps(names, f"stage {stage.name}", quiet=rank() != 0, bar=bar) as steps:
        if stage.collective:
            files = stage.compute(case, folder, key, steps)
        else:
            files = on_root(lambda: stage.compute(case, folder, key, steps))
        times = {f"{stage.name}: {name}": round(t, 3) for name, t in steps.times.items()}
        memory = total(peak_memory())
        on_root(lambda: mark_finished(folder, stage.name, key, files, times, memory))


def _draw(stage: Stage, case: Case, folder: Path, key: str, bar: bool) -> None:
    with Steps({DRAWING: 1.0}, f"stage {stage.name}", bar=bar) as steps, steps.step(DRAWING):
        files = stage.draw(case, folder)
    mark_drawn(folder, stage.name, key, files, round(steps.times[DRAWING], 3))


def _write_results(case: Case, result: Run, stages: list[Stage], started: str) -> None:
    published = dict(case.published)
    published |= {f"ensemble.median.{name}": value for name, value in case.published.items()}
    write_findings(result.folder, case, result.checks)
    write_summary(result.folder / SUMMARY, result.scalars, published)
    write_json(
        result.folder / PROVENANCE,
        provenance(
            case=case.path.name,
            case_hash=case.content_hash(),
            inputs={one.name: one.key(case) for one in stages},
            seeds=_seeds(case),
            started=started,
            reused=result.reused,
            seconds=result.times,
            peak_memory=result.memory,
            ranks=size(),
            files={name: file_digest(result.folder / name) for name in (CASE, CHECKS, SUMMARY)},
        ),
    )
