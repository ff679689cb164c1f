"""Contact laws as they are written in the case file."""

from collections.abc import Callable
from pathlib import Path

import pytest

from impactfem.case import HertzDampLaw, HertzLaw, HuntCrossleyLaw, JankowskiLaw, load_case
from impactfem.system.errors import InputError

WRITTEN = """type = "kelvin-voigt"
stiffness = "1e11 N/m"
damping_ratio = "12 %"
tension = true
"""
HERTZ = 'type = "hertz"\nstiffness = "2 N/m^1.5"\n'
DAMPED = {
    "hertz-damp": HertzDampLaw,
    "hunt-crossley": HuntCrossleyLaw,
    "jankowski": JankowskiLaw,
}
NAMES = " or ".join(f"'{name}'" for name in ("kelvin-voigt", "hertz", *DAMPED))

Broken = Callable[..., Path]


def test_law_of_hertz(broken: Broken) -> None:
    law = load_case(broken((None, WRITTEN, HERTZ))).contact_laws["floor"]
    assert law == HertzLaw(type="hertz", stiffness=2.0)


@pytest.mark.parametrize("name", DAMPED)
def test_damped_laws(broken: Broken, name: str) -> None:
    written = HERTZ.replace("hertz", name) + 'restitution = "60 %"\n'
    law = load_case(broken((None, WRITTEN, written))).contact_laws["floor"]
    assert law == DAMPED[name](type=name, stiffness=2.0, restitution=0.6)
    exact = f'{written}relation = "exact"\n'
    if name != "jankowski":
        exact += 'slowest_approach = "5 mm/s"\n'
    law = load_case(broken((None, WRITTEN, exact))).contact_laws["floor"]
    more = {} if name == "jankowski" else {"slowest_approach": 0.005}
    assert law == DAMPED[name](type=name, stiffness=2.0, restitution=0.6, relation="exact", **more)


@pytest.mark.parametrize(
    ("unit", "factor"), [("N/m^1.5", 1.0), ("kN/mm^1.5", 1e3 * 1e3**1.5), ("MN/m^1.5", 1e6)]
)
def test_units_of_the_stiffness_of_hertz(broken: Broken, unit: str, factor: float) -> None:
    path = broken((None, WRITTEN, HERTZ.replace("N/m^1.5", unit)))
    assert load_case(path).contact_laws["floor"].stiffness == pytest.approx(2.0 * factor)


REFUSED = [
    ('type = "hertz"\nstiffness = "1e11 N/m"', "stiffness",
     "'N/m' is a stiffness; expected a stiffness of Hertz contact"),
    ('type = "kelvin-voigt"\nstiffness = "2 N/m^1.5"\nrestitution = 0.6', "stiffness",
     "'N/m^1.5' is a stiffness of Hertz contact; expected a stiffness"),
    ('type = "hertz"', "stiffness", "missing; expected a stiffness of Hertz contact"),
    (f"{HERTZ}restitution = 0.6", "restitution", "unknown key; known: type, stiffness"),
    (f"{HERTZ}damping_ratio = 0.1", "damping_ratio", "unknown key"),
    ('type = "kelvin-voigt"\nstiffness = "1 N/m"\nrestitution = 0.6\nrelation = "exact"',
     "relation", "unknown key"),
    ('type = "jankowski"\nstiffness = "2 N/m^1.5"\nrestitution = 0.6\nslowest_approach = "1 m/s"',
     "slowest_approach", "unknown key"),
]  # fmt: skip


@pytest.mark.parametrize(("written", "key", "expected"), REFUSED)
def test_law_refused(broken: Broken, written: str, key: str, expected: str) -> None:
    with pytest.raises(InputError) as caught:
        load_case(broken((None, WRITTEN, f"{written}\n")))
    (fault,) = caught.value.faults
    assert fault.key == f"contact_laws.floor.{key}" and expected in fault.expected


@pytest.mark.parametrize("name", DAMPED)
@pytest.mark.parametrize(
    ("written", "key", "expected"),
    [
        ("restitution = 1\ntension = true", "tension", "unknown key"),
        ("restitution = 1\ndamping_ratio = 0", "damping_ratio", "unknown key"),
    ],
)
def test_damped_law_refused(
    broken: Broken, name: str, written: str, key: str, expected: str
) -> None:
    test_law_refused(broken, f"{HERTZ.replace('hertz', name)}{written}", key, expected)


@pytest.mark.parametrize("name", ["hertz-damp", "hunt-crossley"])
@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ('"0 m/s"', "expected a velocity above 0"),
    ],
)
def test_slowest_approach_refused(broken: Broken, name: str, value: str, expected: str) -> None:
    written = f"{HERTZ.replace('hertz', name)}restitution = 0.6\nslowest_approach = {value}"
    test_law_refused(broken, written, "slowest_approach", expected)


@pytest.mark.parametrize(
    ("written", "lead"),
    [
        ('type = "herz"\nstiffness = "2 N/m^1.5"', "expected "),
        ('stiffness = "2 N/m^1.5"', "missing; expected "),
    ],
)
def test_unknown_type_names_the_known_ones(broken: Broken, written: str, lead: str) -> None:
    test_law_refused(broken, written, "type", lead + NAMES)
