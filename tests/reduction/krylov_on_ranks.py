"""A Krylov basis on the ranks of this program, for test_krylov.py.

On three ranks the one in the middle holds no row.
"""

import numpy as np

from impactfem.dynamics.columns import inner, product
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.krylov import KrylovBasis
from impactfem.reduction.reduced import reduced_model, residual_norms
from impactfem.system.errors import SolutionError
from ranks import COMM, distributed, my_rows


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
    tail = inner(basis.M, basis.Q, basis.shifted_tail())
    gram = inner(basis.M, basis.V, product(basis.M, basis.V))
    return {
        "rows": COMM.allgather(mine.stop - mine.start),
        "sizes": basis.sizes,
        "orthonormal": np.abs(gram - np.eye(basis.size)).max(),
        "transfer": model.transfer(V, omega, Rayleigh(0.5, 1e-4)),
        "residual": residual_norms(tail, model, omega, Rayleigh(0.5, 1e-4)),
        "norm": norm,
        "refused": refused,
    }
