"""Natural modes of a large model: SLEPc, shift-invert on MUMPS, none missed (Sturm)."""

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from petsc4py import PETSc
from slepc4py import SLEPc

from impactfem.dynamics.columns import (
    combined,
    inner,
    product,
    random_column,
    wrapped,
)
from impactfem.dynamics.factorisation import Factorisation
from impactfem.dynamics.orientation import FIELDS, signs
from impactfem.system.arrays import Array
from impactfem.system.errors import SolutionError

ROUNDS = 4
GAP = 1e-5
"""Relative distance of two eigenvalues ω² between which the Sturm count may be taken."""


@dataclass(frozen=True)
class Modes:
    """Modes in ascending frequency, normalised so that φᵀ M φ = 1.

    The sign of a shape is that of :mod:`impactfem.dynamics.orientation`. Modes of equal frequency
    are any basis of their space.
    """

    frequency: Array  #: Natural frequencies, shape (k,) [Hz].
    shapes: Array  #: Rows of this rank of the mode shapes, shape (n_local, k).
    #: ‖φ - ω² K⁻¹ M φ‖_M of each mode, shape (k,) [-]. Some eigenvalue of the matrices is within
    #: this fraction of ω².
    residual: Array


def modes(
    K: PETSc.Mat,
    M: PETSc.Mat,
    count: int,
    *,
    fields: Array | None = None,
    tolerance: float = 1e-10,
) -> Modes:
    """The lowest modes of K φ = ω² M φ. Collective.

    SLEPc's Krylov-Schur iteration on K⁻¹ M finds a few modes more than requested. Then the inertia
    of K - σ M, with σ in a gap above the last wanted mode, counts how many lie below (Sturm). One
    that was missed, as the second of two equal ones can be, is looked for in the space orthogonal
    to those that were found. On one rank the results are the same from run to run.

    Args:
        K: Stiffness, symmetric, positive definite (AIJ).
        M: Mass, symmetric, positive definite (AIJ), on part of the pattern of K.
        count: Number of modes wanted.
        fields: Displacements that give the shapes their signs, shape (n_local, FIELDS); by default
            random numbers by row, which depend on the order of the rows.
        tolerance: Largest residual of a mode (see `Modes`).

    SingularMatrixError where the stiffness is singular: the model is a mechanism. SolutionError
    where it is not positive definite, fewer modes than requested exist or were found, or one that
    is missing could not be found.
    """
    n = int(K.getSize()[0])
    if not 0 < count <= n:
        raise SolutionError(f"{count} modes cannot be computed for {n} degrees of freedom")
    values: Array = np.empty(0)
    shapes: Array = np.empty((K.getLocalSize()[0], 0))
    residual: Array = np.empty(0)
    wanted = min(n, count + 2)
    below = 0
    for turn in range(ROUNDS):
        with Factorisation(K, name="the stiffness matrix") as factor:
            new = _krylov_schur(K, M, factor, wanted - values.size, tolerance, shapes, turn)
            values, shapes, residual = _ritz(M, factor, np.hstack([shapes, new]))
        good = residual <= tolerance
        values, shapes, residual = values[good], shapes[:, good], residual[good]
        if values.size == n:
            below = count
            break
        if values.size <= count:
            wanted += 2
            continue
        place = _gap(values, count)
        below = number_below(K, M, math.sqrt(values[place - 1] * values[place]))
        if below == place:
            break
        wanted = max(wanted, values.size) + max(0, below - place)
    else:
        if values.size < count:
            raise SolutionError(f"only {values.size} of {count} modes could be computed")
        frequency = math.sqrt(values[count - 1]) / (2.0 * math.pi)
        raise SolutionError(
            f"{values.size} modes were computed for {count}, and the Sturm count says {below} up to"
            f" {frequency:.6g} Hz: not all could be found"
        )
    return with_signs(M, values[:count], shapes[:, :count], residual[:count], fields)


def with_signs(
    M: PETSc.Mat, values: Array, shapes: Array, residual: Array, fields: Array | None
) -> Modes:
    """Return the modes of eigenvalues ω², with signs by fields as of `modes`. Collective."""
    if fields is None:
        fields = np.stack([random_column(M, stream) for stream in range(FIELDS)], axis=1)
    Mf = product(M, fields)
    norms = np.sqrt(np.diag(inner(M, fields, Mf)))
    shapes = np.array(shapes * signs(inner(M, shapes, Mf), norms), order="F")
    return Modes(frequency=np.sqrt(values) / (2.0 * np.pi), shapes=shapes, residual=residual)


