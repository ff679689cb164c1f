"""A heavy device on the shipped frame, and its force by all degrees of freedom in SciPy."""

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from mpi4py import MPI
from scipy.sparse.linalg import splu

from impactfem.building.floor import edge_load
from impactfem.building.from_case import read_parts
from impactfem.building.links import find_base_plate, linked
from impactfem.building.model import assemble_building
from impactfem.case import load_case
from impactfem.device.device import coupled
from impactfem.device.models import on_springs
from impactfem.device.parts import BaseSprings, RigidBody
from impactfem.dynamics.damping import Rayleigh

GEOMETRY = Path(__file__).parents[3] / "geometry"
FACTOR, STEP, STEPS = 0.5, 1e-3, 400
POINT = (2.0, 2.2, 6.0)


@pytest.fixture(scope="session")
def frame():
    case = load_case(GEOMETRY / "frame.toml")
    parts, _, _ = read_parts(case, GEOMETRY / "frame.msh")
    return case, parts


@pytest.fixture(scope="session")
def device():
    springs = BaseSprings.of_directions(x=2e7, y=2e7, z=np.inf, rx=2e7, ry=2e7, rz=np.inf)
    return on_springs(
        "pump",
        springs,
        RigidBody.at_height(800.0, 0.6, 60.0, 60.0, 40.0),
        Rayleigh.through(0.02, 10, 60),
    )


@pytest.fixture(scope="session")
def base_plate(frame):
    return find_base_plate(frame[1].mesh, "pump", POINT, 0.8)


def shaken_and_hit():
    """An impact on floor 2, and a ground motion along y."""
    t = STEP * np.arange(STEPS + 1)
    force = np.where((t > 0.05) & (t < 0.07), 2e5 * np.sin(np.pi * (t - 0.05) / 0.02), 0.0)
    ground = np.zeros((STEPS + 1, 3))
    ground[:, 1] = np.sin(2 * np.pi * 6 * t) * np.sin(np.pi * t / t[-1])
    return force, ground


def scipy_matrix(matrix):
    indptr, indices, values = matrix.getValuesCSR()
    return sp.csr_matrix((values, indices, indptr), shape=matrix.getSize())


@pytest.fixture(scope="session")
def full(frame, device, base_plate):
    """Force on the floor by average acceleration with all degrees of freedom, shape (6, n_t)."""
    case, parts = frame
    building, _ = linked(
        assemble_building(MPI.COMM_SELF, parts), [base_plate.link], parts.mesh.nodes
    )
    K, M = scipy_matrix(building.stiffness(FACTOR)), scipy_matrix(building.mass)
    n = K.shape[0]
    row = int(building.rows(np.array([base_plate.master]))[0])
    S = np.zeros((6, n))
    S[:, row : row + 6] = base_plate.carried
    own = coupled(device, "relative")
    m = len(own.M) - 6
    W = sp.bmat([[sp.csr_matrix(S), None], [None, sp.eye(m)]]).tocsr()
    damping = case.building("F").damping.rayleigh

    def whole(of_building, of_device):
        empty = sp.csr_matrix((m, m))
        return (sp.block_diag([of_building, empty]) + W.T @ sp.csr_matrix(of_device) @ W).tocsc()

    K_all, M_all = whole(K, own.K), whole(M, own.M)
    C_all = whole(damping.matrix(K, M), own.C)
    force, ground = shaken_and_hit()
    edge = edge_load(parts.mesh, 2).vector(building, (0.0, -1.0, 0.0))
    shaken = np.zeros(6 + m)
    shaken[1] = 1.0
    p = np.zeros((STEPS + 1, n + m))
    p[:, :n] = np.outer(force, edge) - np.outer(ground[:, 1], building.ground[:, 1])
    p -= np.outer(ground[:, 1], W.T @ (own.M @ shaken))
    h = STEP
    factor = splu((M_all + 0.5 * h * C_all + 0.25 * h**2 * K_all).tocsc())
    u, v, a = (np.zeros(n + m) for _ in range(3))
    found = np.zeros((6, STEPS + 1))
    for k in range(1, STEPS + 1):
        u, v = u + h * v + 0.25 * h**2 * a, v + 0.5 * h * a
        a = factor.solve(p[k] - C_all @ v - K_all @ u)
        u, v = u + 0.25 * h**2 * a, v + 0.5 * h * a
        y = W @ a
        y[1] += ground[k, 1]
        found[:, k] = -(own.M @ y)[:6]
    return found
