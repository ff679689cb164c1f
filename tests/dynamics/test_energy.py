import numpy as np
import pytest

from impactfem.dynamics.energy import Energy


def test_residual_of_a_start_with_energy():
    """Relative to the energy stored, where no work is done; a part of a history has one too."""
    stored, nothing = np.array([8.0, 6.0]), np.zeros(2)
    damped = np.array([3.0, 4.9])
    assert Energy(stored, nothing, damped, nothing).residual == pytest.approx(0.1 / 8.0)


BALANCED = {
    "kinetic": [5.0, 3.0, 1.0],
    "elastic": [0.0, 2.0, 3.0],
    "damped": [0.0, 0.5, 1.0],
    "numerical": [0.0, 0.5, 1.0],
    "input": [0.0, 1.0, 2.0],
    "contact": [0.0, 0.0, -1.0],
}


def energy(**parts):
    names = {**dict.fromkeys(BALANCED, (0.0, 0.0, 0.0)), **parts}
    return Energy(**{name: np.array(values) for name, values in names.items()})


@pytest.mark.parametrize("name", ["damped", "numerical", "input", "contact"])
def test_a_balance_of_all_parts(name):
    """2 J come in, 5 J are there; 1 J each goes to the damping, the rule and the contact."""
    assert energy(**BALANCED).residual == energy(**BALANCED).gained == 0.0
    wrong = {**BALANCED, name: np.add(BALANCED[name], [0.0, 0.0, 0.5])}
    assert energy(**wrong).residual == pytest.approx(0.1)


def test_what_the_contact_gains():
    assert energy(kinetic=[4.0, 4.0, 4.0], contact=[0.0, -1.0, -0.8]).gained == pytest.approx(0.05)
    assert energy(kinetic=[4.0, 4.0, 4.0], contact=[0.0, 0.4, 0.4]).gained == pytest.approx(0.1)
    assert energy(input=[0.0, -9.0, 0.0]).scale == 9.0
    nothing = energy()
    assert nothing.gained == nothing.residual == nothing.scale == 0.0
