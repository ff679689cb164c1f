"""The section [wall_impact] of a case file, and the laws that take their values from it."""

import json
import pickle
from collections.abc import Callable
from pathlib import Path

import pytest

from impactfem.case import KelvinVoigtLaw, WallImpactSetup, load_case
from impactfem.stages.calibrate.experiment import SEPARATION, WallExperiment

from .faults import own_faults, refused
from .texts import added, replaced

Structured = Callable[..., Path]
Broken = Callable[..., Path]
With = Callable[..., Path]

SHORT = """[wall_impact]
gap = "1 cm"
displacement = "-2 cm"
duration = "1.3 s"
time_step = "0.34 ms"
"""
FULL = f"""{SHORT}floors = [7, 4]
displaced_floor = 5
pull = "even_load"
theta = 0.55
separation = "4 ms"
"""
WRITTEN = 'stiffness = "1e11 N/m"\ndamping_ratio = "12 %"\n'
CALIBRATED = 'stiffness = "calibrated"\nrestitution = "calibrated"\n'
GIVEN = {"stiffness": '"2 N/m^1.5"', "restitution": "0.6"}  # of a law of Hertz
THIRD = """
[[buildings]]
name = "B3"
material = "concrete"
floors = "pair_floors.csv"
axis = ["23.1 m", "40 m"]
rigid_below = "0.06 m"
rigid_above = "0.79 m"

[[contacts]]
a = { building = "B2", floor = 8 }
b = { building = "B3", floor = 8 }
normal = [0, 1, 0]
gap = "1 cm"
law = "floor"
"""


@pytest.fixture
def with_wall(structured: Structured) -> With:
    """A case with a structure and a section [wall_impact], with texts of both replaced."""

    def write(section: str = SHORT, *edits: tuple[str, str], case: tuple[str, str] = ("", "")):
        path = structured((None, *case)) if case[0] else structured()
        added(path, replaced(section, *edits))
        return path

    return write


def setup_of(path: Path) -> WallImpactSetup:
    setup = load_case(path).wall_impact
    assert setup is not None
    return setup


def test_left_out(pair: Path, structured: Structured) -> None:
    assert load_case(pair).wall_impact is None
    assert load_case(structured()).wall_impact is None


def test_defaults(with_wall: With) -> None:
    setup = setup_of(with_wall())
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


def test_every_key(with_wall: With) -> None:
    case = load_case(with_wall(FULL))
    setup = case.wall_impact
    assert setup is not None
    assert (setup.floors, setup.displaced_floor) == ((4, 7), 5)  # bottom to top
    assert (setup.pull, setup.theta, setup.separation) == ("even_load", 0.55, 4e-3)
    assert pickle.loads(pickle.dumps(case)) == case
    assert json.loads(case.model_dump_json(include={"wall_impact"}))["wall_impact"]["theta"] == 0.55


def test_one_floor(with_wall: With) -> None:
    assert setup_of(with_wall(f"{SHORT}floors = 8\n")).floors == (8,)


def test_fewer_floors_than_three(tmp_path: Path) -> None:
    frame = Path(__file__).parents[2] / "geometry" / "frame.toml"
    section = '[wall_impact]\ngap = "1 cm"\ndisplacement = "-2 cm"\nduration = "1 s"\n'
    path = tmp_path / "wall.toml"
    path.write_text(f'extends = "{frame}"\n{section}time_step = "1 ms"\n', encoding="utf-8")
    setup = setup_of(path)
    assert (setup.floors, setup.displaced_floor) == ((1, 2), 2)


@pytest.mark.parametrize("displacement", ["-2 cm", "9 mm"])
def test_accepted_is_an_experiment(with_wall: With, displacement: str) -> None:
    setup = setup_of(with_wall(SHORT, ("-2 cm", displacement)))
    assert WallExperiment(**setup.model_dump(exclude={"building", "contact_spacing"})).n_t > 2


REFUSED = [
    ('"-2 cm"', '"0 m"', "displacement", "0 m expected a displacement that is not zero"),
    ('"-2 cm"', '"1 cm"', "displacement", "1 cm the wall would start inside the building"),
    ('"-2 cm"', '"2 cm"', "displacement", "expected less than the gap, 0.01 m"),
    ('"0.34 ms"', '"0.66 s"', "time_step", "0.66 s expected at most half of the duration, 1.3 s"),
    ('"0.34 ms"', '"0.34 ms"\nseparation = "2 s"', "separation", "2 s expected less than the dur"),
    ('"0.34 ms"', '"0.34 ms"\ncontact_spacing = "0 m"', "contact_spacing", "above 0"),
    ('"0.34 ms"', '"0.34 ms"\nfloors = []', "floors", "the list is empty"),
    ('"0.34 ms"', '"0.34 ms"\nfloors = [8, 7, 8]', "floors", "each floor once, found 8 again"),
    ('"0.34 ms"', '"0.34 ms"\nfloors = [8, 9, 12]', "floors",
     "[8, 9, 12] B1 has no floor 9, 12; its floors are 1, 2, 3, 4, 5, 6, 7, 8"),
    ('"0.34 ms"', '"0.34 ms"\ndisplaced_floor = 9', "displaced_floor", "9 B1 has no floor 9"),
    ('"0.34 ms"', '"0.34 ms"\nside = "y+"', "side", "unknown key"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "key", "expected"), REFUSED)
