import numpy as np
import pytest

from impactfem.device.body import Body, solid_cylinder
from impactfem.system.errors import ImpactfemError


def test_steiner_about_the_anchor():
    body = Body(10.0, np.array([0.3, 0.0, 0.5]), np.diag([1.0, 2.0, 3.0]))
    m = body.about(np.zeros(3))
    assert m[:3, :3] == pytest.approx(10.0 * np.eye(3))
    assert np.diag(m)[3:] == pytest.approx([1.0 + 2.5, 2.0 + 10.0 * 0.34, 3.0 + 0.9])
    assert m[3, 5] == pytest.approx(-10.0 * 0.3 * 0.5)
    # A rotation about x moves the centre along -y, one about y along +x.
    assert m[1, 3] == pytest.approx(-5.0)
    assert m[0, 4] == pytest.approx(5.0)


def test_kinetic_energy_of_points():
    """A cloud of points has the same energy as the body made of it, for any motion."""
    rng = np.random.default_rng(4)
    masses, places = rng.uniform(1.0, 2.0, 30), rng.standard_normal((30, 3))
    centre = masses @ places / masses.sum()
    arms = places - centre
    inertia = sum(
        m * (d @ d * np.eye(3) - np.outer(d, d)) for m, d in zip(masses, arms, strict=True)
    )
    point = np.array([0.2, -0.1, 0.4])
    v = rng.standard_normal(6)
    speeds = v[:3] + np.cross(v[3:], places - point)
    energy = v @ Body(masses.sum(), centre, inertia).about(point) @ v
    assert energy == pytest.approx(np.sum(masses * np.sum(speeds**2, axis=1)), rel=1e-12)


def test_cylinder_of_the_paper():
    assert solid_cylinder(1500.0, 0.5, 1.0) == pytest.approx((218.75, 218.75, 187.5))


def test_bad_bodies_are_refused():
    with pytest.raises(ImpactfemError, match=r"mass of a body is 0\.0 kg"):
        Body.at_height(0.0, 0.5, 1.0, 1.0, 1.0)
    with pytest.raises(ImpactfemError, match="three moments of inertia, got 2"):
        Body.at_height(1.0, 0.5, 1.0, 1.0)
    with pytest.raises(ImpactfemError, match="negative in a direction"):
        Body.at_height(1.0, 0.5, 1.0, -1.0, 1.0)
    skew = np.eye(3)
    skew[0, 1] = 0.1
    with pytest.raises(ImpactfemError, match="not symmetric"):
        Body(1.0, np.zeros(3), skew)
    with pytest.raises(ImpactfemError, match=r"shape \(3, 3\)"):
        Body(1.0, np.zeros(3), np.eye(2))
    with pytest.raises(ImpactfemError, match="three finite coordinates"):
        Body(1.0, np.array([0.0, 0.0, np.inf]), np.eye(3))
