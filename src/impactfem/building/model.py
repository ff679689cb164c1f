"""The building as matrices: stiffness of what stays and of what is scaled, mass, ground motion."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse
from petsc4py import PETSc

from impactfem._fenicsx import assembled, cellwise, compiled, constant
from impactfem.building.assembly import (
    LocalCells,
    added,
    global_matrix,
    local_cells,
    shared_out,
    without,
)
from impactfem.building.beam import BeamFields
from impactfem.building.mesh import DOFS, rigid_body
from impactfem.building.parts import BuildingParts, Flags, Kind, PartDamping
from impactfem.building.section import Material
from impactfem.building.shell import ShellFields
from impactfem.dynamics.columns import product
from impactfem.dynamics.damping import Rayleigh
from impactfem.dynamics.orientation import FIELDS, fields
from impactfem.system.arrays import Array, Index


@dataclass(frozen=True)
class BuildingModel:
    """Matrices of the free degrees of freedom; clamped nodes are not among them.

    A node has six, (ux, uy, uz, rx, ry, rz). The pattern of the mass is part of the stiffness's.
    """

    comm: Any  #: Communicator.
    nodes: Index  #: Free nodes of this rank's rows in their order, shape (n_local / 6,).
    coordinates: Array  #: Their coordinates, shape (n_local / 6, 3) [m].
    fixed: Any  #: Stiffness of slabs and beams, PETSc AIJ.
    storeys: Any  #: Stiffness of walls and columns at the storey factor 1, PETSc AIJ.
    mass: Any  #: Mass matrix M, PETSc AIJ.
    #: M r of the free rows for unit rigid-body motions of everything, base included, about the
    #: origin; the load of a ground acceleration a is −(M r) a; shape (n_local, 6).
    ground: Array
    total: Array  #: rᵀ M r with the base, shape (6, 6) [kg, kg m, kg m2].
    n_nodes: int  #: Number of nodes, clamped ones included.

    @property
    def n_free(self) -> int:
        """Number of free degrees of freedom on all ranks."""
        return int(self.mass.getSize()[0])

    def stiffness(self, storey_factor: float = 1.0) -> Any:
        """K = K_fixed + factor K_storeys, a new PETSc AIJ matrix. Collective."""
        return self._add_storeys(self.fixed.copy(), storey_factor)

    def take_stiffness(self, storey_factor: float) -> Any:
        """K, made from `fixed` and `storeys`, which are gone afterwards. Collective.

        For large models: their memory is a good part of what a factorisation needs.
        """
        K = self._add_storeys(self.fixed, storey_factor)
        self.storeys.destroy()
        return K

    def orientation(self) -> Array:
        """Return fields that give modes their signs, on any ranks, shape (n_local, FIELDS).

        Collective (:mod:`impactfem.dynamics.orientation`).
        """
        ends = [np.min(self.coordinates, axis=0, initial=np.inf)]
        ends.append(np.max(self.coordinates, axis=0, initial=-np.inf))
        every = np.array(self.comm.allgather(ends))
        low, high = every[:, 0].min(axis=0), every[:, 1].max(axis=0)
        return fields(self.coordinates, low, high).reshape(6 * len(self.nodes), FIELDS)

    def _add_storeys(self, K: Any, storey_factor: float) -> Any:
        different = PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN
        K.axpy(storey_factor, self.storeys, structure=different)
        K.setOption(PETSc.Mat.Option.SPD, True)
        return K

    def about(self, origin: Array) -> tuple[Array, Array]:
        """`ground` and `total` about x0, shape (3,) [m]: r S, with S = [I, -e × x0; 0, I]."""
        S = rigid_body(-np.asarray(origin)[None], np.zeros(3))
        return self.ground @ S, S.T @ self.total @ S

    def rigid_body(self, origin: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Array:
        """Rigid-body motions about a point at this rank's rows, shape (n_local, 6)."""
        return rigid_body(self.coordinates, np.asarray(origin))

    def node_of(self, row: int) -> int:
        """The node of a global row. Collective."""
        every = np.concatenate(self.comm.allgather(self.nodes))
        return int(every[row // DOFS])

    def global_rows(self, nodes: Index) -> Index:
        """First global row of each given node, −1 where it is clamped, shape (n,). Collective."""
        every = np.concatenate(self.comm.allgather(self.nodes))
        place = np.full(self.n_nodes, -1, dtype=np.int64)
        place[every] = DOFS * np.arange(len(every))
        return place[np.asarray(nodes)]

    def rows(self, nodes: Index) -> Index:
        """First local row of each node; −1 where it is clamped or on another rank, shape (n,)."""
        row = np.full(self.n_nodes, -1, dtype=np.int64)
        row[self.nodes] = DOFS * np.arange(len(self.nodes))
        return row[np.asarray(nodes, dtype=np.int64)]

    def along(self, nodes: Index, direction: Sequence[float] | Array) -> scipy.sparse.csr_matrix:
        """What gives n · u of nodes, as columns at this rank's rows, shape (n_local, n), sparse.

        Nodes that are clamped or on another rank have no entries; n is a unit vector.
        """
        row = self.rows(nodes)
        here = np.flatnonzero(row >= 0)
        rows = (row[here, None] + np.arange(3)).ravel()
        entries = np.tile(np.asarray(direction, dtype=np.float64), len(here))
        shape = (DOFS * len(self.nodes), len(nodes))
        columns = scipy.sparse.csr_matrix((entries, (rows, np.repeat(here, 3))), shape=shape)
        columns.eliminate_zeros()
        return columns


def assemble_building(comm: Any, parts: BuildingParts) -> BuildingModel:
    """Assemble the matrices of a building, the same on all ranks. Collective.

    Raises:
        SolutionError: A node belongs to no cell, or mid nodes are not in the middle.
    """
    share = shared_out(comm, parts)
    stiffness: dict[bool, list[Any]] = {False: [], True: []}
    masses: list[Any] = []
    for kind, cells in zip(share.kinds, share.cells_here, strict=True):
        K, M, local_nodes = _local_matrices(parts, kind, cells)
        stiffness[kind.storey].append(global_matrix(K, local_nodes, share))
        masses.append(global_matrix(M, local_nodes, share))
    fixed, storeys = (added(stiffness[storey], share) for storey in (False, True))
    mass = added(masses, share)
    # Of the whole mass, clamped nodes included, what moves with the ground: M r.
    owned = share.owned
    r = rigid_body(parts.mesh.nodes[owned], np.zeros(3))
    Mr = product(mass, r)
    free = share.free_rows(mass)
    nodes = owned[share.free[::DOFS]]
    return BuildingModel(
        comm=comm,
        nodes=nodes,
        coordinates=parts.mesh.nodes[nodes],
        fixed=without(fixed, free),
        storeys=without(storeys, free),
        mass=without(mass, free),
        ground=Mr[share.free],
        total=share.comm.allreduce(r.T @ Mr),
        n_nodes=len(parts.mesh.nodes),
    )


Actions = dict[tuple[object, ...], tuple[Index, Array, Array]]
"""By cells and all of their properties except Young's modulus: rows, K X for E = 1 Pa, and M X."""


def action_of_cells(
    parts: BuildingParts,
    cells: tuple[Flags, Flags],
    storey_factor: float,
    X: Array,
    known: Actions | None = None,
) -> tuple[Array, Array]:
    """K X and M X of some of the cells alone, clamped nodes included. Not collective.

    `cells` says whether each triangle, and each line, is among them; X are columns at the six
    components of each node of the mesh, shape (6 n_nodes, k). Products that were computed before
    for the same X and mesh are known; new ones are added.
    """
    KX, MX = np.zeros_like(X), np.zeros_like(X)
    known = {} if known is None else known
    for kind in parts.kinds():
        among = np.flatnonzero((cells[0] if kind.shells else cells[1])[kind.number])
        if not among.size:
            continue
        # K is linear in the modulus: cells that differ in nothing else are assembled once.
        E, unit = kind.material.E, replace(kind, material=replace(kind.material, E=1.0))
        number = kind.number[among]
        properties = (
            [np.array(parts.drilling), parts.thickness()[number], parts.added_mass[number]]
            if kind.shells
            else _beam_properties(parts, kind, among).values()
        )
        of_cells = kind.shells, unit.material, number.tobytes()
        key = (*of_cells, *(one.tobytes() for one in properties))
        if key not in known:
            K, M, nodes = _local_matrices(parts, unit, among)
            rows = (DOFS * nodes[:, None] + np.arange(DOFS)).ravel()
            known[key] = rows, product(K, X[rows]), product(M, X[rows])
            K.destroy()
            M.destroy()
        rows, of_K, of_M = known[key]
        KX[rows] += E * (storey_factor if kind.storey else 1.0) * of_K
        MX[rows] += of_M
    return KX, MX


def _local_matrices(parts: BuildingParts, kind: Kind, cells: Index) -> tuple[Any, Any, Index]:
    """Stiffness and mass of some cells of a kind on this rank, and their nodes. Not collective."""
    # Both are PETSc AIJ on COMM_SELF, at the storey factor 1; None where there is no cell.
    if cells.size == 0:
        return None, None, cells
    local = local_cells(parts.mesh.nodes, kind.cells[cells])
    chosen = cells[local.cells]
    fields: ShellFields | BeamFields
    if kind.shells:
        fields = shell_fields(parts, local, kind.material, kind.number[chosen])
    else:
        values = _beam_properties(parts, kind, chosen)
        fields = BeamFields(
            **{name: cellwise(local.mesh, value) for name, value in values.items()},
            young_modulus=constant(local.mesh, kind.material.E),
            poisson_ratio=constant(local.mesh, kind.material.nu),
            density=constant(local.mesh, kind.material.rho),
        )
    K, M = (assembled(compiled(form(local.space))) for form in (fields.stiffness, fields.mass))
    # Five of six entries of the mass are zero; in K they keep the blocks of a node whole.
    mass = scipy.sparse.csr_matrix(M.getValuesCSR()[::-1], shape=M.getSize())
    M.destroy()
    mass.eliminate_zeros()
    arrays = mass.indptr, mass.indices, mass.data
    M = PETSc.Mat().createAIJ(mass.shape, bsize=DOFS, csr=arrays, comm=PETSc.COMM_SELF)
    M.assemble()
    return K, M, local.nodes


def _beam_properties(parts: BuildingParts, kind: Kind, cells: Index) -> dict[str, Array]:
    """Of some cells of a kind, by the names of `BeamFields`, a row each."""
    sections = [parts.sections.beams[i] for i in kind.part[cells]]
    values: dict[str, list[Any]] = {
        "area": [s.A for s in sections],
        "second_moments": [(s.I1, s.I2) for s in sections],
        "torsion": [s.J for s in sections],
        "shear": [(s.k1, s.k2) for s in sections],
        "reference": [s.reference for s in sections],
        "offset": [s.offset for s in sections],
    }
    return {name: np.array(value) for name, value in values.items()}


def shell_fields(
    parts: BuildingParts, local: LocalCells, material: Material, number: Index
) -> ShellFields:
    """Section and material of shells on their mesh; `number` is the triangle of each cell of it."""
    return ShellFields(
        thickness=cellwise(local.mesh, parts.thickness()[number]),
        added_mass=cellwise(local.mesh, parts.added_mass[number]),
        young_modulus=constant(local.mesh, material.E),
        poisson_ratio=constant(local.mesh, material.nu),
        density=constant(local.mesh, material.rho),
        drilling=constant(local.mesh, parts.drilling),
    )


def damping_matrix(
    comm: Any, parts: BuildingParts, dampings: PartDamping, storey_factor: float, whole: Rayleigh
) -> Any:
    """The damping by part in addition to the Rayleigh damping of the building. Collective.

    With the coefficients α_p, β_p of the parts p that have a damping, α, β of all others, and the
    factor φ_p on the stiffness of walls and columns (1 on that of slabs and beams),

        C = Σ_p (α_p M_p + β_p φ_p K_p) = α M + β K + C₊,
        C₊ = Σ_p (α_p − α) M_p + (β_p − β) φ_p K_p

    over the parts with a damping. M_p holds what of the added mass of a floor lies on the slab p.
    C₊ is a PETSc AIJ matrix on the rows of `assemble_building`.
    """
    share = shared_out(comm, parts)
    matrices = []
    for kind, cells in zip(share.kinds, share.cells_here, strict=True):
        by_part = dampings.shells if kind.shells else dampings.beams
        factor = storey_factor if kind.storey else 1.0
        # All ranks make a matrix of each kind and damping, also those that have none of its cells.
        for damping in dampings.distinct:
            of_damping = np.array([d == damping for d in by_part], dtype=bool)
            K, M, nodes = _local_matrices(parts, kind, cells[of_damping[kind.part[cells]]])
            if K is not None:
                K.scale((damping.beta - whole.beta) * factor)
                K.axpy(damping.alpha - whole.alpha, M, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
                M.destroy()
            matrices.append(global_matrix(K, nodes, share))
    C = added(matrices, share)
    return without(C, share.free_rows(C))