def test_refused(with_wall: With, old: str, new: str, key: str, expected: str) -> None:
    refused(with_wall(SHORT, (old, new)), f"wall_impact.{key}", expected)


def test_all_at_once(with_wall: With) -> None:
    faults = own_faults(with_wall(FULL, ("[7, 4]", "[7, 7]"), ('"-2 cm"', '"2 cm"'), ("0.55", "2")))
    assert set(faults) == {f"wall_impact.{key}" for key in ("floors", "displacement", "theta")}
    faults = own_faults(with_wall(FULL, ("[7, 4]", "[7, 9]"), ("= 5", "= 10")))
    assert set(faults) == {"wall_impact.floors", "wall_impact.displaced_floor"}


def test_without_structure(broken: Broken) -> None:
    path = broken((None, "[pounding]", f"{SHORT}\n[pounding]"))
    faults = own_faults(path)
    assert faults == {
        "wall_impact": "None expected a [buildings.structure] beside it: the 3D model that moves"
    }


@pytest.mark.parametrize(
    ("written", "stiffness", "restitution"),
    [
        (CALIBRATED, "calibrated", "calibrated"),
        ('stiffness = "calibrated"\nrestitution = "60 %"\n', "calibrated", 0.6),
        ('stiffness = "calibrated"\ndamping_ratio = 0.1\n', "calibrated", None),
        ('stiffness = "2 kN/m"\nrestitution = "calibrated"\n', 2e3, "calibrated"),
    ],
)
def test_calibrated_law(
    with_wall: With, written: str, stiffness: float | str, restitution: float | str | None
) -> None:
    case = load_case(with_wall(case=(WRITTEN, written)))
    law = case.contact_laws["floor"]
    assert isinstance(law, KelvinVoigtLaw) and law.calibrated
    assert (law.stiffness, law.restitution) == (stiffness, restitution)
    dumped = json.loads(case.model_dump_json(include={"contact_laws"}))
    assert dumped["contact_laws"]["floor"]["stiffness"] == stiffness


def test_given_law_is_not_calibrated(pair: Path) -> None:
    law = load_case(pair).contact_laws["floor"]
    assert isinstance(law, KelvinVoigtLaw) and not law.calibrated


def test_calibrated_without_the_impact(structured: Structured, broken: Broken) -> None:
    for write in (structured, broken):
        faults = own_faults(write((None, WRITTEN, CALIBRATED)))
        assert set(faults) == {f"contact_laws.floor.{k}" for k in ("stiffness", "restitution")}
        for text in faults.values():
            assert text.startswith("calibrated expected a section [wall_impact] beside it")


@pytest.mark.parametrize(
    ("written", "key", "expected"),
    [
        ('stiffness = "calibratd"\nrestitution = 0.6', "stiffness",
         "expected a stiffness with its unit, for example '1e11 N/m'; or 'calibrated'"),
        ('stiffness = "1 N/m"\nrestitution = "measured"', "restitution",
         "expected a number above 0 and at most 1, bare or as a percentage: 0.05 or '5 %'; "
         "or 'calibrated'"),
        ('stiffness = "1 N/m"\nrestitution = 1.2', "restitution", "at most 1"),
        (f"{CALIBRATED}damping_ratio = 0.1", "damping_ratio", "not both"),
    ],
)  # fmt: skip
def test_law_refused(with_wall: With, written: str, key: str, expected: str) -> None:
    refused(with_wall(case=(WRITTEN, f"{written}\n")), f"contact_laws.floor.{key}", expected)


@pytest.mark.parametrize(
    ("name", "key"),
    [("hertz", "stiffness")]
    + [(n, k) for n in ("hertz-damp", "hunt-crossley", "jankowski") for k in GIVEN],
)
def test_laws_of_hertz_are_not_calibrated(with_wall: With, name: str, key: str) -> None:
    values = GIVEN | {key: '"calibrated"'}
    if name == "hertz":
        del values["restitution"]
    lines = [f"{k} = {value}\n" for k, value in values.items()]
    old = f'type = "kelvin-voigt"\n{WRITTEN}tension = true\n'
    refused(
        with_wall(case=(old, f'type = "{name}"\n{"".join(lines)}')),
        f"contact_laws.floor.{key}",
        "only a law of type 'kelvin-voigt' is calibrated",
    )


def test_contact_away_from_the_structure(with_wall: With) -> None:
    faults = own_faults(with_wall(SHORT + THIRD, case=(WRITTEN, CALIBRATED)))
    assert faults == {
        "contacts[1].law": "floor expected a law with values of its own: 'floor' is calibrated on "
        "B1, the contact is of B2 and B3"
    }
    # A law with values of its own holds for any pair.
    assert len(load_case(with_wall(SHORT + THIRD)).contacts) == 9
