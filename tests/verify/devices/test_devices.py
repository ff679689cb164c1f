import pytest

from impactfem.dynamics.damping import Rayleigh
from impactfem.verify import devices

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


def test_another_rigid_body_is_seen(wrong, failed):
    wrong(devices, "rigid_modes", lambda right: lambda m, J: right(m, (1.0 + 1e-6) * J))
    found = {name for name in failed(devices.device_table_6()) if "rigid body" in name}
    assert len(found) == 8


@pytest.mark.parametrize("benchmark", [devices.device_sdll06, devices.device_on_shaking_anchor])
def test_a_wrong_step_is_seen(wrong, failed, benchmark):
    wrong(
        devices,
        "anchor_force",
        lambda right: lambda d, a, dt, **rest: right(d, a, 1.001 * dt, **rest),
    )
    assert len(failed(benchmark())) >= 3


def test_drag_is_seen(monkeypatch, failed):
    """Forces with mass-proportional damping left out of the modes."""
    right = devices.PAPER_DAMPING
    made = devices.paper_device(8.0e7)
    light = Rayleigh(0.0, right.beta)
    monkeypatch.setattr(devices, "PAPER_DAMPING", light)
    changed = devices.paper_device(8.0e7)
    monkeypatch.setattr(devices, "paper_device", lambda _: made)
    force = devices.anchor_force
    monkeypatch.setattr(devices, "anchor_force", lambda _, *a, **k: force(changed, *a, **k))
    assert any("F_y" in name for name in failed(devices.device_on_shaking_anchor()))
