"""A heavy device on the shipped frame, and its force by all degrees of freedom in SciPy."""

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from mpi4py import MPI
from scipy.sparse.linalg import splu

from impactfem.building.floor import edge_load
from impactfem.building.from_case import read_parts
from impactfem.building.links import BasePlate, linked
from impactfem.building.model import assemble_building
from impactfem.case import load_case
from impactfem.device.device import coupled
from impactfem.device.models import on_springs
from impactfem.device.parts import BaseSprings, RigidBody
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.edge_force import EdgeForce
from impactfem.reduction.reduced_basis import Accuracy
from impactfem.reduction.reduced_building import ReductionPlan, reduce_building
from one_building import building_of

GEOMETRY = Path(__file__).parents[3] / "geometry"
FACTOR, STEP, STEPS = 0.5, 1e-3, 400
POINT = (2.0, 2.2, 6.0)
FLOOR = EdgeForce("floor 2", 2, (0.0, -1.0, 0.0))


@pytest.fixture(scope="session")
def frame():
    case = load_case(GEOMETRY / "frame.toml")
    parts, _ = read_parts(building_of(case), GEOMETRY / "frame.msh")
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
    return BasePlate.find(frame[1].mesh, "pump", POINT, 0.8)


def shaken_and_hit():
    """An impact on floor 2, and a ground motion along y."""
    t = STEP * np.arange(STEPS + 1)
    force = np.where((t > 0.05) & (t < 0.07), 2e5 * np.sin(np.pi * (t - 0.05) / 0.02), 0.0)
    ground = np.zeros((STEPS + 1, 3))
    ground[:, 1] = np.sin(2 * np.pi * 6 * t) * np.sin(np.pi * t / t[-1])
    return force, ground


def plan_of(frame, base_plates, **changes):
    """What the frame is reduced for: a motion along y, a push of floor 2, and its base plates."""
    case, parts = frame
    mesh = parts.mesh
    masters = [one.master for one in base_plates]
    asked = {
        "probes": np.unique([*masters, mesh.centres[2], mesh.edges[2].min()]),
        "accuracies": (Accuracy(case.building("F").damping.rayleigh, 300.0, 0.002),),
        "directions": (1,),
        "edges": (FLOOR,),
        "base_plates": tuple(base_plates),
        "largest": 600,
    }
    asked |= changes
    return ReductionPlan(nodes=asked["probes"], **asked)


def reduced_frame(frame, plan):
    parts = frame[1]
    return reduce_building(assemble_building(MPI.COMM_SELF, parts), parts.mesh, FACTOR, plan)


def scipy_matrix(matrix):
    indptr, indices, values = matrix.getValuesCSR()
    return sp.csr_matrix((values, indices, indptr), shape=matrix.getSize())


def average_acceleration(M, C, K, loads):
    """Displacement and acceleration from rest after each of the loads, by sparse matrices."""
    h = STEP
    factor = splu((M + 0.5 * h * C + 0.25 * h**2 * K).tocsc())
    u, v, a = np.zeros((3, loads.shape[1]))
    for load in loads:
        u, v = u + h * v + 0.25 * h**2 * a, v + 0.5 * h * a
        a = factor.solve(load - C @ v - K @ u)
        u, v = u + 0.25 * h**2 * a, v + 0.5 * h * a
        yield u, a


def full_order(frame, device, base_plates, force, ground):
    """Force on the floors by average acceleration with all degrees of freedom, shape (6 p, n_t).

    Args:
        force: On the edge of floor 2, shape (n_t,) [N].
        ground: Acceleration along y, shape (n_t,) [m/s2].
    """
    case, parts = frame
    links = [one.link for one in base_plates]
    building, _ = linked(assemble_building(MPI.COMM_SELF, parts), links, parts.mesh.nodes)
    K, M = scipy_matrix(building.stiffness(FACTOR)), scipy_matrix(building.mass)
    n, p6 = K.shape[0], 6 * len(base_plates)
    M_own, C_own, K_own = coupled(device)
    S = np.zeros((p6, n))
    for k, one in enumerate(base_plates):
        row = int(building.rows(np.array([one.master]))[0])
        S[6 * k : 6 * k + 6, row : row + 6] = one.carried
    m = len(M_own) - p6
    W = sp.bmat([[sp.csr_matrix(S), None], [None, sp.eye(m)]]).tocsr()
    damping = case.building("F").damping.rayleigh

    def whole(of_building, of_device):
        empty = sp.csr_matrix((m, m))
        return (sp.block_diag([of_building, empty]) + W.T @ sp.csr_matrix(of_device) @ W).tocsc()

    K_all, M_all = whole(K, K_own), whole(M, M_own)
    C_all = whole(damping.matrix(K, M), C_own)
    edge = edge_load(parts.mesh, 2).vector(building, (0.0, -1.0, 0.0))
    shaken = np.zeros(p6 + m)
    shaken[1:p6:6] = 1.0
    p = np.zeros((len(ground), n + m))
    p[:, :n] = np.outer(force, edge) - np.outer(ground, building.ground[:, 1])
    p -= np.outer(ground, W.T @ (M_own @ shaken))
    # What the device does to the floors: inertia and the stiffness between its supports.
    states = zip(average_acceleration(M_all, C_all, K_all, p), ground, strict=True)
    found = [-M_own @ (W @ a + now * shaken) - K_own @ (W @ u) for (u, a), now in states]
    return np.array(found).T[:p6]


@pytest.fixture(scope="session")
def full(frame, device, base_plate):
    """Force of the pump on its floor that is shaken and hit."""
    force, ground = shaken_and_hit()
    return full_order(frame, device, [base_plate], force, ground[:, 1])
