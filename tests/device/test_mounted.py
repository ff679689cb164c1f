from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from scipy.signal import lsim

from impactfem.coupling.body import reduced_body
from impactfem.coupling.pounding import simulate
from impactfem.device import mounted as module
from impactfem.device.models import from_matrices, on_springs
from impactfem.device.mounted import MountedDevice, mounted_response
from impactfem.device.parts import BaseSprings, Beam, RigidBody
from impactfem.dynamics.damping import Rayleigh
from impactfem.sticks.element import rigid_link
from impactfem.system.errors import ImpactfemError, SolutionError

STEP, SAMPLES = 2e-3, 300
TIME = STEP * np.arange(SAMPLES)
ALPHA, BETA = 0.8, 2e-4
GROUND = np.tile(np.eye(6, 3), (2, 1))
"""Two nodes with six components each; how the ground moves them."""


class Frame:
    """Mass and stiffness of two nodes, and two places where something stands on them."""

    def __init__(self):
        rng = np.random.default_rng(3)
        size = np.tile([1.0, 1.0, 1.0, 0.8, 0.8, 0.8], 2)
        turn = scipy.linalg.expm(0.3 * np.triu(rng.standard_normal((12, 12)), 1))
        self.M = 4000.0 * np.outer(size, size) * (turn @ turn.T)
        shapes = np.linalg.inv(np.linalg.cholesky(self.M)).T @ np.linalg.qr(turn)[0]
        omega = 2.0 * np.pi * np.geomspace(2.0, 60.0, 12)
        self.K = self.M @ shapes * omega**2 @ shapes.T @ self.M
        self.impact = np.zeros(12)
        self.impact[[1, 6]] = 1.0, 0.5
        self.places = [np.zeros((6, 12)), np.zeros((6, 12))]
        self.places[0][:, 6:] = rigid_link(np.array([0.4, -0.3, 0.2]))
        self.places[1][:, :6] = rigid_link(np.array([-0.2, 0.5, 0.0]))
        self.omega2, self.shapes = scipy.linalg.eigh(self.K, self.M)

    @property
    def body(self):
        ports = {str(k): place @ self.shapes for k, place in enumerate(self.places)}
        return reduced_body("frame", self.omega2, Rayleigh(ALPHA, BETA), ports)

    @property
    def loads(self):
        patterns = np.column_stack([-self.M @ GROUND, self.impact])
        return self.shapes.T @ patterns

    def carrying(self, device, *places, name="device"):
        return MountedDevice(name, device, tuple(("frame", str(k)) for k in places))


@pytest.fixture
def frame():
    return Frame()


def excitation():
    """The ground shakes from the first sample on; an impact comes later."""
    ground = np.column_stack([np.cos(2.0 * np.pi * f * TIME) for f in (3.0, 7.0, 11.0)])
    impact = 2e4 * np.where((TIME > 0.1) & (TIME < 0.13), np.sin(np.pi * (TIME - 0.1) / 0.03), 0.0)
    return ground, np.column_stack([ground, impact])


class Pump:
    """A body on six springs, as a device and as the matrices of its node and its anchor."""

    def __init__(self, mass, scale=1.0):
        self.k = scale * np.array([2e7, 1.5e7, 9e7, 3e6, 2.5e6, 4e6])
        self.body = RigidBody.at_height(
            scale * mass, 0.46, scale * 60.0, scale * 70.0, scale * 50.0
        )
        self.law = Rayleigh.through(0.02, 10.0, 40.0)
        springs = BaseSprings(np.diag(self.k), np.zeros(6, dtype=bool))
        self.device = on_springs("pump", springs, self.body, self.law)

    @property
    def damping(self):
        """Between its node and its anchor."""
        return self.law.matrix(np.diag(self.k), self.body.about(np.zeros(3)))

    def put(self, M, C, K, where, base):
        """Add it to the matrices of a model: its node, and its anchor by the rows `where`."""
        own = np.zeros((6, len(M)))
        own[:, base] = np.eye(6)
        x = own - where
        M += own.T @ self.body.about(np.zeros(3)) @ own
        K += x.T @ np.diag(self.k) @ x
        C += x.T @ self.damping @ x
        return x


