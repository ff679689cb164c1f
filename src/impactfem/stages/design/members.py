"""All members of an ensemble through the 3D building, each kept in a file of its own."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor, as_completed
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impactfem.stages.design.member import Carrier, carry
from impactfem.stages.design.member_loads import MemberLoads
from impactfem.system.errors import ImpactfemError, SolutionError
from impactfem.system.files import read_archive, write_archive
from impactfem.system.log import LOGGER

Array = NDArray[np.float64]
Arrays = dict[str, Any]

RESULTS = (
    *("psa", "pfa", "floor_psa", "floor_pfa", "vertices", "impact_force"),
    *("device_force", "device_spectrum", "basis_error"),
)


def stored_members(files: Mapping[str, Path], keys: Mapping[str, str]) -> dict[str, Arrays]:
    """The members that are done, by name.

    Args:
        files: Where each member is kept, by name.
        keys: Hash of what it depends on.
    """
    found = {name: read_archive(path, keys[name]) for name, path in files.items()}
    return {name: arrays for name, arrays in found.items() if arrays is not None}


def carry_members(
    carrier: Carrier,
    waiting: Mapping[str, MemberLoads],
    files: Mapping[str, Path],
    keys: Mapping[str, str],
    executor: Executor,
    progress: Callable[[int], None],
) -> tuple[dict[str, Arrays], dict[str, str]]:
    """Carry members through the 3D building, and keep each as soon as it is done.

    Args:
        carrier: What they share.
        waiting: Their loads, by name.
        files: Where each is kept.
        keys: Hash of what it depends on.
        executor: Runs them.
        progress: Called with the number of members done.

    Returns:
        The results by name, and the reason of those that failed.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    futures = {executor.submit(partial(carry, carrier), waiting[name]): name for name in waiting}
    found: dict[str, Arrays] = {}
    failed: dict[str, str] = {}
    for done, future in enumerate(as_completed(futures), 1):
        name = futures[future]
        try:
            found[name] = future.result()
        except ImpactfemError as error:
            failed[name] = str(error)
            LOGGER.warning("warning: ensemble member %s in 3D failed: %s", name, error)
        else:
            write_archive(files[name], keys[name], found[name])
        progress(done)
    return found, failed


def stacked(names: list[str], found: Mapping[str, Arrays], failed: Mapping[str, str]) -> Arrays:
    """The results of all members, each array with the members first.

    Args:
        names: Names of those that gave a result, in their order.
        found: Their results.
        failed: Name and reason of the others.

    Raises:
        SolutionError: There are fewer than two.
    """
    if len(names) < 2:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in failed.items())
        raise SolutionError(
            f"fewer than two members of the ensemble went through the 3D model: {reasons}"
        )
    return {part: np.stack([found[name][part] for name in names]) for part in RESULTS}
