import math
from dataclasses import replace

import numpy as np
import pytest

from impactfem.device.device import coupled, refuse_mechanism
from impactfem.device.models import on_springs
from impactfem.device.modes import device_modes
from impactfem.device.parts import BaseSprings, Beam, RigidBody
from impactfem.system.errors import ImpactfemError

EVERY = {"x": 1.0, "y": 2.0, "z": math.inf, "rx": 4.0, "ry": 5.0, "rz": math.inf}


def test_one_spring_a_direction():
    springs = BaseSprings.of_directions(**EVERY)
    assert springs.free.tolist() == [0, 1, 3, 4]
    assert np.diag(springs.stiffness).tolist() == [1.0, 2.0, 0.0, 4.0, 5.0, 0.0]


@pytest.mark.parametrize(
    ("stiffness", "words"),
    [
        ({"x": 1.0}, "a stiffness for each of x, y, z, rx, ry, rz"),
        (EVERY | {"w": 1.0}, "a stiffness for each of"),
        (EVERY | {"x": math.nan}, "is not a number"),
    ],
)
def test_a_missing_or_unknown_direction_is_refused(stiffness, words):
    with pytest.raises(ImpactfemError, match=words):
        BaseSprings.of_directions(**stiffness)


def test_a_matrix_must_be_symmetric_where_it_is_free():
    k = np.diag(np.arange(1.0, 7.0))
    k[0, 4] = k[4, 0] = 0.5
    assert BaseSprings(k, np.zeros(6, dtype=bool)).free.size == 6
    k[4, 0] = 0.4
    with pytest.raises(ImpactfemError, match="symmetric and finite"):
        BaseSprings(k, np.zeros(6, dtype=bool))
    blocked = np.array([True, False, False, False, False, False])
    assert BaseSprings(k, blocked).free.size == 5
    with pytest.raises(ImpactfemError, match=r"shape \(6, 6\) and 6 marks"):
        BaseSprings(k[:5, :5], blocked)


def test_steiner_about_the_anchor():
    body = RigidBody(10.0, np.array([0.3, 0.0, 0.5]), np.diag([1.0, 2.0, 3.0]))
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
    energy = v @ RigidBody(masses.sum(), centre, inertia).about(point) @ v
    assert energy == pytest.approx(np.sum(masses * np.sum(speeds**2, axis=1)), rel=1e-12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mass": 0.0}, r"mass of a body is 0\.0 kg"),
        ({"inertia": np.diag([1.0, -1.0, 1.0])}, "negative in a direction"),
        ({"inertia": np.eye(3) + np.eye(3, k=1)}, "not symmetric"),
        ({"inertia": np.eye(2)}, r"shape \(3, 3\)"),
        ({"centre": np.array([0.0, 0.0, np.inf])}, "three finite coordinates"),
    ],
)
def test_bad_bodies_are_refused(change, words):
    given = {"mass": 1.0, "centre": np.zeros(3), "inertia": np.eye(3)}
    with pytest.raises(ImpactfemError, match=words):
        RigidBody(**given | change)
    with pytest.raises(ImpactfemError, match="inertia, got 2"):
        RigidBody.at_height(1.0, 0.5, 1.0, 1.0)


BEAM = Beam(2.0, 3.0e6, 5.0e6, stretching=8.0e8, twisting=1.0e6, mass=60.0, elements=6)
CLAMPED = BaseSprings.of_directions(**dict.fromkeys(("x", "y", "z", "rx", "ry", "rz"), math.inf))


def frequencies(beam, mass=1e-3, inertia=1e-9):
    body = RigidBody.at_height(mass, beam.length, inertia, inertia, inertia)
    modes = device_modes(on_springs("beam", CLAMPED, body, 0.02, beam))
    axis = np.argmax(modes.share[[0, 1, 2, 5]], axis=0)
    return {c: modes.frequency[axis == k] for k, c in enumerate(("x", "y", "z", "rz"))}


def test_cantilever_of_euler_and_bernoulli():
    found = frequencies(BEAM)
    for axis, EI in (("x", BEAM.bending_y), ("y", BEAM.bending_x)):
        first = np.array([1.8751041, 4.6940911]) ** 2 / (2 * np.pi) / BEAM.length**2
        wanted = first * np.sqrt(EI / (BEAM.mass / BEAM.length))
        assert found[axis][:2] == pytest.approx(wanted, rel=1e-3)
    assert found["x"][0] != pytest.approx(found["y"][0], rel=0.1)
    along = np.sqrt(BEAM.stretching / (BEAM.mass / BEAM.length)) / (4 * BEAM.length)
    assert found["z"][0] == pytest.approx(along, rel=5e-3)


@pytest.mark.parametrize("elements", [1, 3])
def test_mass_on_a_massless_timoshenko_beam(elements):
    beam = replace(BEAM, shear_x=4.0e7, shear_y=2.0e7, mass=0.0, elements=elements)
    found = frequencies(beam, mass=300.0)
    for axis, EI, GAv in (("x", 5.0e6, 4.0e7), ("y", 3.0e6, 2.0e7)):
        give = 2.0**3 / (3.0 * EI) + 2.0 / GAv
        assert found[axis] == pytest.approx([1 / (2 * np.pi * np.sqrt(300.0 * give))], rel=1e-6)
    assert found["z"] == pytest.approx([np.sqrt(8.0e8 / 2.0 / 300.0) / (2 * np.pi)], rel=1e-9)


