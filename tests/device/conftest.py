"""A pump like the paper's, rigid or on a beam, and motions of its anchor."""

import math
from dataclasses import fields

import numpy as np
import pytest

from impactfem.device.device import Device
from impactfem.device.models import on_springs
from impactfem.device.parts import BaseSprings, RigidBody
from impactfem.dynamics.damping import Rayleigh

from ..sticks.conftest import floors, row, shake  # noqa: F401

STIFFNESS = {"x": 1.4e8, "y": 1.2e8, "z": math.inf, "rx": 3.0e7, "ry": 2.5e7, "rz": math.inf}
DAMPING = Rayleigh.through(0.02, 30.0, 80.0)


@pytest.fixture
def pump():
    """A body of 1500 kg at 0.46 m; springs can be altered, a beam added."""

    def make(beam=None, damping=DAMPING, mass=1500.0, **stiffness):
        springs = BaseSprings.of_directions(**{**STIFFNESS, **stiffness})
        body = RigidBody.at_height(mass, 0.46, 220.0, 240.0, 190.0)
        return on_springs("pump", springs, body, damping, beam)

    return make


@pytest.fixture
def altered(pump):
    """The pump, or another device, with some of its matrices replaced."""

    def make(device=None, **changes):
        given = device or pump()
        kept = {f.name: getattr(given, f.name) for f in fields(Device) if f.init}
        return Device(**kept | changes)

    return make


@pytest.fixture
def shaking():
    """Noise in six components, at rest at the first sample."""

    def make(samples=800, seed=1, anchors=1):
        motion = np.random.default_rng(seed).standard_normal((6 * anchors, samples))
        motion[:, 0] = 0.0
        return motion

    return make
