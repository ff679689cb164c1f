"""The matrix of damping by part, beside the Rayleigh damping of the whole building.

With the coefficients α_p, β_p of the parts p that have their own and α, β of all others, and with
the factor φ_p on the stiffness of walls and columns (1 on that of slabs and beams),

    C = Σ_p (α_p M_p + β_p φ_p K_p) = α M + β K + C₊,
    C₊ = Σ_p (α_p − α) M_p + (β_p − β) φ_p K_p                                             (1)

over the parts with a damping of their own. M_p holds what of the added mass of a floor lies on the
slab p.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from petsc4py import PETSc

from impactfem.building.assembly import added, global_matrix, without
from impactfem.building.model import local_matrices
from impactfem.building.part_damping import PartDamping
from impactfem.building.parts import BuildingParts, ShellCells
from impactfem.building.share import shared_out
from impactfem.dynamics.damping import Rayleigh


def damping_matrix(
    comm: Any,
    parts: BuildingParts,
    dampings: PartDamping,
    storey_factor: float,
    whole: Rayleigh,
) -> Any:
    """C₊ of equation (1) of the module, on the rows of `assemble_building`. Collective.

    Args:
        comm: Communicator.
        parts: The building, the same on all ranks.
        dampings: Dampings of its parts.
        storey_factor: φ, the factor on the stiffness of walls and columns.
        whole: The damping of the building.

    Returns:
        PETSc AIJ matrix of the free degrees of freedom.
    """
    share = shared_out(comm, parts)
    matrices = []
    for kind, mine in zip(share.kinds, share.mine, strict=True):
        own = dampings.shells if isinstance(kind, ShellCells) else dampings.beams
        factor = storey_factor if kind.storey else 1.0
        # All ranks make a matrix of each kind and damping, also those that have none of its cells.
        for damping in dampings.distinct:
            of_damping = np.array([one == damping for one in own], dtype=bool)
            K, M, nodes = local_matrices(parts, kind, mine[of_damping[kind.part[mine]]])
            if K is not None:
                K.scale((damping.beta - whole.beta) * factor)
                K.axpy(damping.alpha - whole.alpha, M, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
                M.destroy()
            matrices.append(global_matrix(K, nodes, share.numbering))
    C = added(matrices, share.numbering)
    return without(C, share.free_rows(C))
