"""Results of the stage `building`: mesh, masses and modes of the 3D model."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.building.mesh_report import MeshReport
from impactfem.building.parts import BuildingParts, FloorMasses
from impactfem.case.buildings import Structure
from impactfem.stages.building.targets import bending_modes
from impactfem.sticks.condensed import CondensedStick
from impactfem.system.arrays import Array, Index
from impactfem.system.quantity import quantity, results, si

_ABOUT = "rotations about the middle of the base"


@results
class BuildingStudy:
    """Mesh, masses and modes of a 3D model; rank 0 has the shapes at all nodes."""

    structure: Structure  #: section `structure` of the case
    parts: BuildingParts  #: mesh, sections and material
    masses: FloorMasses  #: masses of the floors
    report: MeshReport  #: report of the mesh
    factor: float = si(
        "-", "storey stiffness factor, on walls and columns, given or fitted", name="storey_factor"
    )
    frequency: Array = si("Hz", "frequency", dims="mode")
    #: Displacements of all nodes in each mode with φᵀ M φ = 1, shape (n_modes, n_nodes, 3); without
    #: nodes on other ranks than 0.
    shapes: NDArray[np.float32] = si(
        "1/sqrt(kg)", "displacement, with unit modal mass", dims="mode node xyz", name="shape"
    )
    #: Γ = φᵀ M r for the six rigid-body motions r about the middle of the base.
    participation: Array = si("sqrt(kg)", f"participation factor, {_ABOUT}", dims="mode direction")
    #: rᵀ M r of the same motions, shape (6,).
    total: Array = si(
        "kg, kg m2", f"mass, base included, {_ABOUT}", dims="direction", name="total_mass"
    )
    residual: Array = si("-", "relative residual of the mode", dims="mode")
    stick: CondensedStick | None = None  #: stick of the building, where it is made of the 3D model

    @property
    @quantity("kg, kg m2", f"effective mass, {_ABOUT}", dims="mode direction")
    def effective_mass(self) -> Array:
        """Γ², shape (n_modes, 6)."""
        return self.participation**2

    @property
    @quantity("", "number of shells and beams")
    def elements(self) -> int:
        """Number of shells and beams."""
        return self.report.shells + self.report.beams

    @property
    @quantity("", "number of nodes")
    def nodes(self) -> int:
        """Number of nodes."""
        return self.report.nodes

    @property
    @quantity("", "number of degrees of freedom, clamped ones included")
    def dofs(self) -> int:
        """Number of degrees of freedom."""
        return 6 * self.report.nodes

    @property
    def bending_direction(self) -> str:
        """Direction of the bending modes: that of the fit, else the one of pounding.

        Buildings pound across the edges that face other buildings; y without such an edge.
        """
        if self.structure.calibration is not None:
            return self.structure.calibration.direction
        mesh = self.parts.mesh
        across = [1 - mesh.edge_axis(floor) for floor, lines in mesh.edges.items() if lines.size]
        return "xy"[across[-1]] if across else "y"

    @property
    def bending(self) -> Index:
        """Indices of the bending modes along this direction, in ascending frequency."""
        axis = "xy".index(self.bending_direction)
        return bending_modes(self.effective_mass[:, axis], float(self.total[axis]))

    @property
    @quantity("", "numbers of the modes that bend along one direction", dims="bending")
    def bending_mode(self) -> Index:
        """Numbers of the bending modes, from 1."""
        return self.bending + 1