def exact(M, C, K, load):
    """Displacements, velocities, accelerations under loads straight between samples (n_t, n)."""
    n = len(M)
    A = np.zeros((2 * n, 2 * n))
    A[:n, n:] = np.eye(n)
    A[n:] = -np.linalg.solve(M, np.hstack([K, C]))
    inverse = np.vstack([np.zeros((n, n)), np.linalg.inv(M)])
    out = lsim((A, inverse, np.eye(2 * n), np.zeros((2 * n, n))), load, TIME)[1]
    u, v = out[:, :n], out[:, n:]
    return u, v, np.linalg.solve(M, (load - v @ C.T - u @ K.T).T).T


def three_devices(frame):
    """The model of the frame, two pumps and a mass held by both anchors, put together at once.

    The pumps make up more than half of the whole mass.
    """
    n = 12 + 6 + 6 + 1
    M, C, K = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    M[:12, :12], K[:12, :12] = frame.M, frame.K
    C[:12, :12] = ALPHA * frame.M + BETA * frame.K
    at = [np.hstack([place, np.zeros((6, 13))]) for place in frame.places]
    first, other = Pump(3000.0), Pump(2500.0)
    x1 = first.put(M, C, K, at[0], slice(12, 18))
    x2 = other.put(M, C, K, at[1], slice(18, 24))
    m, k = 200.0, np.array([4e6, 7e6])
    own = np.eye(n)[24]
    pulls = [own - place[1] for place in at]
    M += m * np.outer(own, own)
    for stiffness, pull in zip(k, pulls, strict=True):
        K += stiffness * np.outer(pull, pull)
    x3 = own - (k[0] * at[0][1] + k[1] * at[1][1]) / k.sum()
    c3 = 2.0 * 0.03 * np.sqrt(k.sum() * m)
    C += c3 * np.outer(x3, x3)
    rigid = np.vstack([GROUND, np.tile(np.eye(6, 3), (2, 1)), [[0.0, 1.0, 0.0]]])
    ground, amplitudes = excitation()
    load = -ground @ (M @ rigid).T
    load[:, :12] += np.outer(amplitudes[:, 3], frame.impact)
    u, v, a = exact(M, C, K, load)
    forces = [
        (u @ x1.T) * first.k + v @ x1.T @ first.damping,
        (u @ x2.T) * other.k + v @ x2.T @ other.damping,
    ]
    both = np.zeros((SAMPLES, 12))
    for i, stiffness in enumerate(k):
        both[:, 6 * i + 1] = stiffness * (u @ pulls[i]) + stiffness / k.sum() * c3 * (v @ x3)
    absolute = [a @ place.T + ground @ np.eye(6, 3).T for place in at]
    pair = np.array([[k[0], 0.0, -k[0]], [0.0, k[1], -k[1]], [-k[0], -k[1], k.sum()]])
    held = from_matrices("held", np.diag([0.0, 0.0, m]), pair, {0: 1, 1: 7}, 0.03, anchors=2)
    devices = [
        frame.carrying(first.device, 0, name="first"),
        frame.carrying(other.device, 1, name="other"),
        frame.carrying(held, 0, 1, name="held"),
    ]
    return devices, [*forces, both], [*absolute, np.hstack(absolute)], (u @ x1.T, a, ground)


def apart(found, wanted):
    return np.abs(found - wanted).max() / np.abs(wanted).max()


def coupled_run(frame, devices, substeps=1):
    ground, amplitudes = excitation()
    loads = amplitudes @ frame.loads.T
    return mounted_response([frame.body], devices, loads, ground, STEP, substeps=substeps)


