from dataclasses import replace

import numpy as np
import pytest

from impactfem.coupling.contact import UNILATERAL, kelvin_voigt
from impactfem.coupling.impacts import largest_means
from impactfem.stages.pounding.compute import Peaks
from impactfem.stages.pounding.scalars import mode_rows, stick_scalars
from impactfem.sticks.element import COMPONENTS

from .conftest import CALIBRATION

# The names that the first issue asks for, with the buildings and floors of the small case.
REQUIRED = {
    "motion.pga": "m/s2",
    "motion.sa_max": "m/s2",
    "motion.sa_max_frequency": "Hz",
    **{f"sticks.{b}.frequency.{k}": "Hz" for b in ("west", "east") for k in (1, 2, 3, 4)},
    **{f"sticks.{b}.effective_mass.{k}": "kg" for b in ("west", "east") for k in (1, 2, 3, 4)},
    "pounding.peak_force.floor_3": "N",
    "pounding.penetration.floor_3": "m",
    "pounding.peak_acceleration.floor_3": "m/s2",
    "pounding.main_impact_force": "N",
    "pounding.main_impact_time": "s",
    "pounding.main_impact_duration": "s",
    "pounding.steps_per_impact_min": "-",
    "pounding.energy_residual": "-",
    "pounding.required_separation": "m",
    "frs.floor_3.peak": "m/s2",
    "frs.floor_3.peak_frequency": "Hz",
    "frs.floor_3.pfa": "m/s2",
}


@pytest.fixture(scope="module")
def scalars(study):
    return {scalar.name: scalar for scalar in stick_scalars(study)}


def test_required_names_and_units(scalars):
    assert {name: scalars[name].unit for name in REQUIRED} == REQUIRED


def test_every_scalar_is_a_finite_number_of_its_own_name(study, scalars):
    assert len(scalars) == len(stick_scalars(study))
    for scalar in scalars.values():
        assert np.isfinite(scalar.value) and scalar.unit


def test_motion(study, scalars):
    assert scalars["motion.pga"].value == pytest.approx(3.0, rel=1e-6)
    spectrum = study.motions[0].spectrum
    k = int(np.argmax(spectrum.psa[0, 0]))
    assert scalars["motion.sa_max"].value == spectrum.psa[0, 0, k]
    assert scalars["motion.sa_max_frequency"].value == spectrum.frequency[k]
    assert "motion.misfit_rms" in scalars


def test_a_motion_over_its_target(study, scalars):
    """Where the buildings answer: from 0.2 of the shortest to 2 of the longest first period."""
    misfit = study.motions[0].misfit
    firsts = [one.frequency[one.of_family("y")[0]] for one in study.modes]
    meant = (misfit.frequency >= min(firsts) / 2.0) & (misfit.frequency <= 5.0 * max(firsts))
    assert 0 < meant.sum() < meant.size
    assert scalars["motion.over_target"].value == pytest.approx(misfit.ratio[meant].mean())
    assert "along y" in scalars["motion.over_target"].note
    assert scalars["motion.pga_over_target"].value == pytest.approx(1.0, rel=1e-6)
    # Half of the motion is half of its target; without a target nothing is said.
    halved = replace(misfit, computed=0.5 * misfit.computed)
    motion = replace(study.motions[0], misfit=halved)
    made = {s.name: s.value for s in stick_scalars(replace(study, motions=(motion,)))}
    assert made["motion.over_target"] == pytest.approx(0.5 * scalars["motion.over_target"].value)
    record = replace(study.motions[0], misfit=None, target_pga=None)
    made = {s.name for s in stick_scalars(replace(study, motions=(record,)))}
    assert not {name for name in made if "over_target" in name}


@pytest.mark.parametrize(
    ("share", "word"), [(0.15, "met"), (-0.15, "met"), (0.17, "missed"), (-0.17, "missed")]
)
def test_components_are_independent_up_to_a_correlation(study, share, word):
    motion = study.motions[0]
    first = motion.accelerogram.acceleration - motion.accelerogram.acceleration.mean()
    other = np.random.default_rng(2).standard_normal(first.size)
    other -= other.mean()
    other -= first * (other @ first) / (first @ first)
    other *= np.sqrt((first @ first) / (other @ other))
    mixed = share * first + np.sqrt(1.0 - share**2) * other
    second = replace(
        motion, direction="x", accelerogram=replace(motion.accelerogram, acceleration=mixed)
    )
    made = stick_scalars(replace(study, motions=(motion, second)))
    (scalar,) = (s for s in made if s.name == f"motion.correlation.{motion.direction}_x")
    assert scalar.value == pytest.approx(share)
    assert scalar.note == f"{word}: at most 0.16 in size is required"


