"""Small matrices by hand, and their way into PETSc."""

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.sparse as sp
from petsc4py import PETSc


@pytest.fixture
def petsc():
    """Make a PETSc matrix (AIJ, one rank) of a dense or sparse one."""
    made = []

    def make(matrix):
        A = sp.csr_matrix(matrix)
        csr = A.indptr, A.indices, A.data
        made.append(PETSc.Mat().createAIJ(A.shape, csr=csr, comm=PETSc.COMM_SELF))
        return made[-1]

    yield make
    for matrix in made:
        matrix.destroy()


@pytest.fixture(scope="session")
def chain():
    """Stiffness of n unit masses in a row, between springs of 1 N/m; free ends on request."""

    def make(n, *, first=True, last=True):
        K = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
        K[0, 0] -= not first
        K[-1, -1] -= not last
        return K

    return make


@dataclass(frozen=True)
class Membrane:
    """A rectangular membrane, held along the side x = 0, in bilinear elements with their mass.

    Dof (ny + 1) i + j is the node i + 1 along x, j along y. K and M are sums of products of those
    of a string each way, so that the eigenvalues are known: those of two strings added.
    """

    K: np.ndarray
    M: np.ndarray
    eigenvalue: np.ndarray
    nx: int
    ny: int

    @property
    def loads(self):
        """Two line loads along the side x = L and one along y = 0, shape (n, 3)."""
        F = np.zeros((len(self.K), 3))
        side = slice(-(self.ny + 1), None)
        F[side, 0] = 1.0
        F[side, 1] = np.linspace(0.0, 1.0, self.ny + 1) ** 2
        F[:: self.ny + 1, 2] = np.linspace(1.0, 3.0, self.nx)
        return F

    def transfer(self, omega, damping, F):
        """Displacements by a dense complex solve at each frequency, shape (n_freq, n, m)."""
        return np.stack([np.linalg.solve(self.dynamic(w, damping), F) for w in omega])

    def dynamic(self, omega, damping):
        """K + iωC − ω²M."""
        C = damping.matrix(self.K, self.M)
        return np.asarray(self.K + 1j * omega * C - omega**2 * self.M)


@pytest.fixture(scope="session")
def membrane():
    """Make a membrane of 1 m x 0.8 m and nx x ny elements, with waves of 20 m/s."""

    def string(n, length, held):
        h = length / n
        ends = np.ones(n + 1)
        ends[[0, -1]] = 0.5
        beside = np.eye(n + 1, k=1) + np.eye(n + 1, k=-1)
        k, m = (2.0 * np.diag(ends) - beside) / h, (4.0 * np.diag(ends) + beside) * h / 6.0
        first = 1 if held else 0
        angle = (np.arange(first, n + 1) - 0.5 * first) * np.pi / n
        values = 6.0 / h**2 * (1.0 - np.cos(angle)) / (2.0 + np.cos(angle))
        return k[first:, first:], m[first:, first:], values

    def make(nx=14, ny=11):
        (kx, mx, x), (ky, my, y) = string(nx, 1.0, True), string(ny, 0.8, False)
        return Membrane(
            K=400.0 * (np.kron(kx, my) + np.kron(mx, ky)),
            M=np.kron(mx, my),
            eigenvalue=400.0 * np.sort(np.add.outer(x, y).ravel()),
            nx=nx,
            ny=ny,
        )

    return make
