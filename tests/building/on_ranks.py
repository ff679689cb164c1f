"""Assembles buildings on the ranks of this program and writes what rank 0 gathers, by node.

Run by test_ranks.py: `mpirun -n 3 python on_ranks.py BUILDINGS RESULTS`.
"""

import pickle
import sys
import traceback
from pathlib import Path

import numpy as np
from mpi4py import MPI
from scipy.sparse import csr_matrix, vstack

from impactfem.building.floor import edge_load, linear
from impactfem.building.links import RigidLink, linked
from impactfem.building.model import assemble_building
from impactfem.dynamics.factorisation import Factorisation


def gathered(model, values):
    """Rows of all ranks in the order of the nodes, on rank 0."""
    # Numbers of a node, said as there may be no node.
    width = 6 * (values.shape[1] if values.ndim == 2 else 1)
    every = model.comm.gather((model.nodes, values.reshape(len(model.nodes), width)))
    if every is None:
        return None
    nodes, blocks = (np.concatenate(part) for part in zip(*every, strict=True))
    return blocks[np.argsort(nodes)].ravel()


def gathered_matrix(model, matrix):
    """A matrix with rows and columns in the order of the nodes, on rank 0."""
    indptr, indices, values = matrix.getValuesCSR()
    rows = csr_matrix((values, indices, indptr), shape=(len(indptr) - 1, matrix.getSize()[1]))
    every = model.comm.gather((model.nodes, rows))
    if every is None:
        return None
    order = np.argsort(np.concatenate([nodes for nodes, _ in every]))
    dofs = (6 * order[:, None] + np.arange(6)).ravel()
    return vstack([part for _, part in every]).tocsr()[dofs][:, dofs]


def displacement(K, load):
    """K⁻¹ f at this rank's rows."""
    with Factorisation(K) as factor:
        return factor.solve_block(load[:, None])[:, 0]


def results(comm, parts, link):
    """What must not depend on the number of ranks; arrays on rank 0."""
    mesh = parts.mesh
    model = assemble_building(comm, parts)
    K = model.stiffness(0.13)
    load = edge_load(mesh, 1, line=linear(0.0, 1.0, 0.7)).vector(model, (0.0, 0.6, 0.8))
    master, follower = link
    small, _ = linked(model, [RigidLink(master, np.array([follower]))], mesh.nodes)
    return {
        "K": gathered_matrix(model, K),
        "M": gathered_matrix(model, model.mass),
        "ground": gathered(model, model.ground),
        "load": gathered(model, load),
        "displacement": gathered(model, displacement(K, load)),
        "total": model.total,
        "linked K": gathered_matrix(small, small.stiffness(0.13)),
        "linked ground": gathered(small, small.ground),
        "rows of a rank": comm.allgather(len(model.nodes)),
    }


def main(buildings, found):
    comm = MPI.COMM_WORLD
    made = [results(comm, *building) for building in pickle.loads(buildings.read_bytes())]
    if comm.rank == 0:
        found.write_bytes(pickle.dumps(made))


if __name__ == "__main__":
    try:
        main(*map(Path, sys.argv[1:]))
    except Exception:
        # `-m mpi4py` aborts too late: PETSc's end waits for the other ranks before.
        traceback.print_exc()
        MPI.COMM_WORLD.Abort(1)
