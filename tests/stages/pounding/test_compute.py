from contextlib import contextmanager
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.signal
import xarray as xr

from impactfem.coupling.from_case import system_of
from impactfem.coupling.ground import interpolate_ground
from impactfem.coupling.laws import Hertz, KelvinVoigt
from impactfem.coupling.pounding import simulate
from impactfem.spectra.resolved import CHANGE, COUNTS, agreement
from impactfem.stages.pounding.compute import (
    STEPS,
    Peaks,
    comparison,
    floor_spectra,
    pounded,
    run_sticks,
    station_dofs,
)
from impactfem.stages.pounding.figures import response
from impactfem.stages.pounding.store import stick_scalars, write_sticks
from impactfem.system.errors import SolutionError

SECOND_MOTION = """
[[motions]]
direction = "x"
type = "record"
file = "record.csv"
pga = "1.5 m/s2"
"""


def record(n=301, dt=0.005):
    t = dt * np.arange(n)
    acceleration = np.sin(20 * t) * np.sin(np.pi * t / t[-1])
    lines = (f"{a:.6g},{b:.9g}" for a, b in zip(t, acceleration, strict=True))
    return "time [s],acceleration [m/s2]\n" + "\n".join(lines) + "\n"


@pytest.fixture(scope="module")
def two_motions(small_case, run):
    return run(small_case(extra=SECOND_MOTION, files={"record.csv": record()}))


def test_steps_are_reported_in_order(study):
    seen = []

    @contextmanager
    def step(name):
        seen.append(f"{name} begins")
        yield
        seen.append(f"{name} ends")

    again = run_sticks(study.case, step)
    assert seen == [f"{name} {what}" for name in STEPS for what in ("begins", "ends")]
    # The same case gives the same numbers to the last bit.
    assert np.array_equal(again.response.u, study.response.u)
    assert np.array_equal(again.floors.psa, study.floors.psa)


def test_shapes_and_time(study):
    response = study.response
    assert response.time_step == 2.5e-4 and response.time.size == 8001
    assert response.ground.shape == (8001, 3) and not response.ground[:, [0, 2]].any()
    assert np.abs(response.ground[:, 1]).max() == pytest.approx(3.0, rel=1e-6)
    assert study.stations == [(name, k) for name in ("west", "east") for k in (1, 2, 3)]
    assert [m.frequency.size for m in study.modes] == [18, 18]
    assert study.floors.psa.shape == (2, 6, 1, study.floors.spectra.frequency.size)
    assert study.floors.directions == study.floors_free.directions == ("y",)


def test_the_run_pounds_and_the_free_one_does_not(study):
    assert study.impacts and study.response.force.any()
    assert study.free.force.shape == (8001, 0)
    first = study.impacts[0].first
    assert np.array_equal(study.free.u[:first], study.response.u[:first])
    assert not np.array_equal(study.free.u[-1], study.response.u[-1])
    assert study.response.energy.residual < 1e-9
    assert len(study.checks) == len(study.impacts)
    assert len(study.separations) == 3


def test_main_impact(study, no_contacts):
    assert study.main_impact.peak_force == study.response.force.max()
    assert no_contacts.main_impact is None


def test_peak_floor_acceleration_is_that_of_the_history(study):
    dofs = station_dofs(study.system)
    assert dofs.shape == (6, 6) and list(dofs[:, 0]) == [0, 6, 12, 18, 24, 30]
    for floors, run in ((study.floors, study.response), (study.floors_free, study.free)):
        peak = np.abs(run.absolute_acceleration[:, dofs[:, 1]]).max(axis=0)
        # Between the samples of the history a band-limited record can be a little higher.
        assert np.all(floors.pfa[:, 0] >= peak * (1 - 1e-9))
        assert floors.pfa[:, 0] == pytest.approx(peak, rel=0.2)
    assert study.floors.pfa.max() > 1.5 * study.floors_free.pfa.max()


def test_a_floor_spectrum_against_another_integrator(study):
    frequency = study.floors.spectra.frequency
    k = int(np.argmin(np.abs(frequency - 4.0)))
    w, xi = 2 * np.pi * frequency[k], study.floors.spectra.damping[1]
    a = study.free.absolute_acceleration[:, station_dofs(study.system)[2, 1]]
    _, x, _ = scipy.signal.lsim(([-1.0], [1.0, 2 * xi * w, w**2]), a, study.free.time)
    found = study.floors_free.sd[1, 2, 0, k]
    # The free vibration after the record may go beyond it, the record's own peak never.
    assert found >= np.abs(x).max() * (1 - 1e-3)
    assert found == pytest.approx(np.abs(x).max(), rel=0.02)
    assert study.floors_free.psa[1, 2, 0, k] == pytest.approx(w**2 * found, rel=1e-9)


