"""Keys of capacities: bolts and spectra of devices, limits of buildings."""

import math

import pytest

from impactfem.case import load_case
from impactfem.case.capacities import AnchorBolts, Limits

from .faults import by_file, check_row, each_row, refused
from .sections import MODES, PUMP, TRANSIENT, Base
from .texts import replaced

ANCHORS = """
[devices.anchors]
count = 4
circle = "0.8 m"
first_angle = "45 deg"
area = "245 mm2"
tension = "141.1 kN"
shear = "94.1 kN"
"""
SPECTRUM = """
[devices.required_spectrum]
file = "pair_rrs.csv"
damping = "5 %"
"""
RRS = """\
frequency [Hz],acceleration [m/s2],axes
1,5,xy
10,50,xy
100,20,xy
100,8,z
1,2,z
"""
LIMITS = """
[limits]
gap = "en1998"
floor_acceleration = "1 g"
storey_drift = "0.5 %"
"""
BASE = Base(TRANSIENT + PUMP + ANCHORS + SPECTRUM + LIMITS, files=MODES | {"pair_rrs.csv": RRS})


def test_capacities_of_a_device(written):
    case = load_case(written(BASE))
    (pump,) = case.devices
    assert pump.anchors == AnchorBolts(
        count=4,
        circle=0.8,
        first_angle=math.pi / 4.0,
        area=245e-6,
        tension=141.1e3,
        shear=94.1e3,
    )
    assert (pump.anchors.exponent, pump.anchors.modular_ratio) == (1.5, 7.0)
    corner = 0.4 / math.sqrt(2.0)
    assert pump.anchors.places(0.5)[1] == pytest.approx((-corner, corner))
    horizontal, vertical = pump.required_spectrum.file
    assert (horizontal.axes, horizontal.acceleration) == ("xy", (5.0, 50.0, 20.0))
    # Ascending, whatever the order in the file.
    assert (vertical.axes, vertical.frequency) == ("z", (1.0, 100.0))
    assert case.limits == Limits(gap="en1998", floor_acceleration=9.80665, storey_drift=0.005)


def test_without_capacities(structured):
    case = load_case(structured(more=TRANSIENT + PUMP, files=MODES))
    assert case.devices[0].anchors is None and case.limits == Limits()


@pytest.mark.parametrize(
    "positions",
    ['"pair_bolts.csv"', '[{ x = "0.2 m", y = "10 cm" }, { x = "-30 cm", y = "0 m" }]'],
)
def test_positions_in_a_file_and_in_the_case(written, positions):
    text = replaced(ANCHORS, ('count = 4\ncircle = "0.8 m"\nfirst_angle = "45 deg"\n', ""))
    more = f"{TRANSIENT}{PUMP}{text}positions = {positions}\n"
    files = MODES | {"pair_bolts.csv": "x [m],y [cm]\n0.2,10\n-0.3,0\n"}
    (pump,) = load_case(written(Base(more, files=files))).devices
    assert pump.anchors.places(0.5) == ((0.2, 0.1), (-0.3, 0.0))


def test_zpa_limit_of_one_value_or_three(written):
    for value, expected in (
        ('"2 g"', [19.6133] * 3),
        ('["1 g", "1 g", "2 m/s2"]', [9.80665] * 2 + [2]),
    ):
        more = f"{TRANSIENT}{PUMP}zpa_limit = {value}\n"
        (pump,) = load_case(written(Base(more, files=MODES))).devices
        assert pump.zpa_limit == pytest.approx(expected)


