from impactfem.sticks.stick import mass_on_spring
from impactfem.verify import integrator


def test_another_frequency_is_seen(monkeypatch, failed):
    assert not failed(integrator.pulse())
    monkeypatch.setattr(
        integrator,
        "mass_on_spring",
        lambda name, m, frequency: mass_on_spring(name, m, frequency=1.001 * frequency),
    )
    assert len(failed(integrator.pulse())) >= 4


def test_a_force_on_the_wrong_side_is_seen(monkeypatch, failed):
    monkeypatch.setattr(integrator, "Y", -integrator.Y)
    assert any("difference" in quantity for quantity in failed(integrator.pulse()))
