"""The section [wall_impact] of a case file, and the laws that take their values from it."""

import json
from pathlib import Path

import pytest

from impactfem.case import KelvinVoigtLaw, load_case
from impactfem.case.calibration import WallImpactSetup
from impactfem.stages.calibrate.experiment import SEPARATION, WallExperiment

from .faults import all_faults, refused
from .sections import WALL

FULL = f"""{WALL}floors = [7, 4]
displaced_floor = 5
pull = "even_load"
theta = 0.55
separation = "4 ms"
"""
WRITTEN = 'stiffness = "1e11 N/m"\ndamping_ratio = "12 %"\n'
CALIBRATED = 'stiffness = "calibrated"\nrestitution = "calibrated"\n'
THIRD = """
[[buildings]]
name = "B3"
material = "concrete"
floors = "pair_floors.csv"
axis = ["23.1 m", "23.42 m"]
rigid_below = "0.06 m"
rigid_above = "0.79 m"

[[contacts]]
a = { building = "B2", floor = 8 }
b = { building = "B3", floor = 8 }
normal = [0, 1, 0]
gap = "1 cm"
law = "floor"
"""


def setup_of(path):
    setup = load_case(path).wall_impact
    assert setup is not None
    return setup


def test_defaults(structured):
    setup = setup_of(structured(more=WALL))
    assert setup == WallImpactSetup(
        building="B1",
        floors=(6, 7, 8),
        displaced_floor=8,
        gap=0.01,
        displacement=-0.02,
        pull="whole_floor",
        duration=1.3,
        time_step=0.34e-3,
        theta=0.5,
        separation=SEPARATION,
    )


def test_every_key(structured):
    case = load_case(structured(more=FULL))
    setup = case.wall_impact
    assert (setup.floors, setup.displaced_floor) == ((4, 7), 5)  # bottom to top
    assert (setup.pull, setup.theta, setup.separation) == ("even_load", 0.55, 4e-3)


def test_points_without_mass_need_average_acceleration(structured):
    more = f'{WALL}unilateral_scheme = "massless"\n'
    assert setup_of(structured(more=more)).unilateral_scheme == "massless"
    faults = all_faults(structured(more=f"{more}theta = 0.55\n"))
    assert [fault.key for fault in faults] == ["wall_impact.unilateral_scheme"]


def test_one_floor(structured):
    assert setup_of(structured(more=f"{WALL}floors = 8\n")).floors == (8,)


def test_fewer_floors_than_three(tmp_path):
    frame = Path(__file__).parents[2] / "geometry" / "frame.toml"
    path = tmp_path / "wall.toml"
    path.write_text(f'extends = "{frame}"\n{WALL}', encoding="utf-8")
    setup = setup_of(path)
    assert (setup.floors, setup.displaced_floor) == ((1, 2), 2)


@pytest.mark.parametrize("displacement", ["-2 cm", "9 mm"])
def test_accepted_is_an_experiment(structured, displacement):
    setup = setup_of(structured((None, "-2 cm", displacement), more=WALL))
    assert WallExperiment(**setup.model_dump(exclude={"building", "contact_spacing"})).n_t > 2


@pytest.mark.parametrize(
    ("law_text", "stiffness", "restitution"),
    [
        (CALIBRATED, "calibrated", "calibrated"),
        ('stiffness = "calibrated"\nrestitution = "60 %"\n', "calibrated", 0.6),
        ('stiffness = "calibrated"\ndamping_ratio = 0.1\n', "calibrated", None),
        ('stiffness = "2 kN/m"\nrestitution = "calibrated"\n', 2e3, "calibrated"),
    ],
)
def test_calibrated_law(structured, law_text, stiffness, restitution):
    case = load_case(structured((None, WRITTEN, law_text), more=WALL))
    law = case.contact_laws["floor"]
    assert isinstance(law, KelvinVoigtLaw) and law.calibrated
    assert (law.stiffness, law.restitution) == (stiffness, restitution)
    dumped = json.loads(case.model_dump_json(include={"contact_laws"}))
    assert dumped["contact_laws"]["floor"]["stiffness"] == stiffness


def test_given_law_is_not_calibrated(pair):
    law = load_case(pair).contact_laws["floor"]
    assert isinstance(law, KelvinVoigtLaw) and not law.calibrated


def test_calibrated_without_the_impact(structured, broken):
    for write in (structured, broken):
        faults = all_faults(write((None, WRITTEN, CALIBRATED)))
        keys = {f"contact_laws.floor.{k}" for k in ("stiffness", "restitution")}
        assert {fault.key for fault in faults} == keys
        assert {fault.kind for fault in faults} == {"missing_section"}


def test_contact_away_from_the_structure(structured):
    path = structured((None, WRITTEN, CALIBRATED), more=WALL + THIRD)
    refused(path, "contacts[1].law", "of_contacts calibrated on B1")
    # A law with values of its own holds for any pair.
    assert len(load_case(structured(more=WALL + THIRD)).contacts) == 9
