"""The tables of the stage `calibrate`, and the paper's values beside its own equations."""

import csv
import math
from pathlib import Path

import pytest

from impactfem.case.report import read_published
from impactfem.stages.calibrate.tables import wall_tables
from impactfem.system.errors import ImpactfemError

PUBLISHED = Path(__file__).parents[3] / "geometry" / "npp_pair_published.csv"
PUBLISHED_RATIOS = {
    "calibration.epsilon": 0.5,
    "calibration.epsilon.under-damped": 0.891,
    "calibration.epsilon.over-damped": 0.414,
    "calibration.epsilon.under-damped.printed": 0.414,
    "calibration.epsilon.over-damped.printed": 0.891,
}


def rows(path):
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def impacts(folder):
    return {(r["model"], r["floor"], r["impact"]): r for r in rows(wall_tables(folder, {})[1])}


def test_values_beside_published_ones(wall_folder):
    folder = wall_folder(scalars={"second_impulse": None})
    published = {"calibration.second_impulse": 37e3, "calibration.K_Ceq": 1e11}
    found = rows(wall_tables(folder, published)[0])
    # Published ones first, in the order of the stage.
    assert [row["name"] for row in found[:2]] == ["calibration.K_Ceq", "calibration.second_impulse"]
    assert float(found[0]["over published"]) == pytest.approx(1.2)
    assert (found[1]["value"], found[1]["over published"]) == ("", "")
    assert all(row["published"] == "" for row in found[2:])
    assert len(found) == 13


def test_a_published_zero_has_no_ratio(wall_folder):
    folder = wall_folder(scalars={"floor_6.impacts": 1.0})
    row = rows(wall_tables(folder, {"calibration.floor_6.impacts": 0.0})[0])[0]
    assert (row["value"], row["published"], row["over published"]) == ("1.0", "0.0", "")


def test_impacts_of_all_floors(wall_folder):
    found = impacts(wall_folder())
    assert set(found) == {
        *(("3D", "8", "1"), ("3D", "7", "1"), ("3D", "6", "0")),
        *(("stick", "8", "1"), ("stick", "8", "2"), ("stick", "7", "1"), ("stick", "6", "0")),
    }
    main = found["3D", "8", "1"]
    assert float(main["start [s]"]) == pytest.approx(0.2003, abs=1e-9)
    assert float(main["duration [ms]"]) == pytest.approx(16.0, abs=1e-6)
    # The trapezoidal rule on a half sine of 32 steps.
    assert float(main["impulse [kN s]"]) == pytest.approx(800.0, rel=2e-3)
    assert float(main["peak [MN]"]) == pytest.approx(0.5 * math.pi * 800e3 / 0.016 / 1e6, rel=3e-3)
    assert float(main["approach [m/s]"]) == pytest.approx(0.16)
    assert float(main["rebound [m/s]"]) == pytest.approx(0.1)
    assert float(main["epsilon [-]"]) == pytest.approx(800e3 / (3e6 * 0.16) - 1.0, rel=5e-3)
    assert (main["pulses"], main["over"]) == ("1", "yes")
    assert float(main["steps"]) == pytest.approx(32.0)
    second = found["stick", "8", "2"]
    assert float(second["start [s]"]) == pytest.approx(0.4502, abs=1e-9)
    assert float(second["impulse [kN s]"]) == pytest.approx(37.0, rel=2e-3)
    none = found["3D", "6", "0"]
    assert none["start [s]"] == none["over"] == ""
    assert float(none["nearest [mm]"]) == pytest.approx(1.0)


@pytest.mark.parametrize(("separation", "number", "pulses"), [(5e-3, 1, "2"), (2e-3, 2, "1")])
def test_pulses_are_parted_as_the_case_asks(wall_folder, separation, number, pulses):
    hits = {8: ((0.2, 0.01, 500e3), (0.214, 0.01, 300e3))}
    found = impacts(wall_folder(hits=hits, stick_hits=hits, separation=separation))
    assert len([key for key in found if key[0] == "3D"]) == number
    assert found["3D", "8", "1"]["pulses"] == pulses
    impulse = 800.0 if number == 1 else 500.0
    assert float(found["3D", "8", "1"]["impulse [kN s]"]) == pytest.approx(impulse, rel=5e-3)


def test_an_impact_that_is_not_over(wall_folder):
    hits = {8: ((0.2, 0.016, 800e3), (0.595, 0.016, 100e3))}
    found = impacts(wall_folder(hits=hits, stick_hits=hits))
    assert (found["3D", "8", "1"]["over"], found["3D", "8", "2"]["over"]) == ("yes", "no")


def test_dampings_beside_both_readings_of_table_8(wall_folder):
    found = rows(wall_tables(wall_folder(), PUBLISHED_RATIOS)[2])
    readings = [(r["damping"], r["by the text [-]"], r["as printed [-]"]) for r in found]
    assert readings == [
        ("own", "0.5", "0.5"),
        ("under-damped", "0.891", "0.414"),
        ("over-damped", "0.414", "0.891"),
    ]
    # ξ = α / (4 π f) + π β f at f = 1 / (2 · 16 ms).
    under = float(found[1]["xi at 31.2 Hz [%]"])
    assert under == pytest.approx(100 * (0.838 / (4 * math.pi * 31.25) + math.pi * 2.12e-4 * 31.25))
    assert float(found[2]["duration [ms]"]) == pytest.approx(17.0)


def test_dampings_without_published_values(wall_folder):
    (row,) = rows(wall_tables(wall_folder(dampings=1), {})[2])
    assert row["damping"] == "own"
    assert not {"by the text [-]", "as printed [-]"} & set(row)


def test_a_table_that_cannot_be_written(wall_folder):
    folder = wall_folder()
    (folder / "tables" / "wall_impacts.csv" / "full").mkdir(parents=True)
    with pytest.raises(ImpactfemError, match=r"cannot write .*wall_impacts"):
        wall_tables(folder, {})


@pytest.fixture(scope="module")
def paper():
    faults = []
    table = read_published(PUBLISHED, faults)
    assert table is not None and not faults
    return {name: entry.value for name, entry in table.items()}


def test_the_papers_values_obey_its_equations(paper):
    mass = paper["building.floor_mass.8"]
    momentum = mass * paper["calibration.approach_velocity"]
    epsilon, xi = paper["calibration.epsilon"], paper["calibration.xi_c"]
    assert paper["calibration.impulse"] / momentum - 1.0 == pytest.approx(epsilon, abs=1e-3)
    stiffness = mass / (1.0 - xi**2) * (math.pi / paper["calibration.impact_duration"]) ** 2
    assert paper["calibration.K_Ceq"] == pytest.approx(stiffness, rel=0.02)
    # Equation 4 does not give the printed 0.129, as the source of that row says.
    by_equation_4 = -math.log(epsilon) / math.hypot(math.pi, math.log(epsilon))
    assert by_equation_4 == pytest.approx(0.1187, abs=1e-4)
    assert xi != pytest.approx(by_equation_4, rel=0.05)


def test_the_orders_of_table_8(paper):
    under, over = (f"calibration.epsilon.{name}-damped" for name in ("under", "over"))
    assert paper[over] < paper["calibration.epsilon"] < paper[under]
    assert paper[f"{under}.printed"] < paper["calibration.epsilon"] < paper[f"{over}.printed"]