def test_three_heavy_devices_against_the_whole_model(frame):
    devices, forces, accelerations, (x, a, ground) = three_devices(frame)
    counts = (8, 16, 32)
    runs = [coupled_run(frame, devices, substeps) for substeps in counts]
    for k, (F, acceleration) in enumerate(zip(forces, accelerations, strict=True)):
        of_force = [apart(run.devices[k].force, F.T) for run in runs]
        of_motion = [apart(run.devices[k].anchor_acceleration, acceleration.T) for run in runs]
        for errors in (of_force, of_motion):
            assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.02)
            assert errors[-1] < 3e-4
        # Without its error of second order the exact solution is left, to that of fourth order.
        last, before = (run.devices[k].force for run in runs[:0:-1])
        better = (4.0 * last - before) / 3.0
        for part in (slice(0, 3), slice(3, 6)):
            scale = np.abs(F.T[part]).max()
            assert np.abs(better[part] - F.T[part]).max() <= 1e-6 * scale
            assert np.abs(last[part] - F.T[part]).max() >= 1e-5 * scale
    first = runs[-1].devices[0]
    assert apart(first.motion, x.T) < 2e-4
    base = a[:, 12:18].T + np.eye(6, 3) @ ground.T
    assert apart(first.acceleration, base) < 5e-4
    assert first.largest == pytest.approx(np.abs(first.force).max(axis=1))
    # Each sees the others.
    for k in (0, 1):
        alone = coupled_run(frame, devices[k : k + 1], 32).devices[0]
        assert apart(alone.force, runs[-1].devices[k].force) > 0.05


def test_action_reaction_and_energy(frame, monkeypatch):
    devices = three_devices(frame)[0]
    found = coupled_run(frame, devices)
    assert found.time[-1] == pytest.approx(TIME[-1])
    assert found.energy.residual < 1e-12
    assert found.energy.input[-1] > 0.0 and found.energy.damped[-1] > 0.0
    assert all(0.0 <= one.imbalance < 1e-12 for one in found.devices)
    right = module.respond

    def wrong(**changes):
        def run(*arguments, **options):
            result = right(*arguments, **options)
            new = {name: change(getattr(result, name)) for name, change in changes.items()}
            return replace(result, **new)

        return run

    monkeypatch.setattr(module, "respond", wrong(reaction=lambda F: 1.00001 * F))
    with pytest.raises(SolutionError, match="springs differs"):
        coupled_run(frame, devices)
    lost = wrong(energy=lambda energy: replace(energy, damped=0.99999 * energy.damped))
    monkeypatch.setattr(module, "respond", lost)
    with pytest.raises(SolutionError, match="out of balance"):
        coupled_run(frame, devices)


def test_a_body_alone_and_a_stiff_device(frame):
    """A body at the anchor only adds its mass to the structure."""
    pump = Pump(3000.0)
    B, place = pump.body.about(np.zeros(3)), frame.places[0]
    ground, amplitudes = excitation()
    M = frame.M + place.T @ B @ place
    load = np.outer(amplitudes[:, 3], frame.impact) - ground @ (M @ GROUND).T
    a = exact(M, ALPHA * frame.M + BETA * frame.K, frame.K, load)[2]
    motion = place @ a.T + np.eye(6, 3) @ ground.T
    rigid = coupled_run(frame, [frame.carrying(pump.body, 0)], 32).devices[0]
    assert apart(rigid.anchor_acceleration, motion) < 1e-3
    assert apart(rigid.force, -B @ motion) < 1e-3
    assert np.isnan(rigid.imbalance) and rigid.motion.shape == (0, SAMPLES)
    differences = []
    for stiffer in (1.0, 1e3, 1e4):
        springs = BaseSprings(stiffer * np.diag(pump.k), np.zeros(6, dtype=bool))
        stiff = on_springs("stiff", springs, pump.body, 0.02)
        found = coupled_run(frame, [frame.carrying(stiff, 0)], 32).devices[0]
        differences.append(apart(found.force, rigid.force))
    assert differences[0] > 0.1 and differences[2] < 1e-3
    assert differences[1] > 5.0 * differences[2]


def test_motions_without_mass_follow(frame):
    """A beam without mass is exact with one element; more of them have nodes without mass."""
    pump = Pump(3000.0)
    springs = BaseSprings(np.diag(pump.k), np.zeros(6, dtype=bool))
    one, four, soft = (
        coupled_run(
            frame,
            [
                frame.carrying(
                    on_springs(
                        "p", springs, pump.body, pump.law, Beam(0.3, *beam, elements=elements)
                    ),
                    0,
                )
            ],
        ).devices[0]
        for *beam, elements in ((1e6, 2e6, 1), (1e6, 2e6, 4), (5e5, 2e6, 4))
    )
    assert four.motion.shape[0] > one.motion.shape[0]
    assert apart(one.force, four.force) < 1e-8 < apart(soft.force, four.force)


