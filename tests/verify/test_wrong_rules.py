"""Benchmarks of spectra, motions and sticks see a wrong rule, table, unit or oscillator."""

import numpy as np
import pytest

from impactfem.motion import design_spectrum
from impactfem.verify import contact, devices, motion, spectra, sticks


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


SHOCK = {"largest force", "duration of contact", "impulse", "time of the second largest force"}
HEIGHT = {"tip along x", "tip along y", *(f"frequency {k} along y, 80 storeys" for k in (1, 2, 3))}
MISSING = {"smallest distance", "its time"}


@pytest.mark.parametrize(
    ("module", "function", "argument", "factor", "benchmark", "least"),
    [
        # The least number of rows that fail, or some of them.
        (spectra, "response_spectra", "time_step", 1.001, spectra.spectrum_sdll06, 1),
        (sticks, "mass_on_spring", "frequency", 1.001, sticks.half_sine_pulse, 4),
        (sticks, "_prismatic", "height", 1.001, sticks.cantilever, HEIGHT),
        (contact, "mass_on_spring", "mass", 1.002, contact.shock_on_wall, SHOCK),
        (contact, "simulate", "time_step", 1.01, contact.missing_pair, MISSING),
        (devices, "anchor_force", "time_step", 1.001, devices.device_sdll06, 3),
        (devices, "anchor_force", "time_step", 1.001, devices.device_on_shaking_anchor, 3),
        (devices, "rigid_modes", "inertia", 1.0 + 1e-6, devices.device_table_6, 8),
    ],
)
def test_another_value_is_seen(
    scaled, failed, module, function, argument, factor, benchmark, least
):
    scaled(module, function, argument, factor)
    found = failed(benchmark())
    assert len(found) >= least if isinstance(least, int) else found >= least


def test_a_wrong_table_is_seen(monkeypatch, failed):
    table = {**design_spectrum.HORIZONTAL[2], "D": (1.6, (0.1, 0.3, 1.2))}
    monkeypatch.setitem(design_spectrum.HORIZONTAL, 2, table)
    (quantity,) = failed(motion.eurocode_ordinates())
    assert "type 2, ground D" in quantity


def test_a_wrong_unit_is_seen(wrong):
    wrong(motion, "esm_text", lambda right, *a: right(*a).replace("cm/s^2", "mm/s^2"))
    assert [r.name for r in motion.record_formats() if not r.passed] == ["ESM round trip"]


def test_a_force_on_the_wrong_side_is_seen(monkeypatch, failed):
    monkeypatch.setattr(sticks, "Y", -sticks.Y)
    assert any("difference" in quantity for quantity in failed(sticks.half_sine_pulse()))


def test_ground_that_is_a_step_late_is_no_second_order(wrong, failed):
    def late(right, system, a, dt):
        return right(system, np.concatenate([a[:1], a[:-1]]), dt)

    wrong(sticks, "simulate", late)
    assert "fitted order in the step" in failed(sticks.newmark_order())
