"""Energies of simple fields on flat panels anywhere in space, against closed forms."""

import math

import numpy as np
import pytest

from impactfem.building.mesh import Part
from impactfem.building.section import ShellSection

E, NU, RHO = 33e9, 0.2, 2500.0
MU = E / (2.0 * (1.0 + NU))
T, A, B = 0.4, 3.0, 2.0
AREA = A * B


@pytest.fixture
def slab(panels, turn, assembled):
    """A turned plate of 3 m by 2 m, and its local coordinates."""

    panels.panel((0, 0, 0), (A, 0, 0), (0, B, 0), (3, 2), Part("floor", 1), T)

    def make(**options):
        model = assembled(panels.parts(turn=turn, **options))
        return model, np.array(panels.points)[model.nodes]

    return make


@pytest.fixture
def triangle(panels, turn, assembled):
    """A skew, turned triangle of some thickness, and its local coordinates."""

    def make(thickness, order=(0, 1, 2)):
        corners = np.array([[0.0, 0.0, 0.0], [1.7, 0.2, 0.0], [0.6, 0.9, 0.0]])[list(order)]
        mids = 0.5 * (corners + np.roll(corners, -1, axis=0))
        panels.points.clear()
        panels.points.extend(np.vstack([corners, mids]))
        panels.triangles[:], panels.triangle_parts[:] = [list(range(6))], [Part("floor", 1)]
        panels.sections[Part("floor", 1)] = ShellSection(thickness)
        model = assembled(panels.parts(turn=turn))
        return model, np.array(panels.points)[model.nodes]

    return make


def turned(turn, u, theta):
    """Degrees of freedom of a field given in the plate's frame, shapes (n, 3)."""
    return np.hstack([u @ turn.T, theta @ turn.T]).ravel()


def stress_energy(strain, factor):
    """½ factor D(ε):ε for the plane stress stiffness D."""
    e11, e22, e12 = strain
    return (
        0.5
        * factor
        * E
        / (1.0 - NU**2)
        * ((1.0 - NU) * (e11**2 + e22**2 + 2.0 * e12**2) + NU * (e11 + e22) ** 2)
    )


def zeros(x):
    return np.zeros((len(x), 3))


def stretch(x):
    u = zeros(x)
    u[:, 0] = 2e-3 * x[:, 0] + 1e-3 * x[:, 1]
    u[:, 1] = 1e-3 * x[:, 0] - 3e-3 * x[:, 1]
    return u, zeros(x), AREA * stress_energy((2e-3, -3e-3, 1e-3), T)


def bend(x):
    """w = −½ (k1 x² + k2 y²) − k12 x y; the normal turns with the surface, so shear is none."""
    k1, k2, k12 = 1e-3, -2e-3, 0.7e-3
    u, theta = zeros(x), zeros(x)
    u[:, 2] = -0.5 * (k1 * x[:, 0] ** 2 + k2 * x[:, 1] ** 2) - k12 * x[:, 0] * x[:, 1]
    theta[:, 0] = -(k2 * x[:, 1] + k12 * x[:, 0])
    theta[:, 1] = k1 * x[:, 0] + k12 * x[:, 1]
    return u, theta, AREA * stress_energy((k1, k2, k12), T**3 / 12.0)


def drill(x):
    theta = zeros(x)
    theta[:, 2] = 1e-3
    return zeros(x), theta, 0.5 * AREA * MU * T * 1e-6


@pytest.mark.parametrize("drilling", [0.0, 0.1, 1.0, 2.0])
def test_energy(slab, turn, csr, drilling):
    """The drilling factor acts on drilling alone."""
    model, x = slab(drilling=drilling)
    for field, factor in ((stretch, 1.0), (bend, 1.0), (drill, drilling)):
        u, theta, expected = field(x)
        w = turned(turn, u, theta)
        energy = 0.5 * w @ csr(model.stiffness()) @ w
        assert energy == pytest.approx(factor * expected, rel=1e-11, abs=1e-12)


QUADRATIC = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
"""Powers of x and y."""


def values(coefficients, x, y, dx=0, dy=0):
    """A derivative of Σ c x^p y^q."""
    return sum(
        c * math.perm(p, dx) * math.perm(q, dy) * x ** max(p - dx, 0) * y ** max(q - dy, 0)
        for c, (p, q) in zip(coefficients, QUADRATIC, strict=True)
    )


def rule(corners):
    """Points and weights on a triangle, exact to degree 9."""
    nodes, weights = np.polynomial.legendre.leggauss(6)
    r, s = (0.5 * (a + 1.0) for a in np.meshgrid(nodes, nodes))
    area = np.linalg.det(np.column_stack([corners[1] - corners[0], corners[2] - corners[0]]))
    bary = np.stack([(1 - r), r * (1 - s), r * s], axis=-1).reshape(-1, 3)
    return bary, bary @ corners, (np.multiply.outer(weights, weights) * r).ravel() * abs(area) / 4


def bending_energy(k11, k22, k12, weights, thickness):
    """∫ ½ D(κ):κ t³/12."""
    return sum(
        w * stress_energy(k, thickness**3 / 12.0)
        for w, *k in zip(weights, k11, k22, k12, strict=True)
    )


