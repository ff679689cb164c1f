"""A pipe between two floors of the shipped frame: all supports coupled, against the full order."""

import numpy as np
import pytest

from impactfem.building.links import BasePlate
from impactfem.coupling.body import reduced_body
from impactfem.device.models import from_matrices, on_springs
from impactfem.device.mounted import MountedDevice, mounted_response
from impactfem.device.parts import BaseSprings, RigidBody
from impactfem.dynamics.damping import Rayleigh
from impactfem.reduction.loads import Loads
from impactfem.spectra import response_spectra
from impactfem.stages.device.analysis import _largest_apart

from .conftest import STEP, full_order, plan_of, reduced_frame, shaken_and_hit

POINTS = np.array([[0.6, 0.7, 3.0], [0.6, 0.7, 6.0]])


def pipe():
    """A vertical beam of four elements with 180 kg between its ends, which are its anchors."""
    count, length, EI, EA, GJ, m = 4, 0.75, 2e6, 4e8, 1e6, 60.0
    n = 6 * (count + 1)
    K, M = np.zeros((n, n)), np.zeros((n, n))
    h, q = length, EI / length**3
    bend = q * np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h * h, -6 * h, 2 * h * h],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h * h, -6 * h, 4 * h * h],
        ]
    )
    turned = np.array([1, -1, 1, -1])  # a rotation about x moves what is above along -y
    spring = np.array([[1, -1], [-1, 1]])
    for e in range(count):
        at = 6 * e
        for rows, block in (
            ([0, 4, 6, 10], bend),
            ([1, 3, 7, 9], bend * np.outer(turned, turned)),
            ([2, 8], EA / h * spring),
            ([5, 11], GJ / h * spring),
        ):
            place = np.ix_([at + r for r in rows], [at + r for r in rows])
            K[place] += block
        masses = 0.5 * m * h * np.array([1, 1, 1, 0.01, 0.01, 0.01])
        for end in (at, at + 6):
            M[range(end, end + 6), range(end, end + 6)] += masses
    anchored = {i: i for i in range(6)} | {n - 6 + i: 6 + i for i in range(6)}
    damping = Rayleigh.through(0.02, 10.0, 60.0)
    return from_matrices("pipe", M, K, anchored, damping, anchors=2)


@pytest.fixture(scope="module")
def base_plates(frame):
    return [BasePlate.find(frame[1].mesh, "pipe", tuple(point), 0.4) for point in POINTS]


@pytest.fixture(scope="module")
def reduced(frame, base_plates):
    mesh = frame[1].mesh
    corner = int(np.argmin(np.linalg.norm(mesh.nodes - [4.0, 0.0, 6.0], axis=1)))
    probes = np.unique([mesh.centres[2], *(plate.master for plate in base_plates), corner])
    points = (corner, int(base_plates[1].followers[0]), int(mesh.base[0]))
    return reduced_frame(frame, plan_of(frame, base_plates, probes=probes, points=points)).complete


def shaking():
    return shaken_and_hit()[1]


def building(reduced, damping):
    ports = {str(k): shapes for k, shapes in enumerate(reduced.anchors)}
    return reduced_body("building", reduced.eigenvalue, damping, ports)


FREQUENCY, RATIO = 14.0, 0.02


def light(mass, height=0.0):
    """A mass above its anchor, against which it can move along y only."""
    k = mass * (2.0 * np.pi * FREQUENCY) ** 2
    springs = BaseSprings.of_directions(**dict.fromkeys(("x", "z", "rx", "ry", "rz"), np.inf), y=k)
    return on_springs("light", springs, RigidBody.at_height(mass, height, 1e-9, 1e-9, 1e-9), RATIO)


def alone(reduced, damping):
    """Acceleration of the anchors without a device, shape (2, 6, n_t)."""
    ground = shaking()
    loads = Loads(STEP, ground, (1,), (), np.zeros((len(ground), 0)), 0.0)
    found = reduced.response(loads, damping)
    motion = reduced.anchors @ found.acceleration
    motion[:, :3] += ground.T
    return motion


def carried(reduced, damping, device, anchors, substeps=8):
    ground = shaking()
    return mounted_response(
        [building(reduced, damping)],
        [MountedDevice(device.name, device, tuple(("building", str(k)) for k in anchors))],
        ground[:, 1:2] @ reduced.ground[:, 1:2].T,
        ground,
        STEP,
        substeps=substeps,
    ).devices[0]


