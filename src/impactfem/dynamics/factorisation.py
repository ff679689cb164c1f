"""A symmetric matrix, factorised once and solved with many times."""

from __future__ import annotations

import ctypes
from abc import ABC, abstractmethod
from typing import Any, Self

import numpy as np
import scipy.sparse
from petsc4py import PETSc

from impactfem.dynamics.columns import random_column, row_of_largest, wrapped
from impactfem.system.arrays import Array
from impactfem.system.errors import SolutionError
from impactfem.system.memory import give_back
from impactfem.system.parallel import all_blas_threads


class Held(ABC):
    """A context manager that frees what it holds when its block ends."""

    @abstractmethod
    def destroy(self) -> None:
        """Free the memory. Collective."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy()


BLOCK = 32
"""Columns that are solved at once. On one core a column costs 0.15 of a lone solve in blocks of 16,
0.12 in blocks of 32, 0.11 in blocks of 64, and a block takes memory."""

CONDITION = 1e13
"""Condition number of the matrix scaled to a diagonal of ones above which it counts as singular.
A mechanism leaves rounding, some 1e-16 to 1e-14, where its pivot should be zero."""

_PREFIX = "impactfem_"
# The ordering stays MUMPS's own choice: PORD for a large matrix, whose factor on buildings has no
# more entries, and up to 30 % fewer, than that of minimum degree (AMD, AMF, QAMD) or of nested
# dissection by METIS or SCOTCH, which Debian's MUMPS lacks. PORD ends the program on tiny ones.
_ROOM = (20, 60, 200)
"""Work space beyond MUMPS's estimate in per cent, tried in turn for pivots that are put off."""

_FAILURES = {
    **dict.fromkeys((-5, -7), "not enough memory for the analysis"),
    **dict.fromkeys((-8, -9), "work space too small"),
    **dict.fromkeys((-13, -19), "not enough memory"),
}


class SingularMatrixError(SolutionError):
    """The matrix is singular: the model is a mechanism; `row` is the global row that moves most."""

    def __init__(self, message: str, row: int) -> None:
        super().__init__(message)
        self.row = row

    def __reduce__(self) -> tuple[type[SingularMatrixError], tuple[str, int]]:
        return type(self), (str(self), self.row)


