"""What the stage `device` needs beside the matrices: devices, where they stand, and loads."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from impactfem.building.from_case import read_parts
from impactfem.building.links import BasePlate, find_base_plates
from impactfem.building.parts import BuildingParts
from impactfem.case import Case, DeviceAnalysis
from impactfem.coupling.force_history import ForceHistory, read_forces
from impactfem.device.device import Device
from impactfem.device.from_case import checked_devices
from impactfem.dynamics.damping import Rayleigh
from impactfem.motion.from_case import GroundMotion, ground_motions
from impactfem.reduction.covered_points import CoveredPoints, covered_points
from impactfem.reduction.loads import Loads
from impactfem.stages.device.spectrum_plan import SpectrumPlan, plan_of
from impactfem.stages.transient.prepared import case_loads, transient_of


@dataclass(frozen=True, eq=False)
class Prepared:
    """What a run needs beside the matrices.

    Args:
        parts: The building.
        storey_factor: Factor on walls and columns.
        devices: The devices.
        base_plates: Where they are anchored, one for each anchor of each.
        points: Further points, which envelopes of spectra cover.
        plans: Response spectrum analyses of each.
        own: Damping of the building, α [1/s] and β [s].
        forces: Impact forces with the building's own damping.
        loads: They and the ground motion, at the step of the 3D model.
        motions: The ground motions.
        calibrated_laws: Contact laws that left their restitution to the impact on the wall; empty
            where none did.
        restitution: What that gave by damping case; empty where there is none.
    """

    parts: BuildingParts
    storey_factor: float
    devices: tuple[Device, ...]
    base_plates: tuple[BasePlate, ...]
    points: CoveredPoints
    plans: tuple[SpectrumPlan, ...]
    own: Rayleigh
    forces: ForceHistory
    loads: Loads
    motions: tuple[GroundMotion, ...]
    calibrated_laws: frozenset[str] = frozenset()
    restitution: Mapping[str, float] = field(default_factory=dict)


def prepare(
    case: Case,
    mesh_file: Path,
    forces_file: Path,
    storey_factor: float,
    calibrated_laws: frozenset[str] = frozenset(),
    restitution: Mapping[str, float] | None = None,
) -> Prepared:
    """Read mesh, motions and forces, and build the devices. Not collective.

    Args:
        case: The case; it has a structure, a transient part and devices.
        mesh_file: The mesh of the building.
        forces_file: The impact forces of the sticks, where the case names none of its own.
        storey_factor: Factor on walls and columns.
        calibrated_laws: Contact laws that left their restitution to the impact on the wall.
        restitution: What that gave by damping case.

    Raises:
        InputError: The mesh, the forces or a device are not usable.
        SolutionError: An anchor stands on no node of a floor.
    """
    structure, transient, analysis = case.structure, transient_of(case), analysis_of(case)
    if structure is None:
        raise ValueError("the case has no structure")
    parts, _, _ = read_parts(case, mesh_file)
    path = transient.forces or forces_file
    forces = read_forces(path)
    motions = tuple(ground_motions(case.motions))
    devices = tuple(checked_devices(case))
    return Prepared(
        parts=parts,
        storey_factor=storey_factor,
        devices=devices,
        base_plates=find_base_plates(case, parts.mesh),
        points=covered_points(case, parts.mesh),
        plans=tuple(
            plan_of(device, setup, analysis)
            for device, setup in zip(devices, case.devices, strict=True)
        ),
        own=case.building(structure.building).damping.rayleigh,
        forces=forces,
        loads=case_loads(
            case, parts.mesh, motions, forces, path, transient.duration or float(forces.time[-1])
        ),
        motions=motions,
        calibrated_laws=calibrated_laws,
        restitution=restitution or {},
    )


def analysis_of(case: Case) -> DeviceAnalysis:
    """How the devices of a case that has some are analysed."""
    if case.device_analysis is None:
        raise ValueError("the case has no devices")
    return case.device_analysis


def substeps_of(case: Case) -> int:
    """Steps of the detailed analysis in one of the loads."""
    whole = transient_of(case).time_step
    return max(1, math.ceil(whole / (analysis_of(case).time_step or whole) * (1.0 - 1e-9)))
