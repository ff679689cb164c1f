"""Rigid links: nodes that follow another one, and the base plates of devices."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse
from petsc4py import PETSc

from impactfem.building.mesh import DOFS, BuildingMesh, rigid_body
from impactfem.building.model import BuildingModel
from impactfem.case import Building3D
from impactfem.case.devices import NODES
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import Fault, InputError, SolutionError

AT_ONCE = 32768
"""Displacements that are taken from vectors at once."""
LEVEL = 0.05
"""How far from a floor's level an anchor may be [m]."""
INSIDE = 1e-6
"""How far outside a triangle a point may be that is on its edge, of the triangle's heights."""


@dataclass(frozen=True, eq=False)
class RigidLink:
    """Nodes that move as one rigid body with a master: u = u_m + θ_m × (x − x_m), θ = θ_m."""

    master: int  #: The node whose motion they follow.
    followers: Index  #: The nodes that follow, shape (n,).


def linked(
    model: BuildingModel, links: Sequence[RigidLink], coordinates: Array
) -> tuple[BuildingModel, Any]:
    """The building with its followers taken out: Tᵀ K T and Tᵀ M T. Collective.

    The matrices of the building without the links stay as they are. The links are the same on all
    ranks; coordinates are those of all nodes of the mesh, shape (n_nodes, 3) [m]. Also gives T,
    from which all free degrees of freedom follow from those of the remaining nodes.

    Raises:
        SolutionError: A node follows two masters or itself, or is clamped.
    """
    free = np.zeros(model.n_nodes, dtype=np.int64)
    for nodes in model.comm.allgather(model.nodes):
        free[nodes] = 1
    # Master of each node, −1 where it follows none; the same on all ranks.
    master_of = np.full(model.n_nodes, -1, dtype=np.int64)
    for link in links:
        followers = link.followers
        if np.any(master_of[followers] >= 0) or len(np.unique(followers)) != len(followers):
            raise SolutionError(f"a node follows two masters, one of them {link.master}")
        master_of[followers] = link.master
    for link in links:
        if master_of[link.master] >= 0:
            raise SolutionError(f"node {link.master} follows another one and cannot be a master")
        for node in (link.master, *link.followers):
            if not free[node]:
                raise SolutionError(f"node {node} is clamped and cannot be part of a rigid link")
    following = master_of[model.nodes] >= 0
    remaining = model.nodes[~following]
    # Place of each remaining node among the blocks of rows of the smaller matrices.
    place = np.full(model.n_nodes, -1, dtype=np.int64)
    every = np.concatenate(model.comm.allgather(remaining))
    place[every] = np.arange(len(every))
    # T: each node moves as its master, a remaining one as itself.
    leader = np.where(following, master_of[model.nodes], model.nodes)
    arm = coordinates[model.nodes] - coordinates[leader]
    n = len(leader)
    blocks = rigid_body(arm, np.zeros(3)).reshape(n, DOFS, DOFS), place[leader], np.arange(n + 1)
    shape = DOFS * n, DOFS * len(every)
    local = scipy.sparse.bsr_matrix(blocks, shape=shape).tocsr()
    local.eliminate_zeros()
    arrays = local.indptr, local.indices, local.data
    sizes = (DOFS * n, None), (DOFS * len(remaining), None)
    T = PETSc.Mat().createAIJ(sizes, bsize=DOFS, csr=arrays, comm=model.comm)
    T.assemble()
    smaller = replace(
        model,
        nodes=remaining,
        coordinates=coordinates[remaining],
        fixed=_reduced(model.fixed, T),
        storeys=_reduced(model.storeys, T),
        mass=_reduced(model.mass, T),
        ground=carried(T, model.ground),
    )
    return smaller, T


def _reduced(A: Any, T: Any) -> Any:
    """Tᵀ A T, a new matrix. Collective."""
    product = A.ptap(T)
    # PETSc keeps what it made on the way with the product, as large again.
    reduced = product.copy()
    product.destroy()
    return reduced


def carried(T: Any, forces: Array) -> Array:
    """Tᵀ f: forces on all free degrees of freedom, those on followers on their masters. Collective.

    f at this rank's rows of the building without the links, shape (n_local, k), gives the same at
    those of the building with them.
    """
    y, x = T.createVecs()
    on_masters: Array = np.empty((y.getLocalSize(), forces.shape[1]))
    for k, column in enumerate(forces.T):
        x.setArray(column)
        T.multTranspose(x, y)
        on_masters[:, k] = y.getArray()
    x.destroy()
    y.destroy()
    return on_masters


