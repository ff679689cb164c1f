"""The shipped frame on soil with a heavy device: reduced against full order, and clamped."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from mpi4py import MPI

from impactfem.building.links import carried, linked
from impactfem.building.mesh import rigid_body
from impactfem.building.model import assemble_building
from impactfem.dynamics.soil import HalfSpace, raft_mass, soil_of
from impactfem.reduction.loads import Loads
from impactfem.reduction.response import modal_histories, node_response

from .conftest import (
    FACTOR,
    FLOOR,
    STEP,
    average_acceleration,
    plan_of,
    reduced_frame,
    scipy_matrix,
    shaken_and_hit,
)


def half_space(speed):
    components, curves = HalfSpace(speed, 2000.0, 0.3).rectangle(8.0, 6.0)
    return soil_of(components, raft_mass(6e4, 0.5, (3.0, 5.3)), curves)


@pytest.fixture(scope="module")
def whole(frame, base_plate):
    return reduced_frame(frame, plan_of(frame, [base_plate], directions=tuple(range(6))))


@pytest.fixture(scope="module")
def loads():
    """The first 0.16 s."""
    force, ground = (one[:161] for one in shaken_and_hit())
    return Loads(STEP, ground, (1,), (FLOOR,), force[:, None], 0.0)


def full_order(frame, base_plate, soil, loads, nodes):
    """Absolute accelerations of nodes by sparse matrices of building, raft and soil."""
    case, parts = frame
    damping = case.building("F").damping.rayleigh
    assembled = assemble_building(MPI.COMM_SELF, parts)
    push = FLOOR.vector(assembled, parts.mesh)
    model, T = linked(assembled, [base_plate.link], parts.mesh.nodes)
    K, M = scipy_matrix(model.stiffness(FACTOR)).tocsc(), scipy_matrix(model.mass).tocsc()
    push = carried(T, push[:, None])[:, 0]
    R, MR, k = model.rigid_body(), model.ground, len(soil)
    below = np.zeros((k, k))
    below[:6, :6] = model.total + soil.raft
    border = np.zeros((len(R), k))
    border[:, :6] = MR
    M_all = sp.bmat([[M, border], [border.T, below + soil.M]]).tocsc()
    C_all = sp.block_diag([damping.alpha * M + damping.beta * K, soil.C]).tocsc()
    K_all = sp.block_diag([K, soil.K]).tocsc()
    f = np.zeros((len(loads.ground), len(R) + k))
    f -= loads.ground @ np.hstack([MR[:, :3].T, below[:3]])
    f[:, : len(R)] += np.outer(loads.force[:, 0], push)
    f[:, len(R) : len(R) + 6] += np.outer(loads.force[:, 0], R.T @ push)
    row, found = model.rows(nodes), []
    arms = rigid_body(parts.mesh.nodes[nodes], np.zeros(3)).reshape(-1, 6, 6)[:, :3]
    states = average_acceleration(M_all, C_all, K_all, f)
    for (_, a), ground in zip(states, loads.ground, strict=True):
        own = np.array([a[r : r + 3] for r in row])
        found.append(own + arms @ a[len(R) : len(R) + 6] + ground)
    return np.array(found)


def accelerations(building, loads, damping, nodes):
    history = modal_histories(building.basis, loads, damping, scheme="newmark")
    return node_response(building.basis, history, loads, nodes).acceleration


def test_against_full_order(frame, base_plate, whole, loads):
    """Accelerations of floor and edge within 1 %; a twentieth more speed of the soil is seen."""
    damping = frame[0].building("F").damping.rayleigh
    nodes = np.array([frame[1].mesh.centres[2], frame[1].mesh.edges[2].min()])
    soil = half_space(150.0)
    origin = whole.complete.base
    about = soil.moved(rigid_body(origin[None], np.zeros(3)))
    exact = full_order(frame, base_plate, about, loads, nodes)
    found = accelerations(whole.on(soil), loads, damping, nodes)
    assert np.abs(found - exact).max() < 0.01 * np.abs(exact).max()
    other = accelerations(whole.on(half_space(157.5)), loads, damping, nodes)
    assert np.abs(other - exact).max() > 0.02 * np.abs(exact).max()
    clamped = accelerations(whole, loads, damping, nodes)
    assert np.abs(clamped - exact).max() > 0.1 * np.abs(exact).max()


def test_very_stiff_soil_is_a_clamped_base(frame, whole, loads):
    """Displacements and accelerations to 1e-6 at 1e6 m/s; not at 1e4 m/s."""
    damping = frame[0].building("F").damping.rayleigh

    def response(building):
        history = modal_histories(building.basis, loads, damping)
        return node_response(building.basis, history, loads, whole.basis.nodes)

    def off(speed, name):
        found, exact = (
            getattr(one, name) for one in (response(whole.on(half_space(speed))), response(whole))
        )
        return np.abs(found - exact).max() / np.abs(exact).max()

    assert max(off(1e6, name) for name in ("displacement", "acceleration")) < 1e-6
    assert off(1e4, "displacement") > 1e-6


def test_anchors_move_with_the_base(frame, whole, loads, base_plate):
    """The anchor of the complete model as the plate's node in the basis carries it, on soil."""
    damping = frame[0].building("F").damping.rayleigh
    on_soil = whole.on(half_space(150.0))
    history = on_soil.complete.response(loads, damping)
    anchor = on_soil.complete.shapes()[0] @ history.acceleration
    R = on_soil.complete.anchors_carried[0]
    assert R[:3, :3] == pytest.approx(np.eye(3)) and np.abs(R[:3, 3:]).max() > 1.0
    at = modal_histories(on_soil.basis, loads, damping), loads, np.array([base_plate.master])
    u, θ = (
        node_response(on_soil.basis, *at, rotations=turned).acceleration[:, 0]
        for turned in (False, True)
    )
    expected = np.hstack([u - loads.ground, θ]) @ base_plate.carried.T
    off = np.abs(anchor - expected.T).max(axis=1)
    assert (off < 1e-3 * np.abs(expected).max(axis=0)).all()
    with pytest.raises(KeyError, match="load ground x"):
        few = replace(on_soil.basis, loads=("ground y", *on_soil.basis.loads[1:]))
        modal_histories(few, loads, damping)
