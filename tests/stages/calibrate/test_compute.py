"""What the stage `calibrate` makes of a case."""

from __future__ import annotations

from pathlib import Path

import pytest

from impactfem.case import Case, DampingCase, load_case
from impactfem.case.wall_impact import WallImpactSetup
from impactfem.stages.calibrate.compute import OWN, prepare

GEOMETRY = Path(__file__).parents[3] / "geometry"
LIGHT = DampingCase(name="light", mass_coefficient=0.838, stiffness_coefficient=2.12e-4)
HEAVY = DampingCase(name="heavy", ratio=0.09, frequencies=(1.0, 20.0), restitution=0.5)


@pytest.fixture(scope="module")
def case() -> Case:
    """The shipped frame in front of a wall."""
    wall = WallImpactSetup(
        floors=(1, 2), displaced_floor=2, gap=0.01, displacement=-0.02, duration=1.3, time_step=1e-3
    )
    return load_case(GEOMETRY / "frame.toml").model_copy(update={"wall_impact": wall})


@pytest.mark.parametrize("cases", [(), (LIGHT, HEAVY), (HEAVY, LIGHT)])
def test_dampings(case: Case, cases: tuple[DampingCase, ...]) -> None:
    """The building's own first, then the damping cases that ask for a restitution."""
    changed = case.model_copy(update={"damping_cases": cases})
    prepared = prepare(changed, GEOMETRY / "frame.msh")
    asking = [one for one in cases if one is not HEAVY]
    assert list(prepared.dampings) == [OWN, *(one.name for one in asking)]
    assert prepared.dampings[OWN] == case.building("F").damping.rayleigh
    for one in asking:
        assert prepared.dampings[one.name] == one.rayleigh
