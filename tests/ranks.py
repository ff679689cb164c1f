"""Calls `results(**given)` of a script on all ranks of this program; rank 0 writes what it gives.

Run by the fixture `on_ranks`: `mpirun -n 3 python ranks.py SCRIPT GIVEN RESULTS`.
"""

import pickle
import runpy
import sys
import traceback
from pathlib import Path

import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

COMM = MPI.COMM_WORLD


def my_rows(n):
    """Rows of this rank: about a third and two thirds, on the first and the last."""
    bounds = {1: [0, n], 2: [0, n // 3, n], 3: [0, n // 3, n // 3, n]}[COMM.size]
    return slice(bounds[COMM.rank], bounds[COMM.rank + 1])


def distributed(matrix):
    """A dense matrix by `my_rows`."""
    n = len(matrix)
    rows = sp.csr_matrix(matrix[my_rows(n)])
    return PETSc.Mat().createAIJ(
        ((rows.shape[0], n),) * 2, csr=(rows.indptr, rows.indices, rows.data), comm=COMM
    )


if __name__ == "__main__":
    try:
        script, given, found = sys.argv[1:]
        results = runpy.run_path(script)["results"]
        made = results(**pickle.loads(Path(given).read_bytes()))
        if COMM.rank == 0:
            Path(found).write_bytes(pickle.dumps(made))
    except BaseException:
        # `-m mpi4py` aborts too late: PETSc's end waits for the other ranks before.
        traceback.print_exc()
        COMM.Abort(1)