def test_what_diverges_is_refused(frame):
    body = replace(frame.body, eigenvalue=np.append(-8.1e5 * np.ones(1), frame.omega2[1:]))
    ground, amplitudes = excitation()
    device = frame.carrying(Pump(10.0).device, 0)
    with pytest.raises(SolutionError, match="its devices"):
        mounted_response([body], [device], amplitudes @ frame.loads.T, ground, STEP)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"devices": ()}, "at least one mounted device.*got none"),
        ({"devices": (0, 0)}, "a name of its own; got device, device"),
        ({"loads": np.zeros((SAMPLES, 3))}, r"the bodies: expected shape \(samples, 12\)"),
        ({"loads": np.zeros((SAMPLES - 1, 12))}, "as many as the other loads"),
        ({"ground": np.zeros((SAMPLES, 2))}, r"acceleration: expected shape \(samples, 3\)"),
        ({"ground": np.full((SAMPLES, 3), np.nan)}, "acceleration: a value is not a finite number"),
        ({"time_step": 0.0}, r"time step of 0\.0 s in 1 sub-steps"),
        ({"substeps": 0}, "in 0 sub-steps"),
        ({"places": (0, 1)}, "has 6 fixed components, the ports have 12"),
    ],
)
def test_bad_requests_are_refused(frame, change, words):
    device = frame.carrying(Pump(1500.0).device, *change.pop("places", (0,)))
    given = {"devices": (0,), "loads": np.zeros((SAMPLES, 12)), "ground": np.zeros((SAMPLES, 3))}
    given |= {"time_step": STEP} | change
    given["devices"] = [device for _ in given["devices"]]
    with pytest.raises(ImpactfemError, match=words):
        mounted_response([frame.body], **given)


def test_motions_without_mass_are_left_out(pump, altered):
    device = pump(Beam(0.46, 8e7, 8e7))
    found = MountedDevice("d", device).own
    assert np.linalg.matrix_rank(device.M) == found.shape[1] < len(device.motions)
    damped = np.zeros_like(device.M)
    damped[-7, -7] = 1e4
    with pytest.raises(ImpactfemError, match="device d: a damper acts"):
        MountedDevice("d", altered(device, dampers=damped)).mount  # noqa: B018
    # On a motion with mass it may be.
    heavy = pump(Beam(0.46, 8e7, 8e7, mass=45.9))
    modal = MountedDevice("d", altered(heavy, dampers=damped)).mount.C[6:, 6:]
    assert np.abs(modal - np.diag(np.diag(modal))).max() > 1.0


def test_a_stiffness_between_anchors_must_leave_translations_free():
    K = 1e6 * np.array([[1.0, -1.0, 0.0], [-1.0, 3.0, -2.0], [0.0, -2.0, 2.0]])
    device = from_matrices("d", np.diag([0.0, 50.0, 0.0]), K, {0: 1, 2: 7}, 0.02, anchors=2)
    assert MountedDevice("d", device).mount.K[1, 7] == pytest.approx(-2e6 / 3.0)
    K[1, 1] += 1e5
    held = from_matrices("d", np.diag([0.0, 50.0, 0.0]), K, {0: 1, 2: 7}, 0.02, anchors=2)
    with pytest.raises(ImpactfemError, match="resists a translation"):
        MountedDevice("d", held).mount  # noqa: B018