@each_row(
    [
        (
            BASE,
            None,
            "devices[0].anchors.",
            [
                ("count = 4", "count = 1", "count", "greater_than_equal"),
                ('circle = "0.8 m"', 'circle = "-1 m"', "circle", "greater_than"),
                ('"45 deg"', '"45 m"', "first_angle", "unit"),
                ('"45 deg"', "45", "first_angle", "unit_missing"),
                ('"245 mm2"', '"20 mm"', "area", "unit"),
                ('"141.1 kN"', '"0 kN"', "tension", "greater_than"),
                ('shear = "94.1 kN"\n', "", "shear", "missing"),
                (
                    'shear = "94.1 kN"',
                    'shear = "94.1 kN"\nexponent = 3',
                    "exponent",
                    "less_than_equal",
                ),
                ("count = 4\n", "", "positions", "count_or_positions missing"),
                (
                    "count = 4\n",
                    'count = 4\npositions = [{ x = "0 m", y = "0 m" }]\n',
                    "positions",
                    "count_or_positions not both",
                ),
                ('circle = "0.8 m"', 'circle = "0.8 m"\nplate = ["1 m"]', "plate", "two_sides two"),
            ],
        ),
        (
            BASE,
            None,
            "devices[0].",
            [
                # On the edge of the plate it may stand, beyond it may not.
                ('circle = "0.8 m"', 'circle = "1.02 m"', "anchors", "on_the_plate 0.5 m"),
                (
                    'circle = "0.8 m"',
                    'circle = "0.8 m"\nplate = ["0.5 m", "1 m"]',
                    "anchors",
                    "on_the_plate 0.5 m x 1 m",
                ),
                ('damping = "5 %"\n', "", "required_spectrum.damping", "missing"),
                (
                    'damping = "5 %"\n',
                    'damping = "0 %"\n',
                    "required_spectrum.damping",
                    "greater_than",
                ),
                ("pair_rrs.csv", "none.csv", "required_spectrum.file", "unreadable"),
            ],
        ),
        (
            BASE,
            None,
            "limits.",
            [
                ('gap = "en1998"', 'gap = "ec8"', "gap", "literal_error"),
                ('"1 g"', '"1 kg"', "floor_acceleration", "unit"),
                ('"0.5 %"', "2", "storey_drift", "less_than"),
            ],
        ),
        (
            BASE,
            "pair_rrs.csv",
            "line ",
            [
                ("10,50,xy", "10,0,xy", "3, column acceleration [m/s2]", "greater_than"),
                ("10,50,xy", "10,50,xy\n2,4,xy", "4, column frequency [Hz]", "order"),
                ("1,2,z", "1,2,z\n1,3,yz\n9,3,yz", "7, column axes", "of_one_spectrum"),
                ("1,2,z\n", "", "5", "points"),
                ("1,5,xy", "1,5,yx", "2, column axes", "text"),
            ],
        ),
    ]
)
def test_each_invalid_value_is_one_fault(written, base, file, key, row):
    check_row(written, base, file, key, row)


def test_bolts_at_one_place_or_alone(written):
    text = replaced(ANCHORS, ('count = 4\ncircle = "0.8 m"\nfirst_angle = "45 deg"\n', ""))
    for rows, kind in (("0.2,0.1\n0.2,0.1\n", "apart 0.2, 0.1"), ("0.2,0.1\n", "apart 2 bolts")):
        more = f'{TRANSIENT}{PUMP}{text}positions = "pair_bolts.csv"\n'
        path = written(Base(more, files=MODES | {"pair_bolts.csv": f"x [m],y [m]\n{rows}"}))
        refused(path, "devices[0].anchors.positions", kind)


def test_faults_of_a_table_of_bolts_are_its_own(written):
    text = replaced(ANCHORS, ('count = 4\ncircle = "0.8 m"\nfirst_angle = "45 deg"\n', ""))
    more = f'{TRANSIENT}{PUMP}{text}positions = "pair_bolts.csv"\n'
    path = written(Base(more, files=MODES | {"pair_bolts.csv": "x [m],z [m]\n0.2,0.1\n"}))
    assert set(by_file(path)) == {"pair_bolts.csv: line 1, column z [m]", "pair_bolts.csv: line 1"}


def test_three_limits_of_two(written):
    more = f'{TRANSIENT}{PUMP}zpa_limit = ["1 g", "1 g"]\n'
    refused(written(Base(more, files=MODES)), "devices[0].zpa_limit", "three_axes three")
