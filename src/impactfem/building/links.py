"""Rigid links: nodes that follow another one, by a transformation of the matrices."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from impactfem.building.local import DOFS
from impactfem.building.model import BuildingModel
from impactfem.building.rigid_body import rigid_body
from impactfem.system.errors import SolutionError

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class RigidLink:
    """Nodes that move as one rigid body with a master: u = u_m + θ_m × (x − x_m), θ = θ_m.

    Args:
        master: The node whose motion is kept.
        followers: The nodes that follow, shape (n,).
    """

    master: int
    followers: Index


def linked(
    model: BuildingModel, links: list[RigidLink], coordinates: Array
) -> tuple[BuildingModel, Any]:
    """The building with its followers taken out: Tᵀ K T and Tᵀ M T. Collective.

    Args:
        model: The building without the links; its matrices stay as they are.
        links: The links, the same on all ranks.
        coordinates: Coordinates of all nodes of the mesh, shape (n_nodes, 3) [m].

    Returns:
        The building on the nodes that are kept, and T, which gives all free degrees of freedom
        from the kept ones.

    Raises:
        SolutionError: A node follows two masters or itself, or is clamped.
    """
    master_of = _masters(model, links)
    following = master_of[model.nodes] >= 0
    kept = model.nodes[~following]
    first = DOFS * _place(model, kept)
    T = PETSc.Mat().create(model.comm)
    rows, columns = DOFS * len(model.nodes), DOFS * len(kept)
    T.setSizes(((rows, None), (columns, None)), bsize=DOFS)
    T.setType("aij")
    T.setPreallocationNNZ(DOFS)
    start = T.getOwnershipRange()[0]
    for i, node in enumerate(model.nodes):
        row = np.arange(start + DOFS * i, start + DOFS * (i + 1), dtype=PETSc.IntType)
        master = master_of[node]
        if master < 0:
            for k in range(DOFS):
                T.setValue(int(row[k]), int(first[node] + k), 1.0)
        else:
            motion = rigid_body(coordinates[node : node + 1], coordinates[master])
            column = np.arange(first[master], first[master] + DOFS, dtype=PETSc.IntType)
            T.setValues(row, column, motion)
    T.assemble()
    ground = carried(T, model.ground)
    return (
        replace(
            model,
            nodes=kept,
            coordinates=coordinates[kept],
            fixed=_reduced(model.fixed, T),
            storeys=_reduced(model.storeys, T),
            mass=_reduced(model.mass, T),
            ground=ground,
        ),
        T,
    )


def _reduced(A: Any, T: Any) -> Any:
    """Tᵀ A T, a new matrix. Collective."""
    product = A.ptap(T)
    # PETSc keeps what it made on the way with the product, as large again.
    found = product.copy()
    product.destroy()
    return found


def _masters(model: BuildingModel, links: list[RigidLink]) -> Index:
    """Master of each node, −1 where it follows none; the same on all ranks."""
    free = np.zeros(model.n_nodes, dtype=np.int64)
    for nodes in model.comm.allgather(model.nodes):
        free[nodes] = 1
    master_of = np.full(model.n_nodes, -1, dtype=np.int64)
    for link in links:
        taken = link.followers[master_of[link.followers] >= 0]
        if taken.size or len(np.unique(link.followers)) != len(link.followers):
            raise SolutionError(f"a node follows two masters, one of them {link.master}")
        master_of[link.followers] = link.master
    for link in links:
        if master_of[link.master] >= 0:
            raise SolutionError(f"node {link.master} follows another one and cannot be a master")
        for node in (link.master, *link.followers):
            if not free[node]:
                raise SolutionError(f"node {node} is clamped and cannot be part of a rigid link")
    return master_of


def _place(model: BuildingModel, kept: Index) -> Index:
    """Place of each kept node among the blocks of rows of the smaller matrices, else −1."""
    place = np.full(model.n_nodes, -1, dtype=np.int64)
    every = np.concatenate(model.comm.allgather(kept))
    place[every] = np.arange(len(every))
    return place


def carried(T: Any, forces: Array) -> Array:
    """Tᵀ f: forces on all free degrees of freedom, those on followers on their masters. Collective.

    Args:
        T: Of `linked`.
        forces: f at this rank's rows of the building without the links, shape (n_local, k).

    Returns:
        The same at its rows of the building with them, shape (n_kept, k).
    """
    y, x = T.createVecs()
    found: Array = np.empty((y.getLocalSize(), forces.shape[1]))
    for k, column in enumerate(forces.T):
        x.setArray(column)
        T.multTranspose(x, y)
        found[:, k] = y.getArray()
    x.destroy()
    y.destroy()
    return found
