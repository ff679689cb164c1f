"""Contact laws that take their values from the impact on a wall."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
import xarray as xr

from impactfem.case import KelvinVoigtLaw, load_case
from impactfem.case.damping import RayleighCase
from impactfem.case.transient import Transient
from impactfem.coupling.from_case import system_of
from impactfem.stages.calibrate.selection import (
    asks_calibration,
    calibrated_laws,
    calibrated_restitutions,
    impulses_of_run,
    with_calibrated_contact,
    with_contact_of_run,
)
from impactfem.stages.calibrate.stage import CALIBRATE
from impactfem.stages.pounding.stage import POUNDING
from impactfem.system.errors import ImpactfemError
from one_building import building_of

GEOMETRY = Path(__file__).parents[3] / "geometry"
EPSILON, K_CEQ = 0.687, 1.1e11


@pytest.fixture(scope="module")
def given(new_case, tmp_path_factory):
    """Two sticks, and the 3D model of the first before a wall."""
    case, paper = (
        load_case(path)
        for path in (new_case(tmp_path_factory.mktemp("given")), GEOMETRY / "npp_pair.toml")
    )
    first = case.buildings[0].model_copy(update={"stick": "own"})
    models = {key: getattr(paper, key) for key in ("structure", "wall_impact")}
    name = {"building": first.name}
    update = {k: v.model_copy(update=name) for k, v in models.items()}
    return case.model_copy(update={**update, "buildings": (first, *case.buildings[1:])})


def asking(case, **values):
    """The case with other values of its one law, unchecked."""
    law = case.contact_laws["floor"].model_copy(update=values)
    return case.model_copy(update={"contact_laws": {"floor": law}})


@pytest.fixture(scope="module")
def case(given):
    return asking(given, stiffness="calibrated", restitution="calibrated")


def law_of(case):
    law = case.contact_laws["floor"]
    assert isinstance(law, KelvinVoigtLaw)
    return law


def store(folder, epsilon, **more):
    values = {"epsilon": [epsilon, 0.5]} | {name: [value, 1e9] for name, value in more.items()}
    xr.Dataset(
        {name: ("case", both) for name, both in values.items()}, coords={"case": ["own", "other"]}
    ).to_netcdf(folder / "calibrate.nc", engine="netcdf4")
    return folder


def test_which_laws_leave_their_restitution_open(given, case):
    assert calibrated_laws(given) == calibrated_laws(asking(given, stiffness="calibrated")) == set()
    assert calibrated_laws(case) == {"floor"}


def test_who_asks(given, case):
    assert not asks_calibration(given)
    assert POUNDING.needs(given) == ()
    for one in (
        case,
        asking(given, stiffness="calibrated"),
        asking(given, restitution="calibrated"),
    ):
        assert asks_calibration(one)
        assert POUNDING.needs(one) == (CALIBRATE,)
    # A law that no contact has needs no calibration.
    assert not asks_calibration(case.model_copy(update={"contacts": ()}))


def test_numbers_in_place_of_the_words(given, case):
    law = law_of(with_calibrated_contact(case, EPSILON, K_CEQ))
    assert (law.stiffness, law.restitution) == (pytest.approx(K_CEQ, rel=1e-15), EPSILON)
    assert law_of(case).calibrated  # a copy
    law = law_of(with_calibrated_contact(asking(given, stiffness="calibrated"), EPSILON, K_CEQ))
    assert (law.stiffness, law.restitution) == (pytest.approx(K_CEQ, rel=1e-15), 0.65)
    law = law_of(with_calibrated_contact(asking(given, restitution="calibrated"), EPSILON, K_CEQ))
    assert (law.stiffness, law.restitution) == (1.2e10, EPSILON)
    damped = asking(given, stiffness="calibrated", restitution=None, damping_ratio=0.1)
    law = law_of(with_calibrated_contact(damped, EPSILON, K_CEQ))
    assert (law.restitution, law.damping_ratio) == (None, 0.1)


def test_a_case_that_does_not_ask_stays(given):
    assert with_calibrated_contact(given, EPSILON, K_CEQ) is given


def test_sticks_get_equations_4_and_6(case):
    found = with_calibrated_contact(case, EPSILON, K_CEQ)
    for pair in system_of(found, None).pairs:
        assert pair.law.stiffness == pytest.approx(K_CEQ, rel=1e-15)
        assert pair.law.xi == pytest.approx(0.1187, abs=5e-5)  # equation 4 for 0.687
        assert pair.law.epsilon == pytest.approx(EPSILON, rel=1e-12)


@pytest.mark.parametrize("epsilon", [0.3, EPSILON, 1.0])
def test_a_law_that_may_not_pull_keeps_the_duration(case, epsilon):
    mass = 3014e3
    logarithm = math.log(epsilon)
    xi_c = -logarithm / math.hypot(math.pi, logarithm)
    duration = math.pi / math.sqrt(K_CEQ / mass * (1.0 - xi_c**2))  # equation 6
    found = with_calibrated_contact(asking(case, tension=False), epsilon, K_CEQ)
    K = law_of(found).stiffness
    assert isinstance(K, float)
    law = system_of(found, None).pairs[0].law
    assert law.epsilon == pytest.approx(epsilon, rel=1e-9)
    # The free flight until p'' = 0 of p'' + 2 ξ Ω p' + Ω² p = 0, p = 0 at the start.
    omega = math.sqrt(K / mass)
    damped = omega * math.sqrt(1.0 - law.xi**2)
    t = duration
    p = math.exp(-law.xi * omega * t) * math.sin(damped * t) / damped
    v = math.exp(-law.xi * omega * t) * (
        math.cos(damped * t) - law.xi * omega / damped * math.sin(damped * t)
    )
    assert omega**2 * p + 2.0 * law.xi * omega * v == pytest.approx(0.0, abs=1e-8 * omega)
    assert v == pytest.approx(-epsilon, rel=1e-8)


@pytest.mark.parametrize("values", [{"stiffness": 1e10}, {"restitution": 0.5}, {}])
def test_sticks_never_see_the_word(case, values):
    with pytest.raises(ValueError, match="contact law floor"):
        system_of(asking(case, **values), None)


def test_a_law_without_any_damping_is_refused(given):
    words = "contact law floor has no restitution and no damping_ratio"
    with pytest.raises(ValueError, match=words):
        system_of(asking(given, restitution=None), None)


def test_values_of_the_run(case, given, tmp_path):
    folder = store(tmp_path, EPSILON, K_Ceq=K_CEQ)
    assert with_contact_of_run(case, folder) == with_calibrated_contact(case, EPSILON, K_CEQ)
    assert with_contact_of_run(given, tmp_path / "nowhere") is given


@pytest.mark.parametrize(
    ("epsilon", "more", "missing"), [(math.nan, {"K_Ceq": K_CEQ}, "epsilon"), (0.6, {}, "K_Ceq")]
)
def test_a_store_without_the_values(case, tmp_path, epsilon, more, missing):
    folder = store(tmp_path, epsilon, **more)
    with pytest.raises(ImpactfemError, match=f"calibrate.nc has no {missing}, case own"):
        with_contact_of_run(case, folder)


def test_restitutions_of_damping_cases(given, tmp_path):
    """Of those that leave it to the wall, by name; none where there is no wall."""
    other = RayleighCase(name="other", ratio=0.07, frequencies=(1.0, 20.0))
    dampings = other, other.model_copy(update={"name": "stiff", "restitution": 0.4})
    case = given.model_copy(update={"damping_cases": dampings})
    without = case.model_copy(update={"wall_impact": None})
    assert calibrated_restitutions(without, tmp_path / "nowhere") == {}
    folder = store(tmp_path, EPSILON)
    assert calibrated_restitutions(case, folder) == {"other": 0.5}
    lone = case.model_copy(update={"damping_cases": dampings[1:]})
    assert calibrated_restitutions(lone, tmp_path / "nowhere") == {}
    light = other.model_copy(update={"name": "light"})
    lacking = case.model_copy(update={"damping_cases": (light,)})
    with pytest.raises(ImpactfemError, match="epsilon, case light"):
        calibrated_restitutions(lacking, folder)


def test_impulses_along_the_edges(given, tmp_path):
    """Of each floor in the order of its points of contact, for the spread that asks for them."""
    xr.Dataset(
        {"constraint_force": (("step", "constraint"), [[1.0, 0.0, 2.0], [3.0, 5.0, 0.0]])},
        coords={"constraint_floor": ("constraint", [2, 2, 3])},
    ).to_netcdf(tmp_path / "calibrate.nc", engine="netcdf4")
    spread = Transient(time_step=1e-3, spread="calibrated")
    found = impulses_of_run(replace(building_of(given), transient=spread), tmp_path)
    assert {floor: of.tolist() for floor, of in found.items()} == {2: [4.0, 5.0], 3: [2.0]}
    uniform = replace(building_of(given), transient=Transient(time_step=1e-3))
    assert impulses_of_run(uniform, tmp_path / "nowhere") is None
