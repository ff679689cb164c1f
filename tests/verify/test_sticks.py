from impactfem.sticks.stick import mass_on_spring
from impactfem.verify import sticks


def test_another_frequency_is_seen(monkeypatch, failed):
    monkeypatch.setattr(
        sticks,
        "mass_on_spring",
        lambda name, m, frequency: mass_on_spring(name, m, frequency=1.001 * frequency),
    )
    assert len(failed(sticks.half_sine_pulse())) >= 4


def test_a_force_on_the_wrong_side_is_seen(monkeypatch, failed):
    monkeypatch.setattr(sticks, "Y", -sticks.Y)
    assert any("difference" in quantity for quantity in failed(sticks.half_sine_pulse()))
