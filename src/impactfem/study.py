"""The study: the stages in order, what each reads and writes, and what may be reused."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

import xarray as xr

import impactfem
from impactfem.case import Case, SyntheticMotion, load_case, motion_files
from impactfem.errors import Fault, InputError
from impactfem.files import write_json
from impactfem.log import LOGGER, Steps, mirrored
from impactfem.motion.from_case import checked_durations
from impactfem.parallel import on_root, rank, size, workers
from impactfem.results.checks import log_stick_checks
from impactfem.results.ensemble import ensemble_results, log_ensemble
from impactfem.results.figures import stick_figures
from impactfem.results.floor_products import write_floor_products
from impactfem.results.provenance import provenance
from impactfem.results.summary import write_summary
from impactfem.results.tables import stick_tables
from impactfem.scalar import Scalar, from_json
from impactfem.sticks.ensemble import run_ensemble
from impactfem.sticks.ensemble_store import write_ensemble
from impactfem.sticks.force_history import ForceHistory, write_forces, write_forces_csv
from impactfem.sticks.from_case import calibration_of, system_of
from impactfem.sticks.stage import STEPS, run_sticks
from impactfem.sticks.store import write_motion, write_sticks

LOG = "run.log"
STICK_ROOMS = ("motion", "spectra", "sticks")
STICK_INPUTS = (
    "materials",
    "damping",
    "buildings",
    "calibration",
    "motions",
    "contact_laws",
    "contacts",
    "pounding",
    "spectra",
)


@dataclass(frozen=True)
class Stage:
    """One stage of the study.

    Args:
        name: Its name on the command line.
        steps: Its steps and their share of its time.
        key: Hash of what it depends on.
        store: Its main file, with the scalars.
        run: Computes and writes; gives the files that it wrote, on rank 0.
        checks: Logs the checks of its results.
        lacks: The section of the case file without which the stage has nothing to do; None when
            nothing is missing.
        collective: Whether all ranks run it together; else rank 0 does.
    """

    name: str
    steps: dict[str, float]
    key: Callable[[Case], str]
    store: str
    run: Callable[[Case, Path, str, Steps], list[Path]]
    checks: Callable[[Case, Path], None]
    lacks: Callable[[Case], str | None] = lambda case: None
    collective: bool = False


@dataclass
class Run:
    """What a run did.

    Args:
        folder: Its folder.
        scalars: All scalar results, in the order of the stages.
        published: Published values in SI by the name of the result.
        reused: Names of the stages whose stores were reused.
        times: Wall time of each step when it ran, by stage and step [s].
    """

    folder: Path
    scalars: list[Scalar]
    published: dict[str, float]
    reused: list[str] = field(default_factory=list)
    times: dict[str, float] = field(default_factory=dict)


def check(path: Path) -> Case:
    """Read a case file and everything it names; nothing is computed.

    Raises:
        InputError: With every fault found.
    """
    case = load_case(path)
    durations = checked_durations(case.motions)
    longest = case.pounding.duration or max(durations)
    if case.pounding.time_step > longest / 2.0:
        expected = f"at most half of what is computed, {longest:g} s"
        raise InputError([Fault(path, "pounding.time_step", case.pounding.time_step, expected)])
    _program(STICK_ROOMS)
    return case


def run(
    path: Path,
    *,
    out: Path | None = None,
    stage: str | None = None,
    resume: bool = False,
    fresh: bool = False,
) -> Run:
    """Run a case up to a stage and write its folder.

    A finished stage with the same inputs is reused; a changed input recomputes from there on.
    Collective under `mpirun`: every rank calls it with the same arguments.

    Args:
        path: The case file.
        out: The run's folder; ``runs/<name of the case file>`` when None.
        stage: The last stage to run; all stages when None.
        resume: Go on with the run in the folder; it must hold one.
        fresh: Compute everything again.

    Raises:
        InputError: The case is not usable, or the folder is not; nothing is written then.
        ImpactfemError: A computation or a file failed.
    """
    folder = out if out is not None else Path("runs") / path.stem

    def prepare() -> Case:
        known = stage_names()
        if stage is not None and stage not in known:
            expected = f"one of the stages {', '.join(known)}"
            raise InputError([Fault("command line", "--stage", stage, expected)])
        case = check(path)
        _asked_stages(case, stage)
        _open_folder(folder, resume)
        return case

    case = on_root(prepare)
    with mirrored(folder / LOG, rank()):
        result = Run(folder, [], _published(case))
        started = datetime.now(UTC).isoformat(timespec="seconds")
        LOGGER.info("%s -> %s", case.title, folder)
        stages = _asked_stages(case, stage)
        for one in stages:
            _run_stage(one, case, result, fresh)
        on_root(lambda: _write_results(case, result, stages, started))
    return result


def stage_names() -> list[str]:
    """Names of the stages in order."""
    return [stage.name for stage in STAGES]


def _asked_stages(case: Case, last: str | None) -> list[Stage]:
    """The stages up to the last one asked for that the case has the input for."""
    stages = STAGES if last is None else STAGES[: stage_names().index(last) + 1]
    missing = stages[-1].lacks(case)
    if last is not None and missing is not None:
        expected = f"a section [{missing}], which the stage {last} needs"
        raise InputError([Fault(case.path, missing, None, expected)])
    return [one for one in stages if one.lacks(case) is None]


def _write_results(case: Case, result: Run, stages: list[Stage], started: str) -> None:
    published = dict(result.published)
    published |= {f"ensemble.median.{name}": v for name, v in result.published.items()}
    write_summary(result.folder / "summary.json", result.scalars, published)
    write_json(
        result.folder / "provenance.json",
        provenance(
            case=case.path.name,
            case_hash=case.content_hash(),
            inputs={one.name: one.key(case) for one in stages},
            seeds=[m.seed for m in case.motions if isinstance(m, SyntheticMotion)],
            started=started,
            reused=result.reused,
            seconds=result.times,
            ranks=size(),
        ),
    )


def _run_stage(stage: Stage, case: Case, result: Run, fresh: bool) -> None:
    folder = result.folder
    key = on_root(lambda: stage.key(case))
    if on_root(lambda: not fresh and _finished(folder, stage, key)):
        LOGGER.info("stage %s: finished before with the same inputs, reused", stage.name)
        result.reused.append(stage.name)
    else:
        with Steps(stage.steps, quiet=rank() != 0) as steps:
            if stage.collective:
                files = stage.run(case, folder, key, steps)
            else:
                files = on_root(lambda: stage.run(case, folder, key, steps))
            times = {f"{stage.name}: {name}": round(t, 3) for name, t in steps.times.items()}
            on_root(lambda: _finish(folder, stage, key, files, times))
        LOGGER.info("stage %s: done in %.1f s", stage.name, sum(steps.times.values()))

    def finish() -> tuple[list[Scalar], dict[str, float]]:
        stage.checks(case, folder)
        manifest = json.loads((folder / _manifest(stage)).read_text(encoding="utf-8"))
        with xr.open_dataset(folder / stage.store, engine="h5netcdf") as store:
            return from_json(store.attrs["scalars"]), manifest["seconds"]

    scalars, seconds = on_root(finish)
    result.scalars += scalars
    result.times |= seconds


def _finished(folder: Path, stage: Stage, key: str) -> bool:
    """Whether all files of a stage are there, whole, and made from the same inputs."""
    try:
        manifest = json.loads((folder / _manifest(stage)).read_text(encoding="utf-8"))
        same = manifest["inputs"] == key
        listed = dict(manifest["files"])
    except FileNotFoundError:
        return False
    except (OSError, ValueError, KeyError, TypeError) as error:
        LOGGER.warning("%s cannot be read (%s); computed again", folder / _manifest(stage), error)
        return False
    if not same:
        return False
    for name, digest in listed.items():
        path = folder / name
        if not path.is_file() or _file_digest(path) != digest:
            LOGGER.warning("%s is missing or was changed; computed again", path)
            return False
    return True


def _finish(
    folder: Path, stage: Stage, key: str, files: list[Path], seconds: dict[str, float]
) -> None:
    """Write down what a stage wrote, last of all: without it the stage is not finished."""
    listed = {str(path.relative_to(folder)): _file_digest(path) for path in sorted(files)}
    write_json(folder / _manifest(stage), {"inputs": key, "seconds": seconds, "files": listed})


def _manifest(stage: Stage) -> str:
    return f"{stage.name}.stage.json"


def _file_digest(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _open_folder(folder: Path, resume: bool) -> None:
    """Make the folder, or see that it may be used."""
    try:
        if resume and not (folder / LOG).is_file():
            raise InputError([Fault(folder, "--resume", None, "a folder that holds a run")])
        if folder.exists() and not folder.is_dir():
            raise InputError([Fault(folder, "--out", None, "a folder, this is a file")])
        if folder.is_dir() and any(folder.iterdir()) and not (folder / LOG).is_file():
            expected = "an empty folder or one of an earlier run; this one holds other files"
            raise InputError([Fault(folder, "--out", None, expected)])
        folder.mkdir(parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK):
            raise PermissionError(13, os.strerror(13))
        (folder / LOG).touch()
    except OSError as error:
        expected = f"a folder that can be written: {error.strerror or error}"
        raise InputError([Fault(folder, "--out", None, expected)]) from error


def _key(case: Case, sections: tuple[str, ...], rooms: tuple[str, ...]) -> str:
    """Hash of the program's version and rooms, of sections of the case, and of its records."""
    digest = hashlib.sha256(_program(rooms).encode())
    # What is in a record counts, not where it lies.
    nowhere = {"motions": {"__all__": {"file"}}}
    digest.update(case.model_dump_json(include=set(sections), exclude=nowhere).encode())
    if "motions" in sections:
        for motion in case.motions:
            for file in motion_files(motion):
                digest.update(file.read_bytes())
    return digest.hexdigest()


