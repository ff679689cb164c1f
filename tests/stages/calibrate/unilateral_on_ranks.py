"""Unilateral contact on the ranks of this program; rank 0 writes what is found.

Run by test_unilateral_full.py: `mpirun -n 2 python unilateral_on_ranks.py MATRICES RESULTS`. On
three ranks the one in the middle holds no row.
"""

import pickle
import sys
import traceback
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

from impactfem.coupling.unilateral import unilateral_response
from impactfem.dynamics.damping import Rayleigh
from impactfem.stages.calibrate.unilateral_full import FullMotion
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


def results(given):
    n = len(given["K"])
    mine = my_rows(n)
    K, M = distributed(given["K"]), distributed(given["M"])
    with FullMotion(
        K,
        M,
        given["G"][mine],
        given["h"],
        damping=Rayleigh(given["alpha"], given["beta"]),
        patterns=given["patterns"][mine],
        probes=given["probes"][mine],
    ) as motion:
        history = unilateral_response(
            motion,
            given["gap"],
            len(given["loads"]) - 1,
            velocity=given["v"][mine],
            amplitudes=given["loads"],
        )
        ended = COMM.gather(motion.displacement)
        try:
            unilateral_response(motion, -1.0, 3)
            refused = ""
        except SolutionError as error:
            refused = str(error)
    copies = COMM.gather((history.impulse, history.displacement))
    if ended is None or copies is None:
        return {}
    return {
        "impulse": history.impulse,
        "gap": history.gap,
        "displacement": history.displacement,
        "velocity": history.velocity,
        "residual": history.residual,
        "energy": vars(history.energy),
        "of energy": history.energy.residual,
        "end": np.concatenate(ended),
        "same": all(np.array_equal(copies[0][k], other[k]) for other in copies for k in range(2)),
        "refused": refused,
    }


if __name__ == "__main__":
    try:
        found = results(pickle.loads(Path(sys.argv[1]).read_bytes()))
        if COMM.rank == 0:
            Path(sys.argv[2]).write_bytes(pickle.dumps(found))
    except Exception:
        # `-m mpi4py` aborts too late: PETSc's end waits for the other ranks before.
        traceback.print_exc()
        COMM.Abort(1)
