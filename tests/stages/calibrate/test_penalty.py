from dataclasses import replace

import numpy as np
import pytest

from impactfem.stages.calibrate.impact import WallImpact
from impactfem.stages.calibrate.penalty import penalty_parameters
from impactfem.system.errors import SolutionError

# The paper's own figures (section 3.2.2): floor 8, 829 kN s, 0.163 m/s, 16.5 ms.
PAPER = WallImpact(
    floor=8,
    mass=3014e3,
    first=583,
    last=631,
    pulses=1,
    start=0.198,
    end=0.198 + 16.5e-3,
    impulse=829e3,
    largest_impulse=829e3,
    peak_force=80e6,
    approach=0.163,
    rebound=0.11,
    work=2e4,
    complete=True,
)


def test_figures_of_the_paper():
    found = penalty_parameters(PAPER)
    assert found.epsilon == pytest.approx(0.687, abs=5e-4)
    # Equation 4 with 0.687; the 0.129 printed beside it goes with ε = 0.6645.
    assert found.xi_c == pytest.approx(0.1187, abs=5e-4)
    assert found.K_Ceq == pytest.approx(1.1e11, rel=0.01)
    assert np.exp(-np.pi * 0.129 / np.sqrt(1.0 - 0.129**2)) == pytest.approx(0.6645, abs=1e-4)


def test_impulse_at_the_end():
    pulled = replace(PAPER, impulse=800e3)
    assert penalty_parameters(pulled).epsilon == penalty_parameters(PAPER).epsilon
    expected = 800e3 / (3014e3 * 0.163) - 1.0
    assert penalty_parameters(pulled, at_end=True).epsilon == pytest.approx(expected)


def test_elastic_impact_has_no_damping():
    elastic = replace(PAPER, largest_impulse=2.0 * PAPER.mass * PAPER.approach)
    found = penalty_parameters(elastic)
    assert (found.epsilon, found.xi_c) == (pytest.approx(1.0), 0.0)
    assert found.K_Ceq == pytest.approx(PAPER.mass * (np.pi / 16.5e-3) ** 2)


def test_without_tension_the_law_needs_more_damping_and_less_stiffness():
    pulls, pushes = (penalty_parameters(PAPER, tension=tension) for tension in (True, False))
    assert pushes.epsilon == pulls.epsilon
    assert pushes.xi_c > pulls.xi_c and pushes.K_Ceq < pulls.K_Ceq


@pytest.mark.parametrize("speed", [0.0, -0.02])
def test_a_floor_that_does_not_approach(speed):
    message = f"approach velocity of floor 8 before its impact at 0.198 s is {speed:g} m/s, not pos"
    with pytest.raises(SolutionError, match=message):
        penalty_parameters(replace(PAPER, approach=speed))


@pytest.mark.parametrize(
    ("impulse", "found"), [(400e3, "-0.1858"), (1e6, "1.035"), (491282.0, "0")]
)
def test_an_impulse_that_is_no_restitution(impulse, found):
    message = (
        f"gives the restitution {found} for floor 8, expected above 0 and at most 1: "
        f"impulse {impulse * 1e-3:.4g} kN s, momentum before the impact 491.3 kN s"
    )
    with pytest.raises(SolutionError, match=message):
        penalty_parameters(replace(PAPER, largest_impulse=impulse))
