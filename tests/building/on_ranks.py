"""Assembles buildings on the ranks of this program; rank 0 gathers by node, for test_ranks.py."""

import numpy as np
from mpi4py import MPI
from scipy.sparse import csr_matrix, vstack

from impactfem.building.floor import edge_load, linear
from impactfem.building.links import RigidLink, linked
from impactfem.building.model import assemble_building
from impactfem.dynamics.factorisation import Factorisation
from impactfem.dynamics.modes import modes


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


def of_building(parts, link):
    """What must not depend on the number of ranks; arrays on rank 0."""
    mesh = parts.mesh
    model = assemble_building(MPI.COMM_WORLD, parts)
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
        "orientation": gathered(model, model.orientation()),
        "shapes": gathered(model, modes(K, model.mass, 4, fields=model.orientation()).shapes),
        "total": model.total,
        "linked K": gathered_matrix(small, small.stiffness(0.13)),
        "linked ground": gathered(small, small.ground),
        "rows of a rank": MPI.COMM_WORLD.allgather(len(model.nodes)),
    }


def results(buildings):
    return [of_building(*building) for building in buildings]
