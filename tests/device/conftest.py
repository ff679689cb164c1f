"""A pump like the paper's, rigid or on a beam, and motions of its anchor."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from impactfem.device.device import Device
from impactfem.device.models import on_springs
from impactfem.device.parts import BaseSprings, Beam, RigidBody
from impactfem.dynamics.damping import Rayleigh

from ..sticks.conftest import floors, row, shake  # noqa: F401

STIFFNESS = {"x": 1.4e8, "y": 1.2e8, "z": math.inf, "rx": 3.0e7, "ry": 2.5e7, "rz": math.inf}
DAMPING = Rayleigh.through(0.02, 30.0, 80.0)


@pytest.fixture
def pump() -> Callable[..., Device]:
    """A body of 1500 kg at 0.46 m; springs can be altered, a beam added."""

    def make(
        beam: Beam | None = None, damping: Any = DAMPING, mass: float = 1500.0, **stiffness: float
    ) -> Device:
        springs = BaseSprings.of_directions(**{**STIFFNESS, **stiffness})
        body = RigidBody.at_height(mass, 0.46, 220.0, 240.0, 190.0)
        return on_springs("pump", springs, body, damping, beam)

    return make


@pytest.fixture
def altered(pump: Callable[..., Device]) -> Callable[..., Device]:
    """The pump, or another device, with some of its matrices replaced."""

    def make(device: Device | None = None, **changes: Any) -> Device:
        given = device or pump()
        kept = {f.name: getattr(given, f.name) for f in fields(Device) if f.init}
        return Device(**kept | changes)

    return make


@pytest.fixture
def shaking() -> Callable[..., np.ndarray]:
    """Noise in six components, at rest at the first sample."""

    def make(samples: int = 800, seed: int = 1, anchors: int = 1) -> np.ndarray:
        motion = np.random.default_rng(seed).standard_normal((6 * anchors, samples))
        motion[:, 0] = 0.0
        return motion

    return make
