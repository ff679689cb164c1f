"""Energies and inertia of beams anywhere in space, against closed forms."""

import numpy as np
import pytest

from impactfem.building.mesh import Part
from impactfem.building.section import BeamSection

E, NU, RHO = 33e9, 0.2, 2500.0
G = E / (2.0 * (1.0 + NU))
L, OFFSET = 5.0, (0.1, -0.3, 0.45)
# No two values alike, so that a mistaken axis shows; the reference is askew to every beam below.
SECTION = BeamSection(
    A=0.5, I1=0.03, I2=0.011, J=0.007, k1=0.7, k2=0.9, reference=(0.3, -0.2, 0.9), offset=OFFSET
)
TANGENTS = {
    "vertical": (0.0, 0.0, 1.0),
    "downwards": (0.0, 0.0, -1.0),
    "along x": (1.0, 0.0, 0.0),
    "along y": (0.0, 1.0, 0.0),
    "oblique": (2.0 / 7.0, -3.0 / 7.0, 6.0 / 7.0),
}


@pytest.fixture(params=TANGENTS.values(), ids=TANGENTS.keys())
def beam(request, panels, assembled):
    """A beam of 5 m: its model, frame as rows (t, n1, n2), and the distance along it."""
    t = np.array(request.param)
    panels.line((1, 2, 3), np.array([1, 2, 3]) + L * t, 4, Part("beam", 1), SECTION)
    model = assembled(panels.parts())
    n2 = np.array(SECTION.reference) - np.dot(SECTION.reference, t) * t
    n2 /= np.linalg.norm(n2)
    return model, np.array([t, np.cross(n2, t), n2]), (model.coordinates - [1, 2, 3]) @ t


def motion(frame, s, axis_motion, theta):
    """Degrees of freedom of the nodes: the axis, at e from them, moves by `axis_motion`.

    Both fields are (n, 3) along (t, n1, n2); u = u_a − θ × e.
    """
    theta = theta @ frame
    return np.hstack([axis_motion @ frame - np.cross(theta, OFFSET), theta]).ravel()


def field(s, *components):
    made = np.zeros((len(s), 3))
    for place, values in components:
        made[:, place] = values
    return made


def strains(s):
    """One strain of 1e-3 each, as motion of the axis and rotation, with its stiffness."""
    none, k = field(s), 1e-3
    return {
        "axial": (field(s, (0, k * s)), none, E * SECTION.A),
        "shear 1": (field(s, (1, k * s)), none, 0.7 * G * SECTION.A),
        "shear 2": (field(s, (2, k * s)), none, 0.9 * G * SECTION.A),
        "twist": (none, field(s, (0, k * s)), G * SECTION.J),
        # Turning about n1 by k s moves the axis along −n2, about n2 along n1: no shear.
        "bending 1": (field(s, (2, -0.5 * k * s**2)), field(s, (1, k * s)), E * SECTION.I1),
        "bending 2": (field(s, (1, 0.5 * k * s**2)), field(s, (2, k * s)), E * SECTION.I2),
    }


@pytest.mark.parametrize("strain", strains(np.zeros(1)))
def test_energy(beam, csr, strain):
    model, frame, s = beam
    u, theta, stiffness = strains(s)[strain]
    w = motion(frame, s, u, theta)
    energy = 0.5 * w @ csr(model.stiffness()) @ w
    assert energy == pytest.approx(0.5 * stiffness * 1e-6 * L, rel=1e-10)


def test_a_turn_without_rotations_costs(beam, csr):
    """u = n1 × x with θ = 0: a shear γ2 of −1 of the nodes' line, which the axis shares."""
    model, frame, _ = beam
    w = model.rigid_body() @ np.concatenate([np.zeros(3), frame[1]])
    w = (w.reshape(-1, 6) * [1, 1, 1, 0, 0, 0]).ravel()
    energy = 0.5 * w @ csr(model.stiffness()) @ w
    assert energy == pytest.approx(0.5 * 0.9 * G * SECTION.A * L, rel=1e-10)


def test_mass_and_inertia(beam):
    """A bar of the mass m with its centre at the offset from the middle of the nodes' line."""
    model, frame, _ = beam
    m = RHO * SECTION.A * L
    centre = np.array([1.0, 2.0, 3.0]) + 0.5 * L * frame[0] + OFFSET
    to_centre = np.eye(6)
    for axis, b in enumerate(np.eye(3)):
        to_centre[:3, 3 + axis] = np.cross(b, -centre)
    about_centre = to_centre.T @ model.total @ to_centre
    polar, across = RHO * L * (SECTION.I1 + SECTION.I2), m * L**2 / 12.0
    inertia = np.diag([polar, RHO * L * SECTION.I1 + across, RHO * L * SECTION.I2 + across])
    assert about_centre[:3, :3] == pytest.approx(m * np.eye(3), rel=1e-12, abs=1e-9)
    assert about_centre[:3, 3:] == pytest.approx(np.zeros((3, 3)), abs=1e-9 * m)
    assert about_centre[3:, 3:] == pytest.approx(frame.T @ inertia @ frame, rel=1e-10, abs=1e-6)


def test_two_sections_on_one_kind_of_line(panels, assembled, csr):
    """Two bars in a row pull like springs in a row."""
    thick, thin = (BeamSection.beam(0.5, side) for side in (0.8, 0.2))
    panels.line((0, 0, 0), (2, 0, 0), 2, Part("beam", 1, "thick"), thick)
    panels.line((2, 0, 0), (3, 0, 0), 1, Part("beam", 1, "thin"), thin)
    model = assembled(panels.parts(base=panels.at((0, 0.0))))
    at_end = model.rows(panels.at((0, 3.0)))[0]
    load = np.zeros(model.n_free)
    load[at_end] = 1e6
    u = np.linalg.solve(csr(model.stiffness()).toarray(), load)
    assert u[at_end] == pytest.approx(1e6 / E * (2.0 / 0.4 + 1.0 / 0.1), rel=1e-10)