def energy_of_bending_and_shear(corners, w, b1, b2, thickness):
    """Energy of quadratic w and β on a triangle, from the definitions.

    Rγ by its eight moments: the fields (1, x, y)² and (y, −x) times x and y.
    """
    bary, points, weights = rule(corners)
    x, y = points.T

    def shear(x, y):
        return np.array(
            [values(w, x, y, 1) + values(b1, x, y), values(w, x, y, 0, 1) + values(b2, x, y)]
        )

    def fields(x, y):
        one, none = np.ones_like(x), np.zeros_like(x)
        constant_and_linear = [(f, none) for f in (one, x, y)] + [(none, f) for f in (one, x, y)]
        return np.array([*constant_and_linear, (x * y, -x * x), (y * y, -x * y)])

    def moments(field):
        found = [field(x, y) @ weights]
        s, ws = np.polynomial.legendre.leggauss(5)
        s, ws = 0.5 * (s + 1.0), 0.5 * ws
        for k in range(3):
            side = corners[(k + 1) % 3] - corners[k]
            px, py = corners[k][:, None] + np.outer(side, s)
            tangential = np.tensordot(field(px, py), side, axes=(-2, 0))
            found += [(tangential @ ws)[..., None], (tangential @ (s * ws))[..., None]]
        return np.concatenate(found, axis=-1)

    coefficients = np.linalg.solve(moments(fields).T, moments(shear))
    reduced = np.tensordot(coefficients, fields(x, y), 1)
    kappa = (
        values(b1, x, y, 1),
        values(b2, x, y, 0, 1),
        0.5 * (values(b1, x, y, 0, 1) + values(b2, x, y, 1)),
    )
    edges = np.roll(corners, -2, axis=0) - np.roll(corners, -1, axis=0)
    twice = 2.0 * weights.sum()
    gradients = np.column_stack([-edges[:, 1], edges[:, 0]]) / twice
    gradients *= np.sign(gradients[0] @ (corners[0] - corners[1]))
    slope = 27.0 * sum(
        np.multiply.outer(bary[:, (k + 1) % 3] * bary[:, (k + 2) % 3], gradients[k])
        for k in range(3)
    )

    def bending(v):
        """With the bubble 27 λ1 λ2 λ3 v."""
        bubble = (v[0] * slope[:, 0], v[1] * slope[:, 1], 0.5 * (slope @ v[::-1]))
        total = (a + b for a, b in zip(kappa, bubble, strict=True))
        return bending_energy(*total, weights, thickness)

    # Quadratic in v: −9/20 A div M·v is its linear part, ½ A v·a v that of second order.
    e, at_0, area = np.eye(2), bending(np.zeros(2)), weights.sum()
    divergence = -np.array([0.5 * (bending(v) - bending(-v)) for v in e]) / (9.0 / 20.0 * area)
    square = [[bending(v + u) - bending(v) - bending(u) + at_0 for v in e] for u in e]
    tau = (9.0 / 20.0) ** 2 * np.linalg.inv(np.array(square) / area)
    stiffness = np.linalg.inv(np.eye(2) / (5.0 / 6.0 * MU * thickness) + tau)
    gamma = reduced + (tau @ divergence)[:, None]
    shear = np.einsum("ap,ab,bp->p", gamma, stiffness, gamma) @ weights
    return at_0 + 0.5 * shear - 0.5 * area * divergence @ tau @ divergence


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 0, 2)])
@pytest.mark.parametrize("thickness", [0.002, 0.2, 5.0])
def test_reduced_shear_and_bubble(triangle, turn, csr, thickness, order):
    model, x = triangle(thickness, order)
    w, b1, b2 = np.random.default_rng(5).uniform(-1.0, 1.0, (3, 6))
    u, theta = zeros(x), zeros(x)
    u[:, 2] = values(w, *x.T[:2])
    theta[:, 0], theta[:, 1] = -values(b2, *x.T[:2]), values(b1, *x.T[:2])
    given = turned(turn, u, theta)
    corners = np.array([[0.0, 0.0], [1.7, 0.2], [0.6, 0.9]])
    expected = energy_of_bending_and_shear(corners, w, b1, b2, thickness)
    assert 0.5 * given @ csr(model.stiffness()) @ given == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("thickness", [0.002, 0.2, 5.0])
def test_six_motions_of_one_triangle_cost_nothing(triangle, csr, thickness):
    model, _ = triangle(thickness)
    values = np.linalg.eigvalsh(csr(model.stiffness()).toarray())
    assert np.abs(values[:6]).max() < 1e-13 * values[-1] and values[6] > 1e-9 * values[-1]


def test_mass_and_inertia(slab, turn):
    """A slab of the mass m about its centre: m (B² + t²)/12, m (A² + t²)/12, and about its
    normal m (A² + B²)/12 + m t²/12, as the rotary inertia acts on drilling too."""
    model, _ = slab()
    m = RHO * T * AREA
    centre = turn @ [0.5 * A, 0.5 * B, 0.0]
    to_centre = np.eye(6)
    to_centre[:3, 3:] = [
        [0.0, -centre[2], centre[1]],
        [centre[2], 0.0, -centre[0]],
        [-centre[1], centre[0], 0.0],
    ]
    about_centre = to_centre.T @ model.total @ to_centre
    inertia = m / 12.0 * np.diag([B**2 + T**2, A**2 + T**2, A**2 + B**2 + T**2])
    assert about_centre[:3, :3] == pytest.approx(m * np.eye(3), rel=1e-12, abs=1e-9)
    assert about_centre[:3, 3:] == pytest.approx(np.zeros((3, 3)), abs=1e-9 * m)
    assert about_centre[3:, 3:] == pytest.approx(turn @ inertia @ turn.T, rel=1e-12, abs=1e-9)


def test_added_mass_has_no_rotary_inertia(slab, csr):
    bare, x = slab()
    loaded, _ = slab(added=np.full(12, 300.0))
    more = (csr(loaded.mass) - csr(bare.mass)).toarray().reshape(len(x), 6, len(x), 6)
    assert not more[:, 3:].any() and not more[:, :, :, 3:].any()
    assert (loaded.total - bare.total)[0, 0] == pytest.approx(300.0 * AREA, rel=1e-10)
