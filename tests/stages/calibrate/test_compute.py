"""What the stage `calibrate` makes of a case."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from impactfem.building.from_case import read_parts
from impactfem.case import Case, DampingCase, load_case
from impactfem.case.wall_impact import WallImpactSetup
from impactfem.stages.calibrate import compute as stage
from impactfem.stages.calibrate.compute import OWN, prepare
from impactfem.system.errors import InputError

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
    prepared = prepare(changed, GEOMETRY / "frame.msh", 0.5)
    asking = [one for one in cases if one is not HEAVY]
    assert list(prepared.dampings) == [OWN, *(one.name for one in asking)]
    assert prepared.dampings[OWN] == case.building("F").damping.rayleigh
    for one in asking:
        assert prepared.dampings[one.name] == one.rayleigh


def test_a_clamped_floor_cannot_be_held_as_a_whole(case: Case, monkeypatch) -> None:
    """A mesh whose floor 2 is clamped at one node: a load can draw it aside, holding it cannot."""
    parts, masses, report = read_parts(case, GEOMETRY / "frame.msh")
    slab = parts.mesh.triangles[parts.mesh.slab(2)]
    mesh = replace(parts.mesh, base=np.union1d(parts.mesh.base, slab[0, :1]))
    clamped = replace(parts, mesh=mesh)
    monkeypatch.setattr(stage, "read_parts", lambda *_: (clamped, masses, report))
    with pytest.raises(InputError, match=r"wall_impact.pull.*1 of the \d+ nodes of the slab of f"):
        prepare(case, GEOMETRY / "frame.msh", 0.5)
    loaded = case.wall_impact.model_copy(update={"pull": "even_load"})
    prepared = prepare(case.model_copy(update={"wall_impact": loaded}), GEOMETRY / "frame.msh", 0.5)
    assert prepared.experiment.pull == "even_load"
