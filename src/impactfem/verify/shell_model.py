"""Matrices of a small model of shells and beams as SciPy's, and solves with them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse
import scipy.sparse.linalg
from numpy.typing import NDArray

from impactfem.building.mesh import BuildingMesh
from impactfem.building.parts import BuildingParts
from impactfem.building.section import BeamSection, Sections, ShellSection

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
UX, UY, UZ, RX, RY, RZ = range(6)


@dataclass(frozen=True)
class Material:
    """An elastic material.

    Args:
        E: Young's modulus [Pa].
        nu: Poisson's ratio ν.
        rho: Density ρ [kg/m3].
    """

    E: float
    nu: float
    rho: float = 1.0

    @property
    def G(self) -> float:
        """Shear modulus [Pa]."""
        return self.E / (2.0 * (1.0 + self.nu))


@dataclass(frozen=True, eq=False)
class ShellModel:
    """Matrices of all nodes of a mesh, in their order, six rows for each.

    Args:
        nodes: Coordinates, shape (n, 3) [m].
        K: Stiffness, SciPy CSR, shape (6 n, 6 n).
        M: Mass, SciPy CSR, shape (6 n, 6 n).
    """

    nodes: Array
    K: Any
    M: Any

    def rows(self, here: NDArray[np.bool_], *components: int) -> Ints:
        """Rows of components of some nodes.

        Args:
            here: Whether a node is among them, shape (n,).
            components: UX to RZ; all six when none is given.
        """
        chosen = np.array(components or range(6))
        found: Ints = (6 * np.flatnonzero(here)[:, None] + chosen).ravel()
        return found

    def displacement(self, load: Array, *fixed: Ints) -> Array:
        """Displacement under a load, shape (6 n,).

        Args:
            load: Forces, shape (6 n,) [N, N m].
            fixed: Rows that do not move.
        """
        free = self._free(fixed)
        found = np.zeros(len(load))
        found[free] = _factor(self.K[free][:, free]).solve(load[free])
        return found

    def prescribed(self, values: Array, given: Ints) -> Array:
        """Displacement without loads, given some rows of it, shape (6 n,).

        Args:
            values: Shape (6 n,), of which the given rows count [m, rad].
            given: Their numbers.
        """
        known = np.zeros(len(values))
        known[given] = values[given]
        return known + self.displacement(-self.K @ known, given)

    def frequencies(self, count: int, *fixed: Ints, shift: float = 0.0) -> Array:
        """Lowest frequencies, ascending, shape (count,) [Hz]; below 0 for a negative eigenvalue.

        Args:
            count: How many.
            fixed: Rows that do not move.
            shift: Frequency below the first one that is looked for, as −(2π shift)² where rigid
                motions make K singular [Hz].
        """
        free = self._free(fixed)
        K, M = (matrix[free][:, free] for matrix in (self.K, self.M))
        sigma = -((2.0 * np.pi * shift) ** 2)
        inverse = scipy.sparse.linalg.LinearOperator(K.shape, _factor(K - sigma * M).solve)
        values = scipy.sparse.linalg.eigsh(
            K,
            count,
            M,
            sigma=sigma,
            OPinv=inverse,
            v0=np.ones(len(free)),
            return_eigenvectors=False,
        )
        return np.sort(np.sign(values) * np.sqrt(np.abs(values))) / (2.0 * np.pi)

    def _free(self, fixed: tuple[Ints, ...]) -> Ints:
        free = np.ones(self.K.shape[0], dtype=bool)
        for rows in fixed:
            free[rows] = False
        return np.flatnonzero(free)


def shell_model(
    mesh: BuildingMesh,
    material: Material,
    *thickness: float,
    beam: BeamSection | None = None,
    drilling: float = 1.0,
) -> ShellModel:
    """Assemble shells, and beams if there are, on this process alone.

    Args:
        mesh: The mesh.
        material: Material of all parts.
        thickness: Thickness of each shell part [m].
        beam: Section of the beams.
        drilling: Factor of the drilling stiffness.
    """
    # Only here: the manual is read, and its other benchmarks run, without dolfinx.
    from mpi4py import MPI

    from impactfem.building.model import assemble_building

    sections = Sections(tuple(ShellSection(t) for t in thickness), () if beam is None else (beam,))
    parts = BuildingParts(
        mesh=mesh,
        sections=sections,
        young_modulus=material.E,
        poisson_ratio=material.nu,
        density=material.rho,
        added_mass=np.zeros(len(mesh.triangles)),
        drilling=drilling,
    )
    made = assemble_building(MPI.COMM_SELF, parts)
    rows = (6 * np.argsort(made.nodes)[:, None] + np.arange(6)).ravel()
    stiffness = made.stiffness()
    K, M = (csr(matrix)[rows][:, rows] for matrix in (stiffness, made.mass))
    for matrix in (stiffness, made.fixed, made.storeys, made.mass):
        matrix.destroy()
    return ShellModel(mesh.nodes, K, M)


def csr(matrix: Any) -> Any:
    """A PETSc matrix (AIJ) of this process alone as SciPy's CSR."""
    indptr, indices, values = matrix.getValuesCSR()
    return scipy.sparse.csr_matrix((values, indices, indptr), shape=matrix.getSize())


def _factor(matrix: Any) -> Any:
    """Factors of a symmetric positive definite matrix, ordered as such."""
    return scipy.sparse.linalg.splu(
        matrix.tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
