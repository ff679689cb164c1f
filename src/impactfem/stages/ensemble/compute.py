"""An ensemble of motions through the same sticks: bands of every scalar, fractiles of spectra."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from concurrent.futures import Executor, as_completed
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.case import Case, SyntheticMotion, motion_files
from impactfem.coupling.pounding import System
from impactfem.stages.pounding.compute import run_sticks
from impactfem.stages.pounding.scalars import stick_scalars
from impactfem.sticks.calibration import Calibration
from impactfem.system.errors import ImpactfemError, SolutionError
from impactfem.system.files import read_archive, write_archive
from impactfem.system.log import LOGGER

Array = NDArray[np.float64]
PERCENTILES = (5.0, 16.0, 50.0, 84.0, 95.0)
PARTS = ("psa", "psa_free", "pfa", "pfa_free")


@dataclass(frozen=True)
class Member:
    """One member of an ensemble.

    Args:
        name: Its seed or record, for messages and files.
        case: The case with its motions.
    """

    name: str
    case: Case


@dataclass(frozen=True)
class EnsembleResult:
    """What the members gave; those that failed are left out of all arrays.

    Args:
        members: Names of the members, n_m of them.
        failed: Name and reason of those that failed.
        names: Names of the scalars that every member has.
        units: Their units.
        scalars: Shape (n_m, n_scalars); nan where a member has none.
        psa: Floor spectra of the first building with contact, shape
            (n_m, n_dampings, n_stations, n_directions, n_frequencies) [m/s2].
        psa_free: The same without contact.
        pfa: Peak floor accelerations, shape (n_m, n_stations, n_directions) [m/s2].
        pfa_free: The same without contact.
        directions: Directions of the spectra.
        frequency: Frequencies, shape (n_frequencies,) [Hz].
        damping: Damping ratios, shape (n_dampings,).
    """

    members: tuple[str, ...]
    failed: dict[str, str]
    names: tuple[str, ...]
    units: tuple[str, ...]
    scalars: Array
    psa: Array
    psa_free: Array
    pfa: Array
    pfa_free: Array
    directions: tuple[str, ...]
    frequency: Array
    damping: Array

    def percentile(self, q: float) -> dict[str, float]:
        """The q-th percentile of each scalar over the members that have it, by name."""
        found = {}
        for name, column in zip(self.names, self.scalars.T, strict=True):
            known = column[np.isfinite(column)]
            if known.size:
                found[name] = float(np.percentile(known, q))
        return found


def members_of(case: Case) -> list[Member]:
    """The members that the case asks for.

    Synthetic motions: member i gets the seed first_seed + i; the motion number c of several
    components gets c × 1,000,000 added, so that components are never the same.
    """
    ensemble = case.ensemble
    if ensemble is None:
        return []
    if ensemble.records is not None:
        (motion,) = case.motions
        return [
            Member(
                file.name,
                case.model_copy(
                    update={"motions": (motion.model_copy(update={"file": file, "format": None}),)}
                ),
            )
            for file in ensemble.files()
        ]
    members = []
    for seed in range(ensemble.first_seed, ensemble.first_seed + (ensemble.motions or 0)):
        motions = tuple(
            motion.model_copy(update={"seed": seed + 1_000_000 * c})
            for c, motion in enumerate(case.motions)
            if isinstance(motion, SyntheticMotion)
        )
        members.append(Member(f"seed_{seed}", case.model_copy(update={"motions": motions})))
    return members


def run_ensemble(
    case: Case,
    ready: tuple[Calibration | None, System],
    folder: Path,
    key: str,
    executor: Executor,
    progress: Callable[[int, int], None],
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

    Raises:
        SolutionError: Fewer than two members gave a result.
        ImpactfemError: A file cannot be written.
    """
    members = members_of(case)
    folder.mkdir(parents=True, exist_ok=True)
    keys = {member.name: member_key(member, key) for member in members}
    files = {name: folder / f"{own}.npz" for name, own in keys.items()}
    found = {name: read_archive(files[name], own) for name, own in keys.items()}
    given = {name: arrays for name, arrays in found.items() if arrays is not None}
    waiting = [member for member in members if member.name not in given]
    failed: dict[str, str] = {}
    done = len(members) - len(waiting)
    progress(done, len(members))
    work = partial(run_member, ready)
    futures = {executor.submit(work, member): member for member in waiting}
    for future in as_completed(futures):
        name = futures[future].name
        try:
            given[name] = future.result()
            write_archive(files[name], keys[name], given[name])
        except ImpactfemError as error:
            failed[name] = str(error)
            LOGGER.warning("warning: ensemble member %s failed: %s", name, error)
        done += 1
        progress(done, len(members))
    return _gather([m.name for m in members if m.name not in failed], given, failed)


def run_member(ready: tuple[Calibration | None, System], member: Member) -> dict[str, Array]:
    """The results of one member: what `EnsembleResult` gathers, and names as arrays of text."""
    study = run_sticks(member.case, lambda _: nullcontext(), ready=ready, buildings=1)
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


def member_key(member: Member, key: str) -> str:
    """Hash of what the results of a member depend on.

    Args:
        member: The member.
        key: Hash of what all members depend on, besides their motions.
    """
    digest = hashlib.sha256(key.encode())
    for motion in member.case.motions:
        digest.update(motion.model_dump_json(exclude={"file"}).encode())
        for file in motion_files(motion):
            digest.update(file.read_bytes())
    return digest.hexdigest()[:24]


def _gather(
    names: list[str], given: dict[str, dict[str, Any]], failed: dict[str, str]
) -> EnsembleResult:
    if len(names) < 2:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in failed.items())
        raise SolutionError(f"fewer than two members of the ensemble gave a result: {reasons}")
    loaded = [given[name] for name in names]
    order = list(dict.fromkeys(str(n) for arrays in loaded for n in arrays["names"]))
    units = {str(n): str(u) for a in loaded for n, u in zip(a["names"], a["units"], strict=True)}
    table = np.full((len(loaded), len(order)), np.nan)
    for row, arrays in zip(table, loaded, strict=True):
        for name, value in zip(arrays["names"], arrays["scalars"], strict=True):
            row[order.index(str(name))] = value
    stacked = {part: np.stack([arrays[part] for arrays in loaded]) for part in PARTS}
    return EnsembleResult(
        members=tuple(names),
        failed=failed,
        names=tuple(order),
        units=tuple(units[name] for name in order),
        scalars=table,
        **stacked,
        directions=tuple(str(d) for d in loaded[0]["directions"]),
        frequency=loaded[0]["frequency"],
        damping=loaded[0]["damping"],
    )
