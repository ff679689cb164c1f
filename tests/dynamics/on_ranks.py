"""Dynamics on the ranks of this program, for test_ranks.py."""

from copy import deepcopy

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

from impactfem.dynamics.columns import inner, product, random_column
from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.factorisation import Factorisation, SingularMatrixError
from impactfem.dynamics.modes import modes
from impactfem.dynamics.newmark import Newmark
from impactfem.system.errors import SolutionError

SIDE = 14  # masses along each side of the grid


def grid(free):
    """Stiffness of a grid of masses, stiffer one way than the other; in the air if free."""
    line = sp.diags([-np.ones(SIDE - 1), 2.0 * np.ones(SIDE), -np.ones(SIDE - 1)], [-1, 0, 1])
    line = line.tolil()
    line[-1, -1] = 1.0
    if free:
        line[0, 0] = 1.0
    one = sp.identity(SIDE)
    return (sp.kron(1000.0 * line, one) + sp.kron(one, 1700.0 * line)).tocsr()


def distributed(matrix):
    """Each rank takes its rows, the same number of blocks of two as PETSc would."""
    A = PETSc.Mat().create(MPI.COMM_WORLD)
    A.setSizes(matrix.shape, bsize=2)
    A.setType("aij")
    A.setUp()
    start, end = A.getOwnershipRange()
    rows = sp.csr_matrix(matrix)[start:end]
    A.destroy()
    return PETSc.Mat().createAIJ(
        ((end - start, matrix.shape[0]),) * 2,
        bsize=2,
        csr=(rows.indptr, rows.indices, rows.data),
        comm=MPI.COMM_WORLD,
    )


def gathered(rows):
    every = MPI.COMM_WORLD.gather(rows)
    return None if every is None else np.concatenate(every)


def refused(A):
    try:
        Factorisation(A)
    except SolutionError as error:
        return str(error), error.row if isinstance(error, SingularMatrixError) else -1
    return "accepted", -1


def results():
    """What must not depend on the number of ranks."""
    stiffness = grid(free=False)
    n = stiffness.shape[0]
    weights = np.linspace(1.0, 2.0, n)
    K, M = distributed(stiffness), distributed(sp.diags(weights).tocsr())
    start, end = K.getOwnershipRange()
    found = modes(K, M, 9)
    r = np.cos(np.outer(np.arange(start, end), np.arange(1.0, 7.0)))
    Mr = product(M, r)

    X = np.stack([random_column(K, j) for j in range(40)], axis=1)
    with Factorisation(K) as factor:
        error = factor.solve_block(product(K, X)) - X
    sigma = (2.0 * np.pi) ** 2 * found.frequency[4] * found.frequency[5]
    shifted = stiffness - sigma * sp.diags(weights)
    with Factorisation(distributed(shifted), definite=False) as factor:
        inertia = factor.inertia()

    patterns = np.zeros((end - start, 2))
    patterns[:, 0] = -weights[start:end]
    patterns[np.arange(start, end) % 7 == 3, 1] = 1.0
    time = 0.01 * np.arange(301)
    loads = np.stack([np.sin(20.0 * time), 30.0 * (abs(time - 0.5) < 0.03)], axis=1)
    probes = [n - 1, 0, n // 2, n // 2 + 1]
    with Newmark(K, M, 0.01, patterns, damping=Rayleigh(0.4, 1e-3)) as system:
        state = system.start(loads[0], np.sin(np.arange(start, end)))
        middle = []
        history = system.march(
            state,
            loads,
            probes=probes,
            each_step=lambda now: middle.append(deepcopy(now)) if now.step == 137 else None,
        )
    with Newmark(K, M, 0.01, patterns, damping=Rayleigh(0.4, 1e-3)) as system:
        resumed = system.march(middle[0], loads, probes=probes)
    island = sp.block_diag([stiffness, grid(free=True), stiffness])
    return {
        "ranks": MPI.COMM_WORLD.size,
        "rows": MPI.COMM_WORLD.allgather(end - start),
        "frequency": found.frequency,
        "residual": found.residual,
        "shapes": gathered(found.shapes),
        "factor": inner(M, Mr, found.shapes),
        "total": np.diag(inner(M, r, Mr)),
        "random": gathered(X),
        "solved": float(np.sqrt(np.trace(inner(K, error, error)))),
        "inertia": inertia,
        "motion": history.motion,
        "residual of energy": history.energy.residual,
        "energy": np.array([history.energy.elastic, history.energy.damped, history.energy.input]),
        "end": gathered(state.displacement),
        "resumed": resumed.motion,
        "island": refused(distributed(island)),
        "indefinite": refused(distributed(shifted)),
        "empty": refused(distributed(sp.diags((np.arange(n) != 100).astype(float)).tocsr())),
    }