def test_modes_are_those_bending_about_x_in_natural_order(study, scalars):
    for k, name in enumerate(("west", "east")):
        result = study.modes[k]
        family = result.of_family("y")
        found = [scalars[f"sticks.{name}.frequency.{n}"].value for n in range(1, 7)]
        assert found == list(result.frequency[family]) and found == sorted(found)
        masses = [scalars[f"sticks.{name}.effective_mass.{n}"].value for n in range(1, 7)]
        assert masses == list(result.effective_mass[COMPONENTS.index("y"), family])
        assert sum(masses) == pytest.approx(672e3) == scalars[f"sticks.{name}.mass"].value
    # Building east bends more easily.
    assert scalars["sticks.east.frequency.1"].value < scalars["sticks.west.frequency.1"].value
    assert "e_x" in scalars["sticks.west.frequency.1"].note


@pytest.mark.parametrize(("pounds", "along"), [("x", "x"), ("y", "y"), ("z", "y")])
def test_modes_are_along_the_direction_of_the_pounding(study, pounds, along):
    """Without a calibration, which has a direction of its own."""
    motion = study.case.motions[0].model_copy(update={"direction": pounds})
    case = study.case.model_copy(update={"motions": (motion,), "contacts": ()})
    rows = {name: value for name, value, *_ in mode_rows(case, study.system.sticks, study.modes)}
    first, other = (
        study.modes[0].frequency[study.modes[0].of_family(axis)[0]]
        for axis in (along, "xy".replace(along, ""))
    )
    assert rows["sticks.west.frequency.1"] == first != other


def test_pounding(study, scalars):
    response = study.response
    assert scalars["pounding.peak_force.floor_3"].value == response.force[:, 2].max()
    assert scalars["pounding.peak_force.floor_3"].value > 0.0
    assert scalars["pounding.penetration.floor_3"].value == pytest.approx(-response.gap[:, 2].min())
    peak = np.abs(response.absolute_acceleration[:, 13]).max()
    assert scalars["pounding.peak_acceleration.floor_3"].value == pytest.approx(peak)
    top = np.abs(response.u[:, 18 + 13]).max()
    assert scalars["pounding.peak_displacement.east"].value == pytest.approx(top)
    free = np.abs(study.free.u[:, 13]).max()
    assert scalars["pounding.peak_displacement_no_contact.west"].value == pytest.approx(free)
    main = study.main_impact
    assert scalars["pounding.main_impact_force"].value == main.peak_force
    assert scalars["pounding.main_impact_time"].value == main.peak_time
    assert scalars["pounding.main_impact_duration"].value == main.duration
    assert scalars["pounding.main_impact_restitution"].value == main.restitution
    assert main.pair.name in scalars["pounding.main_impact_time"].note
    assert scalars["pounding.impacts"].value == len(study.impacts)


@pytest.mark.parametrize(("turned", "together"), [(False, 1.5), (True, 1.0)])
def test_pairs_on_one_side_push_a_floor_together(study, scalars, turned, together):
    """A second pair at the top with half of the force; on the other side it pushes alone."""
    top = study.system.pairs[2]
    second = replace(top, name="corner", normal=-np.asarray(top.normal) if turned else top.normal)
    system = replace(study.system, pairs=(*study.system.pairs, second))
    force = study.response.force
    force = np.hstack([force, 0.5 * force[:, [2]]])
    response = replace(study.response, system=system, force=force)
    found = {s.name: s for s in stick_scalars(replace(study, system=system, response=response))}
    name = "pounding.peak_force.floor_3"
    assert found[name].value == pytest.approx(together * scalars[name].value)


def test_checks(study, scalars):
    assert scalars["pounding.energy_residual"].value < 1e-9
    expected = max(separation.required for separation in study.separations)
    assert scalars["pounding.required_separation"].value == expected > 0.005
    fewest = min(impact.steps for impact in study.impacts)
    assert scalars["pounding.steps_per_impact_observed"].value == fewest
    # The duration for 96 t, the lightest pair, when the tops touch: some 9 ms in all.
    law = kelvin_voigt(1.2e10, study.system.pairs[2].law.xi, 96e3)
    assert scalars["pounding.steps_per_impact_min"].value == pytest.approx(
        law.duration(1.0) / 2.5e-4
    )
    depth = max(impact.penetration for impact in study.impacts) / 0.005
    assert scalars["pounding.penetration_over_gap"].value == pytest.approx(depth)
    pressure = max(impact.peak_force for impact in study.impacts) / 5.0
    assert scalars["pounding.bearing_pressure_max"].value == pytest.approx(pressure)
    assert scalars["pounding.bearing_ratio_max"].value == pytest.approx(pressure / 25e6)


