"""A heavy device on the shipped frame: the reduced study against the full order."""

import numpy as np
import pytest
from mpi4py import MPI
from scipy.sparse.linalg import splu

from impactfem.building.links import linked
from impactfem.building.model import assemble_building
from impactfem.coupling.body import reduced_body
from impactfem.device.mounted import MountedDevice, mounted_response
from impactfem.dynamics.damping import Rayleigh
from impactfem.stages.device.study_model import Accuracy, StudyModel, study_model

from .conftest import FACTOR, STEP, scipy_matrix, shaken_and_hit


@pytest.fixture(scope="module")
def reduced(frame, base_plate) -> StudyModel:
    case, parts = frame
    return study_model(
        assemble_building(MPI.COMM_SELF, parts),
        parts.mesh,
        FACTOR,
        [base_plate],
        directions=[1],
        hit=[2],
        eccentricity=0.0,
        wall=((1, 2), 2, "whole_floor"),
        accuracies=[Accuracy(case.building("F").damping.rayleigh, 300.0, 0.002)],
        largest=600,
    )


def mounted(reduced, device, damping, *, shapes=None):
    force, ground = shaken_and_hit()
    load = np.column_stack([reduced.ground[:, 1], reduced.edges[:, -1]])
    anchor = reduced.anchors[0] if shapes is None else shapes
    return mounted_response(
        [reduced_body("building", reduced.eigenvalue, damping, {"anchor": anchor})],
        [MountedDevice("pump", device, (("building", "anchor"),))],
        np.column_stack([ground[:, 1], force]) @ load.T,
        ground,
        STEP,
    ).devices[0]


def test_detailed_analysis_against_full_order(frame, reduced, device, full):
    damping = frame[0].building("F").damping.rayleigh
    found = mounted(reduced, device, damping).force
    largest = np.abs(full).max(axis=1)
    for c in (0, 1, 2, 3):
        if largest[c] > 1e-3 * largest[:3].max():
            assert np.abs(found[c]).max() == pytest.approx(largest[c], rel=5e-3)
    assert np.abs(found[1] - full[1]).max() < 5e-3 * largest[1]
    # Half of the mass is another device.
    light = np.abs(
        mounted(reduced, device, Rayleigh(damping.alpha, damping.beta / 5)).force[1]
    ).max()
    assert abs(light / largest[1] - 1.0) > 0.01


def test_anchors_yield_as_in_full_order(frame, base_plate, reduced):
    building, _ = linked(
        assemble_building(MPI.COMM_SELF, frame[1]), [base_plate.link], frame[1].mesh.nodes
    )
    K = scipy_matrix(building.stiffness(FACTOR)).tocsc()
    row = int(building.rows(np.array([base_plate.master]))[0])
    S = np.zeros((6, K.shape[0]))
    S[:, row : row + 6] = base_plate.carried
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
    # The device's rigid plate lies in the floor that is held, and moves with it.
    assert wall.uneven < 1e-9


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
