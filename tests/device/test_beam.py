import math
from dataclasses import replace

import numpy as np
import pytest

from impactfem.device.beam import Beam
from impactfem.device.body import Body
from impactfem.device.modes import device_modes
from impactfem.device.on_springs import on_springs
from impactfem.device.springs import BaseSprings
from impactfem.system.errors import ImpactfemError

BEAM = Beam(2.0, 3.0e6, 5.0e6, stretching=8.0e8, twisting=1.0e6, mass=60.0, elements=6)
CLAMPED = BaseSprings.of_directions(**dict.fromkeys(("x", "y", "z", "rx", "ry", "rz"), math.inf))


def frequencies(beam, mass=1e-3, inertia=1e-9):
    body = Body.at_height(mass, beam.length, inertia, inertia, inertia)
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
