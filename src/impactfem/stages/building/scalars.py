"""The scalar results of the stage `building`, by the names of `summary.json`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.building.bending import bending_modes
from impactfem.stages.building.compute import BuildingStudy
from impactfem.system.scalar import Scalar

SHOWN_BENDING = 3


def bending_direction(study: BuildingStudy) -> str:
    """Direction in which the bending modes of the summary move: that of the fit, else y."""
    fit = study.structure.calibration
    return fit.direction if fit is not None else "y"


def bending_of(study: BuildingStudy) -> NDArray[np.int64]:
    """Indices of the bending modes along that direction, in ascending frequency."""
    axis = "xy".index(bending_direction(study))
    return bending_modes(study.effective_mass[:, axis], float(study.total[axis]))


def building_scalars(study: BuildingStudy) -> list[Scalar]:
    """All scalars of the stage."""
    report = study.report
    direction = bending_direction(study)
    axis = "xy".index(direction)
    about = {"x": "e_y", "y": "e_x"}[direction]
    effective = study.effective_mass[:, axis]
    bending = bending_of(study)
    note = f"bending about {about}"
    scalars = [
        Scalar("building.elements", report.shells + report.beams, "-", "shells and beams"),
        Scalar("building.nodes", report.nodes, "-"),
        Scalar("building.dofs", 6 * report.nodes, "-", "clamped ones included"),
        Scalar("building.mass", float(study.total[0]), "kg", "with what belongs to the base"),
        Scalar("building.storey_stiffness_factor", study.factor, "-", "on walls and columns"),
    ]
    for number in range(SHOWN_BENDING):
        mode = int(bending[number]) if number < len(bending) else None
        which = note if mode is None else f"{note}, mode {mode + 1} of all"
        frequency = None if mode is None else float(study.frequency[mode])
        mass = None if mode is None else float(effective[mode])
        scalars += [
            Scalar(f"building.frequency.{number + 1}", frequency, "Hz", which),
            Scalar(f"building.effective_mass.{number + 1}", mass, "kg", which),
        ]
    for k, (mass, added) in enumerate(
        zip(study.masses.floors, study.masses.added, strict=True), start=1
    ):
        share = f"of it {added / 1e3:.0f} t added" if added else ""
        scalars.append(Scalar(f"building.floor_mass.{k}", float(mass), "kg", share))
    return scalars
