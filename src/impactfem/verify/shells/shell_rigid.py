"""Rigid-body motions of shell parts: six motions without energy, drilling included, no more."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from impactfem.building.section import BeamSection, Material
from impactfem.building.shell_model import Beams, ShellModel, Shells, shell_model
from impactfem.verify.row import Row
from impactfem.verify.shells.rigid_body_rows import rigid_body_rows
from impactfem.verify.shells.shell_meshes import ROTATION, flat, joined, lines_at, panel

CONCRETE = Material(E=33e9, nu=0.2, rho=2500.0)


def rigid_body_modes() -> list[Row]:
    """Free parts in no special direction, far from the origin, on distorted meshes.

    For each unit motion r of the six: |rᵀ K r| over the norm of K. Then the number of zero
    eigenvalues of K: six, so that no other motion is free, either. Last, the drilling energy is
    there: a turn φ about the normal with the rotations turned the wrong way, θ = −φ n, costs
    ½ c μ t (2 φ)² A.
    """
    rows = []
    for label, model in _parts().items():
        rows += rigid_body_rows("rigid-body modes", label, model)
    return [*rows, _wrong_way()]


def _parts() -> dict[str, ShellModel]:
    def turned(
        mesh: tuple[NDArray[np.float64], NDArray[np.int64]], t: float, *beams: Beams
    ) -> ShellModel:
        nodes, triangles = mesh
        moved = nodes @ ROTATION.T + [40.0, -25.0, 30.0]
        return shell_model(moved, Shells(triangles, t, CONCRETE), *beams)

    skew = panel(4, 3, flat((6.0, 1.0, 0.0), (1.5, 4.0, 0.0)), 0.3)
    roof = panel(4, 3, lambda a, b: (5.0 * np.sin(a), 5.0 * np.cos(a), 4.0 * b), 0.3)
    along = (6.0, 0.0, 0.0)
    wings = ((0.0, 0.0, -2.0), (0.0, 2.0, 0.0), (0.0, -2.0, 0.0))
    nodes, triangles, _ = joined([panel(3, 2, flat(along, wing)) for wing in wings])
    joint = lines_at(triangles, (nodes[:, 1] == 0.0) & (nodes[:, 2] == 0.0))
    section = BeamSection.rectangle(0.4, 0.7, reference=(0.3, 0.2, 0.9), offset=(0.1, 0.2, -0.5))
    return {
        "thin skew plate": turned(skew, 0.06),
        "thick skew plate": turned(skew, 0.9),
        "curved panel": turned(roof, 0.3),
        "T-joint with an eccentric beam": turned(
            (nodes, triangles), 0.3, Beams(joint, section, CONCRETE)
        ),
    }


def _wrong_way() -> Row:
    length, width, t, phi = 6.0, 4.0, 0.3, 1e-3
    nodes, triangles = panel(4, 3, flat((length, 0.0, 0.0), (0.0, width, 0.0)), 0.3)
    model = shell_model(nodes @ ROTATION.T, Shells(triangles, t, CONCRETE))
    motion = np.zeros((len(nodes), 6))
    normal = ROTATION[:, 2]
    motion[:, :3] = phi * np.cross(normal, model.nodes)
    motion[:, 3:] = -phi * normal
    energy = 0.5 * motion.ravel() @ (model.K @ motion.ravel())
    return Row(
        "rigid-body modes",
        "energy of rotations against the turn of a plate",
        0.5 * CONCRETE.G * t * (2.0 * phi) ** 2 * length * width,
        float(energy),
        "J",
        1e-10,
        "the element's drilling energy (Hughes and Brezzi 1989), closed form",
    )
