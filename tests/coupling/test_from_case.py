import numpy as np
import pytest

from impactfem.case.motions import RestMotion
from impactfem.coupling.from_case import (
    calibration_of,
    given_parameters,
    ground_of,
    loads_of,
    stick_of,
    system_of,
)
from impactfem.coupling.laws import (
    Hertz,
    HertzDamp,
    HuntCrossley,
    Jankowski,
    KelvinVoigt,
    effective_mass,
)
from impactfem.coupling.pounding import simulate
from impactfem.coupling.restitution import kelvin_voigt as restitution
from impactfem.stages.calibrate.experiment import WallExperiment, run_stick, static_state
from impactfem.sticks.calibration import Parameters
from impactfem.system.errors import ImpactfemError, InputError

STOREY_CONTACT = """
[[contacts]]
a = { building = "west", floor = 2, offset = ["1 m", "6 m", "0.5 m"] }
b = { building = "east", storey = 3, relative_height = 0.25, offset = ["0 m", "-6 m", "0 m"] }
normal = [0, 2, 0]
gap = "3 cm"
law = "floor"
"""
# The floors of that pair pass each other by 0.6 m.
PASSING = ('allow = "gap"', 'allow = ["gap", "depth"]')
CALIBRATION = """
[calibration]
mode = "{mode}"
targets = "targets.csv"
direction = "y"
stiffness_factor = [0.1, 1.0]
rigid_depth = "0.5 m"
height = "10.5 m"
starts = 1
"""
UNDAMPED = 'mass_coefficient = "0.6 1/s"\nstiffness_coefficient = "0 s"\n'
TARGETS = """building,mode,frequency [Hz],effective_mass [t]
west,1,3.4,540
west,2,12.4,110
"""


FLOORS = """floor,mass [t],Jx [t m2],Jy [t m2],Jz [t m2],Ix [m4],Iy [m4],Iz [m4],\
A [m2],Avy [m2],Avx [m2],storey_height [m]
1,240,2880,8000,10880,0.9,0.9,1.8,3.4,1.0,1.0,
2,240,2880,8000,10880,0.9,0.9,1.8,3.4,1.0,1.0,
3,192,2304,6400,8704,0.9,0.9,1.8,3.4,1.0,1.0,
"""


@pytest.fixture(scope="module")
def case(small_case):
    return small_case(PASSING, extra=STOREY_CONTACT)


def test_section_and_axes(case):
    given = given_parameters(case.building("west"))
    assert (given.factor, given.below, given.above) == (0.5, 0.4, 0.1)
    assert given.heights == pytest.approx([3.5, 3.5, 3.5])
    assert calibration_of(case) is None
    # No two areas alike: Avx is for a force along x, Avy for one along y.
    building = case.building("east")
    row = building.floors[1].model_copy(
        update={"Avy": 0.7, "Avx": 1.3, "Ix": 0.8, "Iy": 1.1, "storey_stiffness_factor": 0.9}
    )
    building = building.model_copy(update={"floors": (building.floors[0], row)})
    section = stick_of(building).floors[1].section
    assert pytest.approx(0.5 * 0.9 * 30e9) == section.E
    assert pytest.approx(section.E / 2.4) == section.G
    assert (section.Avx, section.Avy, section.A, section.Iz) == (1.3, 0.7, 3.4, row.Iz)
    assert (section.Ix, section.Iy) == pytest.approx((0.4 * 0.8, 0.4 * 1.1))


def test_floors_and_damping(case):
    stick = stick_of(case.building("west"))
    floor = stick.floors[2]
    assert floor.number == 3 and floor.mass == 192e3
    assert floor.inertia == pytest.approx((2304e3, 6400e3, 8704e3))
    assert stick.damping.ratio(np.array([1.0, 20.0])) == pytest.approx(0.05)
    assert pytest.approx(stick.damping.alpha * stick.M + stick.damping.beta * stick.K) == stick.C
    assert stick.name == "west" and stick.axis == (10.0, 6.0) and stick.base == 0.0
    assert stick.positions[2] == pytest.approx([10.0, 6.0, 10.5])


def test_a_building_with_its_own_damping(small_case):
    own = small_case(("# damping = { ratio", "damping = { ratio"))
    west, east = (stick_of(building).damping for building in own.buildings)
    assert west.ratio(20.0) == pytest.approx(0.04) and east.ratio(20.0) == pytest.approx(0.05)


