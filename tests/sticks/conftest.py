"""Small buildings and small cases that the tests of this room share."""

from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from impactfem.case import load_case
from impactfem.case.template import write_new_case
from impactfem.coupling.laws import KelvinVoigt
from impactfem.coupling.pounding import End, Pair, System
from impactfem.dynamics.damping import Rayleigh
from impactfem.stages.pounding.compute import run_sticks
from impactfem.sticks.element import Section
from impactfem.sticks.stick import Floor, build_stick

# No two values alike, so that a mistaken axis shows.
SECTION = Section(E=30e9, G=12.5e9, A=3.4, Avx=1.1, Avy=0.9, Ix=0.8, Iy=1.3, Iz=1.8)
FLOOR = Floor(
    number=1,
    mass=240e3,
    inertia=(2.9e6, 8.0e6, 10.9e6),
    height=3.5,
    section=SECTION,
    below=0.4,
    above=0.1,
)

damped_stick = partial(build_stick, damping=Rayleigh(0.6, 8e-4))


@pytest.fixture(scope="session")
def section():
    return SECTION


@pytest.fixture(scope="session")
def floors():
    """Floors 1 to n, all alike, with the fields of `Floor` changed as asked."""
    return lambda n=3, **changes: [
        replace(FLOOR, **changes, number=number) for number in range(1, n + 1)
    ]


@pytest.fixture(scope="session")
def row(floors):
    """Buildings a, b, ... of two floors in a row along y, each softer than the one before.

    All facing floors are a pair, but at `gap` = None.
    """

    def make(gap=0.01, *, buildings=2, x=0.0, softer=0.5, law=None, tension=True):
        sticks = []
        for k in range(buildings):
            stiffness = SECTION.E * softer**k
            soft = replace(SECTION, E=stiffness, G=stiffness / 2.4)
            sticks.append(damped_stick("abcdef"[k], floors(2, section=soft), axis=(0.0, 12.0 * k)))
        law = law or KelvinVoigt(1e10, 0.12, mass=FLOOR.mass / 2.0, tension=tension)
        pairs = []
        if gap is not None:
            for a, b in pairwise(sticks):
                for k in (1, 2):
                    ends = (
                        End(a.name, k - 1, (x, 6.0, 0.0), k),
                        End(b.name, k - 1, (x, -6.0, 0.0), k),
                    )
                    normal = np.array([0.0, 1.0, 0.0])
                    pairs.append(Pair(f"{a.name}{k}-{b.name}{k}", *ends, normal, gap, law, 5.0))
        return System(tuple(sticks), tuple(pairs))

    return make


@pytest.fixture(scope="session")
def shake():
    """Ground acceleration of a few seconds that makes the buildings of `row` pound."""

    def make(n_t=4000, dt=2.5e-4, components=(1,)):
        t = dt * np.arange(n_t)
        ground = np.zeros((n_t, 3))
        for component in components:
            f = (5.7, 4.0, 7.4)[component]
            ground[:, component] = 6.0 * np.sin(2 * np.pi * f * t) * np.minimum(t, 1)
        return ground

    return make


SHORT = (
    ('duration = "10 s"\n', 'duration = "2 s"\n'),
    ('strong_phase = ["2 s", "6 s"]', 'strong_phase = ["0.3 s", "1.2 s"]'),
    ("# iterations = 30", "iterations = 3"),
    ("per_decade = 50", "per_decade = 8"),
    ('# compressive_strength = "25 MPa"', 'compressive_strength = "25 MPa"'),
    ('# bearing_area = "5 m2"', 'bearing_area = "5 m2"'),
    ('gap = "2 cm"', 'gap = "0.5 cm"'),
    ("title = ", 'allow = "gap"\ntitle = '),
    ('pga = "1.2 m/s2"', 'pga = "3 m/s2"'),
    ('ground_acceleration = "1.2 m/s2"', 'ground_acceleration = "3 m/s2"'),
    (
        'type = "hunt-crossley"\nstiffness = "2.75e9 N/m^1.5"',
        'type = "kelvin-voigt"\nstiffness = "1.2e10 N/m"',
    ),
    ('relation = "exact"', '# relation = "exact"'),
)


@pytest.fixture(scope="session")
def small_case(tmp_path_factory):
    """The template of `impactfem new`, made short and changed as asked; further files beside it."""

    def make(*edits, extra="", files=None):
        path = write_new_case(tmp_path_factory.mktemp("case") / "small")[0]
        text = path.read_text(encoding="utf-8")
        for old, new in (*SHORT, *edits):
            if old not in text:
                raise ValueError(f"{old!r} is not in the template: the test does not test")
            text = text.replace(old, new, 1)
        path.write_text(text + extra, encoding="utf-8")
        for name, content in (files or {}).items():
            Path(path.parent / name).write_text(content, encoding="utf-8")
        return load_case(path)

    return make


@pytest.fixture(scope="session")
def run():
    """Run the stage quietly."""
    return lambda case: run_sticks(case, lambda name: nullcontext())


@pytest.fixture(scope="session")
def study(small_case, run):
    """The small case, run once for all tests."""
    return run(small_case())