class Displacements:
    """Displacements of nodes, from the degrees of freedom of a building with rigid links.

    A follower's come from its master's motion, u = u_m + θ_m × (x − x_m), θ = θ_m; those of a
    clamped node are zero. Making one is collective.

    Args:
        model: The building, of `linked` where there are links.
        nodes: The nodes, shape (n,); they may lie on any rank.
        links: Its links.
        coordinates: Coordinates of all nodes of the mesh, shape (n_nodes, 3) [m]; None without
            links.
        rotations: Whether the nodes' rotations are meant in place of their displacements.

    Raises:
        ValueError: There are links, and no coordinates.

    Attributes:
        rows: Global rows of the degrees of freedom that count, shape (m,); −1 where clamped.
        motion: The displacements from these, node by node, shape (3 n, m), sparse.
    """

    def __init__(
        self,
        model: BuildingModel,
        nodes: Index,
        links: Sequence[RigidLink] = (),
        coordinates: Array | None = None,
        *,
        rotations: bool = False,
    ) -> None:
        if links and coordinates is None:
            raise ValueError("the displacements of followers need the coordinates of the nodes")
        self.comm = model.comm
        self.count = len(nodes)
        master = np.array(nodes, dtype=np.int64)
        for link in links:
            master[np.isin(nodes, link.followers)] = link.master
        still = np.zeros((len(nodes), 3))
        arm = still if coordinates is None else coordinates[nodes] - coordinates[master]
        every = rigid_body(arm, np.zeros(3))
        wanted = slice(DOFS // 2, DOFS) if rotations else slice(DOFS // 2)
        each = every.reshape(len(nodes), DOFS, DOFS)[:, wanted]
        node, component, dof = np.nonzero(each)
        freedom, column = np.unique(DOFS * master[node] + dof, return_inverse=True)
        shape = (DOFS // 2 * len(nodes), len(freedom))
        entries = (each[node, component, dof], (DOFS // 2 * node + component, column.ravel()))
        self.motion = scipy.sparse.csr_matrix(entries, shape=shape)
        first = model.global_rows(freedom // DOFS)
        self.rows = np.where(first >= 0, first + freedom % DOFS, -1)
        start = DOFS * int(np.sum(model.comm.allgather(len(model.nodes))[: model.comm.rank]))
        self._here = np.flatnonzero(
            (self.rows >= start) & (self.rows < start + DOFS * len(model.nodes))
        )
        self._local = self.rows[self._here] - start
        self._size = DOFS * len(model.nodes)

    @property
    def columns(self) -> scipy.sparse.csc_matrix:
        """The displacements as columns at this rank's rows, shape (n_local, 3 n), sparse."""
        shape = (self._size, len(self.rows))
        entries = (np.ones(len(self._here)), (self._local, self._here))
        return scipy.sparse.csc_matrix(
            scipy.sparse.csr_matrix(entries, shape=shape) @ self.motion.T
        )

    def of(self, rows: Callable[[Index], Array]) -> Array:
        """The displacements in some vectors, shape (n, 3, k), the same on all ranks. Collective.

        `rows` gives this rank's rows of the k vectors, shape (number of rows, k).
        """
        motion, moved = self.motion[:, self._here], np.empty((0, 0))
        # Some at a time, as of many nodes in many vectors a copy takes gigabytes; not a few, as
        # vectors in files are read each time.
        for first in range(0, max(motion.shape[0], 1), AT_ONCE):
            part = motion[first : first + AT_ONCE]
            used = np.unique(part.indices)
            found = part[:, used] @ rows(self._local[used])
            if first == 0:
                moved = np.empty((motion.shape[0], found.shape[1]))
            moved[first : first + AT_ONCE] = found
        if self.comm.size > 1:
            from mpi4py import MPI

            self.comm.Allreduce(MPI.IN_PLACE, moved)
        return moved.reshape(self.count, DOFS // 2, -1)


@dataclass(frozen=True, eq=False)
class BasePlate:
    """A rigid plate between nodes of a slab, with the anchor of a device in it."""

    name: str  #: Name of the device.
    floor: int  #: Number of the floor.
    point: Array  #: The anchor, shape (3,) [m].
    master: int  #: The node nearest to it.
    followers: Index  #: The other nodes within the radius, shape (n,).
    offset: Array  #: From the master to the anchor, shape (3,) [m].
    least_radius: float  #: Radius that ties `NODES` nodes of the floor [m].

    @property
    def link(self) -> RigidLink:
        """The rigid link of the nodes."""
        return RigidLink(self.master, self.followers)

    @property
    def nodes(self) -> Index:
        """All of its nodes, shape (n + 1,)."""
        return np.append(self.followers, self.master)

    @property
    def carried(self) -> Array:
        """S of the anchor's motion by the master's: u + θ × offset and θ, shape (6, 6)."""
        return rigid_body(self.offset[None], np.zeros(3))

    @classmethod
    def find(
        cls, mesh: BuildingMesh, name: str, point: tuple[float, float, float], radius: float
    ) -> BasePlate:
        """Find the nodes within a radius [m] of the anchor of a device, a point on a floor [m].

        Raises:
            SolutionError: The anchor is on no floor, over a hole of it or beside its slab; or no
                node of the floor is within the radius.
        """
        at = np.array(point, dtype=np.float64)
        floor = min(mesh.elevations, key=lambda k: abs(mesh.elevations[k] - at[2]))
        if abs(mesh.elevations[floor] - at[2]) > LEVEL:
            raise SolutionError(
                f"device {name}: its anchor at z = {at[2]:g} m is on no floor; the nearest one, "
                f"floor {floor}, is at {mesh.elevations[floor]:g} m"
            )
        slab = mesh.triangles[mesh.triangles_of("floor", floor)]
        flat = slab[np.ptp(mesh.nodes[slab[:, :3], 2], axis=1) < 1e-6]  # without upstands
        nodes = np.unique(flat)
        # Of each triangle, the parts that the anchor and two of the corners make.
        a, b, c = np.moveaxis(mesh.nodes[flat[:, :3], :2], 1, 0)

        def turned(p: Array, q: Array) -> Array:
            return np.asarray(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])

        parts = np.stack([turned(q - p, at[:2] - p) for p, q in ((a, b), (b, c), (c, a))])
        if not np.any((parts / turned(b - a, c - a)).min(axis=0) >= -INSIDE):
            raise SolutionError(
                f"device {name}: its anchor at ({at[0]:g}, {at[1]:g}) m stands over a hole of "
                f"floor {floor}, or beside its slab; expected a point on the slab"
            )
        away = np.linalg.norm(mesh.nodes[nodes, :2] - at[:2], axis=1)
        within = nodes[away <= radius * (1.0 + 1e-9)]
        master = int(nodes[np.argmin(away)])
        if not within.size:
            x, y, z = mesh.nodes[master]
            raise SolutionError(
                f"device {name}: no node of floor {floor} is within {radius:g} m of its anchor at "
                f"({at[0]:g}, {at[1]:g}) m; the nearest one, at ({x:.4g}, {y:.4g}, {z:.4g}) m, is "
                f"{away.min():.3g} m away: type a radius of at least "
                f"{math.ceil(100.0 * away.min())} cm, or reduce floor_size of the mesh"
            )
        return cls(
            name=name,
            floor=floor,
            point=at,
            master=master,
            followers=np.asarray(within[within != master], dtype=np.int64),
            offset=at - mesh.nodes[master],
            least_radius=float(np.sort(away)[:NODES][-1]),
        )


def find_base_plates(building: Building3D, mesh: BuildingMesh) -> tuple[BasePlate, ...]:
    """Find the nodes of every anchor of every device of a building.

    Raises:
        InputError: Anchors are on no node of a floor, or two tie the same nodes; all of them.
    """
    faults: list[Fault] = []
    base_plates: list[BasePlate] = []
    for index, device in building.numbered_devices:
        for number, anchor in enumerate(device.anchor_points, 1):
            key, name = f"devices[{index}]", device.name
            if device.supports:
                key, name = f"{key}.supports[{number - 1}]", f"{name}, support {number}"
            try:
                base_plate = BasePlate.find(mesh, name, anchor.point, anchor.radius)
            except SolutionError as error:
                faults.append(Fault(building.case.path, f"{key}.point", anchor.point, str(error)))
                continue
            for other in base_plates:
                if np.intersect1d(base_plate.nodes, other.nodes).size:
                    apart = float(np.linalg.norm(base_plate.point - other.point))
                    expected = (
                        f"the anchors of {other.name} and {name} are {apart:.3g} m apart and tie "
                        f"the same nodes of floor {base_plate.floor}; expected smaller radii, or "
                        "anchors further apart"
                    )
                    faults.append(
                        Fault(building.case.path, f"{key}.radius", anchor.radius, expected)
                    )
                    break
            base_plates.append(base_plate)
    if faults:
        raise InputError(faults)
    return tuple(base_plates)
