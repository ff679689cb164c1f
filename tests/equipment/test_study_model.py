"""A heavy device on the shipped frame: the reduced study against the full order."""

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from mpi4py import MPI
from scipy.sparse.linalg import splu

from impactfem.building.edge_load import edge_load
from impactfem.building.links import linked
from impactfem.building.model import assemble_building
from impactfem.building.read_parts import read_parts
from impactfem.case import load_case
from impactfem.device.body import Body
from impactfem.device.coupled import coupled
from impactfem.device.damping import Rayleigh
from impactfem.device.interface import MountedDevice
from impactfem.device.mounted import ModalStructure, mounted_response
from impactfem.device.on_springs import on_springs
from impactfem.device.springs import BaseSprings
from impactfem.equipment.rosette import find_rosette
from impactfem.equipment.study_model import Accuracy, StudyModel, study_model

GEOMETRY = Path(__file__).parents[2] / "geometry"
FACTOR, STEP, STEPS = 0.5, 1e-3, 400
POINT = (2.0, 2.2, 6.0)


@pytest.fixture(scope="module")
def frame():
    case = load_case(GEOMETRY / "frame.toml")
    parts, _, _ = read_parts(case, GEOMETRY / "frame.msh")
    return case, parts


@pytest.fixture(scope="module")
def device():
    springs = BaseSprings.of_directions(x=2e7, y=2e7, z=np.inf, rx=2e7, ry=2e7, rz=np.inf)
    return on_springs(
        "pump",
        springs,
        Body.at_height(800.0, 0.6, 60.0, 60.0, 40.0),
        Rayleigh.through(0.02, 10, 60),
    )


@pytest.fixture(scope="module")
def rosette(frame):
    return find_rosette(frame[1].mesh, "pump", POINT, 0.8)


@pytest.fixture(scope="module")
def reduced(frame, rosette) -> StudyModel:
    case, parts = frame
    return study_model(
        assemble_building(MPI.COMM_SELF, parts),
        parts.mesh,
        FACTOR,
        [rosette],
        directions=[1],
        hit=[2],
        eccentricity=0.0,
        wall=((1, 2), 2),
        accuracies=[Accuracy(case.building("F").damping.coefficients, 300.0, 0.002)],
        largest=600,
    )


def loads():
    """An impact on floor 2, and a ground motion along y."""
    t = STEP * np.arange(STEPS + 1)
    force = np.where((t > 0.05) & (t < 0.07), 2e5 * np.sin(np.pi * (t - 0.05) / 0.02), 0.0)
    ground = np.zeros((STEPS + 1, 3))
    ground[:, 1] = np.sin(2 * np.pi * 6 * t) * np.sin(np.pi * t / t[-1])
    return force, ground


def scipy_matrix(matrix):
    indptr, indices, values = matrix.getValuesCSR()
    return sp.csr_matrix((values, indices, indptr), shape=matrix.getSize())


@pytest.fixture(scope="module")
def full(frame, device, rosette):
    """Force on the floor by average acceleration with all degrees of freedom, shape (6, n_t)."""
    case, parts = frame
    building, _ = linked(assemble_building(MPI.COMM_SELF, parts), [rosette.link], parts.mesh.nodes)
    K, M = scipy_matrix(building.stiffness(FACTOR)), scipy_matrix(building.mass)
    n = K.shape[0]
    row = int(building.rows(np.array([rosette.master]))[0])
    S = np.zeros((6, n))
    S[:, row : row + 6] = rosette.carried
    own = coupled(device, "relative")
    m = len(own.M) - 6
    W = sp.bmat([[sp.csr_matrix(S), None], [None, sp.eye(m)]]).tocsr()
    alpha, beta = case.building("F").damping.coefficients

    def whole(of_building, of_device):
        empty = sp.csr_matrix((m, m))
        return (sp.block_diag([of_building, empty]) + W.T @ sp.csr_matrix(of_device) @ W).tocsc()

    K_all, M_all = whole(K, own.K), whole(M, own.M)
    C_all = whole(alpha * M + beta * K, own.C)
    force, ground = loads()
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


def mounted(reduced, device, damping, *, shapes=None):
    force, ground = loads()
    load = np.column_stack([reduced.ground[:, 1], reduced.edges[:, -1]])
    return mounted_response(
        ModalStructure(reduced.eigenvalue, load, *damping),
        [MountedDevice("pump", device, reduced.anchors[0] if shapes is None else shapes)],
        np.column_stack([ground[:, 1], force]),
        ground,
        STEP,
    ).devices[0]


def test_detailed_analysis_against_full_order(frame, reduced, device, full):
    damping = frame[0].building("F").damping.coefficients
    found = mounted(reduced, device, damping).force
    largest = np.abs(full).max(axis=1)
    for c in (0, 1, 2, 3):
        if largest[c] > 1e-3 * largest[:3].max():
            assert np.abs(found[c]).max() == pytest.approx(largest[c], rel=5e-3)
    assert np.abs(found[1] - full[1]).max() < 5e-3 * largest[1]
    # Half of the mass is another device.
    light = np.abs(mounted(reduced, device, (damping[0], damping[1] / 5)).force[1]).max()
    assert abs(light / largest[1] - 1.0) > 0.01


def test_anchors_yield_as_in_full_order(frame, rosette, reduced):
    building, _ = linked(
        assemble_building(MPI.COMM_SELF, frame[1]), [rosette.link], frame[1].mesh.nodes
    )
    K = scipy_matrix(building.stiffness(FACTOR)).tocsc()
    row = int(building.rows(np.array([rosette.master]))[0])
    S = np.zeros((6, K.shape[0]))
    S[:, row : row + 6] = rosette.carried
    exact = S @ splu(K).solve(S.T)
    found = (reduced.anchors[0] / reduced.eigenvalue) @ reduced.anchors[0].T
    assert np.diag(found) == pytest.approx(np.diag(exact), rel=2e-3)
    assert np.all(np.diag(found) <= np.diag(exact) * (1.0 + 1e-9))  # Galerkin is too stiff


def test_wall_of_the_study(reduced, frame):
    """The same experiment as that of the wall's own model."""
    wall = reduced.wall
    assert wall is not None and wall.contact.shape == (len(reduced.eigenvalue), 18)
    z = wall.start(-0.01)
    assert z @ wall.seen[:, -1] == pytest.approx(-0.01)


def test_archive(reduced, tmp_path):
    path = tmp_path / "model.npz"
    reduced.write(path, "key")
    again = StudyModel.read(path, "key")
    assert again is not None and np.array_equal(again.anchors, reduced.anchors)
    assert StudyModel.read(path, "other") is None


def test_total_ground_load(reduced, frame):
    """Rigid-body part of the load: bᵀ b is the effective mass of the modes, below the total."""
    total = assemble_building(MPI.COMM_SELF, frame[1]).total[1, 1]
    effective = reduced.ground[:, 1] @ reduced.ground[:, 1]
    assert 0.8 * total < effective < total
