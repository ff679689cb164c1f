"""Targets of the sticks from the bending modes of the 3D model (paper, section 3.1)."""

from __future__ import annotations

from pathlib import Path

from impactfem.building.bending import bending_modes
from impactfem.case import Case
from impactfem.case.targets import Target
from impactfem.stages.stores import open_store
from impactfem.system.errors import SolutionError


def from_structure(case: Case) -> bool:
    """Whether the sticks of a case are calibrated on the modes of its 3D model."""
    return case.calibration is not None and case.calibration.from_structure


def with_structure_targets(case: Case, folder: Path) -> Case:
    """The case with the 3D model's modes in the place of the targets of its building.

    Args:
        case: The case.
        folder: The run's folder, with `building.nc` where the case asks for it.

    Raises:
        SolutionError: The 3D model has no such bending mode.
    """
    calibration, structure = case.calibration, case.structure
    if calibration is None or structure is None or not calibration.from_structure:
        return case
    with open_store(folder / "building.nc") as store:
        direction = calibration.direction
        masses = store["effective_mass"].sel(direction=direction).values
        modes = bending_modes(masses, float(store["total_mass"].sel(direction=direction)))
        frequency = store["frequency"].values

    def measured(target: Target) -> Target:
        if target.building != structure.building:
            return target
        if target.mode > len(modes):
            raise SolutionError(
                f"mode {target.mode} of {target.building} is a target, and the {len(frequency)} "
                f"modes of the 3D model hold {len(modes)} that bend along {direction}; "
                "ask for more in structure.modes"
            )
        mode = modes[target.mode - 1]
        return target.model_copy(
            update={
                "frequency": float(frequency[mode]),
                "effective_mass": float(masses[mode]),
            }
        )

    targets = tuple(measured(target) for target in calibration.targets)
    return case.model_copy(
        update={"calibration": calibration.model_copy(update={"targets": targets})}
    )
