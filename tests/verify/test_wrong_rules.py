"""Benchmarks of spectra, motions and sticks see a wrong rule, table, unit or oscillator."""

import numpy as np
import pytest

from impactfem.motion import design_spectrum
from impactfem.verify import contact, motion, spectra, sticks


@pytest.mark.parametrize(
    ("benchmark", "function", "rule"),
    [
        (spectra.rg_1_122, "rg_1_122_frequencies", lambda *_: np.linspace(0.2, 34.0, 75)),
        (
            spectra.broadening,
            "broaden",
            lambda f, s, _, at: np.exp(np.interp(np.log(at), np.log(f), np.log(s))),
        ),
        (spectra.peak_reduction, "clip_peaks", lambda f, s: (f, s, ())),
        # Linear in the ordinate instead of its logarithm.
        (
            spectra.sdld25,
            "interpolate_damping",
            lambda d, s, at: s[0] + (s[1] - s[0]) * (at - d[0]) / (d[1] - d[0]),
        ),
    ],
)
def test_a_wrong_rule_is_seen(monkeypatch, failed, benchmark, function, rule):
    monkeypatch.setattr(spectra, function, rule)
    assert failed(benchmark())


def test_a_wrong_oscillator_is_seen(scaled, failed):
    scaled(spectra, "response_spectra", "time_step", 1.001)
    assert failed(spectra.spectrum_sdll06())


def test_a_wrong_table_is_seen(monkeypatch, failed):
    table = {**design_spectrum.HORIZONTAL[2], "D": (1.6, (0.1, 0.3, 1.2))}
    monkeypatch.setitem(design_spectrum.HORIZONTAL, 2, table)
    (quantity,) = failed(motion.eurocode_ordinates())
    assert "type 2, ground D" in quantity


def test_a_wrong_unit_is_seen(wrong):
    wrong(motion, "esm_text", lambda right: lambda *a: right(*a).replace("cm/s^2", "mm/s^2"))
    assert [r.name for r in motion.record_formats() if not r.passed] == ["ESM round trip"]


def test_another_frequency_is_seen(scaled, failed):
    scaled(sticks, "mass_on_spring", "frequency", 1.001)
    assert len(failed(sticks.half_sine_pulse())) >= 4


def test_a_force_on_the_wrong_side_is_seen(monkeypatch, failed):
    monkeypatch.setattr(sticks, "Y", -sticks.Y)
    assert any("difference" in quantity for quantity in failed(sticks.half_sine_pulse()))


def test_a_heavier_mass_at_the_wall_is_seen(scaled, failed):
    scaled(contact, "mass_on_spring", "mass", 1.002)
    seen = {"largest force", "duration of contact", "impulse", "time of the second largest force"}
    assert seen <= failed(contact.shock_on_wall())


def test_ground_that_is_a_step_late_is_no_second_order(wrong, failed):
    def make(right):
        return lambda system, a, dt: right(system, np.concatenate([a[:1], a[:-1]]), dt)

    wrong(sticks, "simulate", make)
    assert "fitted order in the step" in failed(sticks.newmark_order())


def test_storeys_of_another_height_are_seen(scaled, failed):
    scaled(sticks, "_prismatic", "height", 1.001)
    seen = {
        "tip along x",
        "tip along y",
        *(f"frequency {k} along y, 80 storeys" for k in (1, 2, 3)),
    }
    assert failed(sticks.cantilever()) == seen