def test_what_is_rigid_does_not_deform():
    stiff = replace(BEAM, stretching=math.inf, twisting=math.inf)
    assert stiff.deforming == (0, 1, 3, 4)
    assert BEAM.deforming == (0, 1, 3, 4, 2, 5)
    assert frequencies(stiff)["x"] == pytest.approx(frequencies(BEAM)["x"], rel=1e-9)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("length", 0.0),
        ("bending_x", -1.0),
        ("bending_y", math.inf),
        ("shear_x", 0.0),
        ("twisting", math.nan),
        ("mass", -1.0),
        ("elements", 0),
    ],
)
def test_bad_beams_are_refused(name, value):
    with pytest.raises(ImpactfemError, match=name):
        replace(BEAM, **{name: value})


def test_columns_and_names(pump, altered):
    device = pump()
    assert device.anchors == 1 and device.inputs == ("x", "y", "z", "rx", "ry", "rz")
    assert device.column("rx") == 3
    with pytest.raises(ImpactfemError, match="component 'w' of anchor 1"):
        device.column("w")
    with pytest.raises(ImpactfemError, match="component 'y' of anchor 2"):
        device.column("y", 2)
    two = altered(
        L=np.hstack([device.L, 0 * device.L]),
        r=np.hstack([device.r, 0 * device.r]),
        J=np.kron(np.diag([1.0, 0.0]), device.J),
    )
    assert two.inputs[6:8] == ("2.x", "2.y") and two.column("y", 2) == 7
    assert altered(J=1.1 * device.J).J[0, 0] == pytest.approx(1650.0)  # more mass than it shows
    with pytest.raises(ImpactfemError, match="components an anchor"):
        altered(L=device.L[:, :5], r=device.r[:, :5], J=device.J[:5, :5])
    with pytest.raises(ImpactfemError, match=r"pump: a mechanism.*base"):
        pump(rx=0.0)


def test_rayleigh_and_one_ratio(pump, altered):
    device = pump()
    law = device.damping
    assert pytest.approx(law.alpha * device.M + law.beta * device.K) == device.C
    same = altered(damping=0.03)
    assert device_modes(same).damping == pytest.approx(0.03)
    assert device_modes(same).proportional


def test_a_damper_couples_the_modes(altered):
    found = device_modes(altered(dampers=np.diag([1e5, 0.0, 0.0, 0.0])))
    assert not found.proportional
    assert device_modes(altered(dampers=np.zeros((4, 4)))).proportional


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("M", lambda M: M + np.eye(4, k=1), "device pump: M is not symmetric"),
        ("K", lambda K: K + np.max(K) * np.eye(4, k=1), "device pump: K is not symmetric"),
        ("J", lambda J: J + np.eye(6, k=1), "device pump: J is not symmetric"),
        ("L", lambda L: L[:, :5], r"L needs shape \(4, 6\)"),
        ("K", lambda K: np.nan * K, "K holds a value that is not a finite number"),
        ("dampers", lambda _: np.eye(3), r"dampers needs shape \(4, 4\)"),
        ("M", lambda M: 0.0 * M, "nothing that moves has a mass"),
        ("J", lambda J: 0.9 * J, "its mass is indefinite"),
        ("damping", lambda _: 1.2, "expected 0 <= ratio < 1"),
    ],
)
def test_bad_matrices_are_refused(altered, pump, name, change, words):
    with pytest.raises(ImpactfemError, match=words):
        altered(**{name: change(getattr(pump(), name))})


def test_motions_of_a_mechanism_are_named():
    with pytest.raises(ImpactfemError, match=r"device d: a mechanism.* motion"):
        refuse_mechanism("d", np.diag([1.0, 0.0]), ["base y", "base rx"])
    K = 1e6 * np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    with pytest.raises(ImpactfemError, match="motion a with b; expected"):
        refuse_mechanism("d", K, ["a", "b", "c"])
    K[0, 0] *= 1.0 + 1e-6
    refuse_mechanism("d", K, ["a", "b", "c"])
    # Units do not matter.
    refuse_mechanism("d", np.diag([1e12, 1e-6]), ["a", "b"])
    with pytest.raises(ImpactfemError, match="motion b;"):
        refuse_mechanism("d", np.diag([1e12, -1e-6]), ["a", "b"])


def test_a_rigid_motion_costs_nothing(pump):
    device = pump(Beam(0.46, 8e7, 8e7, mass=45.9), z=1e9, rz=1e7)
    M, C, K = coupled(device)
    assert M[:6, :6] == pytest.approx(device.J, abs=1e-9)
    for matrix in (C, K):
        assert np.abs(matrix[:, :6]).max() < 1e-12 * np.abs(matrix).max()
