import numpy as np

from impactfem.dynamics.damping import Rayleigh
from impactfem.verify.waves import forced
from impactfem.verify.waves.forced import DAMPED


def test_another_damping_is_seen(wrong, failed):
    wrong(forced, "response", lambda right: lambda t, w, ratio: right(t, w, 1.001 * ratio))
    found = failed(forced.modal_equation())
    pulse = "largest difference over the peak, an oscillating pulse, "
    assert found == {pulse + name for name in DAMPED if name != "undamped"}


def test_a_wrong_damping_of_the_strip_is_seen(monkeypatch, failed):
    monkeypatch.setattr(forced, "Rayleigh", lambda alpha, beta=0.0: Rayleigh(1.1 * alpha, beta))
    found = failed(forced.strip_pulse())
    assert {"largest deflection, overdamped, full", "largest deflection, overdamped, reduced"} <= (
        found
    )


def test_a_force_on_the_nearest_node_alone_is_seen(monkeypatch, failed):
    def nearest(x, at):
        forces = np.zeros((len(at), len(x)))
        forces[np.arange(len(at)), np.rint(at / x[1]).astype(int)] = 1.0
        return forces

    monkeypatch.setattr(forced, "ELEMENTS", 4)
    monkeypatch.setattr(forced, "nodal_forces", nearest)
    assert failed(forced.travelling_force())