@pytest.fixture(scope="module")
def full(frame, base_plates):
    """Force on both floors with all unknowns, shape (12, n_t)."""
    ground = shaking()[:, 1]
    return full_order(frame, pipe(), base_plates, 0.0 * ground, ground)


def test_detailed_analysis_against_full_order(frame, reduced, full):
    damping = frame[0].building("F").damping.rayleigh
    found = carried(reduced, damping, pipe(), [0, 1], substeps=1)
    largest = np.abs(full).max(axis=1)
    for rows in (slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12)):
        size = largest[rows].max()
        assert np.abs(found.force[rows] - full[rows]).max() < 5e-3 * size
    # Masses sit on the anchors, too: what presses on them without a spring is known.
    assert found.imbalance < 1e-9
    # Both supports matter: a pipe that hangs at one of them alone is another device.
    assert largest[1] > 0.3 * largest[7] > 0.0


def test_points_move_as_the_rigid_plate_and_the_base_do(reduced, base_plates, frame):
    _, follower, base = reduced.points
    arm = frame[1].mesh.nodes[base_plates[1].followers[0]] - POINTS[1]
    anchor = reduced.anchors[1]
    moved = anchor[:3] + np.cross(anchor[3:].T, arm).T
    assert follower[:3] == pytest.approx(moved, abs=1e-9 * np.abs(moved).max())
    assert follower[3:] == pytest.approx(anchor[3:], abs=1e-12)
    assert not base.any() and np.abs(reduced.points[0]).max() > 0.0


def test_displacements_apart(reduced):
    """A rigid motion of all anchors strains nothing; a shift of one of them does."""
    device, t = pipe(), np.linspace(0.0, 1.0, 5)
    tilt = np.zeros((12, 5))
    tilt[3], tilt[9] = t, t
    tilt[7] = -3.0 * t  # a rotation about x carries the upper anchor along -y
    assert _largest_apart(device, POINTS, tilt) == pytest.approx(np.zeros(12), abs=1e-12)
    tilt[7] += 0.25 * t
    apart = _largest_apart(device, POINTS, tilt)
    assert apart[7] == pytest.approx(0.25) and np.abs(np.delete(apart, 7)).max() < 1e-12


def test_a_light_device_sees_the_translational_spectrum_of_the_floor(reduced, frame):
    """Mass → 0, rotations blocked, at the floor: force over mass is the floor's spectrum."""
    damping = frame[0].building("F").damping.rayleigh
    floor = alone(reduced, damping)[1, 1]
    spectrum = response_spectra(floor, STEP, [FREQUENCY], [RATIO], absolute=False)
    wanted = float(spectrum.psa[0, 0, 0])
    found = carried(reduced, damping, light(1e-3), [1])
    assert found.largest[1] / 1e-3 == pytest.approx(wanted, rel=5e-3)
    assert found.imbalance < 1e-9
    # A heavy one moves the floor; one above it is moved by the floor's rotation, too.
    heavy = carried(reduced, damping, light(3e4), [1])
    assert abs(heavy.largest[1] / 3e4 / wanted - 1.0) > 0.02
    above = carried(reduced, damping, light(1e-3, 1.0), [1])
    assert abs(above.largest[1] / 1e-3 / wanted - 1.0) > 0.01


def test_two_supports_with_one_motion_are_one_support(reduced, frame):
    """A light mass on two springs of half the stiffness, both on the same anchor."""
    damping = frame[0].building("F").damping.rayleigh
    half = 0.5e-3 * (2.0 * np.pi * FREQUENCY) ** 2
    K = half * np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    M = np.diag([0.0, 1e-3, 0.0])
    device = from_matrices("link", M, K, {0: 1, 2: 7}, RATIO, anchors=2)
    both = carried(reduced, damping, device, [1, 1])
    one = carried(reduced, damping, light(1e-3), [1])
    assert both.force[1] == pytest.approx(0.5 * one.force[1], abs=1e-6 * one.largest[1])
    assert both.force[1] == pytest.approx(both.force[7], abs=1e-9 * one.largest[1])
    # On two floors they share unequally, and what holds them apart is between them.
    apart = carried(reduced, damping, device, [0, 1])
    assert np.abs(apart.force[1] - apart.force[7]).max() > 0.1 * one.largest[1]
    assert apart.imbalance < 1e-9