def test_parameters_take_the_place_of_the_file(case):
    parameters = Parameters(0.8, np.array([4.0, 3.4, 3.1]), 0.3, 0.2)
    stick = stick_of(case.building("west"), parameters)
    assert [floor.height for floor in stick.floors] == [4.0, 3.4, 3.1]
    assert {(floor.below, floor.above) for floor in stick.floors} == {(0.3, 0.2)}
    assert pytest.approx(0.8 * 30e9) == stick.floors[0].section.E


def test_pairs(case):
    system = system_of(case, None)
    assert [stick.name for stick in system.sticks] == ["west", "east"]
    first = system.pairs[0]
    assert first.a.building == "west" and first.b.building == "east"
    assert (first.a.floor, first.a.master, first.a.offset) == (1, 0, (0.0, 6.0, 0.0))
    assert first.a.relative_height is None
    assert first.gap == pytest.approx(0.005) and first.area == 5.0
    assert first.normal == pytest.approx([0.0, 1.0, 0.0])
    masses = [pair.law.mass for pair in system.pairs[:3]]
    assert masses == pytest.approx([120e3, 120e3, 96e3])
    law = first.law
    assert isinstance(law, KelvinVoigt) and law.tension and law.epsilon == pytest.approx(0.65)
    assert law.parameters[0] == 1.2e10
    assert law.parameters[1] == pytest.approx(2 * law.xi * np.sqrt(1.2e10 * 120e3))
    assert len({pair.name for pair in system.pairs}) == 4


def test_a_pair_inside_a_storey(case):
    system = system_of(case, None)
    pair, east = system.pairs[3], system.sticks[1]
    assert (pair.b.floor, pair.b.relative_height, pair.b.master) == (3, 0.25, 3)
    assert east.positions[3] == pytest.approx([10.0, 18.02, 7.0 + 0.25 * 3.5])
    assert not east.M[18:].any() and system.sticks[0].n == 18
    assert pair.area is None and pair.gap == pytest.approx(0.03)
    eccentric = 1 / (1 / 240e3 + 1.0**2 / 10880e3 + 0.5**2 / 2880e3)
    inside = 1 / (0.25**2 / 192e3 + 0.75**2 / 240e3)
    assert pair.law.mass == pytest.approx(effective_mass(eccentric, inside))


def test_a_pair_with_a_rigid_wall(small_case):
    """It has no mass to yield, and the law is that of the impact on the wall of `calibrate`."""
    case = small_case(('b = { building = "east"', 'wall = "pit" # "east"'))
    system = system_of(case, None)
    first = system.pairs[0]
    assert first.name == "west.floor_1-pit" and first.b is None
    assert first.law.mass == pytest.approx(240e3)
    K, xi = first.law.stiffness, first.law.xi
    experiment = WallExperiment((1, 2, 3), 3, -0.02, first.gap, duration=0.5, time_step=5e-4)
    stick = system.stick("west")
    expected = run_stick(stick, experiment, K=K, xi=xi)
    u0 = np.concatenate([static_state(stick, experiment), np.zeros(system.stick("east").n)])
    found = simulate(system, np.zeros((experiment.n_t, 3)), 5e-4, u0=u0)
    assert expected.force.max() > 1e6
    assert found.force == pytest.approx(expected.force, abs=1e-9 * expected.force.max())
    assert case.contacts[0].words == "west and the wall pit"


def test_laws(small_case):
    asked = "restitution = 0.65                    #"
    by_ratio = small_case((asked, 'damping_ratio = "14 %" #'))
    law = system_of(by_ratio, None).pairs[0].law
    assert law.xi == pytest.approx(0.14) and law.epsilon == pytest.approx(restitution(0.14))
    law = system_of(small_case((asked, f"tension = false\n{asked}")), None).pairs[0].law
    assert isinstance(law, KelvinVoigt) and not law.tension and law.epsilon == pytest.approx(0.65)
    assert law.xi == pytest.approx(0.1436, abs=0.05)
    assert restitution(law.xi, tension=False) == pytest.approx(0.65)
    assert law.xi != pytest.approx(system_of(by_ratio, None).pairs[0].law.xi, rel=1e-3)


LINEAR_LAW = 'type = "kelvin-voigt"\nstiffness = "1.2e10 N/m" '
ASKED = "restitution = 0.65 "
HERTZ_UNIT = 'stiffness = "3e11 N/m^1.5"\n#'
MAKERS = {"hertz-damp": HertzDamp, "hunt-crossley": HuntCrossley, "jankowski": Jankowski}


