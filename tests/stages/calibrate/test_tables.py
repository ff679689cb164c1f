"""The tables of the stage `calibrate`, and the paper's values beside its own equations."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.axes import Axes

from impactfem.case.report import read_published
from impactfem.plot import style
from impactfem.stages.calibrate.checks import wall_checks
from impactfem.stages.calibrate.stage import CALIBRATE
from impactfem.stages.calibrate.tables import wall_tables
from impactfem.system.files import write_netcdf

from ..figure_file import assert_drawn, draw_all, rows
from ..wall_store import WantedWall, calibrate_store

PUBLISHED = Path(__file__).parents[3] / "geometry" / "npp_pair_published.csv"
PUBLISHED_RATIOS = {
    "calibration.epsilon": 0.5,
    "calibration.epsilon.under-damped": 0.891,
    "calibration.epsilon.over-damped": 0.414,
    "calibration.epsilon.under-damped.printed": 0.414,
    "calibration.epsilon.over-damped.printed": 0.891,
}


def impacts(folder):
    return {(r["model"], r["floor"], r["impact"]): r for r in rows(wall_tables(folder, {})[1])}


def test_values_beside_published_ones(wall_folder):
    folder = wall_folder(numbers={"second_impulse": math.nan})
    published = {"calibration.second_impulse": 37e3, "calibration.K_Ceq": 1e11}
    found = rows(wall_tables(folder, published)[0])
    # Published ones first, in the order of the stage.
    assert [row["name"] for row in found[:2]] == ["calibration.K_Ceq", "calibration.second_impulse"]
    assert float(found[0]["over published"]) == pytest.approx(1.2)
    assert (found[1]["value"], found[1]["over published"]) == ("", "")
    assert all(row["published"] == "" for row in found[2:])


def test_a_published_zero_has_no_ratio(wall_folder):
    folder = wall_folder()
    row = rows(wall_tables(folder, {"calibration.floor_8.impacts": 0.0})[0])[0]
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


IDS = [
    "start",
    "start_unevenness",
    "restitution",
    "stick_delay",
    *["least_distance"] * 2,
    "contact_at_end",
    "complementarity",
    "energy_residual",
    "energy_gained",
    "basis_error",
    *["steps_per_impact"] * 2,
    *["penetration"] * 2,
]
VALUES = [-20, 2e-11, 0.667, 5.1, 1, 1, 0, 1e-14, 1e-13, 0, 3e-3, 30, 33, 8e-3, 0]
FREE = {"start", "restitution", "stick_delay", "least_distance"}


def name_of(check):
    return check.id.removeprefix("calibrate.")


def missed(folder):
    return [check for check in wall_checks(folder) if check.passed is False]


def test_all_is_well(wall_folder):
    checks = wall_checks(wall_folder())
    assert [name_of(check) for check in checks] == IDS
    assert [check.value for check in checks] == pytest.approx(VALUES, rel=1e-2, abs=1e-16)
    assert all(c.passed is (None if name_of(c) in FREE else True) for c in checks)
    assert all(text in checks[2].detail for text in ("0.128", "1.2e+11", "16 ms", "800.3 kN s"))
    assert all(text in checks[3].detail for text in ("-2.5 %", "+3 %"))
    assert checks[11].place == "floor 8 of the 3D model, damping under-damped"


def test_how_a_floor_starts(wall_folder):
    """Held as a whole it is even; a load displaces it unevenly."""
    (check,) = missed(wall_folder(numbers={"start_unevenness": 0.2}))
    assert (name_of(check), check.value) == ("start_unevenness", 0.2)
    folder = wall_folder(pull="even_load", numbers={"start_unevenness": 0.2})
    first, second, *_ = wall_checks(folder)
    assert first.passed is None and "0.2; pull = even_load" in first.detail
    assert name_of(second) == "restitution"


CUT_SHORT = {6: (), 7: (), 8: ((0.2003, 0.016, 800e3), (0.595, 0.016, 100e3))}


@pytest.mark.parametrize(
    ("wanted", "name", "value"),
    [
        ({"numbers": {"complementarity": 1e-6}}, "complementarity", 1e-6),
        ({"numbers": {"energy_residual": 1e-3}}, "energy_residual", 1e-3),
        ({"numbers": {"energy_gained": 1e-4}}, "energy_gained", 1e-4),
        ({"numbers": {"basis_error": 0.02}}, "basis_error", 0.02),
        ({"numbers": {"penetration": 2e-3}}, "penetration", 0.2),
        ({"durations": (0.016, 0.007, 0.017)}, "steps_per_impact", 14.0),
        ({"hits": CUT_SHORT}, "contact_at_end", 1.0),
    ],
)
def test_a_number_that_fails(wall_folder, wanted, name, value):
    (check,) = missed(wall_folder(**wanted))
    assert (name_of(check), check.value) == (name, pytest.approx(value))


def test_too_few_steps_of_the_stick(wall_folder):
    hits = {6: (), 7: (), 8: ((0.2054, 0.006, 780e3),)}
    folder = wall_folder(stick_hits=hits, dampings=1)
    (check,) = missed(folder)
    assert (check.place, check.value) == ("floor 8 of the stick", pytest.approx(12.0))
    # Both floors that it does not hit, and one damping needs no name.
    places = [check.place for check in wall_checks(folder)]
    assert "floor 8 of the 3D model" in places
    names = [name_of(c) for c in wall_checks(folder) if c.place.endswith("of the stick")]
    assert names.count("least_distance") == 2


def test_a_stick_that_is_before_the_3d_model(wall_folder):
    found = wall_checks(wall_folder(numbers={"stick_delay": -2e-3}))
    assert (name_of(found[3]), found[3].value) == ("stick_delay", pytest.approx(-2.0))


ALL = ["wall_damping", "wall_energy", "wall_impact", "wall_line_load", "wall_stick"]
ONE_FLOOR = {8: ((0.2003, 0.016, 800e3),)}
CASES = {
    "three dampings": ({}, ALL),
    "one floor": ({"hits": ONE_FLOOR, "stick_hits": ONE_FLOOR}, ALL),
    "one damping, a scheme that damps": (
        {"dampings": 1, "numerical": 5e3},
        [name for name in ALL if name != "wall_damping"],
    ),
}


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Each case, drawn once and coarsely: files, curves by label, and images."""
    found = {}
    plot, image = Axes.plot, Axes.pcolormesh
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(style.SETTINGS, "figure.dpi", 40.0)
        for name, (wanted, _) in CASES.items():
            one = SimpleNamespace(folder=tmp_path_factory.mktemp("wall"), curves={}, images=[])
            found[name] = one

            def kept_plot(self, x, y, *args, one=one, **options):
                one.curves.setdefault(options.get("label"), []).append((np.array(x), np.array(y)))
                return plot(self, x, y, *args, **options)

            def kept_image(self, x, y, values, one=one, **options):
                one.images.append((np.array(x), np.array(y), np.array(values)))
                return image(self, x, y, values, **options)

            patch.setattr(Axes, "plot", kept_plot)
            patch.setattr(Axes, "pcolormesh", kept_image)
            write_netcdf(one.folder / "calibrate.nc", calibrate_store(WantedWall(**wanted)))
            one.files = draw_all(CALIBRATE.figures, one.folder)
    return found


