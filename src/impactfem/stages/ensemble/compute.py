"""An ensemble of motions through the same sticks: bands of every scalar, fractiles of spectra."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from impactfem.case import Case, SyntheticMotion, motion_files
from impactfem.coupling.pounding import System
from impactfem.stages.pounding.compute import run_sticks
from impactfem.stages.pounding.store import stick_scalars
from impactfem.sticks.calibration import Calibration
from impactfem.system.arrays import Array
from impactfem.system.errors import ImpactfemError, SolutionError
from impactfem.system.files import read_archive, write_archive
from impactfem.system.log import LOGGER

if TYPE_CHECKING:
    from impactfem.reduction.models_3d import Models3D

PERCENTILES = (5.0, 16.0, 50.0, 84.0, 95.0)
_SPECTRUM = ("damping", "station", "direction", "frequency")
PARTS = {"psa": _SPECTRUM, "psa_free": _SPECTRUM, "pfa": _SPECTRUM[1:3], "pfa_free": _SPECTRUM[1:3]}
"""Arrays of a member by name, with their dimensions."""
ZERO_WITHOUT_IMPACT = (
    "pounding.main_impact_band_force",
    "pounding.main_impact_force",
    "pounding.main_impact_impulse",
)
"""Results that are 0 in a motion without an impact; time and duration of one it does not have."""


@dataclass(frozen=True, eq=False)
class EnsembleResult:
    """What the members gave, without those that failed."""

    scalars: pd.DataFrame  #: scalars by member and name; nan where a member has none
    units: dict[str, str]  #: units of the scalars by name
    failed: dict[str, str]  #: name and reason of those that failed
    #: Floor spectra of all buildings with contact, "psa", and without, "psa_free", shape (n_m,
    #: n_dampings, n_stations, n_directions, n_frequencies) [m/s2]; peak floor accelerations, "pfa"
    #: and "pfa_free", shape (n_m, n_stations, n_directions) [m/s2]; their "directions", of any
    #: member, "frequency" [Hz] and "damping".
    spectra: dict[str, Any]


def members_of(case: Case) -> dict[str, Case]:
    """The case with the motions of each member that it asks for, by their seeds or records.

    Synthetic motions: member i gets the seed first_seed + i; the motion number c of several
    components gets c × 1,000,000 added, so that components are never the same.
    """
    ensemble = case.ensemble
    if ensemble is None:
        return {}
    if ensemble.records is not None:
        found: dict[str, tuple[Any, ...]] = {
            one.file.name: (one,) for one in ensemble.of_records(case.motions)
        }
    else:
        first = ensemble.first_seed
        found = {
            f"seed_{seed}": tuple(
                motion.model_copy(update={"seed": seed + 1_000_000 * c})
                for c, motion in enumerate(case.motions)
                if isinstance(motion, SyntheticMotion)
            )
            for seed in range(first, first + (ensemble.motions or 0))
        }
    return {name: case.model_copy(update={"motions": m}) for name, m in found.items()}


def run_ensemble(
    case: Case,
    ready: tuple[Calibration | None, System],
    folder: Path,
    key: str,
    executor: Executor,
    progress: Callable[[int, int], None],
    models: Models3D | None = None,
) -> EnsembleResult:
    """Run the members that are not done yet, and gather all.

    Each member is kept in a file of its own, so that an interrupted ensemble goes on where it was
    and a larger one only adds members. A member that fails is named and left out.

    Args:
        case: The case.
        ready: Calibration and system, shared by all members.
        folder: Where the members' files are.
        key: Hash of what the members depend on, besides their motion.
        executor: Runs the members.
        progress: Called with the number of members done and of all.
        models: The 3D models that pound, shared as well; None where all buildings are sticks.

    Raises:
        SolutionError: Fewer than two members gave a result.
        ImpactfemError: A file cannot be written.
    """
    members = members_of(case)
    folder.mkdir(parents=True, exist_ok=True)
    keys = {name: member_key(member, key) for name, member in members.items()}
    files = {name: folder / f"{own}.npz" for name, own in keys.items()}
    found = {name: read_archive(files[name], own) for name, own in keys.items()}
    given = {name: arrays for name, arrays in found.items() if arrays is not None}
    waiting = {name: (member,) for name, member in members.items() if name not in given}
    before = len(given)
    progress(before, len(members))
    more, failed = worked_off(
        partial(run_member, ready, models=models),
        waiting,
        files,
        keys,
        executor,
        lambda done: progress(before + done, len(members)),
    )
    given |= more
    names = [name for name in members if name not in failed]
    if len(names) < 2:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in failed.items())
        raise SolutionError(f"fewer than two members of the ensemble gave a result: {reasons}")
    rows: list[dict[str, float]] = []
    units: dict[str, str] = {}
    for name in names:
        labels, of_each, values = (
            given[name][key].tolist() for key in ("names", "units", "scalars")
        )
        units |= dict(zip(labels, of_each, strict=True))
        rows.append(dict(zip(labels, values, strict=True)))
    spectra: dict[str, Any] = {axis: given[names[0]][axis] for axis in ("frequency", "damping")}
    for part, dims in PARTS.items():
        # A member that moves along fewer directions than another has zeros along the others.
        of_each = [
            xr.DataArray(given[name][part], {"direction": given[name]["directions"]}, dims)
            for name in names
        ]
        together = xr.concat(of_each, "motion", join="outer", fill_value=0.0)
        spectra[part], spectra["directions"] = together.values, together["direction"].values
    table = pd.DataFrame(rows, index=names, columns=list(units), dtype=float)
    # A motion without an impact has no time or duration of one, but these.
    if case.contacts:
        table = table.fillna(dict.fromkeys(ZERO_WITHOUT_IMPACT, 0.0))
    return EnsembleResult(table, units, failed, spectra)


def worked_off(
    work: Callable[..., dict[str, Any]],
    waiting: Mapping[str, tuple[Any, ...]],
    files: Mapping[str, Path],
    keys: Mapping[str, str],
    executor: Executor,
    progress: Callable[[int], None],
    where: str = "",
) -> tuple[dict[str, dict[str, Any]], dict[str, str]]:
    """Do the work of members with the arguments of each, and store each result when it is there.

    `files` and `keys` are where it is stored and the hash of what it depends on; `progress` is
    called with the number of members done. Gives the results by name, and the reason of those that
    failed. ImpactfemError where a file cannot be written.
    """
    futures = {executor.submit(work, *given): name for name, given in waiting.items()}
    found: dict[str, dict[str, Any]] = {}
    failed: dict[str, str] = {}
    for done, future in enumerate(as_completed(futures), 1):
        name = futures[future]
        try:
            found[name] = future.result()
        except ImpactfemError as error:
            failed[name] = str(error)
            LOGGER.warning("warning: ensemble member %s%s failed: %s", name, where, error)
        else:
            write_archive(files[name], keys[name], found[name])
        progress(done)
    return found, failed


def run_member(
    ready: tuple[Calibration | None, System], member: Case, models: Models3D | None = None
) -> dict[str, Array]:
    """The results of one member: what `EnsembleResult` gathers, and names as arrays of text."""
    study = run_sticks(member, ready=ready, models=models)
    scalars = [s for s in stick_scalars(study) if not s.name.startswith("sticks.")]
    return {
        "names": np.array([s.name for s in scalars]),
        "units": np.array([s.unit for s in scalars]),
        "scalars": np.array([np.nan if s.value is None else s.value for s in scalars]),
        "psa": study.floors.psa,
        "psa_free": study.floors_free.psa,
        "pfa": study.floors.pfa,
        "pfa_free": study.floors_free.pfa,
        "directions": np.array(study.floors.directions),
        "frequency": study.floors.spectra.frequency,
        "damping": study.floors.spectra.damping,
    }


def member_key(member: Case, key: str) -> str:
    """Hash of what a member depends on: its motions, and the key of what all members depend on."""
    digest = hashlib.sha256(key.encode())
    for motion in member.motions:
        digest.update(motion.model_dump_json(exclude={"file"}).encode())
        for file in motion_files(motion):
            digest.update(file.read_bytes())
    return digest.hexdigest()[:24]
