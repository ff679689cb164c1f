"""Bending modes of the 3D model, and the targets of sticks that they give (paper, section 3.1)."""

from pathlib import Path

import numpy as np

from impactfem.case import Case
from impactfem.stages.stores import open_store
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError

LEAST_SHARE = 0.01
"""Share of the total mass that a bending mode moves at least. Modes of single slabs, of which a
building has about ten in each hertz, move less."""
SHOWN_BENDING = 3
"""Bending modes among the results."""


def bending_modes(effective_mass: Array, total: float, least_share: float = LEAST_SHARE) -> Index:
    """Indices of the bending modes along a direction, in ascending frequency.

    A bending mode about e_x moves most of its mass along y. Where a slab's mode of nearly the same
    frequency shares the motion, both are returned if both move enough: at least a share of the
    total mass [kg] by their effective masses along the direction, shape (n_modes,) [kg].
    """
    return np.flatnonzero(effective_mass >= least_share * total)


def from_structure(case: Case) -> bool:
    """Whether the sticks of a case are calibrated on the modes of its 3D model."""
    return case.calibration is not None and case.calibration.from_structure


def with_structure_targets(case: Case, run: Path) -> Case:
    """The case with the modes of each `building.nc` of a run in the place of the targets.

    SolutionError where the 3D model has no such bending mode.
    """
    calibration = case.calibration
    if calibration is None or not calibration.from_structure:
        return case
    targets, direction = list(calibration.targets), calibration.direction
    for name, building in case.modelled.items():
        with open_store(building.folder(run) / "building.nc") as store:
            frequency = store["frequency"].values
            masses = store["effective_mass"].sel(direction=direction).values
            modes = bending_modes(masses, float(store["total_mass"].sel(direction=direction)))
        for k, target in enumerate(targets):
            if target.building != name:
                continue
            if target.mode > len(modes):
                raise SolutionError(
                    f"mode {target.mode} of {name} is a target, and the {len(frequency)} modes of "
                    f"the 3D model hold {len(modes)} that bend along {direction}; request more "
                    "modes in [buildings.structure]"
                )
            mode = modes[target.mode - 1]
            found = {"frequency": float(frequency[mode]), "effective_mass": float(masses[mode])}
            targets[k] = target.model_copy(update=found)
    fitted = calibration.model_copy(update={"targets": tuple(targets)})
    return case.model_copy(update={"calibration": fitted})
