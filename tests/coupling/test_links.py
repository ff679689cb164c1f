"""Bodies, ports and links against one dense matrix of everything."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from impactfem.coupling.body import Port, modal_coordinates, reduced_body
from impactfem.coupling.implicit import Start, respond
from impactfem.coupling.laws import KelvinVoigt
from impactfem.coupling.links import Assembly, Inverse, Link, Mount, Spring
from impactfem.coupling.modal_motion import ModalMotion
from impactfem.coupling.pounding import System, simulate
from impactfem.coupling.unilateral import unilateral_response
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import ImpactfemError, SolutionError

from ..sticks.conftest import damped_stick

DT, STEPS = 1e-3, 400


def newmark(M, C, K, f, dt=DT):
    """Displacements and velocities by average acceleration from rest, in dense matrices."""
    S = M + dt / 2 * C + dt**2 / 4 * K
    u, v = np.zeros((2, *f.shape))
    a = np.linalg.lstsq(M, f[0], rcond=None)[0]
    for t in range(1, len(f)):
        ahead, faster = u[t - 1] + dt * v[t - 1] + dt**2 / 4 * a, v[t - 1] + dt / 2 * a
        a = np.linalg.solve(S, f[t] - C @ faster - K @ ahead)
        u[t], v[t] = ahead + dt**2 / 4 * a, faster + dt / 2 * a
    return u, v


@pytest.fixture
def stick(floors):
    return damped_stick("a", floors(3))


@pytest.fixture
def shaken():
    return np.cumsum(np.random.default_rng(2).standard_normal((STEPS, 3)), axis=0)


def body_of(stick, name="a", **changes):
    """A stick as body with its top as port."""
    (basis, body), *_ = System((stick,), ()).modes
    base = Port(np.zeros((6, stick.n)), np.eye(6))
    return basis, replace(
        body, name=name, ports={"top": body.ports["floor 3"], "base": base}, **changes
    )


def block_on(name):
    """A block of 50 t fixed to the top of a body, with an oscillator of 20 t on it along y."""
    M, C, K = np.diag([5e4, 5e4, 5e4, 1e5, 1e5, 1e5, 1.0]), *np.zeros((2, 7, 7))
    M[1, 6] = M[6, 1] = np.sqrt(2e4)
    M[1, 1] += 2e4
    C[6, 6], K[6, 6] = 2.0, 400.0
    return Mount(((name, "top"),), 6, M, C, K, np.eye(7, 3))


def by_assembly(assembly, ground, **options):
    return respond(assembly, ground @ assembly.ground.T, ground, DT, **options)


def coordinates(motion, assembly):
    u = np.zeros((len(motion.u), len(assembly)))
    u[:, motion.moving] = motion.u
    return u


def test_modal_coordinates_are_exact(floors):
    stick = damped_stick("a", floors(2), storey_points=[(2, 0.3), (1, 0.5)])
    basis, mass, eigenvalue, damping = modal_coordinates(stick.M, stick.C, stick.K)
    size = np.sqrt(np.outer(eigenvalue, eigenvalue))
    assert np.abs(basis.T @ stick.K @ basis - np.diag(eigenvalue)).max() < 1e-10 * size.max()
    assert np.abs(basis.T @ stick.M @ basis - np.diag(mass)).max() < 1e-10
    assert (mass == 0.0).sum() == 12 and damping.modal(eigenvalue).ndim == 1
    # Bending along x and y, and the others, do not mix: what does not move stays exactly zero.
    assert {len(set(np.flatnonzero(column) % 6)) for column in basis.T} == {1, 2}


def test_negative_mass_and_stiffness_are_refused(stick):
    """And not taken for none."""
    for name, what in (("M", "a mass or an inertia is negative"), ("K", "stiffness is indefinite")):
        matrices = {"M": stick.M.copy(), "C": stick.C, "K": stick.K.copy()}
        matrices[name][13, 13] *= -1.0
        with pytest.raises(ImpactfemError, match=what):
            modal_coordinates(*matrices.values())
    first = replace(stick.floors[0], mass=-1e5)
    with pytest.raises(ImpactfemError, match="inertia is negative"):
        _ = System((damped_stick("b", [first, *stick.floors[1:]]),), ()).modes


def test_damping_that_couples_the_modes(floors, shaken):
    stick = damped_stick("a", floors(3))
    stick = replace(stick, damping=None, C=stick.C + np.diag(np.tile([5e5, 0, 0, 0, 0, 0], 3)))
    assert System((stick,), ()).modes[0][1].damping.modal(np.ones(18)).ndim == 2
    response = simulate(System((stick,), ()), shaken, DT)
    f = -shaken @ (stick.M @ stick.rigid_body()[:, :3]).T
    u, v = newmark(stick.M, stick.C, stick.K, f)
    assert np.abs(response.u - u).max() < 1e-9 * np.abs(u).max()
    assert np.abs(response.v - v).max() < 1e-9 * np.abs(v).max()
    assert response.energy.residual < 1e-11


def on_soil(stick):
    """A stick on a free base with springs and dashpots, and its dense matrices."""
    _, body = body_of(stick, free_base=True)
    R, M = stick.rigid_body(), stick.M
    heavy = R.T @ M @ R + np.diag([9e5, 9e5, 9e5, 2e7, 2e7, 2e7])
    body = replace(body, rigid_mass=heavy)
    k, c = np.diag([4e9, 4e9, 6e9, 9e11, 9e11, 1e12]), np.diag([2e7] * 3 + [2e9] * 3)
    k[0, 4] = k[4, 0] = 1e9
    soil = Spring(("a", "base"), None, k, c)
    dense = [
        np.block([[M, M @ R], [R.T @ M, heavy]]),
        scipy.linalg.block_diag(stick.C, c),
        scipy.linalg.block_diag(stick.K, k),
    ]
    return body, soil, dense, R


def test_a_free_base(stick, shaken):
    body, soil, dense, R = on_soil(stick)
    assembly = Assembly([body], springs=[soil])
    motion = by_assembly(assembly, shaken)
    n = stick.n
    f = -shaken @ dense[0][:, n : n + 3].T
    u, _ = newmark(*dense, f)
    z = coordinates(motion, assembly)
    top = z @ assembly.rows(("a", "top")).T
    expected = u[:, n - 6 : n] + u[:, n:] @ R[-6:].T
    assert np.abs(top - expected).max() < 1e-9 * np.abs(expected).max()
    base = z @ assembly.rows(("a", "base")).T
    assert np.abs(base - u[:, n:]).max() < 1e-9 * np.abs(u[:, n:]).max()
    assert motion.energy.residual < 1e-11
    # The soil makes a difference, and its force is the sum of spring and dashpot.
    clamped = Assembly([body_of(stick)[1]])
    stiff = coordinates(by_assembly(clamped, shaken), clamped) @ clamped.rows(("a", "top")).T
    assert np.abs(stiff - top).max() > 0.05 * np.abs(top).max()


@pytest.mark.parametrize("free", [False, True])
def test_contact_of_bodies_on_springs(stick, shaken, free):
    """Contact forces put in as loads of the dense matrices give the same motion."""
    body, soil, dense, R = on_soil(stick)
    if not free:
        body, soil = body_of(stick)[1], Spring(("a", "top"), None, 1e8 * np.eye(6), 1e5 * np.eye(6))
        dense = [stick.M, stick.C.copy(), stick.K.copy()]
        dense[1][-6:, -6:] += soil.damping
        dense[2][-6:, -6:] += soil.stiffness
        R = np.zeros((stick.n, 0))
    along = np.array([0.0, 1.0, 0.0, 0.3, 0.0, 0.0])
    link = Link("wall", ("a", "top"), None, along, 1e-3, KelvinVoigt(5e8, 0.1, mass=2e5))
    assembly = Assembly([body], [link], springs=[soil])
    motion = by_assembly(assembly, shaken)
    n, extra = stick.n, R.shape[1]
    row = np.zeros(n + extra)
    row[n - 6 : n] = along
    row[n:] = along @ R[-6:]
    M = dense[0]
    moved = M[:, n : n + 3] if free else M @ stick.rigid_body()[:, :3]
    u, _ = newmark(*dense, -shaken @ moved.T - np.outer(motion.force[:, 0], row))
    expected = u @ row
    found = coordinates(motion, assembly) @ (along @ assembly.rows(("a", "top")))
    assert motion.force.max() > 0.0
    assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()
    assert np.all(found[motion.force[:, 0] > 0.0] > 1e-3 * (1.0 - 1e-9))
    assert motion.energy.residual < 1e-11 and motion.energy.contact[-1] < 0.0


def test_a_spring_between_two_bodies_and_a_mounted_mass(stick, shaken):
    bodies = [body_of(stick, name)[1] for name in "ab"]
    k, c = np.diag([1e8, 2e8, 3e8, 1e9, 1e9, 1e9]), 1e5 * np.eye(6)
    block = block_on("b")
    M_y, C_y, K_y = block.M, block.C, block.K
    assembly = Assembly(bodies, springs=[Spring(("a", "top"), ("b", "top"), k, c)], mounts=[block])
    motion = by_assembly(assembly, shaken, substeps=1)
    n = stick.n
    B = np.zeros((6, 2 * n))
    B[:, n - 6 : n], B[:, -6:] = np.eye(6), -np.eye(6)
    P = np.zeros((7, 2 * n + 1))
    P[:6, 2 * n - 6 : 2 * n], P[6, -1] = np.eye(6), 1.0
    dense = []
    for own, attached in ((stick.M, M_y), (stick.C, C_y), (stick.K, K_y)):
        dense.append(scipy.linalg.block_diag(own, own, 0.0) + P.T @ attached @ P)
    dense[1][:-1, :-1] += B.T @ c @ B
    dense[2][:-1, :-1] += B.T @ k @ B
    moved = np.vstack([stick.M @ stick.rigid_body()[:, :3]] * 2 + [np.zeros((1, 3))])
    moved += P.T @ M_y @ np.eye(7, 3)
    u, v = newmark(*dense, -shaken @ moved.T)
    ((fixed, own),) = assembly.attached.mounts
    found = motion.displacement[:, [*fixed, *own]]
    expected = u @ P.T
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
    assert np.abs(motion.velocity[:, own[0]] - v[:, -1]).max() < 1e-9 * np.abs(v[:, -1]).max()
    # Its force on the floor is that of its inertia.
    a = motion.acceleration[:, [*fixed, *own]] + shaken @ np.eye(7, 3).T
    F = -a @ M_y[:6].T
    assert np.abs(motion.reaction[:, fixed] - F).max() < 1e-9 * np.abs(F).max()
    assert motion.energy.residual < 1e-11
    # Sub-steps of a straight load are the same steps.
    fine = np.repeat(shaken, 2, axis=0)[1:]
    fine[::2], fine[1::2] = shaken, 0.5 * (shaken[:-1] + shaken[1:])
    half = respond(assembly, fine @ assembly.ground.T, fine, DT / 2)
    sub = by_assembly(
        assembly, shaken, substeps=2, start=Start(recorded=np.zeros(0, dtype=np.int64))
    )
    assert np.abs(sub.reaction - half.reaction[::2]).max() < 1e-9 * np.abs(half.reaction).max()
    assert not sub.u.size


@pytest.mark.parametrize("theta", [0.5, 0.7])
def test_unilateral_links_of_a_body_on_soil(stick, theta):
    """Thrown against walls: complementary, behind them nowhere, energies in balance."""
    body, soil, *_ = on_soil(stick)
    links = [
        Link(str(k), ("a", port), None, np.eye(6)[1], 1e-3)
        for k, port in enumerate(("top", "base"))
    ]
    assembly = Assembly([body], links, springs=[soil])
    motion = ModalMotion(assembly, DT, theta=theta)
    v0 = np.zeros(len(assembly))
    v0[-5] = 0.5 * np.sqrt(body.rigid_mass[1, 1])
    history = unilateral_response(motion, assembly.gaps, 300, velocity=v0)
    assert history.impulse.max(axis=0).min() > 0.0
    assert history.residual.max() < 1e-9 and history.energy.residual < 1e-11
    assert history.energy.gained < 1e-12
    # Free motion of it is that of the implicit loop.
    free = Assembly([body], springs=[soil])
    z = respond(free, np.zeros((100, len(free))), np.zeros((100, 3)), DT, start=Start(v=v0))
    far = unilateral_response(ModalMotion(assembly, DT), 10.0, 99, velocity=v0)
    tops = coordinates(z, free) @ free.rows(("a", "top"))[1]
    assert np.abs(10.0 - far.gap[:, 0] - tops).max() < 1e-9 * np.abs(tops).max()


def test_the_ground_shakes_what_is_mounted_before_a_wall(stick, shaken):
    """Without contact the unilateral loop moves a stick and a mass on it as the implicit one."""
    body, block = body_of(stick)[1], block_on("a")
    wall = Assembly([body], [Link("1", ("a", "top"), None, np.eye(6)[1], 10.0)], mounts=[block])
    free = Assembly([body], mounts=[block])
    motion = ModalMotion(
        wall, DT, load=wall.ground, push=wall.attached.push, probes=wall.rows(("a", "top"))[:2].T
    )
    history = unilateral_response(motion, wall.gaps, STEPS - 1, amplitudes=shaken)
    found = by_assembly(free, shaken)
    tops = coordinates(found, free) @ free.rows(("a", "top"))[:2].T
    assert not history.impulse.any()
    assert np.abs(history.displacement - tops).max() < 1e-9 * np.abs(tops).max()
    assert history.energy.residual < 1e-11
    # The ground on the mass itself makes a difference.
    still = ModalMotion(wall, DT, load=wall.ground)
    other = unilateral_response(still, wall.gaps, STEPS - 1, amplitudes=shaken)
    assert np.abs(other.gap - history.gap).max() > 1e-3 * np.abs(tops).max()


def test_the_inverse_is_the_inverse(stick):
    body, soil, *_ = on_soil(stick)
    assembly = Assembly([body], springs=[soil])
    one, s, r = assembly.attached, 2e-3, len(assembly)
    B = one.rows
    whole = np.diag(assembly.mass + s * assembly.damping + s**2 * assembly.eigenvalue)
    whole += B.T @ (one.M + s * one.C + s**2 * one.K) @ B
    b = np.random.default_rng(1).standard_normal(r)
    z, y, _ = Inverse(assembly, s).solve(b, np.zeros(len(one.M)))
    assert z == pytest.approx(np.linalg.solve(whole, b), rel=1e-9, abs=1e-12 * np.abs(z).max())
    assert y == pytest.approx(B @ z, rel=1e-9, abs=1e-12 * np.abs(y).max())


def test_what_is_refused(stick):
    _, body = body_of(stick)
    with pytest.raises(ImpactfemError, match="no port 'roof'"):
        Assembly([body], [Link("1", ("a", "roof"), None, np.eye(6)[1])])
    with pytest.raises(ImpactfemError, match="no body 'c'; there"):
        Assembly([body], springs=[Spring(("c", "top"), None, np.eye(6), np.eye(6))])
    with pytest.raises(ImpactfemError, match="unique name for"):
        Assembly([body, body])
    with pytest.raises(ImpactfemError, match=r"roof of shape \(2, 3\)"):
        replace(body, ports={"roof": Port(np.zeros((2, 3)), np.zeros((2, 6)))})
    infinite = replace(body.ports["top"], shapes=np.full((6, 18), np.inf))
    with pytest.raises(ImpactfemError, match=r"port top .* finite"):
        replace(body, ports={"top": infinite})
    with pytest.raises(ImpactfemError, match=r"eigenvalue .* finite values"):
        replace(body, eigenvalue=np.nan * body.eigenvalue)
    with pytest.raises(ImpactfemError, match=r"participation of shape \(17, 6\)"):
        replace(body, participation=body.participation[1:])
    with pytest.raises(ImpactfemError, match=r"mass of shape \(17,\)"):
        replace(body, mass=np.ones(17))
    with pytest.raises(ImpactfemError, match="needs a positive definite"):
        replace(body, rigid_mass=np.zeros((6, 6)), free_base=True)
    # A matrix of six components at a port of three is not taken for one with own coordinates.
    small = Port(np.zeros((3, 18)), np.zeros((3, 6)))
    two = replace(body, ports={**body.ports, "small": small})
    with pytest.raises(ImpactfemError, match=r"stiffness .* ground: .*\(3, 3\)"):
        Assembly([two], springs=[Spring(("a", "small"), None, np.eye(6), np.eye(6))])
    with pytest.raises(ImpactfemError, match=r"damping .*: .*\(6, 6\).* got \(3, 3\)"):
        Assembly([two], springs=[Spring(("a", "top"), ("a", "base"), np.eye(6), np.eye(3))])
    with pytest.raises(ImpactfemError, match="6 components, the other"):
        Assembly([two], springs=[Spring(("a", "top"), ("a", "small"), np.eye(6), np.eye(6))])
    with pytest.raises(ImpactfemError, match=r"direction .*: .*\(6,\).* got \(3,\)"):
        Assembly([two], [Link("1", ("a", "top"), None, np.eye(3)[1])])
    walls = Assembly([body], [Link("1", ("a", "top"), None, np.eye(6)[1], 1.0)])
    with pytest.raises(SolutionError, match="unilateral constraint needs"):
        by_assembly(walls, np.zeros((3, 3)))
    law = KelvinVoigt(1e9, 0.1, mass=1e3)
    closed = Assembly([body], [Link("wall", ("a", "top"), None, np.eye(6)[1], -1.0, law)])
    with pytest.raises(SolutionError, match="pair wall penetrates"):
        by_assembly(closed, np.zeros((3, 3)))


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("wrong", [False, True])
def test_a_body_and_its_mirror_image(smooth, wrong):
    """With twice the gap, and a law half as stiff: every history of the body before a wall.

    Both move towards the middle by the loads of the one; four of the ten rows touch.
    """
    rng = np.random.default_rng(5)
    r, m, gap, steps = 10, 4, 2e-3, 600
    eigenvalue = np.sort(rng.uniform(20.0, 4e4, r))
    shapes, damping = rng.standard_normal((m, r)), Rayleigh(0.5, 1e-5)
    load = np.cumsum(rng.standard_normal((steps + 1, r)), axis=0)
    start = np.linalg.lstsq(shapes, np.ones(m), rcond=None)[0]

    def assembly(pair):
        law = KelvinVoigt((0.5 if pair else 1.0) * 1e6, 0.1, mass=(0.5 if pair else 1.0) * 10.0)
        names = ("a", "b") if pair else ("a",)
        bodies = [reduced_body(name, eigenvalue, damping, {"edge": shapes}) for name in names]
        other = ("b", "edge") if pair else None
        g = (2.1 if wrong else 2.0) * gap if pair else gap
        # The rows of the image move the other way: n · (u_b - u_a) with u_b = -u of the image.
        links = [
            Link(str(k), ("a", "edge"), other, n, g, law if smooth else None)
            for k, n in enumerate(np.eye(m))
        ]
        return Assembly(bodies, links)

    found = []
    for pair in (False, True):
        one = assembly(pair)
        loads, v0 = (np.concatenate([x, -x], axis=-1) if pair else x for x in (load, start))
        if smooth:
            motion = respond(one, loads, np.zeros((steps + 1, 3)), DT, start=Start(v=v0))
            found.append((coordinates(motion, one), motion.force))
        else:
            motion = ModalMotion(one, DT, load=np.eye(len(one)), probes=np.eye(len(one)))
            history = unilateral_response(motion, one.gaps, steps, velocity=v0, amplitudes=loads)
            assert history.residual.max() < 1e-10 and history.energy.residual < 1e-10
            found.append((history.displacement, history.force))
    (u, force), (both, pushes) = found
    assert np.count_nonzero(force.max(axis=0)) == m
    apart = max(
        np.abs(both[:, :r] - u).max() / np.abs(u).max(),
        np.abs(both[:, r:] + u).max() / np.abs(u).max(),
        np.abs(pushes - force).max() / np.abs(force).max(),
    )
    assert (apart > 1e-3) if wrong else (apart < 1e-8)