def test_floor_spectra(study, scalars):
    psa, f = study.floors.psa[0, 2, 0], study.floors.spectra.frequency
    assert scalars["frs.floor_3.peak"].value == psa.max()
    assert scalars["frs.floor_3.peak_frequency"].value == f[np.argmax(psa)]
    assert scalars["frs.floor_3.pfa"].value == study.floors.pfa[2, 0]
    assert scalars["frs.floor_3.pfa_no_contact"].value == study.floors_free.pfa[2, 0]
    assert scalars["frs.east.floor_3.peak"].value == study.floors.psa[0, 5, 0].max()
    assert "0.02 damping" in scalars["frs.floor_3.peak"].note
    assert scalars["frs.points_per_cycle"].value >= 20


def test_nothing_touches(no_contacts):
    scalars = {scalar.name: scalar for scalar in stick_scalars(no_contacts)}
    for name in ("main_impact_time", "main_impact_duration", "steps_per_impact_min"):
        assert scalars[f"pounding.{name}"].value is None
    assert scalars["pounding.required_separation"].value is None
    assert scalars["pounding.impacts"].value == 0.0
    assert scalars["pounding.main_impact_time"].note == "no impact"
    absent = ("pounding.peak_force.floor_3", "pounding.bearing_pressure_max")
    assert not set(absent) & set(scalars)
    assert scalars["frs.floor_3.pfa"].value == scalars["frs.floor_3.pfa_no_contact"].value


def test_calibration(study, scalars):
    assert not [name for name in scalars if name.startswith("sticks.storey_height")]
    fitted = replace(study, calibration=CALIBRATION)
    found = {scalar.name: scalar.value for scalar in stick_scalars(fitted)}
    assert found["sticks.stiffness_factor"] == 0.4
    assert [found[f"sticks.storey_height.{k}"] for k in (1, 2, 3)] == [3.5, 3.4, 3.6]
    assert (found["sticks.rigid_below"], found["sticks.rigid_above"]) == (0.3, 0.2)
    assert found["sticks.frequency_error_max"] == pytest.approx(0.125)
    assert found["sticks.mass_error_max"] == pytest.approx(0.2)


@pytest.mark.parametrize("rest", [0.0, 0.2])
def test_the_last_period_of_a_run(study, rest):
    """Of its motion each building keeps a part; one that is held away from rest does not swing."""
    response = study.response
    lowest = min(modes.frequency[0] for modes in study.modes)
    n, k = len(response.u), round(1.1 / lowest / response.time_step)
    late = np.where(np.arange(n) > n - k, rest, 1.0)[:, None]
    held = np.where(late < 1.0, response.u[n - k], response.u)
    ended, still, cut = (
        next(one for one in stick_scalars(of) if one.name == "pounding.swing_at_end")
        for of in (
            replace(study, response=replace(response, u=u))
            for u in (response.u * late, held, response.u)
        )
    )
    assert (ended.value > 0.0) == (rest > 0.0) and ended.value < 0.5 < cut.value
    assert still.value < 1e-12 and cut.note in ("west", "east")


def test_lines_that_touch_in_3d(study):
    """Points and forces are those of lines, not of the pair of sticks that hits harder."""
    first, *others = study.system.pairs
    system = replace(study.system, pairs=(replace(first, line=first.name), *others))
    force = study.response.force.copy()
    force[:, 0] = 0.5 * force.max(axis=1)
    largest = float(force[:, 0].max())
    assert 0.0 < largest < force.max()

    def of(pairs):
        one = replace(system, pairs=pairs)
        response = replace(study.response, system=one, force=force, in_3d=("west",))
        # Of three floors the smallest one does not count, the second one changes most.
        frs, pfa = np.array([[30.0], [20.0], [2.0]]), np.array([[20.0], [10.0], [1.0]])
        peaks = Peaks(largest, 1e6, frs, pfa)
        halved = Peaks(1.03 * largest, 0.98e6, np.array([[30.0], [20.2], [4.0]]), 0.5 * pfa)
        doubled = Peaks(0.7 * largest, 1e6, frs, pfa)
        made = replace(study, system=one, response=response)
        made = replace(made, peaks=peaks, halved=halved, doubled=doubled)
        return {scalar.name: scalar.value for scalar in stick_scalars(made)}

    found = of(system.pairs)
    assert found["pounding.contact_points"] == 1.0
    means = largest_means(study.response.time, force)
    assert found["pounding.mean_force_5ms"] == pytest.approx(means.max()) and means.max() > 0.0
    changes = [
        found[f"pounding.halved_{what}_change"] for what in ("force", "mean_force", "frs", "pfa")
    ]
    assert changes == pytest.approx([0.03, 0.02, 0.01, 0.5])
    assert found["pounding.doubled_step_force_change"] == pytest.approx(0.3)
    # A contact law has nothing that could fail to be complementary.
    assert "pounding.complementarity" not in found
    rigid = tuple(replace(p, law=replace(p.law, code=UNILATERAL)) for p in system.pairs)
    assert of(rigid)["pounding.complementarity"] == study.response.residual
