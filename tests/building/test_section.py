"""Sections against closed forms and handbook values."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from impactfem.building.section import E_Y, BeamSection

sides = st.floats(0.05, 5.0)


def torsion_constant(a, b):
    return BeamSection.rectangle(a, b).J


# Timoshenko and Goodier, Theory of Elasticity, section 109: J = k1 a³ b.
@pytest.mark.parametrize(
    ("ratio", "k1"),
    [(1.0, 0.1406), (1.2, 0.166), (1.5, 0.196), (2.0, 0.229), (2.5, 0.249), (3.0, 0.263),
     (4.0, 0.281), (5.0, 0.291), (10.0, 0.312)],
)  # fmt: skip
def test_torsion_constant_of_the_handbook(ratio, k1):
    a = 0.3
    assert torsion_constant(a, ratio * a) == pytest.approx(k1 * ratio * a**4, rel=2.5e-3)


@given(sides, sides)
def test_torsion_constant_does_not_know_width_from_depth(a, b):
    assert torsion_constant(a, b) == torsion_constant(b, a)
    assert torsion_constant(a, b) < a * b * (a**2 + b**2) / 12.0  # the polar moment bounds it


def test_rectangle():
    section = BeamSection.rectangle(0.75, 0.85)
    assert pytest.approx(0.6375) == section.A
    assert pytest.approx(0.75 * 0.85**3 / 12.0) == section.I1
    assert pytest.approx(0.85 * 0.75**3 / 12.0) == section.I2
    assert (section.k1, section.k2) == (5.0 / 6.0, 5.0 / 6.0)


def test_depth_of_a_beam_is_vertical():
    n1, n2 = BeamSection.beam(0.2, 0.28, -0.1).frame([0.0, 1.0, 0.0])
    np.testing.assert_allclose(n2, [0.0, 0.0, 1.0])
    np.testing.assert_allclose(n1, [-1.0, 0.0, 0.0])
    assert BeamSection.beam(0.2, 0.28, -0.1).offset == (0.0, 0.0, -0.1)


@pytest.mark.parametrize("up", [1.0, -1.0])
def test_width_of_a_column_is_along_x(up):
    section = BeamSection.column(0.8, 1.2)
    n1, n2 = section.frame([0.0, 0.0, up])
    np.testing.assert_allclose(n1, [up, 0.0, 0.0])
    np.testing.assert_allclose(n2, [0.0, 1.0, 0.0])
    # Moving along y bends the side along y.
    assert pytest.approx(0.8 * 1.2**3 / 12.0) == section.I1


@given(st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda t: np.linalg.norm(t[:2]) > 0.05))
def test_the_frame_is_right_handed_and_orthonormal(direction):
    t = np.array(direction) / np.linalg.norm(direction)
    n1, n2 = BeamSection.beam(0.3, 0.5).frame(t)
    axes = np.array([n1, n2, t])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert n2[2] > 0.0


def test_a_beam_along_its_reference_has_no_frame():
    with pytest.raises(ValueError, match="parallel to the reference"):
        BeamSection.beam(0.3, 0.5).frame([0.0, 0.0, 1.0])
    with pytest.raises(ValueError, match="parallel to the reference"):
        BeamSection.rectangle(0.3, 0.5, reference=E_Y).frame([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