@pytest.mark.parametrize("rank", [20, 3])
def test_against_one_matrix_of_everything(pump, rank):
    """A heavy pump and a body on rows of full rank, and where anchors cannot move in all ways."""
    rng = np.random.default_rng(2)
    eigenvalue = (2.0 * np.pi * np.geomspace(1.5, 4000.0, 20)) ** 2
    rows = 0.02 * rng.standard_normal((12, rank)) @ rng.standard_normal((rank, 20))
    ports = {"p": rows[:6], "q": rows[6:]}
    body = reduced_body("b", eigenvalue, Rayleigh(0.6, 2e-4), ports)
    mass = RigidBody.at_height(700.0, 0.3, 30.0, 40.0, 50.0)
    devices = [
        MountedDevice("pump", pump(z=8e8), (("b", "p"),)),
        MountedDevice("body", mass, (("b", "q"),)),
    ]
    samples, substeps = 60, 3
    ground, loads = rng.standard_normal((samples, 3)), rng.standard_normal((samples, 20))

    def run(count=substeps, factor=1.0):
        return mounted_response(
            [body], devices, factor * loads, factor * ground, STEP, substeps=count
        )

    found = run()
    # The same rule with one matrix of everything: anchors and own modes of both are y = B x.
    mounts = [one.mount for one in devices]
    own = len(mounts[0].M) - 6
    B = np.zeros((12 + own, 20 + own))
    B[:6, :20], B[6 : 6 + own, 20:], B[6 + own :, :20] = rows[:6], np.eye(own), rows[6:]
    M_y, C_y, K_y = (
        scipy.linalg.block_diag(*of)
        for of in zip(*[(one.M, one.C, one.K) for one in mounts], strict=True)
    )
    R = np.vstack([one.ground for one in mounts])
    M, C, K = (B.T @ matrix @ B for matrix in (M_y, C_y, K_y))
    for whole, of_body in ((M, np.ones(20)), (C, 0.6 + 2e-4 * eigenvalue), (K, eigenvalue)):
        whole[:20, :20] += np.diag(of_body)
    h = STEP / substeps
    fine, at = np.linspace(0.0, samples - 1.0, substeps * (samples - 1) + 1), np.arange(samples)
    p, g = (np.column_stack([np.interp(fine, at, q) for q in of.T]) for of in (loads, ground))
    f = np.hstack([p, np.zeros((len(fine), own))]) - g @ (B.T @ M_y @ R).T
    u, v = np.zeros((2, 20 + own))
    a = np.linalg.solve(M, f[0])
    S = M + 0.5 * h * C + 0.25 * h**2 * K
    states = [(u, v, a)]
    for load in f[1:]:
        u, v = u + h * v + 0.25 * h**2 * a, v + 0.5 * h * a
        a = np.linalg.solve(S, load - C @ v - K @ u)
        u, v = u + 0.25 * h**2 * a, v + 0.5 * h * a
        states.append((u, v, a))
    y, w, b = (np.array(of)[::substeps] @ B.T for of in zip(*states, strict=True))
    b = b + ground @ R.T
    F = -(b @ M_y + w @ C_y + y @ K_y)
    for one, first in zip(found.devices, (0, 6 + own), strict=True):
        here = slice(first, first + 6)
        for value, wanted in (
            (one.anchor_displacement, y),
            (one.anchor_velocity, w),
            (one.anchor_acceleration, b),
            (one.force, F),
        ):
            assert np.abs(value.T - wanted[:, here]).max() < 1e-10 * np.abs(wanted).max()
    x = y[:, 6 : 6 + own] @ devices[0].own.T
    assert np.abs(found.devices[0].motion.T - x).max() < 1e-10 * np.abs(x).max()
    assert found.energy.residual < 1e-12
    assert apart(run(substeps - 1).devices[0].force, found.devices[0].force) > 1e-3
    still = run(factor=0.0)
    assert not any(one.force.any() for one in still.devices) and still.energy.residual == 0.0


def test_a_cabinet_on_the_floor_of_a_stick_that_pounds(row, shake):
    """On the link, the floor and its own base at once; the cabinet is data, not code."""
    system, dt = row(0.003), 2.5e-4
    ground = shake(2000, dt)
    bodies = [body for _, body in system.modes]
    loads = ground @ system.assembly.ground.T
    bare = simulate(system, ground, dt)

    def on_roof(device):
        one = MountedDevice("cabinet", device, (("b", "floor 2"),))
        return mounted_response(
            bodies, [one], loads, ground, dt, links=system.assembly.links, substeps=2
        )

    light, heavy = (on_roof(Pump(6e4, scale=s).device) for s in (1e-8, 1.0))
    fine = np.repeat(ground, 2, axis=0)[1:]
    fine[1::2] = 0.5 * (ground[:-1] + ground[1:])
    fine[::2] = ground
    same = simulate(system, fine, dt / 2).force[::2]
    assert bare.force.any() and np.abs(light.link_force - same).max() < 1e-5 * same.max()
    # A heavy one changes the impacts, and its spring force is its inertia force.
    assert np.abs(heavy.link_force - same).max() > 0.05 * same.max()
    assert heavy.devices[0].imbalance < 1e-9 and heavy.energy.residual < 1e-10
