"""The checks of the stage `pounding` in words."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from impactfem.case import load_case
from impactfem.plot.table import columns_of
from impactfem.stages.pounding.checks import distance_check, facing_checks, stick_checks
from impactfem.stages.pounding.store import OUTPUTS
from impactfem.stages.pounding.tables import COLUMNS
from impactfem.stages.stores import dataset
from impactfem.system.files import write_netcdf
from impactfem.system.scalar import Scalar

SCALARS = {
    "sticks.stiffness_factor": 0.131,
    "sticks.rigid_below": 0.06,
    "sticks.rigid_above": 0.79,
    "sticks.storey_height.1": 3.26,
    "sticks.frequency_error_max": 0.012,
    "sticks.mass_error_max": 0.091,
    "pounding.impacts": 2.0,
    "pounding.peak_force.floor_1": 121.6e6,
    "pounding.main_impact_force": 131.2e6,
    "pounding.main_impact_time": 5.1,
    "pounding.main_impact_duration": 0.0126,
    "pounding.main_impact_restitution": 0.6,
    "pounding.required_separation": 0.046,
    "pounding.steps_per_impact_min": 26.0,
    "pounding.steps_per_impact_observed": 26.0,
    "pounding.energy_residual": 1e-14,
    "pounding.contact_energy_defect": 7e-4,
    "pounding.bearing_pressure_max": 8.8e6,
    "pounding.shear_stress_max": 2.3e6,
    "pounding.storey_shear_max": 27.6e6,
    "frs.points_per_cycle": 23.8,
    "frs.peak_error_bound": 0.0087,
}
ASKED = {
    "sticks.one.frequency.1": 0.015,
    "sticks.one.frequency.2": 0.015,
    "sticks.one.effective_mass.1": 0.1,
}


@pytest.fixture
def checked(tmp_path):
    """The checks of a store with scalars and impacts that no run made."""

    def check(
        tolerances=ASKED,
        *,
        points=16,
        scalars=SCALARS,
        notes=None,
        distance=np.nan,
        defect=(-10.0, 12.0),
        taken=(500.0, 500.0),
        restitution=(0.6, 0.5),
        end=1.05,
        gap=0.01,
        onset=1e5,
        pairs=1,
        **more,
    ):
        scalars = [Scalar(name, x, "-") for name, x in (scalars | more).items()]
        scalars += [Scalar(name, 1.0, "-", note) for name, note in (notes or {}).items()]
        values = {
            "pair": ["one.floor_1-two.floor_1"][:pairs],
            "pair_rest_gap": [gap][:pairs],
            "pair_distance": [distance][:pairs],
            "pair_onset_force": [onset][:pairs],
            "impact_restitution": restitution,
            "impact_peak_force": [4e6, 1e6],
            "impact_steps": [26, 7],
            "impact_defect": np.array(defect),
            "impact_dissipated": np.add(defect, taken),
            "target_building": ["one", "one"],
            "target_mode": [1, 2],
            "target_frequency": [1.75, 5.19],
            "calibrated_frequency": [1.75 * 1.01, 5.19 * 0.988],
            "target_effective_mass": [1e7, np.nan],
            "calibrated_effective_mass": [0.909e7, 2e6],
            "station": ["one.floor_1", "two.floor_1"],
            "direction": ["y"],
            "frequency": [10.0, 500.0],
            "psa": [[[[9.0, 5.0]], [[9.0, 5.0 * end]]]],
            "pfa": np.full((2, 1), 5.0),
        }
        store = dataset(OUTPUTS, values, attributes={}, scalars=scalars)
        write_netcdf(tmp_path / "pounding.nc", store)
        return stick_checks(tmp_path, points, tolerances)

    return check


def one(checks, words):
    (found,) = (check for check in checks if words in check[1])
    return found


@pytest.mark.parametrize(
    ("words", "name", "limits"),
    [
        ("discrete identity", "pounding.energy_residual", (1e-9, 2e-9)),
        ("steps:", "pounding.steps_per_impact_min", (16.0, 15.9)),
        ("points in a cycle", "frs.peak_error_bound", (0.05, 0.06)),
        ("of the gap", "pounding.penetration_over_gap", (0.5, 0.51)),
        ("last period", "pounding.swing_at_end", (0.5, 0.51)),
        ("bearing pressure", "pounding.bearing_ratio_max", (1.0, 1.01)),
        ("storey shear", "pounding.cracking_ratio_max", (1.0, 1.01)),
    ],
)
def test_a_limit(checked, words, name, limits):
    for value, good in zip(limits, (True, False), strict=True):
        assert one(checked(**{name: value}), words)[0] is good


@pytest.mark.parametrize(
    ("kind", "low", "high"), [("over_target", 0.9, 1.3), ("pga_over_target", 0.99, 1.3)]
)
def test_a_motion_that_is_scaled_away_from_its_target(checked, kind, low, high):
    """EN 1998-1, 3.2.3.1.2(4), and SRP 3.7.1; a record has no target, and no such line."""
    for value, good in ((low, True), (low - 0.01, False), (high, True), (high + 0.01, False)):
        for name in ("motion", "motion.x"):
            met, text = one(checked(**{f"{name}.{kind}": value}), "of the target's")
            assert met is good and text.startswith(f"{name}: its ")
    assert not any("of the target's" in text for _, text in checked())


@pytest.mark.parametrize(("left", "good"), [(0.9e-4, True), (1.1e-4, False)])
def test_what_waves_that_pass_leave(checked, left, good):
    """At most 1 % of the gap of 1 cm, by the velocity at the end of the motions."""
    of = {"delay": -0.0312, "apart": 3.1e-3, "left": left}
    passing = {f"motion.passage.two.{name}": value for name, value in of.items()}
    found = checked(**passing)
    met, text = one(found, "waves reach two")
    assert met is good and ("baseline = 'rest'" in text) is not good
    assert "31.2 ms sooner than the first building" in text and "up to 3.1 mm" in text
    assert one(checked(gap=0.0, **passing), "waves reach two")[0] is None
    assert not any("waves" in text for _, text in checked())


def test_a_run_that_ends_while_a_building_moves(checked):
    assert not any("last period" in text for _, text in checked())
    met, text = one(checked(notes={"pounding.swing_at_end": "two"}), "last period")
    assert not met and "last period of the run two still moves by 100 % of its largest" in text
    assert text.endswith("what comes after it is not computed: see duration of [pounding]")
    # Where nothing can touch, nothing comes after it.
    found = checked(notes={"pounding.swing_at_end": "two"}, pairs=0)
    assert not any("last period" in text for _, text in found)


def test_the_steps_asked_are_those_of_the_case(checked):
    assert [one(checked(points=n), "steps:")[0] for n in (16, 100)] == [True, False]
    # With fewer steps an impact, or none measured, nothing is said of the speeds.
    assert any("effective restitution" in text for _, text in checked())
    assert not any("effective restitution" in text for _, text in checked(points=100))


@pytest.mark.parametrize(
    ("force", "frs", "good", "words"),
    [
        (0.03, 0.01, True, "change the largest force by 3 % (limit 5 %), the largest mean"),
        (0.12, 0.01, False, "change the largest force by 12 % (limit 5 %), the largest mean"),
        (0.03, 0.06, False, "ordinates of floor spectra by up to 6 % (limit 5 %), the accel"),
        (None, None, None, "125 points in 3D; what half of them change is not known: too few"),
    ],
)
def test_edges_that_touch_in_3d(checked, force, frs, good, words):
    """Without a law there is no defect of its energy, and no impact of two free floors."""
    scalars = {name: x for name, x in SCALARS.items() if "energy_defect" not in name}
    of = {"pounding.contact_points": 125.0, "pounding.complementarity": 1e-14}
    changes = {"force": force, "mean_force": frs, "frs": frs, "pfa": 0.4 if force else None}
    for name, begin in (("halved", "125 points in 3D; half"), ("doubled_step", "steps twice")):
        more = {f"pounding.{name}_{what}_change": x for what, x in changes.items()}
        found = checked(scalars=scalars, **of, **more)
        lines = [line for line in found if words in line[1]]
        if force is not None:
            lines = [line for line in lines if begin in line[1]]
            assert lines[0][1].endswith("the accelerations of floors by up to 40 %")
        assert [good for good, _ in lines] == [good]
    assert one(found, "complementarity")[0]
    del of["pounding.complementarity"]
    assert not any("compl" in text for _, text in checked(scalars=scalars, **of))
    assert not one(checked(scalars=scalars, **of | {"pounding.complementarity": 1e-6}), "compl")[0]
    few = of | {"pounding.steps_per_impact_min": 9.0, "pounding.steps_per_impact_observed": 2.0}
    steps = one(checked(scalars=scalars, **few), "steps:")
    assert steps == (False, "steps: in the larger impacts 9 (at least 16)")


def test_without_an_impact_or_a_pair(checked):
    apart = "; a gap of 4.6 cm would prevent contact"
    assert one(checked(), "impacts, the largest")[1].endswith(apart)
    none = {name: x for name, x in SCALARS.items() if "main_impact" not in name}
    assert one(checked(scalars=none), "no impact") == (None, f"pounding: no impact{apart}")
    none.pop("pounding.required_separation")
    assert one(checked(scalars=none), "no impact") == (None, "pounding: no impact")


def test_what_has_no_limit_is_neither_met_nor_missed(checked):
    told = [text for good, text in checked() if good is None]
    words = ["sticks", *["pounding:"] * 2, *["linear"] * 2]
    assert [text.split(" ")[0] for text in told] == words


def test_the_force_is_that_of_the_impact_it_names(checked):
    """Two other buildings hit harder than the first one, or the first one is not hit at all."""
    words = "2 impacts, the largest with 131.2 MN at 5.1 s for 12.6 ms"
    assert words in one(checked(), "impacts, the largest")[1]
    without = {k: v for k, v in SCALARS.items() if not k.startswith("pounding.peak_force")}
    assert words in one(checked(scalars=without), "impacts, the largest")[1]


@pytest.mark.parametrize(
    ("restitution", "main", "lines"),
    [
        (
            (0.6, 0.5),
            0.6,
            ["effective restitution 0.6 in the largest impact, 0.5 to 0.6 in all (the "],
        ),
        # What is above 1 is no restitution.
        (
            (2.12, 0.5),
            2.12,
            ["effective restitution 0.5 to 0.5 in 1 of 2 (the", "in 1 impacts the buildings' own"],
        ),
        ((1.5, 2.0), 1.5, ["in 2 impacts the buildings' own forces part the floors: no"]),
        # Nor what is below 0, of the middles of floors that a corner stops.
        (
            (-0.2, 0.5),
            -0.2,
            [
                "effective restitution 0.5 to 0.5 in 1 of 2 (the",
                "in 1 impacts the middles of floors",
            ],
        ),
    ],
)
def test_no_restitution_above_one(checked, restitution, main, lines):
    found = checked(restitution=restitution, **{"pounding.main_impact_restitution": main})
    texts = [text for _, text in found if "restitution" in text]
    assert len(texts) == len(lines)
    for text, line in zip(texts, lines, strict=True):
        assert text.startswith(f"pounding: {line}") and "2.1" not in text


@pytest.mark.parametrize("observed", [26.0, 7.0])
def test_an_impact_that_other_forces_cut_short(checked, observed):
    good, text = one(checked(**{"pounding.steps_per_impact_observed": observed}), "steps:")
    assert good is True
    told = "; 7 in the shortest contact, of 25 % of the largest force, which other forces end"
    assert text.startswith("steps: per impact of two free floors 26 (at least 16)")
    assert (told in text) is (observed < 16.0)


def test_the_gap_beside_axis_and_offset(checked):
    assert one(checked(distance=0.02), "contact:")[0] is False


@pytest.mark.parametrize("missed", [False, True])
def test_a_reviewers_criteria_are_told(checked, missed):
    notes = {
        "motion.acceptance.duration": "missed: at least 20 is required"
        if missed
        else "met: so it is",
        "motion.correlation.x_y": "met: at most 0.16 in size is required",
    }
    good, text = one(checked(notes=notes), "3.7.1")
    assert good is None
    met = "1 of 2 criteria met; not met: duration 1 (at least 20 is required)"
    assert text.endswith(f"information): {met if missed else '2 of 2 criteria met'}")
    # Of records the other criteria are not known.
    notes = {"motion.correlation.x_y": notes["motion.correlation.x_y"]}
    (text,) = (text for _, text in checked(notes=notes) if "3.7.1" in text)
    assert "SRP 3.7.1, independence of the components alone (for information): 1 of 1" in text


def test_targets_against_the_tolerances_of_the_reference(checked):
    good, text = one(checked(), "target frequency")
    assert good is True and text.endswith("(limits: the tolerances of the case's reference)")
    good, text = one(checked(ASKED | {"sticks.one.frequency.2": 0.011}), "target frequency")
    assert good is False
    assert text.endswith("; beyond: sticks.one.frequency.2 1.2 % (limit 1.1 %)")
    good, text = one(checked(ASKED | {"sticks.one.effective_mass.1": 0.09}), "target frequency")
    assert good is False and "sticks.one.effective_mass.1 9.1 % (limit 9 %)" in text


@pytest.mark.parametrize("lacking", ASKED)
def test_targets_without_a_tolerance_are_told(checked, lacking):
    fewer = {name: value for name, value in ASKED.items() if name != lacking}
    assert one(checked(fewer), "target frequency")[0] is None


@pytest.mark.parametrize(("end", "good"), [(1.05, True), (1.18, False), (0.85, False)])
def test_whether_spectra_end(checked, end, good):
    found, text = one(checked(end=end), "spectra at 500 Hz")
    assert found is good and text.startswith(
        f"pounding: spectra at 500 Hz over the peak acceleration {end:g} (limit 1.1 or 1/1.1) at "
        "two.floor_1, y"
    )
    assert ("so it is at 1 of 2 points" in text) is not good


@pytest.mark.parametrize(
    ("defect", "good", "share"),
    [
        ((-10.0, 12.0), True, "2.2 %"),
        ((50.0, 0.0), True, "5 %"),
        # What one impact adds does not make good what another loses.
        ((-40.0, 40.0), False, "8 %"),
        ((-60.0, 0.0), False, "6 %"),
    ],
)
def test_the_defect_against_what_the_laws_took(checked, defect, good, share):
    found = one(checked(defect=defect), "time stepping in contact")
    assert found == (
        good,
        f"energy: error of time stepping in contact, signs left out, {share} of what the laws "
        "take (limit 5 %); in sum it takes 7e-4 of the largest kinetic energy",
    )


def test_the_defect_of_an_elastic_law_is_told(checked):
    found = one(checked(taken=(0.0, 1e-12)), "time stepping in contact")
    text = "energy: time stepping in contact takes 7e-4 of the largest kinetic energy"
    assert found == (None, text)


@pytest.mark.parametrize(
    ("ratio", "words"),
    [("pounding.bearing_ratio_max", "bearing"), ("pounding.cracking_ratio_max", "shear stress")],
)
def test_a_stress_needs_a_strength(checked, ratio, words):
    assert one(checked(), words)[0] is None
    for value, good in ((0.29, True), (1.2, False)):
        found = one(checked(**{ratio: value}), words)
        assert found[0] is good and "strength (limit 100 %)" in found[1]


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
    ("nearest", "good", "text"),
    [
        (
            -0.0138,
            False,
            "facing floors: B.floor_4 and C.floor_3 overlap by 13.8 mm at 4.36 s and are in no "
            "pair, and 1 more do (tables/facing_floors.csv); list them in [[contacts]]",
        ),
        (
            -0.005,
            False,
            "facing floors: B.floor_4 and C.floor_3 overlap by 5 mm at 4.36 s and are in no pair "
            "(tables/facing_floors.csv); list them in [[contacts]]",
        ),
        (
            0.0012,
            True,
            "facing floors: 3 in no pair keep apart; the nearest, B.floor_4 and C.floor_3, by "
            "1.2 mm at 4.36 s",
        ),
    ],
)
def test_facing_floors(tmp_path, case, nearest, good, text):
    store(nearest).to_netcdf(tmp_path / "pounding.nc", engine="netcdf4")
    assert facing_checks(tmp_path, case) == [(good, text)]


def test_all_in_pairs(tmp_path, case):
    xr.Dataset().to_netcdf(tmp_path / "pounding.nc", engine="netcdf4")
    assert facing_checks(tmp_path, case) == []


def test_a_plan_that_is_not_known(tmp_path, case):
    xr.Dataset().to_netcdf(tmp_path / "pounding.nc", engine="netcdf4")
    bare = {"length": None, "width": None}
    buildings = tuple(one.model_copy(update=bare) for one in case.buildings)
    other = case.model_copy(update={"buildings": buildings, "contacts": case.contacts[:3]})
    ((good, text),) = facing_checks(tmp_path, other)
    assert good is None
    assert "whether floors of B and C that are in no pair meet cannot be checked" in text


def test_the_table_of_facing_floors():
    content = store(-0.0138).assign(overlap=("facing", [True, False, True]))
    table = columns_of(content, "facing_floors", "", COLUMNS["facing_floors"])
    assert table.rows[0][:3] == ("B.floor_4", "C.floor_3", 12.0)
    assert table.rows[0][3:6] == pytest.approx((30.0, -13.8, 4.36))
    assert [row[-1] for row in table.rows] == ["yes", "no", "yes"]


@pytest.mark.parametrize(
    ("gap", "distance", "good"),
    [
        # A millimetre, or a tenth of the gap.
        (0.005, 0.0059, True),
        (0.005, 0.0061, False),
        (0.04, 0.0437, True),
        (0.04, 0.0443, False),
        (0.0, -0.0009, True),
        # Metres for inches.
        (1.2, 0.03, False),
    ],
)
def test_one_pair(gap, distance, good):
    ((found, text),) = distance_check(["a-b"], [gap], [distance])
    assert found is good
    if good:
        assert text == "contact: 1 pair, the gap equals the geometry"
    else:
        assert f"the points of a-b are {distance:.4g} m apart" in text
        assert f"its gap is {gap:.4g} m; the gap counts" in text


def test_the_worst_is_named():
    names, gaps = ["a-b", "b-c", "c-d", "d-e"], [0.01, 0.01, 0.01, 0.01]
    ((good, text),) = distance_check(names, gaps, [0.03, 0.5, 0.01, np.nan])
    assert good is False
    assert "the points of b-c are 0.5 m apart" in text and text.endswith("so it is for 1 more")


@pytest.mark.parametrize("distances", [[], [np.nan, np.nan]])
def test_nothing_is_known(distances):
    names, gaps = ["a-b"] * len(distances), [np.inf] * len(distances)
    assert distance_check(names, gaps, distances) == []
