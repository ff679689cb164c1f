"""Membrane forces, moments and transverse shears of shells, as fields and at points.

Positive: N in tension, M in tension at the side of the normal (axis 3), Q3i on a face with the
normal along axis i where it acts along axis 3. They balance the loads as in the element's energy
(`impactfem.building.shell`): ∂j Mij = Qi, ∂i Qi + p = 0 for a pressure p along axis 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from impactfem._fenicsx import cell_nodes, cellwise, evaluator, function
from impactfem.building.assembly import local_cells
from impactfem.building.mesh import DOFS, BuildingMesh, place
from impactfem.building.model import shell_fields
from impactfem.building.parts import BuildingParts
from impactfem.system.arrays import Array, Index
from impactfem.system.errors import Fault, InputError

STEEP = np.sqrt(0.5)
"""|cos| of the angle from the normal to the vertical below which a facet is a wall."""
NEAR = 1e-3
"""Distance within which a point lies on a triangle [m]."""
_NODES = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.5], [0.0, 0.5], [0.5, 0.0]])
"""Nodes of dolfinx's quadratic triangle on the reference cell."""


@dataclass(frozen=True, eq=False)
class SectionForces:
    """Section forces at n places, of one displacement or (leading axes) of several."""

    axes: Array  #: Unit vectors 1, 2 and 3 (the normal) of each place, shape (n, 3, 3).
    membrane: Array  #: N11, N22, N12, shape (..., n, 3) [N/m].
    moment: Array  #: M11, M22, M12, shape (..., n, 3) [N m/m].
    shear: Array  #: Q1, Q2, shape (..., n, 2) [N/m].

    @classmethod
    def of(cls, axes: Array, values: Array) -> SectionForces:
        """From all eight of them, shape (..., n, 8)."""
        return cls(axes, values[..., :3], values[..., 3:6], values[..., 6:])


@dataclass(frozen=True, eq=False)
class SectionForceField:
    """Section forces on triangles, quadratic on each and not continuous between them."""

    mesh: BuildingMesh  #: The mesh.
    triangles: Index  #: Their numbers in it, shape (k,).
    #: Unit vectors 1, 2 and 3 (the normal) of each (see `facet_axes`), shape (k, 3, 3).
    axes: Array
    #: N11, N22, N12, M11, M22, M12, Q1, Q2 at the six nodes of each triangle, in the mesh's order,
    #: shape (..., k, 6, 8) [N/m, N m/m, N/m].
    values: Array

    def centres(self) -> SectionForces:
        """At the centre of each triangle: the most accurate place."""
        return SectionForces.of(self.axes, _quadratic(np.full((1, 3), 1.0 / 3.0))[0] @ self.values)

    def at(self, points: Array) -> SectionForces:
        """At points on the triangles, shape (m, 3) [m]; the mean of those that share the point.

        Raises:
            InputError: No triangle is there, or some with other axes are: choose among them when
                the field is made.
        """
        values, axes, faults = [], [], []
        p, q, r = np.moveaxis(self.mesh.nodes[self.mesh.triangles[self.triangles, :3]], 1, 0)
        a, b = q - p, r - p
        normal = np.cross(a, b)
        twice = np.linalg.norm(normal, axis=1)
        normal /= twice[:, None]
        sides = np.linalg.norm(np.stack([r - q, b, a], axis=1), axis=2)
        for i, point in enumerate(np.asarray(points, dtype=np.float64)):
            away = point - p
            second = np.einsum("ij,ij->i", np.cross(normal, away), b) / twice
            third = np.einsum("ij,ij->i", np.cross(normal, a), away) / twice
            coordinates = np.column_stack([1.0 - second - third, second, third])
            # A coordinate times the triangle's height is a distance from a side.
            outside = -(coordinates * (twice[:, None] / sides)).min(axis=1)
            height = np.abs(np.einsum("ij,ij->i", normal, away))
            here = np.flatnonzero((height < NEAR) & (outside < NEAR))
            if not here.size:
                faults.append(_fault(i, point, "a point on one of the field's triangles"))
            elif np.ptp(self.axes[here], axis=0).max() > 1e-6:
                faults.append(_fault(i, point, "triangles of one plane only: name them"))
            else:
                weights = _quadratic(coordinates[here])
                each = np.einsum("jn,...jnc->...jc", weights, self.values[..., here, :, :])
                values.append(each.mean(axis=-2))
                axes.append(self.axes[here[0]])
        if faults:
            raise InputError(faults)
        return SectionForces.of(np.array(axes).reshape(-1, 3, 3), np.stack(values, axis=-2))