def test_required_separation_belongs_to_the_free_run(study):
    # Floors of west are the components 1, 7 and 13 along y, those of east 18 further.
    u = study.free.u
    approach = [(u[:, k] - u[:, 18 + k]).max() for k in (1, 7, 13)]
    assert [separation.required for separation in study.separations] == pytest.approx(approach)
    for k, separation in enumerate(study.separations):
        assert separation.touched == study.response.force[:, k].any()


def test_fewest_steps_by_the_laws(study, no_contacts):
    touched = [s.pair.law for s in study.separations if s.touched]
    by_hand = min(np.pi / np.sqrt(1.2e10 / law.mass * (1 - law.xi**2)) / 2.5e-4 for law in touched)
    assert study.steps_per_impact_min == pytest.approx(by_hand)
    assert by_hand < KelvinVoigt(1.2e10, 0.14, mass=240e3).duration(1.0) / 2.5e-4
    assert no_contacts.steps_per_impact_min is None


def test_steps_of_a_law_that_depends_on_the_speed(study):
    law = Hertz(3e11, mass=120e3)
    impacts = tuple(replace(i, pair=replace(i.pair, law=law)) for i in study.impacts)
    fastest = max(impact.approach for impact in impacts)
    found = replace(study, impacts=impacts).steps_per_impact_min
    assert found == pytest.approx(law.duration(fastest) / 2.5e-4)
    # One that begins at rest has no duration of its own; none is left without the others.
    resting = replace(impacts[0], approach=0.0)
    assert replace(study, impacts=(*impacts, resting)).steps_per_impact_min == found
    assert np.isnan(replace(study, impacts=(resting,)).steps_per_impact_min)


def test_no_contacts(study, no_contacts):
    assert no_contacts.impacts == () == no_contacts.checks == no_contacts.separations
    assert np.array_equal(no_contacts.response.u, no_contacts.free.u)
    assert np.array_equal(no_contacts.response.u, study.free.u)
    assert np.array_equal(no_contacts.floors.psa, study.floors_free.psa)
    assert no_contacts.calibration is None


def test_two_motions(study, two_motions):
    assert [motion.direction for motion in two_motions.motions] == ["y", "x"]
    ground = two_motions.response.ground
    assert np.array_equal(ground[:, 1], study.response.ground[:, 1])
    assert np.abs(ground[:, 0]).max() == pytest.approx(1.5, rel=1e-3)
    # The record ends after 1.5 s of 2 s.
    assert not ground[6002:, 0].any() and ground[5900:5999, 0].any()
    assert two_motions.floors.directions == ("x", "y")
    assert two_motions.floors.psa.shape[2] == 2
    # Central pairs along y: nothing of x comes into y.
    assert two_motions.floors.pfa[:, 1] == pytest.approx(study.floors.pfa[:, 0], rel=1e-9)


def test_duration_and_update_of_the_case(study, run):
    pounding = study.case.pounding.model_copy(update={"duration": 0.5, "update": "lagged"})
    short = run(study.case.model_copy(update={"pounding": pounding}))
    assert short.response.time[-1] == pytest.approx(0.5)
    assert short.response.time.size == 2001
    longer = study.case.pounding.model_copy(update={"duration": 2.25})
    after = run(study.case.model_copy(update={"pounding": longer})).response
    assert after.time.size == 9001 and not after.ground[8001:].any() and after.u[9000].any()


def test_directions_asked_of_the_spectra(study):
    x = floor_spectra(study.case, study.response, ("x", "y"))
    assert not x.pfa[:, 0].any() and not x.psa[:, :, 0].any()
    assert np.array_equal(x.pfa[:, 1], study.floors.pfa[:, 0])


def test_pounded_under_given_motions(study):
    """The sticks alone: by hand, and with the update that the case has."""
    case, motions = study.case, study.motions
    found = pounded(case, None, motions, 1.5)
    dt = case.pounding.time_step
    assert found.time[-1] >= 1.5 > found.time[-1] - 2.0 * dt
    motion = motions[0].accelerogram
    history = (1, motion.time_step, motion.acceleration)
    ground = interpolate_ground([history], dt, len(found.time))
    known = simulate(system_of(case, None), ground, dt)
    assert np.any(found.force) and np.array_equal(found.force, known.force)
    pounding = case.pounding.model_copy(update={"update": "lagged"})
    lagged = pounded(case.model_copy(update={"pounding": pounding}), None, motions, 1.5)
    assert not np.allclose(found.force, lagged.force)


