"""The study: the stages in order, what each reads and writes, and what may be reused."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import xarray as xr

import impactfem
from impactfem.case import Case, RecordMotion, load_case
from impactfem.errors import Fault, InputError
from impactfem.files import write_json
from impactfem.log import LOGGER, Steps, mirrored
from impactfem.motion.from_case import check_records
from impactfem.results.checks import log_stick_checks
from impactfem.results.figures import stick_figures
from impactfem.results.provenance import provenance
from impactfem.results.summary import write_summary
from impactfem.results.tables import stick_tables
from impactfem.scalar import Scalar, from_json
from impactfem.sticks.force_history import ForceHistory, write_forces, write_forces_csv
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
        files: What it writes, relative to the run's folder; each carries the key as the attribute
            `inputs`, and the first one the scalars.
        run: Computes and writes.
        checks: Logs the checks of its results.
    """

    name: str
    steps: dict[str, float]
    key: Callable[[Case], str]
    files: tuple[str, ...]
    run: Callable[[Case, Path, str, Steps], None]
    checks: Callable[[Case, Path], None]


@dataclass
class Run:
    """What a run did.

    Args:
        folder: Its folder.
        scalars: All scalar results, in the order of the stages.
        published: Published values in SI by the name of the result.
        reused: Names of the stages whose stores were reused.
        times: Wall time of each step that ran [s].
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
    check_records(case.motions)
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
    stages = STAGES
    if stage is not None:
        names = [known.name for known in STAGES]
        if stage not in names:
            expected = f"one of the stages {', '.join(names)}"
            raise InputError([Fault("command line", "--stage", stage, expected)])
        stages = STAGES[: names.index(stage) + 1]
    case = check(path)
    folder = out if out is not None else Path("runs") / path.stem
    _open_folder(folder, resume)
    with mirrored(folder / LOG):
        published = {name: entry.value for name, entry in case.published.items()}
        result = Run(folder, [], published)
        started = datetime.now(UTC).isoformat(timespec="seconds")
        LOGGER.info("%s -> %s", case.title, folder)
        for one in stages:
            _run_stage(one, case, result, fresh)
        write_summary(folder / "summary.json", result.scalars, published)
        write_json(
            folder / "provenance.json",
            provenance(
                case=path.name,
                case_hash=case.content_hash(),
                inputs={one.name: one.key(case) for one in stages},
                seeds=[m.seed for m in case.motions if hasattr(m, "seed")],
                started=started,
                reused=result.reused,
                seconds={name: round(value, 3) for name, value in result.times.items()},
                ranks=1,
            ),
        )
    return result


def _run_stage(stage: Stage, case: Case, result: Run, fresh: bool) -> None:
    key = stage.key(case)
    if not fresh and _finished(result.folder, stage, key):
        LOGGER.info("stage %s: finished before with the same inputs, reused", stage.name)
        result.reused.append(stage.name)
    else:
        with Steps(stage.steps) as steps:
            stage.run(case, result.folder, key, steps)
        result.times |= steps.times
        seconds = sum(steps.times.values())
        LOGGER.info("stage %s: done in %.1f s", stage.name, seconds)
    stage.checks(case, result.folder)
    with xr.open_dataset(result.folder / stage.files[0], engine="h5netcdf") as store:
        result.scalars += from_json(store.attrs["scalars"])


def _finished(folder: Path, stage: Stage, key: str) -> bool:
    """Whether all files of a stage are there, whole, and made from the same inputs."""
    for name in stage.files:
        path = folder / name
        if not path.exists():
            return False
        if path.suffix != ".nc":
            continue
        try:
            with xr.open_dataset(path, engine="h5netcdf") as store:
                if store.attrs.get("inputs") != key:
                    return False
        except (OSError, ValueError) as error:
            LOGGER.warning("%s cannot be read (%s); computed again", path, error)
            return False
    return True


def _open_folder(folder: Path, resume: bool) -> None:
    """Make the folder, or see that it may be used."""
    if resume and not (folder / LOG).is_file():
        raise InputError([Fault(folder, "--resume", None, "a folder that holds a run")])
    if folder.exists() and not folder.is_dir():
        raise InputError([Fault(folder, "--out", None, "a folder, this is a file")])
    try:
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


def _stick_key(case: Case) -> str:
    digest = hashlib.sha256(impactfem.__version__.encode())
    for room in STICK_ROOMS:
        # A changed program may change the result: it counts as an input.
        for source in sorted((Path(impactfem.__file__).parent / room).glob("*.py")):
            digest.update(source.read_bytes())
    digest.update(case.model_dump_json(include=set(STICK_INPUTS)).encode())
    for motion in case.motions:
        if isinstance(motion, RecordMotion):
            digest.update(motion.file.read_bytes())
    return digest.hexdigest()


def _run_sticks(case: Case, folder: Path, key: str, steps: Steps) -> None:
    study = run_sticks(case, steps.step)
    with steps.step("stores"):
        write_motion(folder / "motion.nc", study, key)
        response = study.response
        write_forces(folder / "forces.nc", response, case.content_hash(), key)
        names = tuple(pair.name for pair in response.system.pairs)
        write_forces_csv(folder / "forces.csv", ForceHistory(response.time, names, response.force))
        write_sticks(folder / "sticks.nc", study, key)
    with steps.step("tables and figures"):
        stick_tables(folder)
        stick_figures(folder)


STAGES: tuple[Stage, ...] = (
    Stage(
        name="sticks",
        steps={**STEPS, "stores": 2.0, "tables and figures": 4.0},
        key=_stick_key,
        files=("sticks.nc", "motion.nc", "forces.nc", "forces.csv"),
        run=_run_sticks,
        checks=lambda case, folder: log_stick_checks(folder, case.pounding.points_per_impact),
    ),
)
