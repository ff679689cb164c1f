"""Stiffness of a 3D building between its floors, each of which moves as a rigid body.

The columns of R, shape (n, 6 f), are the motions of f floors: of floor k a rigid motion r_k about
its node, which fades linearly in walls and columns to the floors above and below,

    R_k = h_k(z) r_k(x, y),   h_k(z_k) = 1,   h_k(z_{k±1}) = 0

A displacement u has the floor motions a = M_c⁻¹ Rᵀ M u, M_c = Rᵀ M R: those nearest to it by mass.
Loads that follow the mass, M R M_c⁻¹ p, do the work p · a on it, so that the floors have the
flexibility

    F = M_c⁻¹ Rᵀ M K⁻¹ M R M_c⁻¹

which holds what slabs, walls and beams deform under loads spread as their mass.
"""

from dataclasses import dataclass

import numpy as np

from impactfem.building.mesh import DOFS, BuildingMesh, rigid_body
from impactfem.building.model import BuildingModel
from impactfem.dynamics.columns import inner, product
from impactfem.dynamics.factorisation import Factorisation
from impactfem.system.arrays import Array


@dataclass(frozen=True, eq=False)
class FloorFlexibility:
    """Flexibility of the floors of a building, and motions of the floors in its modes."""

    F: Array  #: F of the floors, bottom to top, six motions each, shape (6 f, 6 f) [m/N, 1/(N m)].
    shapes: Array  #: Motions a of the floors in each mode, shape (6 f, n_modes).


def floor_flexibility(
    model: BuildingModel, mesh: BuildingMesh, storey_factor: float, shapes: Array
) -> FloorFlexibility:
    """Condense the stiffness of a building to its floors. Collective.

    Args:
        model: Its matrices.
        mesh: Its mesh, with the nodes at which the motions of floors are measured.
        storey_factor: Factor on the stiffness of walls and columns.
        shapes: Modes at this rank's rows, shape (n_local, n_modes).
    """
    R = floor_motions(model.coordinates, mesh)
    MR = product(model.mass, R)
    M_c = model.comm.allreduce(R.T @ MR)
    loads = MR @ np.linalg.inv(M_c)
    K = model.stiffness(storey_factor)
    with Factorisation(K, name="the stiffness") as factor:
        moved = factor.solve_block(loads)
    K.destroy()
    F = inner(model.mass, loads, moved)
    return FloorFlexibility((F + F.T) / 2.0, model.comm.allreduce(loads.T @ shapes))


def floor_motions(points: Array, mesh: BuildingMesh) -> Array:
    """Return R at points, shape (6 n, 6 f): unit motions of the floors about their nodes [m].

    What stands on the top floor moves with it.
    """
    floors = list(mesh.elevations)
    z = np.array([float(mesh.nodes[mesh.base, 2].min()), *mesh.elevations.values()])
    R = np.zeros((DOFS * len(points), DOFS * len(floors)))
    for k, floor in enumerate(floors):
        share = np.interp(points[:, 2], z, np.eye(len(z))[k + 1])
        level = np.array(points)
        # Heights count on the top floor alone: in storeys they are in the shares.
        level[:, 2] = np.maximum(points[:, 2], z[-1]) - z[-1] + z[k + 1]
        origin = np.array([*mesh.nodes[mesh.centres[floor], :2], z[k + 1]])
        motion = rigid_body(level, origin)
        R[:, DOFS * k : DOFS * (k + 1)] = motion * np.repeat(share, DOFS)[:, None]
    return R