@pytest.mark.parametrize("relation", ["", "published", "exact"])
@pytest.mark.parametrize("name", MAKERS)
def test_laws_after_hertz(small_case, name, relation):
    more = f'\nrelation = "{relation}"' if relation else ""
    asked = f"restitution = 0.4{more} #"
    case = small_case((LINEAR_LAW, f'type = "{name}"\n{HERTZ_UNIT}'), (ASKED, asked))
    pair = system_of(case, None).pairs[2]
    expected = MAKERS[name](3e11, 0.4, relation or "published", mass=96e3)
    assert pair.law.name == name == expected.name
    assert type(pair.law) is type(expected) and pair.law.target_restitution == 0.4
    assert pair.law.parameters == pytest.approx(expected.parameters)
    assert pair.law.mass == pytest.approx(96e3)
    slow = asked.replace(" #", '\nslowest_approach = "2 cm/s" #')
    if name != "jankowski":
        change = (LINEAR_LAW, f'type = "{name}"\n{HERTZ_UNIT}')
        law = system_of(small_case(change, (ASKED, slow)), None).pairs[0].law
        assert (law.parameters[2], pair.law.parameters[2]) == (0.02, 1e-3)
    assert (pair.law.epsilon == pytest.approx(0.4, abs=1e-4)) == (relation == "exact")


def test_elastic_law_of_hertz(small_case):
    elastic = (LINEAR_LAW, f'type = "hertz"\n{HERTZ_UNIT}')
    law = system_of(small_case(elastic, (ASKED, "# ")), None).pairs[0].law
    assert law == Hertz(3e11, mass=120e3)
    with pytest.raises(InputError, match="restitution"):
        small_case(elastic)


def test_relative_height_at_the_end_of_a_storey_is_refused(small_case):
    for height in ("0", "1", "0.0", '"100 %"'):
        with pytest.raises(InputError, match="relative_height"):
            small_case(PASSING, extra=STOREY_CONTACT.replace("0.25", height))
    with pytest.raises(InputError, match="rigid zones"):
        small_case(PASSING, extra=STOREY_CONTACT.replace("0.25", '"89 %"'))
    assert small_case(PASSING, extra=STOREY_CONTACT.replace("0.25", '"88 %"')).contacts[-1].b


def test_a_level_is_a_height_in_a_storey(small_case):

    def given(level):
        key = "storey = 3, relative_height = 0.25"
        return small_case(PASSING, extra=STOREY_CONTACT.replace(key, f'level = "{level}"'))

    (pair,) = given("7.875 m").contacts[3:]
    assert (pair.b.storey, pair.b.relative_height) == (3, 0.25)
    for level, expected in (("10.5 m", "no_storey"), ("0 m", "no_storey"), ("7 m", "of_contacts")):
        with pytest.raises(InputError) as error:
            given(level)
        assert [(fault.key, fault.kind) for fault in error.value.faults] == [
            ("contacts[1].b.level", expected)
        ]


def test_a_storey_point_needs_damping(small_case):
    undamped = ('ratio = "5 %"\nfrequencies = ["1 Hz", "20 Hz"]\n', UNDAMPED)
    case = small_case(undamped, PASSING, extra=STOREY_CONTACT)
    with pytest.raises(ImpactfemError, match="below floor 3 has"):
        system_of(case, None)
    assert len(system_of(small_case(undamped), None).pairs) == 3


def test_calibration_as_given(small_case):
    extra = CALIBRATION.format(mode="given")
    found = calibration_of(small_case(extra=extra, files={"targets.csv": TARGETS}))
    assert found.parameters.factor == 0.5 and found.parameters.below == 0.4
    assert [target.frequency for target in found.targets] == [3.4, 12.4]
    assert found.targets[0].effective_mass == 540e3
    assert np.abs(found.frequency_error).max() > 1e-3


def test_a_mode_too_high_is_found_by_the_check(small_case):
    high = TARGETS + "west,7,90,1\n"
    with pytest.raises(InputError, match="mode 7 of west"):
        small_case(extra=CALIBRATION.format(mode="given"), files={"targets.csv": high})
    highest = TARGETS + "west,6,90,1\n"
    case = small_case(extra=CALIBRATION.format(mode="given"), files={"targets.csv": highest})
    assert calibration_of(case).frequency.size == 3


