"""A Krylov basis on the ranks of this program; rank 0 writes what is found.

Run by test_krylov.py: `mpirun -n 3 python krylov_on_ranks.py MATRICES RESULTS`. On three ranks the
one in the middle holds no row.
"""

import pickle
import sys
import traceback
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

from impactfem.dynamics.columns import inner, product
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.reduced import Residual, reduced_model
from impactfem.system.errors import SolutionError

COMM = MPI.COMM_WORLD


def my_rows(n):
    """Rows of this rank: about a third and two thirds, on the first and the last."""
    bounds = {1: [0, n], 2: [0, n // 3, n], 3: [0, n // 3, n // 3, n]}[COMM.size]
    return slice(bounds[COMM.rank], bounds[COMM.rank + 1])


def distributed(matrix):
    n = len(matrix)
    rows = sp.csr_matrix(matrix[my_rows(n)])
    return PETSc.Mat().createAIJ(
        ((rows.shape[0], n),) * 2, csr=(rows.indptr, rows.indices, rows.data), comm=COMM
    )


def results(K, M, F, shift):
    mine = my_rows(len(K))
    omega = 2.0 * np.pi * np.geomspace(2.0, 200.0, 30)
    with KrylovBasis(distributed(K), distributed(M), shift) as basis:
        basis.add(F[mine, :2])
        basis.grow(8)
        basis.add(np.column_stack([F[mine, 0], F[mine, 2]]))
        basis.grow(20)
        norm = basis.dual_norm(F[mine])
        bad = F[mine].copy()
        if COMM.rank == COMM.size - 1:
            bad[-1, 0] = np.nan
        try:
            basis.add(bad)
            refused = ""
        except SolutionError as error:
            refused = str(error)
    model = reduced_model(basis)
    every = COMM.allgather(basis.rows(np.arange(mine.stop - mine.start)))
    V = np.concatenate(every)
    gram = inner(basis.M, basis.V, product(basis.M, basis.V))
    return {
        "rows": COMM.allgather(mine.stop - mine.start),
        "sizes": basis.sizes,
        "orthonormal": np.abs(gram - np.eye(basis.size)).max(),
        "transfer": model.transfer(V, omega, Rayleigh(0.5, 1e-4)),
        "residual": Residual(basis).norms(model, omega, Rayleigh(0.5, 1e-4)),
        "norm": norm,
        "refused": refused,
    }


def main():
    source, target = map(Path, sys.argv[1:])
    found = results(**pickle.loads(source.read_bytes()))
    if COMM.rank == 0:
        target.write_bytes(pickle.dumps(found))


try:
    main()
except BaseException:
    traceback.print_exc()
    COMM.Abort(1)