@cache
def _program(rooms: tuple[str, ...]) -> str:
    """Hash of the program's version and of the rooms' sources, as they were when first asked.

    A changed program may change the result: it counts as an input.
    """
    digest = hashlib.sha256(impactfem.__version__.encode())
    for room in rooms:
        for source in sorted((Path(impactfem.__file__).parent / room).glob("*.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()


def _run_sticks(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    study = run_sticks(case, steps.step)
    files = [folder / name for name in ("motion.nc", "forces.nc", "forces.csv", "sticks.nc")]
    with steps.step("stores"):
        write_motion(files[0], study, key)
        response = study.response
        write_forces(files[1], response, case.content_hash(), key)
        names = tuple(pair.name for pair in response.system.pairs)
        write_forces_csv(files[2], ForceHistory(response.time, names, response.force))
        write_sticks(files[3], study, key)
    with steps.step("tables and figures"):
        files += stick_tables(folder)
        files += stick_figures(folder)
        files += write_floor_products(
            folder,
            folder / "sticks.nc",
            broadening=case.spectra.broadening,
            clipping=case.spectra.clipping,
        )
    return files


def _ensemble_key(case: Case) -> str:
    digest = hashlib.sha256(_key(case, (*STICK_INPUTS, "ensemble"), STICK_ROOMS).encode())
    for file in case.ensemble.files() if case.ensemble is not None else ():
        digest.update(file.read_bytes())
    return digest.hexdigest()


def _run_ensemble(case: Case, folder: Path, key: str, steps: Steps) -> list[Path]:
    with steps.step("sticks"):
        calibration = on_root(lambda: calibration_of(case))
        ready = (calibration, system_of(case, calibration))
    sections = tuple(section for section in STICK_INPUTS if section != "motions")
    members_key = on_root(lambda: _key(case, sections, STICK_ROOMS))
    with workers() as executor:
        if executor is None:
            return []  # this rank has worked for rank 0 until now
        with steps.step("members"):
            result = run_ensemble(
                case,
                ready,
                folder / "ensemble" / "members",
                members_key,
                executor,
                lambda done, of: steps.within("members", done / of),
            )
    with steps.step("stores and figures"):
        write_ensemble(folder / "ensemble.nc", case, result, key)
        return [
            folder / "ensemble.nc",
            *ensemble_results(folder, _published(case)),
            *write_floor_products(
                folder / "ensemble",
                folder / "ensemble.nc",
                broadening=case.spectra.broadening,
                clipping=case.spectra.clipping,
                statistic="mean",
            ),
        ]


def _published(case: Case) -> dict[str, float]:
    return {name: entry.value for name, entry in case.published.items()}


STAGES: tuple[Stage, ...] = (
    Stage(
        name="sticks",
        steps={**STEPS, "stores": 2.0, "tables and figures": 4.0},
        key=lambda case: _key(case, STICK_INPUTS, STICK_ROOMS),
        store="sticks.nc",
        run=_run_sticks,
        checks=lambda case, folder: log_stick_checks(folder, case.pounding.points_per_impact),
    ),
    Stage(
        name="ensemble",
        steps={"sticks": 2.0, "members": 40.0, "stores and figures": 2.0},
        key=_ensemble_key,
        store="ensemble.nc",
        run=_run_ensemble,
        checks=lambda case, folder: log_ensemble(folder, _published(case)),
        lacks=lambda case: "ensemble" if case.ensemble is None else None,
        collective=True,
    ),
)