class _Inverse:
    """Preconditioner of PETSc that applies K⁻¹: one factorisation serves SLEPc, too."""

    def __init__(self, factor: Factorisation) -> None:
        self.factor = factor

    def apply(self, _: PETSc.PC, b: PETSc.Vec, x: PETSc.Vec) -> None:
        self.factor.solve(b, x)


def _krylov_schur(
    K: PETSc.Mat,
    M: PETSc.Mat,
    factor: Factorisation,
    count: int,
    tolerance: float,
    known: Array,
    turn: int,
) -> Array:
    """Vectors of the lowest modes that are orthogonal to the known ones, shape (n_local, j)."""
    n = int(K.getSize()[0])
    count = min(max(count, 1), n - known.shape[1])
    eps = SLEPc.EPS().create(K.getComm())
    eps.setOperators(K, M)
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setType(SLEPc.EPS.Type.KRYLOVSCHUR)
    # Of what was tried on a building this takes the fewest solves, some 4 a mode.
    eps.setDimensions(count, min(n, max(5 * count // 2, count + 15)))
    eps.setTarget(0.0)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    eps.setTolerances(0.1 * tolerance, 500)
    eps.setPurify(False)  # for masses that are singular
    st = eps.getST()
    st.setType(SLEPc.ST.Type.SINVERT)
    st.setMatMode(SLEPc.ST.MatMode.SHELL)
    ksp = st.getKSP()
    ksp.setType(PETSc.KSP.Type.PREONLY)
    pc = ksp.getPC()
    pc.setType(PETSc.PC.Type.PYTHON)
    pc.setPythonContext(_Inverse(factor))
    start = random_column(K, turn)
    first = wrapped(K, start)
    eps.setInitialSpace([first])
    deflated = [wrapped(K, np.ascontiguousarray(known[:, j])) for j in range(known.shape[1])]
    if deflated:
        eps.setDeflationSpace(deflated)
    eps.solve()
    found = min(eps.getConverged(), count)
    x = K.createVecRight()
    vectors = np.empty((K.getLocalSize()[0], found), order="F")
    for j in range(found):
        eps.getEigenpair(j, x)
        vectors[:, j] = x.getArray()
    for item in (eps, pc, ksp, st, x, first, *deflated):
        item.destroy()
    return vectors


def _ritz(M: PETSc.Mat, factor: Factorisation, V: Array) -> tuple[Array, Array, Array]:
    """Eigenvalues ω², M-orthonormal shapes and residuals in the span of columns V."""
    # With Y = K⁻¹ M V, (M V)ᵀ Y q = θ Vᵀ M V q, ω² = 1/θ. Through K⁻¹ the small ω² lose nothing to
    # the large entries of K.
    MV = product(M, V)
    Y = factor.solve_block(MV)
    T, G = inner(M, MV, Y), inner(M, V, MV)
    del MV  # these blocks are a good part of all memory
    theta, Q = scipy.linalg.eigh(0.5 * (T + T.T), 0.5 * (G + G.T))
    theta, Q = theta[::-1], Q[:, ::-1]
    shapes = V @ Q
    Y = Y @ (Q / theta)
    np.subtract(shapes, Y, out=Y)
    squares = np.einsum("ii->i", inner(M, Y, product(M, Y)))
    return 1.0 / theta, shapes, np.sqrt(np.maximum(squares, 0.0))


def _gap(values: Array, count: int) -> int:
    """Return the number of values below the first clear gap with at least `count` below it."""
    ratio = values[count:] / values[count - 1 : -1] - 1.0
    wide = np.flatnonzero(ratio > GAP)
    return count + int(wide[0] if wide.size else np.argmax(ratio))


def number_below(K: PETSc.Mat, M: PETSc.Mat, sigma: float) -> int:
    """Number of eigenvalues ω² below σ [1/s2]: the inertia of K - σ M. Collective."""
    shifted = combined(1.0, K, -sigma, M)
    try:
        with Factorisation(shifted, definite=False, name="K - σ M") as factor:
            return factor.inertia()[0]
    finally:
        shifted.destroy()
