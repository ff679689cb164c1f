"""Scalars and results of the stage `pounding` against its histories."""

from dataclasses import replace

import numpy as np
import pytest

from impactfem.coupling.impacts import largest_means
from impactfem.coupling.laws import KelvinVoigt, Unilateral
from impactfem.stages.pounding.compute import Peaks
from impactfem.stages.pounding.store import (
    motion_results,
    scalars_of_modes,
    stick_results,
    stick_scalars,
)

from .conftest import CALIBRATION


def values(study):
    return {scalar.name: scalar.value for scalar in stick_scalars(study)}


@pytest.fixture(scope="module")
def scalars(study):
    return {scalar.name: scalar for scalar in stick_scalars(study)}


def test_each_scalar_has_a_name_of_its_own_and_a_unit(study, scalars):
    assert len(scalars) == len(stick_scalars(study))
    assert all(scalar.unit for scalar in scalars.values())


def test_a_motion_over_its_target(study, scalars):
    """From 0.2 of the shortest to 2 of the longest first period of the buildings."""
    misfit = study.motions[0].misfit
    firsts = [one.frequency[one.of_family("y")[0]] for one in study.modes]
    near = (misfit.frequency >= min(firsts) / 2.0) & (misfit.frequency <= 5.0 * max(firsts))
    assert 0 < near.sum() < near.size
    assert scalars["motion.pga"].value == pytest.approx(3.0, rel=1e-6)
    assert scalars["motion.over_target"].value == pytest.approx(misfit.ratio[near].mean())
    assert scalars["motion.pga_over_target"].value == pytest.approx(1.0, rel=1e-6)
    halved = replace(study.motions[0], misfit=replace(misfit, computed=0.5 * misfit.computed))
    made = values(replace(study, motions=(halved,)))
    assert made["motion.over_target"] == pytest.approx(0.5 * scalars["motion.over_target"].value)
    record = replace(study.motions[0], misfit=None, target_pga=None)
    assert values(replace(study, motions=(record,)))["motion.over_target"] is None


@pytest.mark.parametrize(
    ("share", "passed"), [(0.15, True), (-0.15, True), (0.17, False), (-0.17, False)]
)
def test_components_are_independent_up_to_a_correlation(study, share, passed):
    motion = study.motions[0]
    first = motion.accelerogram.acceleration - motion.accelerogram.acceleration.mean()
    other = np.random.default_rng(2).standard_normal(first.size)
    other -= other.mean()
    other -= first * (other @ first) / (first @ first)
    other *= np.sqrt((first @ first) / (other @ other))
    mixed = share * first + np.sqrt(1.0 - share**2) * other
    record = replace(motion.accelerogram, acceleration=mixed)
    second = replace(motion, direction="x", accelerogram=record, acceptance=None)
    found = motion_results(replace(study, motions=(replace(motion, acceptance=None), second)))
    assert found["criterion_motion"].values.tolist() == ["y_x"]
    assert found["criterion_value"].item() == pytest.approx(abs(share))
    assert (found["criterion_limit"].item(), found["criterion_passed"].item()) == (0.16, passed)


@pytest.mark.parametrize(("pounds", "along"), [("x", "x"), ("y", "y"), ("z", "y")])
def test_modes_are_along_the_direction_of_the_pounding(study, pounds, along):
    """Without a calibration, which has a direction of its own."""
    motion = study.case.motions[0].model_copy(update={"direction": pounds})
    case = study.case.model_copy(update={"motions": (motion,), "contacts": ()})
    modes, sticks = study.modes[0], study.system.sticks
    found = {one.name: one.value for one in scalars_of_modes(case, sticks, study.modes)}
    family = modes.of_family(along)
    frequency = [found[f"sticks.west.frequency.{n}"] for n in range(1, 7)]
    assert frequency == modes.frequency[family].tolist() == sorted(frequency)
    masses = [found[f"sticks.west.effective_mass.{n}"] for n in range(1, 7)]
    assert sum(masses) == pytest.approx(672e3) == found["sticks.west.mass"]


