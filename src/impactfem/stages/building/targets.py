"""Bending modes of the 3D model, and the targets of sticks that they give (paper, section 3.1)."""

from pathlib import Path

import numpy as np

from impactfem.case import Building3D, Case
from impactfem.stages.stores import open_store
from impactfem.sticks.condensed import ModelStick
from impactfem.sticks.element import Section
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import SolutionError

LEAST_SHARE = 0.01
"""Share of the total mass that a bending mode moves at least. Modes of single slabs, of which a
building has about ten in each hertz, move less."""
ECCENTRIC = 0.01
"""Distance of a centre of mass from the node of its floor, over the size of the plan, from which
on it is reported, and the stick has it."""
SHOWN_BENDING = 3
"""Bending modes among the results."""


def bending_modes(effective_mass: Array, total: float, least_share: float = LEAST_SHARE) -> Index:
    """Indices of the bending modes along a direction, in ascending frequency.

    A bending mode about e_x moves most of its mass along y. Where a slab's mode of nearly the same
    frequency shares the motion, both are returned if both move enough: at least a share of the
    total mass [kg] by their effective masses along the direction, shape (n_modes,) [kg].
    """
    return np.flatnonzero(effective_mass >= least_share * total)


STOREY = ("A", "Avx", "Avy", "Ix", "Iy")
"""Columns of a storey in the store: area, shear areas along x and y, second moments of area."""
LEAST_SHEAR = 1e-3
"""Shear area of a storey over its area, at least: walls along one direction alone have none."""


def from_structure(case: Case) -> bool:
    """Whether sticks of a case are made of, or calibrated on, its 3D models."""
    calibrated = case.calibration is not None and case.calibration.from_structure
    return calibrated or bool(case.sticks_on_models)


def with_structure_sticks(case: Case, run: Path) -> Case:
    """The case with what its sticks need of each `building.nc` of a run.

    Sticks of 3D models, and their modes in the place of the targets of a calibration.

    SolutionError where the 3D model has no such bending mode.
    """
    sticks = {
        name: _model_stick(building, run)
        for name, building in case.modelled.items()
        if name in case.sticks_on_models
    }
    if sticks:
        case = case.model_copy(update={"model_sticks": sticks})
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


def _model_stick(building: Building3D, run: Path) -> ModelStick:
    """Read the floors of a 3D model from its store."""
    material = building.structure.material
    with open_store(building.folder(run) / "building.nc") as store:
        E = float(store["storey_factor"]) * material.young_modulus
        G = E / (2.0 * (1.0 + material.poisson_ratio))
        rows = {name: store[f"floor_{name}"].values for name in STOREY}
        sections = []
        for A, x, y, Ix, Iy in zip(*rows.values(), strict=True):
            Avx, Avy = max(x, LEAST_SHEAR * A), max(y, LEAST_SHEAR * A)
            sections.append(Section(E, G, A=A, Avx=Avx, Avy=Avy, Ix=Ix, Iy=Iy, Iz=Ix + Iy))
        return ModelStick(
            K=store["stick_stiffness"].values,
            M=store["stick_mass"].values,
            mass=store["floor_mass"].values,
            inertia=np.array([store[f"floor_J{axis}"].values for axis in "xyz"]).T,
            sections=tuple(sections),
        )
