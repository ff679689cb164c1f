import numpy as np
import pytest

from impactfem.coupling.contact_history import ContactEnergy, ContactHistory


def energy(**parts):
    zero = np.zeros(3)
    names = ("kinetic", "elastic", "damped", "numerical", "input", "contact")
    return ContactEnergy(**{name: np.array(parts.get(name, zero), float) for name in names})


def test_a_balance():
    """2 J come in, 5 J are there; 1 J each goes to the damping, the rule and the contact."""
    balanced = {
        "kinetic": [5.0, 3.0, 1.0],
        "elastic": [0.0, 2.0, 3.0],
        "damped": [0.0, 0.5, 1.0],
        "numerical": [0.0, 0.5, 1.0],
        "input": [0.0, 1.0, 2.0],
        "contact": [0.0, 0.0, -1.0],
    }
    assert energy(**balanced).residual == 0.0 and energy(**balanced).gained == 0.0
    assert energy(**balanced).scale == 5.0
    for name in ("damped", "numerical", "input", "contact"):
        wrong = {**balanced, name: np.add(balanced[name], [0.0, 0.0, 0.5])}
        assert energy(**wrong).residual == pytest.approx(0.1), name


def test_what_the_contact_gains():
    assert energy(kinetic=[4.0, 4.0, 4.0], contact=[0.0, -1.0, -0.8]).gained == pytest.approx(0.05)
    assert energy(kinetic=[4.0, 4.0, 4.0], contact=[0.0, 0.4, 0.4]).gained == pytest.approx(0.1)
    assert energy(input=[0.0, -9.0, 0.0]).scale == 9.0
    nothing = energy(contact=[0.0, 0.0, 0.0])
    assert nothing.gained == nothing.residual == nothing.scale == 0.0


def test_forces_and_penetration():
    none = np.empty((3, 0))
    history = ContactHistory(
        time=np.array([0.0, 0.5, 1.0]),
        impulse=np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]),
        gap=np.array([[0.1, 0.2], [-0.3, 0.1], [-0.2, 0.0]]),
        displacement=none,
        velocity=none,
        residual=np.zeros(3),
        energy=energy(),
    )
    assert history.force.tolist() == [[0.0, 0.0], [2.0, 0.0], [4.0, 0.0]]
    assert history.penetration.tolist() == [0.3, 0.0]