def test_waves_that_pass(small_case, run, study, tmp_path):
    """B is reached later, and its displacement is that to the ground under it."""
    waves = '\n[wave_passage]\napparent_velocity = "500 m/s"\ndirection = [0, 1]\n'
    found = run(small_case(extra=waves))
    first, second = found.system.sticks
    delay = found.case.delays[second.name]
    assert delay == pytest.approx((second.axis[1] - first.axis[1]) / 500.0) and delay > 0.0
    named = {one.name: one.value for one in stick_scalars(found)}
    prefix = f"motion.passage.{second.name}"
    moved = found.response.relative[second.name][0]
    assert named[f"{prefix}.delay"] == delay and 0.0 <= named[f"{prefix}.left"] < 1e-6
    assert named[f"{prefix}.apart"] == np.linalg.norm(moved, axis=1).max() > 1e-5
    alike = {one.name: one.value for one in stick_scalars(study)}
    assert not any("passage" in name for name in alike)
    write_sticks(tmp_path / "pounding.nc", found, "")
    with xr.open_dataset(tmp_path / "pounding.nc", engine="netcdf4") as store:
        np.testing.assert_array_equal(store["ground_apart"].values, [0.0 * moved, moved])
        assert "ground under" in response(store).caption
    # Without contact each does what it did, only later.
    for stick in (first, second):
        name = f"pounding.peak_displacement_no_contact.{stick.name}"
        assert named[name] == pytest.approx(alike[name], rel=1e-3)


def test_the_mean_of_a_force_over_5_ms():
    """Of the second line, whose 30 N last 10 ms behind a spike; a pair of sticks is none."""
    time = 1e-3 * np.arange(30)
    force = np.zeros((30, 3))
    force[3, 0], force[:, 2] = 60.0, 1e3
    force[10:21, 1], force[10, 1] = 30.0, 80.0
    floors = SimpleNamespace(
        psa=np.array([[[[4.0, 5.0, 7.0]]], [[[9.0, 9.0, 9.0]]]]),
        pfa=np.array([[3.0]]),
        spectra=SimpleNamespace(frequency=np.array([10.0, 100.0, 101.0])),
    )
    found = Peaks.of(SimpleNamespace(force=force, largest_forces=force, time=time), 2, floors)
    assert (found.force, found.frs.tolist(), found.pfa.tolist()) == (80.0, [[5.0]], [[3.0]])
    # From the step before: up to 80 N, down to 30 N, and 3 ms of these.
    assert found.mean_force == pytest.approx((40.0 + 55.0 + 3 * 30.0) / 5.0)


def test_a_run_to_compare_with_that_fails(caplog):
    """It is warned of and ends no stage; another error does."""
    with comparison("steps twice as long"):
        raise SolutionError("no contact found")
    assert "failed: no contact" in caplog.text
    with pytest.raises(MemoryError), comparison("steps twice as long"):
        raise MemoryError


@pytest.fixture(scope="module")
def quarter(study):
    """The case with a quarter of the time step, without runs to compare with."""
    pounding = study.case.pounding
    step = {"time_step": 0.25 * pounding.time_step}
    case = study.case.model_copy(update={"pounding": pounding.model_copy(update=step)})
    return run_sticks(case, ready=(study.calibration, study.system))


def test_a_quarter_of_the_step_changes_resolved_ordinates_little(study, quarter):
    """At most 5 % in the stated band; the band is not much too narrow for ordinates that count."""
    frequency, psa = study.floors.spectra.frequency, study.floors.psa
    counts = psa >= COUNTS * psa.max(axis=(1, 2, 3), keepdims=True)
    change = np.where(counts, np.abs(quarter.floors.psa / psa - 1.0), 0.0).max(axis=(0, 1, 2))
    band = study.band
    assert change[frequency <= band.frequency].max() <= CHANGE
    measured = agreement(frequency, psa, quarter.floors.psa)
    assert band.refinement >= 0.7 * min(measured, float(frequency[-1]))


def test_the_other_run_has_half_of_the_step(study, quarter):
    assert study.other.time_step == 0.5 * study.response.time_step
    assert quarter.other is None and quarter.band.refinement == np.inf


def test_few_steps_in_an_impact_narrow_the_band(study):
    required = study.case.pounding.points_per_impact
    assert study.steps_per_impact_min >= required
    more = study.case.pounding.model_copy(update={"points_per_impact": 10_000})
    narrow = replace(study, case=study.case.model_copy(update={"pounding": more})).band
    part = study.steps_per_impact_min / 10_000
    assert narrow.contact == pytest.approx(part * study.band.contact)