def section_forces(
    parts: BuildingParts, displacement: Array, triangles: Index | None = None
) -> SectionForceField:
    """Section forces of displacements of the whole model. Not collective.

    Args:
        parts: The building.
        displacement: ux, uy, uz [m], rx, ry, rz [rad] of all nodes of its mesh, zero at clamped
            ones, shape (..., n_nodes, 6). Of a vector x of the free rows of a `BuildingModel` on
            one rank: ``full[model.nodes] = x.reshape(-1, 6)`` in zeros. Where rotations are left
            zero, the membrane forces are right all the same.
        triangles: Which, for example ``mesh.triangles_of("floor", 3)``; all when None.
    """
    mesh = parts.mesh
    given = np.asarray(displacement, dtype=np.float64)
    if given.shape[-2:] != (len(mesh.nodes), DOFS):
        raise ValueError(
            f"displacement has the shape {given.shape}, expected (..., {len(mesh.nodes)}, {DOFS})"
        )
    chosen = np.arange(len(mesh.triangles)) if triangles is None else np.asarray(triangles)
    cells = mesh.triangles[chosen]
    axes = facet_axes(mesh.nodes, cells)
    vectors = given.reshape(-1, len(mesh.nodes), DOFS)
    values = np.zeros((len(vectors), len(cells), 6, 8))
    part = mesh.triangle_part[chosen].astype(np.int64)
    materials = parts.materials.shells
    for material in dict.fromkeys(materials):
        some = np.flatnonzero(np.array([m == material for m in materials])[part])
        if not some.size:
            continue
        local = local_cells(mesh.nodes, cells[some])
        fields = shell_fields(parts, local, material, chosen[some][local.cells])
        plane = cellwise(local.mesh, axes[some][local.cells, :2].reshape(-1, 6))
        w = function(local.space)
        evaluate = evaluator(fields.section_forces(w, plane), local.mesh, _NODES)
        # Where the mesh has each node that dolfinx's cell has.
        numbers = local.nodes[cell_nodes(local.space)]
        order = np.argmax(numbers[:, None, :] == cells[some][local.cells][:, :, None], axis=2)
        for vector, of_vector in zip(vectors, values, strict=True):
            w.x.array[:] = vector[local.nodes].ravel()
            found = np.take_along_axis(evaluate(), order[:, :, None], axis=1)
            of_vector[some[local.cells]] = found
    return SectionForceField(
        mesh, chosen, axes, values.reshape(*given.shape[:-2], *values.shape[1:])
    )


def facet_axes(nodes: Array, triangles: Index) -> Array:
    """Axes that an engineer would draw on slabs and walls, unit vectors 1, 2, 3, shape (k, 3, 3).

    - Slabs (normal within 45° of the vertical): 1 and 2 lie along the global x and y as seen from
      above, the normal points upwards.
    - Walls: 1 is horizontal, towards positive x (positive y where it has no x); 2 points upwards.
      The normal is 1 × 2: that of a wall along x is −y, that of a wall along y is x.
    """
    p, q, r = np.moveaxis(nodes[triangles[:, :3]], 1, 0)
    normal = np.cross(q - p, r - p)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    slab = np.abs(normal[:, 2]) > STEEP
    level = np.column_stack([-normal[:, 1], normal[:, 0], np.zeros(len(normal))])
    along_x = np.where(np.abs(level[:, 0]) > 1e-9, level[:, 0], level[:, 1])
    level *= np.where(along_x < 0.0, -1.0, 1.0)[:, None]
    # What of x lies in a slab's plane and has no y, seen from above.
    x_on_slab = np.column_stack([normal[:, 2], np.zeros(len(normal)), -normal[:, 0]]) * np.sign(
        normal[:, 2:]
    )
    first = np.where(slab[:, None], x_on_slab, level)
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(normal, first)
    upright = np.where(slab, second[:, 1], second[:, 2])
    second *= np.where(upright < 0.0, -1.0, 1.0)[:, None]
    return np.stack([first, second, np.cross(first, second)], axis=1)


def _quadratic(barycentric: Array) -> Array:
    """The six shape functions in the mesh's order, shape (m, 6)."""
    a, b, c = barycentric.T
    return np.column_stack(
        [a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a]
    )


def _fault(number: int, point: Array, expected: str) -> Fault:
    return Fault("section forces", f"points[{number}]", place(point), f"expected {expected}")
