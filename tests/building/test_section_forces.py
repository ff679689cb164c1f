"""Section forces of simple fields on slabs and walls, in their axes, against closed forms."""

import numpy as np
import pytest

from impactfem.building.mesh import Part
from impactfem.building.section_forces import facet_axes, section_forces
from impactfem.system.errors import InputError

E, NU = 33e9, 0.2
T = 0.3
PLANE = E * T / (1.0 - NU**2)
RIGIDITY = PLANE * T**2 / 12.0
FLOOR, WALL = Part("floor", 1), Part("storey", 1)


@pytest.fixture
def joint(panels):
    """A slab z = 3 m and the wall y = 0 below it."""
    panels.panel((0, 0, 3), (4, 0, 0), (0, 2, 0), (4, 2), FLOOR, T)
    panels.panel((0, 0, 0), (4, 0, 0), (0, 0, 3), (4, 3), WALL, T)
    return panels.parts()


def field(parts, u=None, theta=None):
    """Displacements of all nodes from functions of x, y and z."""
    place = parts.mesh.nodes.T
    zero = (0.0, 0.0, 0.0)
    columns = (*(u(*place) if u else zero), *(theta(*place) if theta else zero))
    return np.stack(np.broadcast_arrays(*columns, place[0])[:6], axis=-1)


def test_axes_of_slabs_and_walls():
    square = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 0.5]], dtype=float)
    cells = np.array([[0, 1, 2], [0, 2, 1], [0, 1, 3], [0, 3, 1], [0, 2, 3], [0, 4, 2]])
    axes = facet_axes(square, cells)
    x, y, z = np.eye(3)
    assert axes[0] == pytest.approx(np.array([x, y, z])) and axes[1] == pytest.approx(axes[0])
    assert axes[2] == pytest.approx(np.array([x, z, -y])) and axes[3] == pytest.approx(axes[2])
    assert axes[4] == pytest.approx(np.array([y, z, x]))
    # A ramp along x: 1 goes up with it, 2 stays level.
    ramp = np.array([2.0, 0.0, 1.0]) / np.sqrt(5.0)
    assert axes[5] == pytest.approx(np.array([ramp, y, np.cross(ramp, y)]))
    assert np.einsum("kia,kja->kij", axes, axes) == pytest.approx(np.tile(np.eye(3), (6, 1, 1)))


def test_membrane_forces_of_slab_and_wall(joint):
    """ε_xx = a, ε_zz = b and γ_xz = 2 c in the wall."""
    a, b, c = 1e-4, -2e-4, 3e-5
    w = field(joint, lambda x, y, z: (a * x + 2 * c * z, 0 * y, b * z))
    wall = section_forces(joint, w, joint.mesh.triangles_of("storey")).centres()
    expected = [PLANE * (a + NU * b), PLANE * (b + NU * a), PLANE * (1 - NU) * c]
    assert wall.membrane == pytest.approx(np.tile(expected, (24, 1)), rel=1e-9)
    slab = section_forces(joint, w, joint.mesh.triangles_of("floor")).centres()
    assert slab.membrane[:, :2] == pytest.approx(np.tile([PLANE * a, PLANE * NU * a], (16, 1)))
    assert np.abs(slab.moment).max() < 1e-9 * RIGIDITY


def test_moments_stretch_the_side_of_the_normal(joint):
    """The slab, arched upwards along x: its upper side is stretched."""
    k = 1e-3
    w = field(
        joint,
        lambda x, y, z: (0 * x, 0 * y, -0.5 * k * x**2),
        lambda x, y, z: (0 * x, k * x, 0 * z),
    )
    found = section_forces(joint, w, joint.mesh.triangles_of("floor"))
    expected = np.tile([RIGIDITY * k, RIGIDITY * NU * k, 0.0], (16, 6, 1))
    assert found.values[..., 3:6] == pytest.approx(expected, rel=1e-9, abs=1e-6)
    assert np.abs(found.values[..., 6:]).max() < 1e-6 * RIGIDITY * k


def test_constant_shear(joint):
    """M11 = D k x and Q1 = D k: the element holds it with its cubic deflection at the nodes."""
    k = 1e-3
    gamma = RIGIDITY * k / (5.0 / 6.0 * E / (2.0 * (1.0 + NU)) * T)
    w = field(
        joint,
        lambda x, y, z: (0 * x, 0 * y, gamma * x - k * x**3 / 6.0),
        lambda x, y, z: (0 * x, 0.5 * k * x**2, 0 * z),
    )
    found = section_forces(joint, w, joint.mesh.triangles_of("floor"))
    assert found.values[..., 6] == pytest.approx(np.full((16, 6), RIGIDITY * k), rel=1e-8)
    assert np.abs(found.values[..., 7]).max() < 1e-8 * RIGIDITY * k
    at = found.at([[1.3, 0.7, 3.0], [2.0, 1.0, 3.0]])
    assert at.moment[:, 0] == pytest.approx(RIGIDITY * k * np.array([1.3, 2.0]), rel=1e-9)


def test_many_displacements(joint):
    one = field(joint, lambda x, y, z: (1e-4 * x, 0 * y, 0 * z))
    found = section_forces(joint, np.stack([[one, 2 * one], [3 * one, 0 * one]]))
    alone = section_forces(joint, one)
    assert found.values.shape == (2, 2, 40, 6, 8)
    assert found.values[1, 0] == pytest.approx(3.0 * alone.values, rel=1e-9, abs=1e-3)
    assert found.values[0, 1] == pytest.approx(2.0 * alone.values, rel=1e-9, abs=1e-3)


def test_a_point_off_the_triangles_or_on_two_planes_is_refused(joint):
    found = section_forces(joint, field(joint))
    with pytest.raises(InputError) as caught:
        found.at([[1.0, 1.0, 3.0], [1.0, 1.0, 2.0], [2.0, 0.0, 3.0]])
    first, second = caught.value.faults
    assert first.key == "points[1]" and "field's triangles" in str(first)
    assert second.key == "points[2]" and "one plane only" in str(second)
    with pytest.raises(ValueError, match=r"expected \(\.\.\., \d+, 6\)"):
        section_forces(joint, np.zeros((4, 6)))