class Factorisation(Held):
    """A = L D Lᵀ by MUMPS, for solving A x = b. A context manager that frees the memory.

    The matrix may be changed or destroyed afterwards. Further MUMPS options can be given in
    the environment, as ``PETSC_OPTIONS="-impactfem_mat_mumps_icntl_14 80"``.

    Args:
        A: Symmetric matrix (AIJ), on any communicator. A block size that PETSc knows (six for
            nodes with six degrees of freedom) makes the analysis faster and the factor smaller.
            Marked as symmetric, and as positive definite or not.
        definite: A is positive definite: Cholesky. Else LDLᵀ with pivoting.
        full_blocks: The blocks of A are full, as those of a stiffness. To be False for a mass: its
            factor then has a fraction of the entries.
        name: What A is, for messages.

    SingularMatrixError where A should be `definite` and is a mechanism; SolutionError where it is
    not definite, has values that are not numbers, or MUMPS failed. Making one, solving and
    `destroy` are collective.
    """

    def __init__(
        self,
        A: PETSc.Mat,
        *,
        definite: bool = True,
        full_blocks: bool = True,
        name: str = "the matrix",
    ) -> None:
        self.definite = definite
        self.name = name
        self._N = int(A.getSize()[0])
        self._rows = A.getSizes()[0]
        self._comm = A.getComm()
        if not np.isfinite(A.norm()):
            raise SolutionError(f"{name} has entries that are not numbers")
        A.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        A.setOption(PETSc.Mat.Option.SPD, definite)
        if definite:
            diagonal = A.getDiagonal()
            bad = np.flatnonzero(diagonal.getArray() <= 0.0) + A.getOwnershipRange()[0]
            diagonal.destroy()
            rows = np.concatenate(self._comm.tompi4py().allgather(bad))
            if rows.size:
                raise SingularMatrixError(
                    f"{name} is not positive definite: {rows.size} of {self._N} diagonal entries"
                    f" are zero or negative, the first in row {rows[0]}",
                    int(rows[0]),
                )
        options = {"icntl_27": BLOCK}  # right-hand sides at once
        if not definite:
            options["icntl_24"] = 1  # null pivots are counted; PETSc gives no inertia without
        if not full_blocks:
            options["icntl_15"] = 0  # analysed entry by entry, not block by block
        self._F = _factor(A, options)
        failed, detail, negative = (self._F.getMumpsInfog(k) for k in (1, 2, 12))
        # MUMPS goes on after a negative pivot; ScaLAPACK, on several ranks, does not.
        if definite and (
            failed in (-10, -40)
            or (failed == 0 and (negative > 0 or _weakest(A, self)[0] > CONDITION))
        ):
            self.destroy()
            A.setOption(PETSc.Mat.Option.SPD, False)
            raise _not_definite(A, name)
        if failed < 0:
            self.destroy()
            why = _FAILURES.get(failed, "see its manual")
            raise SolutionError(
                f"{name} ({self._N} rows) could not be factorised: MUMPS error {failed} ({detail}),"
                f" {why}"
            )

    def destroy(self) -> None:
        """Free the memory; the factorisation is of no use afterwards. Collective."""
        self._F.destroy()
        give_back()

    def solve(self, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve A x = b without allocating; x, not b itself, is filled. Collective."""
        self._F.solve(b, x)

    def solve_block(self, B: Any) -> Array:
        """Solve A X = B for many columns at once, far faster than one by one. Collective.

        B, shape (n_local, k), is an array or of `scipy.sparse`; X has its shape, Fortran order.
        """
        if scipy.sparse.issparse(B):
            B = B.tocsc()
        n, k = B.shape
        X = np.empty((n, k - k % BLOCK + _even(k % BLOCK)), order="F")
        for first in range(0, k, BLOCK):
            part = slice(first, min(first + BLOCK, k))
            given = np.zeros((n, _even(part.stop - first)), order="F")
            block = B[:, part]
            given[:, : block.shape[1]] = block.toarray() if scipy.sparse.issparse(B) else block
            right, left = self._dense(given), self._dense(X[:, first : first + given.shape[1]])
            _unlocked("MatMatSolve", self._F, right, left)
            right.destroy()
            left.destroy()
        return X[:, :k]

    def inertia(self) -> tuple[int, int, int]:
        """Numbers of negative, zero and positive eigenvalues of A, those of D (Sylvester)."""
        if self.definite:
            return 0, 0, self._N
        negative, zero, positive = self._F.getInertia()
        return int(negative), int(zero), int(positive)

    @property
    def entries(self) -> float:
        """Entries of the factor, all ranks together."""
        # MUMPS counts in millions where the number does not fit, and says so by the sign.
        count = float(self._F.getMumpsInfog(29))
        return count if count >= 0.0 else -1e6 * count

    @property
    def operations(self) -> float:
        """Floating-point operations of the elimination, all ranks together."""
        return float(self._F.getMumpsRinfog(3))

    def _dense(self, columns: Array) -> PETSc.Mat:
        size = (self._rows, (None, columns.shape[1]))
        return PETSc.Mat().createDense(size, array=columns, comm=self._comm)


def _even(columns: int) -> int:
    """A number of columns, not less, with which the products of MUMPS's solution are fast."""
    # Seven columns take a tenth longer than eight, and six a third.
    return columns if columns < 3 else max(8, -(-columns // 4) * 4)


def _factor(A: PETSc.Mat, wanted: dict[str, int]) -> PETSc.Mat:
    """Return the factor; check INFOG(1) for success."""
    options = PETSc.Options()
    for room in _ROOM:
        # By the options database: what is set on the factor itself before its first use is lost in
        # PETSc 3.18. What the user has set there stays.
        mine = {f"{_PREFIX}mat_mumps_{k}": v for k, v in {"icntl_14": room, **wanted}.items()}
        mine = {key: value for key, value in mine.items() if not options.hasName(key)}
        pc = PETSc.PC().create(A.getComm())
        try:
            for key, value in mine.items():
                options[key] = value
            pc.setOptionsPrefix(_PREFIX)
            pc.setType("cholesky")
            pc.setFactorSolverType("mumps")
            pc.setOperators(A)
            pc.setFromOptions()
            with all_blas_threads():
                _unlocked("PCSetUp", pc)
            F = pc.getFactorMatrix()
        finally:
            for key in mine:
                options.delValue(key)
            pc.destroy()
        if F.getMumpsInfog(1) not in (-8, -9) or room == _ROOM[-1]:
            break
        F.destroy()
    return F


def _unlocked(function: str, *objects: Any) -> None:
    """Call a function of PETSc without Python's lock, which petsc4py keeps."""
    # With it no other thread would tell how far the run is, answer Ctrl-C, or compute.
    petsc = ctypes.CDLL(PETSc.__file__)  # with the PETSc that it is linked to
    failed = getattr(petsc, function)(*(ctypes.c_void_p(one.handle) for one in objects))
    if failed:
        raise PETSc.Error(failed)


def _weakest(A: PETSc.Mat, factor: Factorisation) -> tuple[float, Array]:
    """Largest eigenvalue in size of S⁻¹, S = D^-½ A D^-½ with D the diagonal of A, and its vector.

    Inverse iteration: where S has an eigenvalue next to zero, one step shows it.
    """
    # The scaling makes translations and rotations, stiff and soft parts comparable.
    diagonal = A.getDiagonal()
    root = np.sqrt(np.abs(diagonal.getArray()))
    diagonal.destroy()
    y = random_column(A)
    comm = A.getComm().tompi4py()
    b, x = np.empty_like(y), np.empty_like(y)
    right, left = wrapped(A, b), wrapped(A, x)
    growth = 0.0
    for _ in range(2):
        y /= np.sqrt(comm.allreduce(float(y @ y)))
        np.multiply(root, y, out=b)
        factor.solve(right, left)
        np.multiply(root, x, out=y)
        growth = float(np.sqrt(comm.allreduce(float(y @ y))))
        if not np.isfinite(growth):
            growth = np.inf
            break
    right.destroy()
    left.destroy()
    return growth, y


def _not_definite(A: PETSc.Mat, name: str) -> SolutionError:
    """Say what is wrong with a matrix that should be positive definite. Collective."""
    # The eigenvalues of D^-½ A D^-½ between -ε and ε are zero but for rounding: the inertias of A +
    # ε D and A - ε D count them, D the diagonal of A.
    epsilon = 1e-10
    diagonal = A.getDiagonal()
    shifted = A.copy()
    shifted.setDiagonal((1.0 + epsilon) * diagonal)
    with Factorisation(shifted, definite=False, name=name) as factor:
        negative = factor.inertia()[0]
        y = _weakest(shifted, factor)[1]
    shifted.setDiagonal((1.0 - epsilon) * diagonal)
    with Factorisation(shifted, definite=False, name=name) as factor:
        zero = factor.inertia()[0] - negative
    shifted.destroy()
    diagonal.destroy()
    row = row_of_largest(A, np.abs(y))
    if zero == 0 and negative > 0:
        return SolutionError(
            f"{name} is not positive definite: it has {negative} negative eigenvalues of"
            f" {A.getSize()[0]}, that nearest to zero with its largest entry in row {row}"
        )
    also = f" and {negative} negative" if negative else ""
    return SingularMatrixError(
        f"{name} is singular: it has {zero}{also} of {A.getSize()[0]} eigenvalues that are zero, so"
        f" the model is a mechanism; row {row} moves most in it",
        row,
    )
