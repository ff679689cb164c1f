"""Linear complementarity with a symmetric positive definite matrix, by active sets.

To find p with

    0 ≤ p ⟂ w = W p + q ≥ 0.

With the set A of the p that are not zero, W_AA p_A = −q_A, and the solution is exact but for the
rounding of that solve. A is found by principal pivoting: all rows of the wrong sign change sides
at once (Júdice and Pires, Comput. Oper. Res. 21 (1994) 587); when that brings no fewer of them,
only the last one does (Murty, Linear Algebra Appl. 7 (1973) 65), which ends after finitely many
steps for any W with positive principal minors. From the set of a similar problem it takes one or
two steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from impactfem.system.arrays import Array
from impactfem.system.errors import SolutionError

Mask = NDArray[np.bool_]

DEPENDENT = 1e-13
"""Pivot tolerance relative to the unit diagonal of the scaled W."""
ROUNDING = 1e-13
"""Negative numbers of this size, over the largest p and q of the scaled problem, count as zero."""
PATIENCE = 5
"""Changes of all wrong rows at once, without fewer of them, before Murty's rule takes over."""
LIMIT = 50
"""Steps per row after which a problem counts as not solved."""


@dataclass(frozen=True, eq=False)
class Complementary:
    """A solution."""

    p: Array  #: p ≥ 0, shape (m,)
    w: Array  #: W p + q, shape (m,); zero where p is not
    active: Mask  #: where p is not zero, shape (m,); starts the next, similar problem


class Complementarity:
    """Problems with one W, solved one after the other. Not collective: each rank has all of W.

    W is symmetric, positive definite, shape (m, m); the name says what it is, for messages.

    Raises:
        SolutionError: W is not square, not finite, not symmetric, or not positive definite.
    """

    def __init__(self, W: Array, *, name: str = "the matrix") -> None:
        W = np.asarray(W, dtype=np.float64)
        if W.ndim != 2 or W.shape[0] != W.shape[1]:
            raise SolutionError(f"{name} of a complementarity problem has the shape {W.shape}")
        if not np.all(np.isfinite(W)):
            raise SolutionError(f"{name} has entries that are not numbers")
        diagonal = np.diagonal(W)
        if np.any(diagonal <= 0.0):
            row = int(np.argmin(diagonal))
            raise SolutionError(
                f"{name} is not positive definite: entry {row} of its diagonal is {diagonal[row]:g}"
            )
        self.name = name
        self.scale = 1.0 / np.sqrt(diagonal)
        scaled = W * self.scale[:, None] * self.scale
        skew = float(np.max(np.abs(scaled - scaled.T), initial=0.0))
        if skew > 1e-8:
            raise SolutionError(
                f"{name} is not symmetric: entries differ from their mirror images by up to"
                f" {skew:.1e} of the diagonal"
            )
        # A copy without the skew rounding: which triangle is read shall not matter.
        self._W: Array = np.asfortranarray(0.5 * (scaled + scaled.T))
        # Every row must have a part that the rows before it have not.
        factor, failed = scipy.linalg.lapack.dpotrf(self._W, lower=True)
        pivots = np.diagonal(factor) ** 2
        small = np.flatnonzero(pivots[: failed - 1 if failed else len(pivots)] < DEPENDENT)
        if failed or small.size:
            row = int(small[0]) if small.size else failed - 1
            raise SolutionError(
                f"{self.name} is not positive definite: row {row} of {len(pivots)} is a combination"
                " of those before it, or they have a negative eigenvalue"
            )
        self._set: Mask = np.zeros(len(W), dtype=np.bool_)
        self._rows = np.flatnonzero(self._set)
        self._factor: Array = np.empty((0, 0))

    def __len__(self) -> int:
        return len(self._W)

    def solve(
        self, q: Array, *, active: Mask | None = None, among: Mask | None = None
    ) -> Complementary:
        """Solve one problem with q of shape (m,).

        A guess of where p is not zero, best `active` of a problem before, changes the time and
        nothing else. Of the rows, those `among` take part, shape (m,): elsewhere p is zero and w of
        any sign.

        Raises:
            SolutionError: q is not finite; the active set is not found, which only rounding can
                cause.
        """
        m = len(self)
        part = np.ones(m, dtype=np.bool_) if among is None else np.asarray(among, dtype=np.bool_)
        A = np.zeros(m, dtype=np.bool_) if active is None else active & part
        q = np.asarray(q, dtype=np.float64)
        if q.shape != (m,) or not np.all(np.isfinite(q)):
            raise SolutionError(f"the right side for {self.name} is not {m} finite numbers")
        q = self.scale * q
        size = float(np.max(np.abs(q), initial=0.0))
        fewest, patience = m + 1, PATIENCE
        for _ in range(LIMIT * (m + 1)):
            p, w = self._try(A, q)
            slack = ROUNDING * (size + float(np.max(np.abs(p), initial=0.0)))
            wrong = np.flatnonzero(part & (np.where(A, p, w) < -slack))
            if wrong.size == 0:
                p = np.maximum(p, 0.0)
                return Complementary(self.scale * p, w / self.scale, A)
            A = A.copy()
            if wrong.size < fewest:
                fewest, patience = wrong.size, PATIENCE
            elif patience > 0:
                patience -= 1
            else:
                wrong = wrong[-1:]
            A[wrong] ^= True
        raise SolutionError(
            f"the active set of a complementarity problem with {m} rows is not found:"
            f" {self.name} is too close to singular"
        )

    def _try(self, A: Mask, q: Array) -> tuple[Array, Array]:
        """The p and w of the scaled problem with the active set A."""
        if not np.array_equal(A, self._set):
            self._rows = np.flatnonzero(A)
            block = np.asfortranarray(self._W[np.ix_(self._rows, self._rows)])
            self._factor, failed = scipy.linalg.lapack.dpotrf(block, overwrite_a=True)
            self._set = A.copy()
            if failed:
                raise SolutionError(f"{self.name} is too close to singular")
        p = np.zeros(len(q))
        if self._rows.size == 0:
            return p, q
        x, _ = scipy.linalg.lapack.dpotrs(self._factor, -q[self._rows])
        p[self._rows] = x
        w = self._W @ p + q
        w[self._rows] = 0.0
        return p, w
