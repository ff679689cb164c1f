"""From each rank's own matrix to one global matrix."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc
from scipy.sparse import csr_matrix

from impactfem.building.local import DOFS
from impactfem.building.share import Numbering

Index = NDArray[np.int64]


def global_matrix(local: Any | None, nodes: Index, numbering: Numbering) -> Any:
    """Add the ranks' matrices up to one. Collective.

    Args:
        local: This rank's matrix, PETSc AIJ on COMM_SELF with six rows for each of its nodes;
            None on a rank without cells. It is destroyed.
        nodes: Global numbers of its nodes, shape (n,).
        numbering: Order of the rows.

    Returns:
        PETSc AIJ matrix of all nodes, clamped ones included.
    """
    comm = numbering.comm
    if local is None:
        local = PETSc.Mat().createAIJ((0, 0), bsize=DOFS, nnz=0, comm=PETSc.COMM_SELF)
        local.assemble()
    blocks = numbering.place[nodes].astype(PETSc.IntType)
    mapping = PETSc.LGMap().create(blocks, bsize=DOFS, comm=comm)
    own, every = DOFS * len(numbering.owned), DOFS * len(numbering.place)
    joined = PETSc.Mat().create(comm)
    joined.setSizes(((own, every), (own, every)), bsize=DOFS)
    joined.setType("is")
    joined.setLGMap(mapping, mapping)
    joined.setISLocalMat(local)
    joined.assemble()
    matrix = joined.convert("aij", PETSc.Mat())
    joined.destroy()
    local.destroy()
    return matrix


def without_zeros(local: Any) -> Any:
    """A matrix on COMM_SELF without the zeros of its pattern; the one given is destroyed."""
    indptr, indices, values = local.getValuesCSR()
    matrix = csr_matrix((values, indices, indptr), shape=local.getSize())
    local.destroy()
    matrix.eliminate_zeros()
    kept = PETSc.Mat().createAIJ(
        matrix.shape,
        bsize=DOFS,
        csr=(matrix.indptr, matrix.indices, matrix.data),
        comm=PETSc.COMM_SELF,
    )
    kept.assemble()
    return kept


def added(matrices: list[Any], numbering: Numbering) -> Any:
    """Sum of matrices with any patterns, which are destroyed; zero without any. Collective."""
    if not matrices:
        return global_matrix(None, np.empty(0, dtype=np.int64), numbering)
    total, *others = matrices
    for other in others:
        total.axpy(1.0, other, structure=PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        other.destroy()
    return total


def without(matrix: Any, free: Index) -> Any:
    """Rows and columns of the free degrees of freedom. Collective.

    Args:
        matrix: PETSc AIJ matrix of all nodes; destroyed.
        free: This rank's rows that stay, as global numbers in ascending order, shape (n,).
    """
    rows = PETSc.IS().createGeneral(free.astype(PETSc.IntType), comm=matrix.comm)
    rows.setBlockSize(DOFS)
    part = matrix.createSubMatrix(rows, rows)
    matrix.destroy()
    rows.destroy()
    return part
