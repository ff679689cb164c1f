import logging
from pathlib import Path

import numpy as np
import pytest

from impactfem.case import RecordMotion, SyntheticMotion
from impactfem.coupling.ground import interpolate_ground
from impactfem.motion.design_spectrum import design_spectrum, eurocode_spectrum
from impactfem.motion.from_case import checked_durations, ground_motions, treated_record
from impactfem.records import FORMATS
from impactfem.records.accelerogram import Accelerogram
from impactfem.records.csv import write_csv
from impactfem.spectra import response_spectra
from impactfem.system.errors import InputError
from impactfem.verify.motion import at2_text, cosmos_text, csmip_text, esm_text, knet_text

CASE = Path("case.toml")
A = np.random.default_rng(9).standard_normal(2001)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "north.csv"
    write_csv(Accelerogram(0.01, A), path)
    return path


def record(file, **keys):
    return RecordMotion.model_validate({"direction": "x", "type": "record", "file": file} | keys)


def synthetic(spectrum, **keys):
    values = {
        "direction": "x",
        "type": "synthetic",
        "seed": 1,
        "pga": 3.0,
        "duration": 8.0,
        "time_step": 0.01,
        "strong_phase": (1.0, 5.0),
        "iterations": 3,
        "spectrum": spectrum,
    }
    return SyntheticMotion.model_validate(values | keys)


@pytest.mark.parametrize("step", [0.3358e-3, 0.5e-3])
def test_a_fine_record_keeps_its_samples(tmp_path, step):
    path = tmp_path / "fine.csv"
    write_csv(Accelerogram(step, A), path)
    motion = treated_record(record(path))
    assert motion.time_step == motion.sampling_step
    assert motion.acceleration == pytest.approx(A, rel=1e-15, abs=0.0)


@pytest.mark.parametrize(("step", "refined"), [(0.02, 1e-3), (0.01, 5e-4), (0.004, 2.5e-4)])
def test_a_coarse_record_is_refined(tmp_path, caplog, step, refined):
    """Its samples stay; a case is told once. The step that the user gives stays, too."""
    path = tmp_path / "coarse.csv"
    write_csv(Accelerogram(step, A), path)
    motion = treated_record(record(path))
    assert motion.time_step == pytest.approx(refined) and motion.sampling_step == step
    assert motion.acceleration[:: round(step / refined)] == pytest.approx(A, abs=1e-12)
    with caplog.at_level(logging.INFO, logger="impactfem"):
        checked_durations([record(path)], CASE)
        checked_durations([record(path, resample=step)], CASE)
    (line,) = [entry.getMessage() for entry in caplog.records]
    assert "coarse.csv: time step" in line and f"{1e3 * refined:g} ms" in line
    given = treated_record(record(path, resample=step))
    assert given.time_step == step and np.array_equal(given.acceleration, A)


def floor_over_ground(motion, structure_step=0.25e-3):
    """Spectrum of a rigid floor over that of the ground, 0.5 to 100 Hz, smallest and largest."""
    (ground,) = ground_motions([motion])
    n_t = round(ground.accelerogram.duration / structure_step) + 1
    floor = interpolate_ground([ground.history], structure_step, n_t)[:, 0]
    f = ground.spectrum.frequency[ground.spectrum.frequency >= 0.5]
    psa = response_spectra(floor, structure_step, f, [0.05], points_per_cycle=40.0).psa[0, 0]
    ratio = psa / ground.spectrum.psa[0, 0, -f.size :]
    return ratio.min(), ratio.max()


@pytest.mark.parametrize("step", [0.02, 0.01, 0.005])
@pytest.mark.parametrize("fmt", list(FORMATS))
def test_a_rigid_floor_has_the_spectrum_of_the_ground(tmp_path, fmt, step):
    """Within 1 % for each format, of noise up to the Nyquist frequency; not by straight lines."""
    n = 800
    a = np.round(80.0 * A[:n] * np.sin(np.pi * np.arange(n) / n), 4)
    path = tmp_path / f"noise.{fmt}"
    texts = {
        "at2": lambda: at2_text(a / 980.665, step),
        "esm": lambda: esm_text(a, step),
        "cosmos": lambda: cosmos_text([("Up", "HNZ", a)], step),
        "csmip": lambda: csmip_text([("Up", a)], step),
        "knet": lambda: knet_text([round(x) for x in 1e3 * a], round(1.0 / step)),
    }
    if fmt == "csv":
        write_csv(Accelerogram(step, 0.01 * a), path)
    else:
        path.write_text(texts[fmt](), encoding="utf-8")
    low, high = floor_over_ground(record(path, format=fmt))
    assert low >= 0.99 and high <= 1.01
    # The negative twin: the ground band-limited, the structure by straight lines.
    (ground,) = ground_motions([record(path, format=fmt)])
    lines = treated_record(record(path, format=fmt, resample=step))
    f = [0.4 / step]
    straight = np.interp(ground.accelerogram.time, lines.time, lines.acceleration)
    psa = [
        response_spectra(x, ground.accelerogram.time_step, f, [0.05], points_per_cycle=40.0).psa
        for x in (straight, ground.accelerogram.acceleration)
    ]
    assert float(psa[0].item() / psa[1].item()) < 0.9


def test_a_step_of_the_user_gives_both_the_straight_lines(file):
    """The spectrum of the ground is that of what the structure takes."""
    low, high = floor_over_ground(record(file, resample=0.01), structure_step=0.1e-3)
    assert low >= 0.985 and high <= 1.01


