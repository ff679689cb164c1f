import math

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
import scipy.optimize
from hypothesis import given, settings
from hypothesis import strategies as st

from impactfem.coupling.laws import Jankowski
from impactfem.coupling.restitution import (
    damped_hertz,
    exact_chi,
    exact_jankowski_xi,
    jankowski,
    kelvin_voigt,
    kelvin_voigt_phase,
    kelvin_voigt_xi,
)


def rebound(force):
    """Speed after and time of x'' = -force(x, x') from x = 0, x' = 1 back to x = 0."""

    def back(t, y):
        return y[0]

    back.terminal, back.direction = True, -1

    def rates(t, y):
        return [y[1], -force(max(y[0], 0.0), y[1])]

    solution = scipy.integrate.solve_ivp(
        rates, (0.0, 1e3), [0.0, 1.0], "LSODA", events=back, rtol=1e-10, atol=1e-12
    )
    assert solution.status == 1
    return -solution.y[1, -1], solution.t[-1]


def let_go(xi):
    """Time and speed where x + 2 ξ x' of x'' + 2 ξ x' + x = 0 first is zero."""
    A = np.array([[0.0, 1.0], [-1.0, -2.0 * xi]])

    def state(t):
        return scipy.linalg.expm(t * A) @ [0.0, 1.0]

    end = scipy.optimize.brentq(lambda t: state(t) @ [1.0, 2.0 * xi], 0.0, 3.2, xtol=1e-15)
    return end, -state(end)[1]


@pytest.mark.parametrize("xi", [0.05, 0.12, 0.9, 1.0, 3.0])
def test_kelvin_voigt_without_tension_by_the_matrix_exponential(xi):
    time, speed = let_go(xi)
    assert kelvin_voigt(xi, tension=False) == pytest.approx(speed, rel=1e-7 if xi == 1 else 1e-12)
    assert kelvin_voigt_phase(xi, tension=False) == pytest.approx(time, rel=1e-7)
    # It lets go before p = 0, where it does come back to that.
    assert time < kelvin_voigt_phase(xi) - 1e-3


def test_limits_of_kelvin_voigt():
    assert kelvin_voigt_xi(0.687) == pytest.approx(0.1187, abs=5e-5)  # equation 4 of the paper
    for tension in (True, False):
        assert kelvin_voigt(0.0, tension=tension) == 1.0
        assert kelvin_voigt_phase(0.0, tension=tension) == pytest.approx(np.pi)
        nothing = kelvin_voigt_xi(1.0, tension=tension)
        # -0.0 would go on into results as such.
        assert nothing == 0.0 and math.copysign(1.0, nothing) == 1.0
    assert kelvin_voigt(1.0) == 0.0
    assert kelvin_voigt(1 - 1e-12) == pytest.approx(0.0, abs=1e-300)
    assert kelvin_voigt_phase(1.0) == kelvin_voigt_phase(2.0) == np.inf
    # Critical damping without tension: continuous, e^-2 at the phase 2.
    near = (1 - 1e-6, 1.0, 1 + 1e-6)
    assert [kelvin_voigt(xi, tension=False) for xi in near] == pytest.approx([np.exp(-2)] * 3, 1e-5)
    assert [kelvin_voigt_phase(xi, tension=False) for xi in near] == pytest.approx([2.0] * 3, 1e-5)
    grid = [kelvin_voigt(xi, tension=False) for xi in np.linspace(0.0, 5.0, 101)]
    assert np.all(np.diff(grid) < 0.0)


@settings(deadline=None)
@given(st.floats(1e-3, 1.0), st.booleans())
def test_kelvin_voigt_xi_is_the_inverse(epsilon, tension):
    xi = kelvin_voigt_xi(epsilon, tension=tension)
    assert xi >= 0.0
    assert kelvin_voigt(xi, tension=tension) == pytest.approx(epsilon, rel=1e-9)
    assert kelvin_voigt(1.01 * xi + 0.01, tension=tension) < epsilon


@pytest.mark.parametrize("chi", [0.0, 0.1, 0.75, 1.0, 2.0, 8.0])
def test_damped_hertz_by_integration(chi):
    speed, _ = rebound(lambda x, v: x**1.5 * (1.0 + chi * v))
    assert damped_hertz(chi) == pytest.approx(speed, rel=1e-6)
    assert abs(damped_hertz(1.1 * chi + 0.1) - speed) > 3e-3


@pytest.mark.parametrize("epsilon", [0.1, 0.4, 0.7, 0.9])
@pytest.mark.parametrize("n", [1.0, 1.5, 2.5])
def test_exact_chi_by_integration_for_any_power(epsilon, n):
    chi = exact_chi(epsilon)
    assert rebound(lambda x, v: x**n * (1.0 + chi * v))[0] == pytest.approx(epsilon, rel=1e-6)


@settings(deadline=None, max_examples=50)
@given(st.floats(0.05, 0.999))
def test_exact_chi_is_the_inverse(epsilon):
    chi = exact_chi(epsilon)
    assert damped_hertz(chi) == pytest.approx(epsilon, rel=1e-7)
    # The published relations are its limit near ε = 1 and too weak elsewhere.
    assert chi > 1.5 * (1.0 - epsilon) >= 0.75 * (1.0 - epsilon**2)


def test_relations_meet_near_one():
    epsilon = 0.999
    published = (1.5 * (1.0 - epsilon), 0.75 * (1.0 - epsilon**2))
    assert published == pytest.approx([exact_chi(epsilon)] * 2, rel=2e-3)
    assert exact_chi(1.0) == exact_jankowski_xi(1.0) == 0.0
    assert damped_hertz(0.0) == jankowski(0.0) == 1.0
    laws = [Jankowski(1.0, epsilon, name, mass=1.0) for name in ("exact", "published")]
    assert laws[0].xi == pytest.approx(laws[1].xi, rel=2e-3)
    assert Jankowski(1.0, 1.0, mass=1.0).xi == 0.0


@pytest.mark.parametrize("xi", [0.05, 0.35, 1.0, 5.0])
def test_jankowski_by_integration(xi):
    speed, _ = rebound(lambda x, v: x**1.5 + 2.0 * xi * x**0.25 * max(v, 0.0))
    assert jankowski(xi) == pytest.approx(speed, rel=1e-6)
    # Damped on the way back as well it would be another law.
    if xi < 0.5:
        both, _ = rebound(lambda x, v: x**1.5 + 2.0 * xi * x**0.25 * v)
        assert both < 0.97 * speed


@pytest.mark.parametrize("epsilon", [1e-3, 0.01, 0.026, 0.999999, 1.0 - 1e-8])
def test_exact_chi_at_the_ends(epsilon):
    chi = exact_chi(epsilon)
    # Near 0 χ ε is 1 but for e^-χ; near 1 χ is 3/2 (1 - ε).
    expected = 1.0 / epsilon if epsilon < 0.5 else 1.5 * (1.0 - epsilon)
    assert chi == pytest.approx(expected, rel=1e-4)
    assert damped_hertz(chi) == pytest.approx(epsilon, rel=1e-6)