def test_peaks_against_histories(study, scalars):
    response, main = study.response, study.main_impact
    assert scalars["pounding.peak_force.floor_3"].value == response.force[:, 2].max() > 0.0
    assert scalars["pounding.penetration.floor_3"].value == pytest.approx(-response.gap[:, 2].min())
    peak = np.abs(response.absolute_acceleration[:, 13]).max()
    assert scalars["pounding.peak_acceleration.floor_3"].value == pytest.approx(peak)
    top = np.abs(response.u[:, 18 + 13]).max()
    assert scalars["pounding.peak_displacement.east"].value == pytest.approx(top)
    free = np.abs(study.free.u[:, 13]).max()
    assert scalars["pounding.peak_displacement_no_contact.west"].value == pytest.approx(free)
    assert scalars["pounding.main_impact_force"].value == main.peak_force
    assert scalars["pounding.main_impact_approach_velocity"].value == main.approach
    psa, f = study.floors.psa[0, 2, 0], study.floors.spectra.frequency
    assert scalars["frs.floor_3.peak"].value == psa.max()
    assert scalars["frs.floor_3.peak_frequency"].value == f[np.argmax(psa)]
    assert scalars["frs.floor_3.pfa_no_contact"].value == study.floors_free.pfa[2, 0]
    assert scalars["frs.east.floor_3.peak"].value == study.floors.psa[0, 5, 0].max()


@pytest.mark.parametrize(("turned", "together"), [(False, 1.5), (True, 1.0)])
def test_pairs_on_one_side_push_a_floor_together(study, scalars, turned, together):
    """A second pair at the top with half of the force; on the other side it pushes alone."""
    top = study.system.pairs[2]
    second = replace(top, name="corner", normal=-np.asarray(top.normal) if turned else top.normal)
    system = replace(study.system, pairs=(*study.system.pairs, second))
    force = study.response.force
    force = np.hstack([force, 0.5 * force[:, [2]]])
    response = replace(study.response, system=system, force=force)
    response.__dict__.pop("gap", None)
    apart = (*study.separations, study.separations[2])
    found = values(replace(study, system=system, response=response, separations=apart))
    name = "pounding.peak_force.floor_3"
    assert found[name] == pytest.approx(together * scalars[name].value)


def test_accuracy_and_demands(study, scalars):
    assert scalars["pounding.energy_residual"].value < 1e-9
    expected = max(separation.required for separation in study.separations)
    assert scalars["pounding.required_separation"].value == expected > 0.005
    # The duration for 96 t, the lightest pair, when the tops touch: some 9 ms in all.
    law = KelvinVoigt(1.2e10, study.system.pairs[2].law.xi, mass=96e3)
    assert scalars["pounding.steps_per_impact_min"].value == pytest.approx(
        law.duration(1.0) / 2.5e-4
    )
    depth = max(impact.penetration for impact in study.impacts) / 0.005
    assert scalars["pounding.penetration_over_gap"].value == pytest.approx(depth)
    pressure = max(impact.peak_force for impact in study.impacts) / 5.0
    assert scalars["pounding.bearing_pressure_max"].value == pytest.approx(pressure)
    assert scalars["pounding.bearing_ratio_max"].value == pytest.approx(pressure / 25e6)


def test_nothing_touches(no_contacts):
    found = values(no_contacts)
    assert found["pounding.main_impact_time"] is None and found["pounding.impacts"] == 0.0
    assert "pounding.bearing_pressure_max" not in found
    assert "pounding.peak_force.floor_3" not in found
    assert found["frs.floor_3.pfa"] == found["frs.floor_3.pfa_no_contact"]


def test_calibration(study, scalars):
    assert not [name for name in scalars if name.startswith("sticks.storey_height")]
    found = values(replace(study, calibration=CALIBRATION))
    assert found["sticks.stiffness_factor"] == 0.4
    assert [found[f"sticks.storey_height.{k}"] for k in (1, 2, 3)] == [3.5, 3.4, 3.6]
    assert (found["sticks.rigid_below"], found["sticks.rigid_above"]) == (0.3, 0.2)