def test_the_peak_asked_holds_after_the_treatment(file):
    motion = treated_record(
        record(file, baseline="rest", taper=1.0, filter=(0.5, 20.0), resample=0.005, pga=2.0)
    )
    assert motion.time_step == 0.005
    assert np.abs(motion.acceleration).max() == pytest.approx(2.0, rel=1e-12)
    assert abs(motion.velocity[-1]) < 1e-12
    words = ["record north.csv", "tapered", "band-pass", "resampled", "brought to rest", "scaled"]
    positions = [motion.origin.index(word) for word in words]
    assert positions == sorted(positions)


def test_scale_and_component(tmp_path):
    path = tmp_path / "two.csv"
    path.write_text("time [s],NS [m/s2],EW [m/s2]\n0,1,4\n1,2,5\n2,3,6\n")
    motion = treated_record(record(path, component="EW", resample=1.0, scale=2.0))
    assert motion.acceleration.tolist() == [8.0, 10.0, 12.0]
    with pytest.raises(InputError, match="component: 'NS', 'EW'"):
        treated_record(record(path))


def test_a_record_that_is_turned_round(file):
    once, turned = (treated_record(record(file, scale=scale)) for scale in (1.0, -1.0))
    assert np.array_equal(turned.acceleration, -once.acceleration)
    scaled = treated_record(record(file, scale=-1.0, pga=2.0)).acceleration
    assert np.abs(scaled).max() == pytest.approx(2.0)
    assert scaled[100] * once.acceleration[100] < 0.0


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"filter": (1.0, 60.0)}, "the high corner of 60 Hz must be below"),
        ({"filter": (1e-6, 20.0)}, "the low corner of 1e-06 Hz must be at least"),
        ({"taper": 15.0}, "the taper of 15 s is longer"),
        ({"resample": 19.0}, ".* at most half the duration"),
        ({"component": "EW"}, "no such component; the file holds 'acceleration'"),
    ],
)
def test_what_a_record_cannot_bear_is_a_fault_of_the_key(file, keys, message):
    (key,) = keys
    with pytest.raises(InputError, match=rf"^case\.toml: motions\[1\]\.{key}[^:]*: {message}"):
        checked_durations([record(file), record(file, **keys)], CASE)
    # Of a record that is not that of the case, the file is named.
    with pytest.raises(InputError, match=rf"^\S*north\.csv: {key}[^:]*: {message}"):
        treated_record(record(file, **keys))
    borne = {"filter": (1.0, 20.0), "taper": 9.0, "resample": 0.005, "component": "acceleration"}
    assert checked_durations([record(file, **{key: borne[key]})], CASE) == [20.0]


def test_a_record_of_zeros_has_no_peak_to_scale(tmp_path):
    path = tmp_path / "zero.csv"
    write_csv(Accelerogram(0.01, np.zeros(100)), path)
    with pytest.raises(InputError, match=r"accelerogram with peak 0.0"):
        checked_durations([record(path, pga=1.0)], CASE)


def test_faults_of_all_records(tmp_path):
    motions = [record(tmp_path / name) for name in ("a.csv", "b.at2")]
    with pytest.raises(InputError) as caught:
        checked_durations(motions, CASE)
    assert len(caught.value.faults) == 2


def design_target(motion):
    return design_spectrum(motion.spectrum, motion.damping)


def test_design_spectra():
    ec8 = {"type": "ec8", "spectrum_type": 1, "ground": "C", "reference_acceleration": 2.0}
    expected = eurocode_spectrum(1, "C", 2.0, damping=0.1)
    assert design_target(synthetic(ec8, damping=0.1)) == expected
    corner = {"ground_acceleration": 2.3, "corner_periods": (0.15, 0.4, 2.0)}
    assert design_target(synthetic(corner)).pseudo_acceleration(1e9) == pytest.approx(2.3)
    decree = {"type": "french-decree", "zone": 4, "ground": "B", "importance_factor": 1.2}
    assert design_target(synthetic(decree)).pseudo_acceleration(5.0) == pytest.approx(6.48)


def test_a_table_is_matched_where_it_holds(tmp_path):
    path = tmp_path / "target.csv"
    path.write_text("period [s],acceleration [g],damping [%]\n1,0.4,5\n0.1,0.5,5\n1,1,2\n0.1,1,2\n")
    motion = synthetic({"type": "table", "file": path})
    (made,) = ground_motions([motion])
    assert made.misfit.frequency[[0, -1]] == pytest.approx([1.0, 10.0])
    assert made.misfit.target[[0, -1]] == pytest.approx(9.80665 * np.array([0.4, 0.5]))
    assert abs(made.misfit.mean) < 0.1
    assert design_target(synthetic({"type": "table", "file": path}, damping=0.02)).range == (1, 10)
    with pytest.raises(InputError, match="have this damping"):
        design_target(synthetic({"type": "table", "file": path}, damping=0.03))
    path.write_text("frequency [Hz],acceleration [g]\n60,1\n70,1\n")
    expected = (
        r"target.csv: frequency = '60 to 70 Hz': expected a range in common with the motion, 0"
    )
    for refuse in (ground_motions, lambda motions: checked_durations(motions, CASE)):
        with pytest.raises(InputError, match=expected):
            refuse([motion])
    path.unlink()
    with pytest.raises(InputError, match="no such file"):
        ground_motions([motion])
