from dataclasses import replace

import numpy as np
import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.verify import devices
from impactfem.verify.devices import spectra as module


def test_a_wrong_coefficient_is_seen(wrong, failed):
    """The form for equal dampings, taken for all."""
    wrong(module, "correlation", lambda right, rule, f, xi: right(rule, f, 0.0 * xi + xi.mean()))
    assert failed(module.cqc_coefficient()) == {
        "10 Hz at 5.00% and 12 Hz at 1.00%",
        "30.51 Hz at 1.99% and 82.9 Hz at 2.04%",
        "5 Hz at 2.00% and 5 Hz at 10.00%",
    }


@pytest.fixture
def other_rules(wrong):
    """Change the rules of all analyses."""

    def change(**changes):
        def altered(right, device, spectra, rules, *q):
            return right(device, spectra, replace(rules, **changes), *q)

        wrong(module, "spectrum_analysis", altered)

    return change


def test_a_lost_mode_is_seen(other_rules, failed):
    """Missing mass at the zero-period acceleration is not the mode's own ordinate."""
    other_rules(maximum_frequency=22.0)
    assert failed(module.device_sdld25())


def test_squares_of_rigid_modes_are_seen(other_rules, failed):
    """Without the rigid part every force and moment of the benchmark is too low."""
    other_rules(rigid=None)
    assert any("two pairs" in name for name in failed(module.missing_mass()))
    found = failed(module.rigid_response())
    assert len(found) == 8 and all("with SRSS" in one or "with CQC" in one for one in found)


def test_a_rigid_part_of_the_wrong_corner_is_seen(wrong, failed):
    """f2 as the frequency of the ZPA itself, without Gupta's mean of it and f1."""

    def corners(right, self, s, xi):
        return right(self, s, xi)[0], s.rigid_from(xi)

    wrong(module.Gupta, "corners", corners)
    assert "rigid part at 12 Hz, Gupta" in failed(module.rigid_response())


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("own_weight", lambda device: np.zeros(6)),
        ("ring_tension", lambda force, radius: force[2] + np.hypot(force[3], force[4]) / radius),
    ],
)
def test_a_tension_without_weight_or_about_the_rim_is_seen(monkeypatch, failed, name, other):
    monkeypatch.setattr(module, name, other)
    assert {"N + 2 M / r", "eight springs on a circle"} <= set(failed(module.net_tension()))


def test_other_rules_are_seen(wrong, failed):
    wrong(module, "combine_modes", lambda right, R, f, xi, _, t: right(R, f, xi, "cqc", t))
    assert len(failed(module.mode_combinations())) == 5


@pytest.mark.parametrize(
    ("benchmark", "seen", "passes"),
    [
        (
            module.two_supports,
            "acceleration, supports independent",
            "acceleration, supports together",
        ),
        (module.sdld30, "reaction at NO4, inertia", "supports apart"),
    ],
)
def test_supports_in_step_are_not_independent(wrong, failed, benchmark, seen, passes):
    wrong(module, "Rules", lambda right, **rest: right(**rest | {"supports": "algebraic"}))
    found = failed(benchmark())
    assert seen in found and not any(passes in name for name in found)


def test_a_mass_centre_elsewhere_is_seen(wrong, failed):
    def higher(right, name, springs, body, damping):
        return right(name, springs, replace(body, centre=1.1 * body.centre), damping)

    wrong(module, "on_springs", higher)
    assert "F_y under a rotation of 5/h rad/s2" in failed(module.rocking_floor())
    seen = failed(module.block_on_a_rotating_base())
    assert {"moment x", "force y", "moment x, base along y"} <= seen


def test_srss_fails_for_close_modes(wrong, failed):
    wrong(module, "combine_modes", lambda right, R, f, xi, _: right(R, f, xi, "srss"))
    assert failed(module.device_under_noise()) == {
        "CQC of mean squares, two close modes, over direct integration"
    }


def test_displacements_of_supports_are_not_lost(monkeypatch, failed):
    monkeypatch.setattr(module, "SDLD30_SHIFTS", (0.04, 0.0))
    seen = failed(module.sdld30())
    assert {"reaction at NO1, supports apart", "displacement of NO3, both"} <= seen
    assert not any(name.endswith("inertia") for name in seen)


def test_a_phase_that_is_ignored_is_seen(wrong, failed):
    """Both supports in step: the second one's motion taken for the first one's."""

    def in_step(right, device, a, dt, displacement):
        scale = np.abs(displacement[7]).max() / np.abs(displacement[1]).max()
        a[7], displacement[7] = scale * a[1], scale * displacement[1]
        return right(device, a, dt, displacement=displacement)

    wrong(module, "anchor_force", in_step)
    assert len(failed(module.harmonic_supports())) == 2


ON_BEAM = "1500 kg on a beam of 45.9 kg"


@pytest.mark.parametrize(
    ("name", "value", "seen"),
    [
        ("MASS", 1490.0, {"frequency of mode 1, along x", "effective mass of mode 4, along y"}),
        ("RADIUS", 0.49, {"effective mass of mode 1, along x"}),
    ],
)
def test_another_body_is_not_the_papers_device(monkeypatch, failed, name, value, seen):
    monkeypatch.setattr(devices, name, value)
    assert {f"{quantity}: {ON_BEAM}" for quantity in seen} <= failed(devices.device_table_6())


def test_drag_is_seen(monkeypatch, failed):
    """Forces with mass-proportional damping left out of the modes."""
    made = devices.paper_device(8.0e7)
    monkeypatch.setattr(devices, "PAPER_DAMPING", Rayleigh(0.0, devices.PAPER_DAMPING.beta))
    changed = devices.paper_device(8.0e7)
    monkeypatch.setattr(devices, "paper_device", lambda _: made)
    force = devices.anchor_force
    monkeypatch.setattr(devices, "anchor_force", lambda _, *a, **k: force(changed, *a, **k))
    assert any("F_y" in name for name in failed(devices.device_on_shaking_anchor()))
