"""Sticks with another damping and restitution."""

from pathlib import Path

import pytest

from impactfem.case import load_case
from impactfem.case.damping import DampingCase
from impactfem.dynamics.damping import Rayleigh
from impactfem.stages.device.compute import damped_case

LIGHT = DampingCase(name="light", mass_coefficient=0.2, stiffness_coefficient=1e-4)


@pytest.fixture
def case(new_case, tmp_path: Path):
    found = load_case(new_case(tmp_path))
    law = found.contact_laws["floor"]
    return found.model_copy(update={"contact_laws": {"floor": law, "column": law}})


def restitutions(case):
    return {name: law.restitution for name, law in case.contact_laws.items()}


def test_all_buildings_take_the_damping(case):
    found = damped_case(case, LIGHT, None)
    assert {b.damping.rayleigh for b in found.buildings} == {Rayleigh(0.2, 1e-4)}
    assert found.contact_laws == case.contact_laws


@pytest.mark.parametrize(
    ("laws", "changed"), [((), {"floor", "column"}), ({"floor"}, {"floor"}), ({"other"}, set())]
)
def test_the_restitution_is_for_those_that_asked(case, laws, changed):
    found, before = restitutions(damped_case(case, LIGHT, 0.31, laws)), restitutions(case)
    assert {name for name in found if found[name] == 0.31} == changed
    assert {name for name in found if found[name] == before[name]} == set(before) - changed