@pytest.mark.parametrize("rest", [0.0, 0.2])
def test_the_last_period_of_a_run(study, rest):
    """Of its motion each building keeps a part; one that is held away from rest does not swing."""
    response = study.response
    lowest = min(modes.frequency[0] for modes in study.modes)
    n, k = len(response.u), round(1.1 / lowest / response.time_step)
    late = np.where(np.arange(n) > n - k, rest, 1.0)[:, None]
    held = np.where(late < 1.0, response.u[n - k], response.u)
    ended, still, cut = (
        values(replace(study, response=replace(response, u=u)))["pounding.swing_at_end"]
        for u in (response.u * late, held, response.u)
    )
    assert (ended > 0.0) == (rest > 0.0) and ended < 0.5 < cut
    assert still < 1e-12


def test_lines_that_touch_in_3d(study):
    """Points and forces are those of lines, not of the pair of sticks that hits harder."""
    first, *others = study.system.pairs
    point = replace(first, line=first.name, hats=np.zeros((2, 3)))
    system = replace(study.system, pairs=(point, *others))
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
        return values(replace(made, peaks=peaks, halved=halved, doubled=doubled))

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
    rigid = tuple(replace(p, law=Unilateral(mass=p.law.mass)) for p in system.pairs)
    assert of(rigid)["pounding.complementarity"] == study.response.residual


def test_variables_of_floors_and_buildings(study):
    found = stick_results(study)
    assert found["peak_acceleration"].dims == ("station",)
    assert found["peak_force"].attrs["units"] == "N"
    assert found["peak_displacement"].dims == ("building",)


@pytest.fixture(scope="module")
def as_line(small_case, run):
    """The small case with lines of two points, and the gap open by a slope along them."""
    line = 'length = "20 m"                     # a line'

    def made(slope=0.0):
        sloping = ("# gap_slope = 0 ", f"gap_slope = {slope:.6f} ")
        return run(small_case((f"# {line}", line), sloping))

    return made


def test_a_line_of_equal_points_has_the_results_of_its_pair(study, as_line):
    """Two Gauss points of half the area, and floors that do not turn: nothing else is reported."""
    line = as_line()
    assert len(line.response.exerted[0]) == 2 * len(study.system.pairs)
    names = [pair.name for pair in line.system.pairs]
    assert names == [pair.name for pair in study.system.pairs]
    found, expected = values(line), values(study)
    assert found.keys() == expected.keys() and found["pounding.impacts"] > 2.0
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=1e-6, abs=1e-9, nan_ok=True), name
    stores = [stick_results(one) for one in (line, study)]
    for name, values_of_it in stores[1].data_vars.items():
        if values_of_it.dims in (("impact",), ("pair",)) and values_of_it.dtype.kind == "f":
            size = float(np.abs(values_of_it).max())
            np.testing.assert_allclose(
                stores[0][name], values_of_it, rtol=1e-6, atol=1e-6 * size, err_msg=str(name)
            )
    assert list(stores[0]["impact_pair"].values) == list(stores[1]["impact_pair"].values)


def test_a_line_whose_points_differ_reports_their_sum(as_line):
    line = as_line(slope=4e-5)
    points, force = line.response.exerted
    main = line.main_impact
    of_main = [k for k, point in enumerate(points) if point.line == main.pair.name]
    first, second = (force[main.first : main.last + 1, k] for k in of_main)
    found = values(line)
    largest = found["pounding.main_impact_force"]
    assert largest == pytest.approx((first + second).max(), rel=1e-12)
    assert abs(first.max() - second.max()) > 0.02 * largest
    assert max(first.max(), second.max()) < 0.9 * largest
    assert found["pounding.main_impact_impulse"] == pytest.approx(
        line.response.time_step * (first + second).sum(), rel=1e-6
    )
