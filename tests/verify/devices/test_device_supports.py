"""Benchmarks of a device on two supports, and what they see."""

import numpy as np

from impactfem.verify.devices import device_supports as module


def test_published_and_closed_form(failed):
    assert failed(module.sdld30()) == failed(module.harmonic_supports()) == set()


def test_supports_in_step_are_not_independent(monkeypatch, failed):
    right = module.Rules
    monkeypatch.setattr(module, "Rules", lambda **rest: right(**rest, supports="algebraic"))
    seen = failed(module.sdld30())
    assert "reaction at NO4, inertia" in seen
    assert not any("supports apart" in name for name in seen)


def test_displacements_of_supports_are_not_lost(monkeypatch, failed):
    monkeypatch.setattr(module, "SDLD30_SHIFTS", (0.04, 0.0))
    seen = failed(module.sdld30())
    assert {"reaction at NO1, supports apart", "displacement of NO3, both"} <= seen
    assert not any(name.endswith("inertia") for name in seen)


def test_a_phase_that_is_ignored_is_seen(monkeypatch, failed):
    """Both supports in step: the second one's motion taken for the first one's."""
    right = module.anchor_force

    def in_step(device, a, dt, displacement):
        scale = np.abs(displacement[7]).max() / np.abs(displacement[1]).max()
        a[7], displacement[7] = scale * a[1], scale * displacement[1]
        return right(device, a, dt, displacement=displacement)

    monkeypatch.setattr(module, "anchor_force", in_step)
    assert len(failed(module.harmonic_supports())) == 2
