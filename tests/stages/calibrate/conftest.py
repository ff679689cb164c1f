"""Small sticks and histories that the tests here share."""

import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.stages.calibrate.experiment import WallExperiment, WallHistory
from impactfem.sticks.element import Section
from impactfem.sticks.stick import Floor, build_stick

from ...dynamics.conftest import chain, membrane, petsc  # noqa: F401

# Unlike in x and y, so that a mistaken axis shows.
SECTION = Section(E=30e9, G=12.5e9, A=3.4, Avx=1.1, Avy=0.9, Ix=0.8, Iy=1.3, Iz=1.8)


@pytest.fixture(scope="session")
def stick():
    """A building of three floors, lightly damped."""
    floors = [Floor(k, 240e3, (2.9e6, 8.0e6, 10.9e6), 3.5, SECTION, 0.4, 0.1) for k in (1, 2, 3)]
    return build_stick("tower", floors, damping=Rayleigh(0.3, 4e-4))


@pytest.fixture(scope="session")
def experiment():
    """Floor 3 drawn 2 cm aside, the wall 1 cm before floors 2 and 3."""
    return WallExperiment((2, 3), 3, -0.02, 0.01, 0.6, 2e-4)


@pytest.fixture(scope="session")
def history():
    """A history of one floor, number 8: 1000 kg that flies at 1 m/s, and a force as given."""

    def make(force, dt=1e-3, **changes):
        F = np.asarray(force, dtype=float)[:, None]
        values = {
            "floors": (8,),
            "mass": np.array([1000.0]),
            "gap": 0.01,
            "time_step": dt,
            "displacement": dt * np.arange(F.size)[:, None] - 0.02,
            "velocity": np.ones_like(F),
            "force": F,
        }
        return WallHistory(**values | changes)

    return make