@pytest.mark.parametrize("name", CASES)
def test_files(drawn, name):
    one = drawn[name]
    assert [path.stem for path in one.files] == CASES[name][1]
    assert sorted((one.folder / "figures").iterdir()) == one.files
    for path in one.files:
        assert_drawn(path, 500, 300)


def test_forces_and_impulses_around_the_first_impact(drawn):
    curves = drawn["three dampings"].curves
    time, force = curves["floor 8"][0]
    assert force.max() == pytest.approx(0.5 * np.pi * 800e3 / 0.016 / 1e6, rel=3e-3)
    assert 0.19 < time[0] < 0.2003 and 0.2163 < time[-1] < 0.23
    _, impulse = curves["floor 8, 800 kN·s"][0]
    assert impulse[0] == 0.0 and impulse[-1] == pytest.approx(800.0, rel=2e-3)
    assert any(label.startswith("floor 7,") for label in curves)
    # Floor 6 does not hit.
    assert not any(label.startswith("floor 6") for label in curves)


def test_stick_beside_the_3d_model(drawn):
    one = drawn["three dampings"]
    displacement, velocity, impulse = (values for _, values in one.curves["stick"])
    assert one.curves["wall"][0][1] == pytest.approx([1.0, 1.0])
    assert displacement.max() == pytest.approx(1.0)
    assert velocity.max() == pytest.approx(0.16)
    # The stick's second impact adds to its first; the 3D model has one.
    assert impulse[-1] == pytest.approx(817.0, rel=2e-3)
    assert one.curves["3D"][2][1][-1] == pytest.approx(800.0, rel=2e-3)


def test_line_load(drawn):
    # Floors 8 and 7, and the scale of the colours.
    images = drawn["three dampings"].images
    assert (len(images), len(drawn["one floor"].images)) == (3, 2)
    time, position, load = images[0]
    assert position.tolist() == [0.0, 3.0, 6.0, 9.0, 12.0]
    assert load.shape == (5, len(time))
    # An even load on 12 m: ends stand for half the length, and have the same load on a metre.
    expected = 0.5 * np.pi * 800e3 / 0.016 / 12.0 / 1e6
    assert load.max(axis=1) == pytest.approx(np.full(5, expected), rel=3e-3)


@pytest.mark.parametrize("name", ["three dampings", "one damping, a scheme that damps"])
def test_the_sum_of_the_energies(drawn, name):
    curves = drawn[name].curves
    for _, total in curves["sum"]:
        assert total == pytest.approx(np.full(total.shape, 170.0))
    # It has a curve only where the scheme takes something.
    assert ("numerical" in curves) == ("scheme" in name)


def test_dampings(drawn):
    curves = drawn["three dampings"].curves
    epsilon, stiffness, duration = curves["over-damped"]
    # ξ = α / (4 π f) + π β f at f = 1 / (2 · 16 ms).
    ratio = 100.0 * (0.559 / (4.0 * np.pi * 31.25) + np.pi * 3e-3 * 31.25)
    assert float(epsilon[0]) == pytest.approx(ratio)
    assert (float(epsilon[1]), float(stiffness[1])) == (0.4, pytest.approx(1.3))
    assert float(duration[1]) == pytest.approx(17.0)
    assert "own" not in drawn["one damping, a scheme that damps"].curves
