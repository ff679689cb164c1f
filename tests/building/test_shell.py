"""Energies of simple fields on flat panels anywhere in space, against closed forms."""

import numpy as np
import pytest

from impactfem.building.part import Part

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


def shear_across(x):
    u = zeros(x)
    u[:, 2] = 1e-3 * x[:, 0] + 2e-3 * x[:, 1]
    return u, zeros(x), 0.5 * AREA * 5.0 / 6.0 * MU * T * (1e-6 + 4e-6)


def drill(x):
    theta = zeros(x)
    theta[:, 2] = 1e-3
    return zeros(x), theta, 0.5 * AREA * MU * T * 1e-6


@pytest.mark.parametrize("field", [stretch, bend, shear_across, drill])
def test_energy(slab, turn, csr, field):
    model, x = slab()
    u, theta, expected = field(x)
    w = turned(turn, u, theta)
    assert 0.5 * w @ csr(model.stiffness()) @ w == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("drilling", [0.0, 0.1, 2.0])
def test_the_drilling_factor_acts_on_drilling_alone(slab, turn, csr, drilling):
    model, x = slab(drilling=drilling)
    for field, factor in ((drill, drilling), (bend, 1.0)):
        u, theta, expected = field(x)
        w = turned(turn, u, theta)
        energy = 0.5 * w @ csr(model.stiffness()) @ w
        assert energy == pytest.approx(factor * expected, rel=1e-11, abs=1e-12)


def test_rigid_body_motions_cost_nothing(slab, csr):
    model, _ = slab()
    K = csr(model.stiffness())
    motions = model.rigid_body((1.0, -2.0, 0.5))
    assert np.abs(K @ motions).max() < 1e-13 * np.abs(K).max() * np.abs(motions).max()


def test_a_turn_with_drilling_the_other_way_round_costs(slab, turn, csr):
    """u = n × x with θ = −n has ω = 2."""
    model, _ = slab()
    about_normal = model.rigid_body() @ np.concatenate([np.zeros(3), turn[:, 2]])
    w = (about_normal.reshape(-1, 6) * [1, 1, 1, -1, -1, -1]).ravel()
    energy = 0.5 * w @ csr(model.stiffness()) @ w
    assert energy == pytest.approx(0.5 * MU * T * AREA * 4.0, rel=1e-11)


def test_six_motions_and_no_more_cost_nothing(slab, csr):
    model, _ = slab()
    values = np.linalg.eigvalsh(csr(model.stiffness()).toarray())
    assert np.abs(values[:6]).max() < 1e-12 * values[-1] and values[6] > 1e-6 * values[-1]


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


def test_the_mass_is_definite(slab, csr):
    model, _ = slab()
    assert np.linalg.eigvalsh(csr(model.mass).toarray())[0] > 0.0
