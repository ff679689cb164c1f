"""The checks of the stage `pounding`: id, value, limits."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from impactfem.case import load_case
from impactfem.plot.table import columns_of
from impactfem.stages.pounding.checks import distance_check, stick_checks
from impactfem.stages.pounding.model_checks import facing_checks
from impactfem.stages.pounding.store import MOTION_OUTPUTS, OUTPUTS
from impactfem.stages.pounding.tables import COLUMNS
from impactfem.stages.stores import dataset
from impactfem.system.files import write_netcdf

ASKED = {
    "sticks.one.frequency.1": 0.015,
    "sticks.one.frequency.2": 0.015,
    "sticks.one.effective_mass.1": 0.1,
}


@pytest.fixture
def checked(tmp_path):
    """The checks of results that no run made; a variable that is None is left out."""

    def check(tolerances=ASKED, *, points=16, end=1.05, defect=(-10.0, 12.0), pairs=1, **more):
        values = {
            "building": ["one", "two"],
            "stiffness_factor": 0.131,
            "rigid_depth_below": 0.06,
            "rigid_depth_above": 0.79,
            "storey_height": [3.26],
            "required_separation": 0.046,
            "steps_per_impact_min": 26.0,
            "steps_per_impact_observed": 26.0,
            "energy_residual": 1e-14,
            "contact_energy_defect": 7e-4,
            "points_per_cycle": 23.8,
            "peak_error_bound": 0.0087,
            "swing_at_end": [0.1, 0.2],
            "passage_delay": [np.nan, np.nan],
            "passage_apart": [np.nan, np.nan],
            "passage_left": [np.nan, np.nan],
            "pair": ["one.floor_1-two.floor_1"][:pairs],
            "pair_rest_gap": [0.01][:pairs],
            "pair_distance": [np.nan][:pairs],
            "pair_onset_force": [1e5][:pairs],
            "pair_stiffness_unit": ["N/m"][:pairs],
            "impact_pair": ["one.floor_1-two.floor_1"] * 2,
            "impact_penetration": [5e-3, 1e-3],
            "impact_restitution": [0.6, 0.5],
            "impact_band_force": [98.4e6, 24.6e6],
            "impact_peak_force": [131.2e6, 32.8e6],
            "impact_peak_time": [5.1, 5.3],
            "impact_duration": [0.0126, 0.01],
            "impact_steps": [26, 7],
            "impact_defect": np.array(defect),
            "impact_dissipated": np.array(defect) + 500.0,
            "impact_bearing_pressure": [8.8e6, np.nan],
            "impact_bearing_ratio": [np.nan, np.nan],
            "impact_shear_stress": [2.3e6, 1e6],
            "impact_storey_shear": [27.6e6, 1e6],
            "impact_cracking_ratio": [np.nan, np.nan],
            "target_building": ["one", "one"],
            "target_mode": [1, 2],
            "frequency_error": [0.01, -0.012],
            "effective_mass_error": [-0.091, np.nan],
            "station": ["one.floor_1", "two.floor_1"],
            "direction": ["y"],
            "frequency": [10.0, 500.0],
            "psa": [[[[9.0, 5.0]], [[9.0, 5.0 * end]]]],
            "pfa": np.full((2, 1), 5.0),
        }
        motion = {
            "direction": ["y"],
            "over_target": [np.nan],
            "over_target_from": [np.nan],
            "over_target_to": [np.nan],
            "pga_over_target": [np.nan],
        }
        for name, value in more.items():
            (motion if name in MOTION_OUTPUTS and name not in values else values)[name] = value
        values = {name: value for name, value in values.items() if value is not None}
        write_netcdf(tmp_path / "pounding.nc", dataset(OUTPUTS, values, attributes={}))
        write_netcdf(tmp_path / "motion.nc", dataset(MOTION_OUTPUTS, motion, attributes={}))
        return stick_checks(tmp_path, points, tolerances)

    return check


def one(checks, name, place=""):
    """The only check of this name whose place contains a word."""
    (check,) = (c for c in checks if c.id == f"pounding.{name}" and place in c.place)
    return check


def ids(checks):
    return {check.id.removeprefix("pounding.") for check in checks}


@pytest.mark.parametrize(
    ("check", "name", "limits"),
    [
        ("energy_residual", "energy_residual", (1e-9, 2e-9)),
        ("steps_per_impact", "steps_per_impact_min", (16.0, 15.9)),
        ("spectrum_sampling", "peak_error_bound", (0.05, 0.06)),
        ("penetration", "penetration_over_gap", (0.5, 0.51)),
        ("swing_at_end", "swing_at_end", (0.5, 0.51)),
        ("bearing_pressure", "impact_bearing_ratio", (1.0, 1.01)),
        ("storey_shear", "impact_cracking_ratio", (1.0, 1.01)),
    ],
)
def test_a_limit(checked, check, name, limits):
    for value, passed in zip(limits, (True, False), strict=True):
        several = OUTPUTS[name].dims in ("impact", "building")
        found = one(checked(**{name: [value, 0.1 * value] if several else value}), check)
        assert found.passed is passed and found.value == value


@pytest.mark.parametrize(
    ("unit", "power", "part"), [("N/m", 2.0, 0.8), ("N/m^1.5", 2.5, 0.8), ("N/m", None, 0.5)]
)
def test_stiffness_for_the_penetration_allowed(checked, unit, power, part):
    """An impact of given energy penetrates by K^(-1/power); none is named within the limit."""
    of = {"penetration_over_gap": part, "impact_penetration": [1e-2 * part, 1e-3]}
    found = one(checked(pair_stiffness_unit=[unit], **of), "penetration")
    assert found.place == "one.floor_1-two.floor_1"
    assert found.detail[:3] == (f"{1.6**power:.1f}" if power else "")


@pytest.mark.parametrize(
    ("kind", "check", "low", "high"),
    [("over_target", "motion_spectrum", 0.9, 1.3), ("pga_over_target", "motion_peak", 0.99, 1.3)],
)
def test_a_motion_that_is_scaled_away_from_its_target(checked, kind, check, low, high):
    """EN 1998-1, 3.2.3.1.2(4), and SRP 3.7.1; a record has no target, and no such check."""
    for value, passed in ((low, True), (low - 0.01, False), (high, True), (high + 0.01, False)):
        assert one(checked(**{kind: [value]}), check).passed is passed
    assert check not in ids(checked())


@pytest.mark.parametrize(("left", "passed"), [(0.9e-4, True), (1.1e-4, False)])
def test_what_waves_that_pass_leave(checked, left, passed):
    """At most 1 % of the gap of 1 cm, by the velocity at the end of the motions."""
    of = {"delay": -0.0312, "apart": 3.1e-3, "left": left}
    passing = {f"passage_{name}": [np.nan, value] for name, value in of.items()}
    found = one(checked(**passing), "wave_passage", "two")
    assert found.passed is passed and found.upper == pytest.approx(0.1)
    assert one(checked(pair_rest_gap=[0.0], **passing), "wave_passage").passed is None
    assert "wave_passage" not in ids(checked())


def test_a_run_that_ends_while_a_building_moves(checked):
    found = one(checked(swing_at_end=[0.1, 1.0]), "swing_at_end", "two")
    assert found.passed is False and found.value == 1.0
    # Where nothing can touch, nothing comes after it.
    assert "swing_at_end" not in ids(checked(swing_at_end=[0.1, 1.0], pairs=0))


def test_the_required_steps_are_those_of_the_case(checked):
    found = [one(checked(points=n), "steps_per_impact") for n in (16, 100)]
    assert [(check.lower, check.passed) for check in found] == [(16, True), (100, False)]
    # With fewer steps an impact, or none measured, there is no restitution.
    assert "restitution" in ids(checked()) and "restitution" not in ids(checked(points=100))


@pytest.mark.parametrize(
    ("force", "frs", "passed"),
    [
        (0.03, 0.01, True),
        (0.12, 0.01, False),
        (0.03, 0.06, False),
        (np.nan, np.nan, None),
    ],
)
def test_edges_that_touch_in_3d(checked, force, frs, passed):
    """Without a law there is no defect of its energy, and no impact of two free floors."""
    of = {
        "contact_energy_defect": None,
        "contact_points": 125.0,
        "complementarity": 1e-14,
        "comparison": ["halved", "doubled_step"],
        "changed": ["force", "mean_force", "frs", "pfa"],
        "change": [[force, frs, frs, 0.4 if passed is not None else np.nan]] * 2,
    }
    for check in ("half_of_the_points", "double_step"):
        found = one(checked(**of), check)
        assert found.passed is passed
        if passed is not None:
            assert found.value == max(force, frs)
    assert one(checked(**of), "complementarity").passed
    assert one(checked(**of | {"complementarity": 1e-6}), "complementarity").passed is False
    assert "complementarity" not in ids(checked(**of | {"complementarity": None}))
    few = of | {"steps_per_impact_min": 9.0, "steps_per_impact_observed": 2.0}
    steps = one(checked(**few), "steps_per_impact")
    assert (steps.value, steps.lower, steps.passed) == (9.0, 16, False)


def test_without_an_impact(checked):
    none = np.zeros(0)
    impacts = {name: none for name, output in OUTPUTS.items() if output.dims == "impact"}
    impacts["impact_pair"] = []
    impacts.pop("impact_defect")
    single = dict.fromkeys(("steps_per_impact_min", "contact_energy_defect"))
    found = checked(defect=none, **impacts | single)
    assert (one(found, "impacts").passed, one(found, "impacts").value) == (None, 0.0)
    assert not {"restitution", "steps_per_impact", "bearing_pressure"} & ids(found)


def test_what_has_no_limit_neither_passes_nor_fails(checked):
    names = [c.id.removeprefix("pounding.") for c in checked() if c.passed is None]
    assert names == ["stick_fit", "impacts", "restitution", "bearing_pressure", "storey_shear"]


def test_the_force_is_that_of_the_impact_it_names(checked):
    found = one(checked(), "impacts")
    assert found.value == 2.0
    assert all(text in found.detail for text in ("131.2 MN", "5.1 s", "12.6 ms"))


@pytest.mark.parametrize(
    ("restitution", "texts"),
    [
        ((0.6, 0.5), ["0.6 in the largest impact, 0.5 to 0.6 in all"]),
        # What is above 1 is no restitution.
        ((2.12, 0.5), ["0.5 to 0.5 in 1 of 2", "undefined in 1"]),
        ((1.5, 2.0), ["undefined in 2"]),
        # Nor what is below 0, of the middles of floors that a corner stops.
        ((-0.2, 0.5), ["0.5 to 0.5 in 1 of 2", "undefined in 1"]),
    ],
)
def test_no_restitution_above_one(checked, restitution, texts):
    checks = checked(impact_restitution=restitution)
    found = [check.detail for check in checks if check.id == "pounding.restitution"]
    assert [text in detail for text, detail in zip(texts, found, strict=True)] == [True] * len(
        found
    )
    assert not any("2.1" in detail for detail in found)


@pytest.mark.parametrize("observed", [26.0, 7.0])
def test_an_impact_that_other_forces_cut_short(checked, observed):
    found = one(checked(steps_per_impact_observed=observed), "steps_per_impact", "two free floors")
    assert found.passed is True and found.value == 26.0
    assert ("7 in the shortest" in found.detail) is (observed < 16.0)


@pytest.mark.parametrize("missed", [False, True])
def test_the_criteria_of_a_reviewer(checked, missed):
    criteria = {
        "criterion": ["duration", "correlation"],
        "criterion_motion": ["x", "x_y"],
        "criterion_value": [1.0, 0.1],
        "criterion_limit": [20.0, 0.16],
        "criterion_at_least": [True, False],
        "criterion_passed": [not missed, True],
    }
    found = one(checked(**criteria), "motion_criteria", "of 2")
    assert (found.passed, found.value) == (None, 2.0 - missed)
    assert ("x duration 1 " in found.detail) is missed
    # Of records the other criteria are not known.
    alone = {name: values[1:] for name, values in criteria.items()}
    assert one(checked(**alone), "motion_criteria", "components alone").value == 1.0


@pytest.mark.parametrize(
    ("name", "tolerance", "missed"),
    [
        ("sticks.one.frequency.2", 0.015, 0),
        ("sticks.one.frequency.2", 0.011, 1),
        ("sticks.one.effective_mass.1", 0.09, 1),
    ],
)
def test_targets_against_the_tolerances_of_the_reference(checked, name, tolerance, missed):
    found = one(checked(ASKED | {name: tolerance}), "fit_targets", "of 3")
    assert (found.value, found.passed) == (missed, not missed)
    assert (name in found.detail) is bool(missed)


@pytest.mark.parametrize("lacking", ASKED)
def test_targets_without_a_tolerance_are_for_information(checked, lacking):
    fewer = {name: value for name, value in ASKED.items() if name != lacking}
    assert one(checked(fewer), "fit_targets").passed is None


@pytest.mark.parametrize(("end", "passed"), [(1.05, True), (1.18, False), (0.85, False)])
def test_the_end_of_the_spectra(checked, end, passed):
    found = one(checked(end=end), "spectrum_end", "two.floor_1, y, 500 Hz")
    assert found.passed is passed and found.value == pytest.approx(end)
    assert ("1 of 2 points" in found.detail) is not passed


@pytest.mark.parametrize(
    ("defect", "passed", "share"),
    [
        ((-10.0, 12.0), True, 0.022),
        ((50.0, 0.0), True, 0.05),
        # The energy that one impact gains does not balance the loss of another.
        ((-40.0, 40.0), False, 0.08),
        ((-60.0, 0.0), False, 0.06),
    ],
)
def test_the_defect_relative_to_the_dissipated_energy(checked, defect, passed, share):
    found = one(checked(defect=defect), "contact_energy")
    assert found.passed is passed and found.value == pytest.approx(share)
    assert "7e-4" in found.detail


def test_the_defect_of_an_elastic_law_has_no_limit(checked):
    found = one(checked(impact_dissipated=[-10.0, 12.0 + 1e-12]), "contact_energy")
    assert (found.value, found.passed) == (None, None) and "7e-4" in found.detail


@pytest.mark.parametrize(
    ("ratio", "name"),
    [("bearing_ratio", "bearing_pressure"), ("cracking_ratio", "storey_shear")],
)
def test_a_stress_needs_a_strength(checked, ratio, name):
    assert one(checked(), name).passed is None
    for value, passed in ((0.0, True), (0.29, True), (1.2, False)):
        found = one(checked(**{f"impact_{ratio}": [value, np.nan]}), name)
        assert found.passed is passed


GEOMETRY = Path(__file__).parents[3] / "geometry"


def store(nearest):
    values = {
        "facing_a": ["B.floor_4", "C.floor_1", "B.floor_3"],
        "facing_b": ["C.floor_3", "B.storey_2_at_0.36", "C.storey_3_at_0.257"],
        "facing_level": [12.0, 4.0, 9.0],
        "facing_rest_gap": [0.03, 0.03, 0.03],
        "facing_distance_min": [nearest, 0.02, nearest + 0.01],
        "facing_time": [4.36, 2.0, 3.0],
    }
    return dataset(OUTPUTS, values, attributes={})


@pytest.fixture(scope="module")
def case():
    return load_case(GEOMETRY / "row_of_three.toml")


@pytest.mark.parametrize(
    ("nearest", "count", "least"), [(-0.0138, 2, "-13.8"), (-0.005, 1, "-5"), (0.0012, 0, "1.2")]
)
def test_facing_floors(tmp_path, case, nearest, count, least):
    store(nearest).to_netcdf(tmp_path / "pounding.nc", engine="netcdf4")
    (found,) = facing_checks(tmp_path, case)
    assert (found.id, found.place) == ("pounding.facing_overlap", "of 3")
    assert (found.value, found.passed) == (count, count == 0)
    assert f"{least} mm between B.floor_4" in found.detail


def test_all_in_pairs(tmp_path, case):
    xr.Dataset().to_netcdf(tmp_path / "pounding.nc", engine="netcdf4")
    assert facing_checks(tmp_path, case) == []


def test_a_plan_that_is_not_known(tmp_path, case):
    xr.Dataset().to_netcdf(tmp_path / "pounding.nc", engine="netcdf4")
    bare = {"length": None, "width": None}
    buildings = tuple(one.model_copy(update=bare) for one in case.buildings)
    other = case.model_copy(update={"buildings": buildings, "contacts": case.contacts[:3]})
    found = facing_checks(tmp_path, other)
    assert {(one.id, one.passed) for one in found} == {("pounding.facing_unknown", None)}
    # Without plans B is not known to be between A and C.
    assert ["B and C" in one.detail for one in found] == [False, True]


def test_the_table_of_facing_floors():
    table = columns_of(store(-0.0138), "facing_floors", "", COLUMNS["facing_floors"].split())
    assert table.rows[0][:3] == ("B.floor_4", "C.floor_3", 12.0)
    assert table.rows[0][3:6] == pytest.approx((30.0, -13.8, 4.36))


@pytest.mark.parametrize(
    ("gap", "distance", "good"),
    [
        # A millimetre.
        (0.005, 0.0059, True),
        (0.005, 0.0061, False),
        (0.04, 0.041, True),
        (0.04, 0.0437, False),
        (0.04, 0.0443, False),
        (0.0, -0.0009, True),
        # Metres for inches.
        (1.2, 0.03, False),
    ],
)
def test_one_pair(gap, distance, good):
    (found,) = distance_check(["a-b"], [gap], [distance])
    assert (found.id, found.place, found.passed) == ("pounding.gap_geometry", "a-b", good)
    assert found.value == pytest.approx(1e3 * abs(distance - gap))


def test_the_worst_is_named():
    names, gaps = ["a-b", "b-c", "c-d", "d-e"], [0.01, 0.01, 0.01, 0.01]
    (found,) = distance_check(names, gaps, [0.03, 0.5, 0.01, np.nan])
    assert (found.passed, found.place, found.value) == (False, "b-c", pytest.approx(490.0))
    assert "1 more pair" in found.detail


@pytest.mark.parametrize("distances", [[], [np.nan, np.nan]])
def test_nothing_is_known(distances):
    names, gaps = ["a-b"] * len(distances), [np.inf] * len(distances)
    assert distance_check(names, gaps, distances) == []