def test_heights_of_the_case_that_add_up_but_for_rounding(small_case):
    # 3.3 + 3.3 + 3.3 is not 9.9 in binary.
    header, *rows = FLOORS.splitlines()
    floors = "\n".join([header, *(row + "3.3" for row in rows)]) + "\n"
    files = {"targets.csv": TARGETS, "small_floors.csv": floors}
    extra = CALIBRATION.format(mode="fit").replace("10.5 m", "9.9 m")
    found = calibration_of(small_case(extra=extra, files=files))
    assert found.parameters.heights == pytest.approx([3.3] * 3, abs=1e-12)
    with pytest.raises(InputError, match=r"sum up to, 9\.9 m"):
        small_case(extra=extra.replace("9.9 m", "9.901 m"), files=files)


def test_calibration_goes_to_the_buildings_of_its_targets(small_case):
    extra = CALIBRATION.format(mode="fit")
    fitted = small_case(extra=extra, files={"targets.csv": TARGETS})
    found = calibration_of(fitted)
    start = calibration_of(
        small_case(extra=CALIBRATION.format(mode="given"), files={"targets.csv": TARGETS})
    )
    assert np.abs(found.frequency_error).max() < np.abs(start.frequency_error).max()
    west, east = system_of(fitted, found).sticks
    assert pytest.approx(found.parameters.factor * 30e9) == west.floors[0].section.E
    assert west.floors[0].below == found.parameters.below
    assert pytest.approx(0.5 * 30e9) == east.floors[0].section.E
    assert east.floors[0].below == 0.4


BLAST = "time [ms],west.floor_3 [MN],east.floor_1 [kN]\n0,0,0\n10,2,-40\n20,0,0\n"
LOADS = '\n[[loads]]\nfile = "blast.csv"\ndirection = [0, -3, 0]\n'


def test_loads_on_floors(small_case, run):
    """A triangle of 20 ms with 2 MN at its peak gives 20 kN s along −y."""
    case = small_case(extra=LOADS, files={"blast.csv": BLAST})
    dt = case.pounding.time_step
    system = system_of(case, None)
    first, second = loads_of(case, system, dt, 400)
    assert (first.at.building, first.at.floor, second.at.building) == ("west", 3, "east")
    assert first.direction.tolist() == [0.0, -1.0, 0.0]
    assert first.force.sum() * dt == pytest.approx(20e3, rel=2e-3)
    study, without = run(case), run(small_case())
    assert len(study.response.loads) == 2
    assert np.abs(study.response.u - without.response.u).max() > 1e-4
    # Also in the run that pounding is held against.
    assert len(study.free.loads) == 2
    assert study.response.energy.residual < 1e-9


def test_loads_alone(small_case, run):
    """The first instants: the momentum of the building is the impulse."""
    case = small_case(extra=LOADS, files={"blast.csv": BLAST})
    rest = RestMotion(direction="y", type="rest", duration=0.02, time_step=1e-3)
    pounding = case.pounding.model_copy(update={"duration": 0.02})
    study = run(case.model_copy(update={"motions": (rest,), "pounding": pounding}))
    assert not study.response.ground.any()
    stick = study.system.stick("west")
    v = study.response.v[-1, : stick.n]
    momentum = float(stick.rigid_body()[:, 1] @ stick.M @ v)
    # The base has taken little of it by then.
    assert momentum == pytest.approx(-20e3, rel=0.1)


def test_steps_that_are_too_coarse_for_a_pulse_are_warned_of(small_case, caplog):
    case = small_case(extra=LOADS, files={"blast.csv": BLAST})
    system = system_of(case, None)
    loads_of(case, system, 1e-3, 100)
    assert "an impulse is" not in caplog.text
    loads_of(case, system, 7e-3, 100)
    assert "pounding.time_step" in caplog.text


def test_the_ground_lasts_until_the_waves_have_passed(small_case):
    """One second of motion, and the delay of the building that they reach last."""
    passage = (
        ("# [wave_passage]\n#", "[wave_passage]\n"),
        ("# direction = [0, 1]", "direction = [0, 1]"),
    )
    case = small_case(*passage, ('"1000 m/s"', '"10 m/s"'))
    ground = ground_of(case, [(1, 0.01, np.ones(101))], 1e-3)
    later = case.delays["east"]
    assert later > 0.1 and len(ground.acceleration) == round((1.0 + later) / 1e-3) + 1
    assert ground.relative["east"][2, -1, 1] == pytest.approx(1.0)
