import mpmath
import numpy as np
import pytest
import scipy.integrate
from hypothesis import given, settings
from hypothesis import strategies as st

from impactfem.sticks.contact import (
    KELVIN_VOIGT,
    KELVIN_VOIGT_NO_TENSION,
    damping_ratio,
    effective_mass,
    kelvin_voigt,
    law_force,
    restitution,
)

K, C = 1e9, 4e6
PARAMETERS = np.array([K, C, 0.0, 0.0])


def two_masses(law, m1, m2, speed, *, tension):
    """Speeds and time at the end of an impact, by adaptive integration and event detection."""
    k, c = law.parameters[:2]

    def force(y):
        return k * (y[0] - y[1]) + c * (y[2] - y[3])

    def rhs(t, y):
        return [y[2], y[3], -force(y) / m1, force(y) / m2]

    def release(t, y):
        # At the very start p = 0 as well: only a falling value counts.
        return y[0] - y[1] if tension else force(y)

    release.terminal, release.direction = True, -1
    solution = scipy.integrate.solve_ivp(
        rhs, (0.0, 100.0), [0.0, 0.0, speed, 0.0], events=release, rtol=1e-11, atol=1e-16
    )
    return solution.y[:, -1], solution.t[-1]


@pytest.mark.parametrize(
    ("xi", "tension"),
    [(0.0, True), (0.05, True), (0.12, True), (0.6, True)]
    + [(0.0, False), (0.05, False), (0.12, False), (0.6, False), (1.0, False), (1.7, False)],
)
def test_restitution_of_two_masses(xi, tension):
    m1, m2, speed = 3.0, 5.0, 0.4
    law = kelvin_voigt(200.0, xi, effective_mass(m1, m2), tension=tension)
    y, time = two_masses(law, m1, m2, speed, tension=tension)
    assert (y[3] - y[2]) / speed == pytest.approx(restitution(xi, tension=tension), rel=1e-7)
    assert law.epsilon == restitution(xi, tension=tension)
    if tension:
        assert time == pytest.approx(law.duration, rel=1e-7)
    if xi > 0.0:  # the two laws differ, and not by little
        other = restitution(xi, tension=not tension)
        assert abs(other - law.epsilon) > 1e-3


def test_restitution_without_tension_in_many_digits():
    # Speed at F = 0 of x'' + 2 ξ x' + x = 0, x(0) = 0, x'(0) = 1, with the time found by mpmath.
    for xi in (0.12, 0.9, 3.0):
        with mpmath.workdps(40):
            z = mpmath.mpf(xi)
            poles = [-z + s * mpmath.sqrt(z**2 - 1 + 0j) for s in (1, -1)]

            def x(t, n, poles=poles):
                a, b = poles
                return mpmath.re((a**n * mpmath.exp(a * t) - b**n * mpmath.exp(b * t)) / (a - b))

            guess = mpmath.pi / 2 if xi < 1 else 2 / z
            end = mpmath.findroot(lambda t, z=z, x=x: x(t, 0) + 2 * z * x(t, 1), guess)
            expected = float(-x(end, 1))
        assert restitution(xi, tension=False) == pytest.approx(expected, rel=1e-13)


def test_limits_of_restitution():
    for tension in (True, False):
        assert restitution(0.0, tension=tension) == 1.0
        assert damping_ratio(1.0, tension=tension) == 0.0
    assert restitution(1.0) == 0.0
    assert restitution(1 - 1e-12) == pytest.approx(0.0, abs=1e-300)
    # Critical damping without tension: continuous, e^-2.
    around = [restitution(xi, tension=False) for xi in (1 - 1e-6, 1.0, 1 + 1e-6)]
    assert around == pytest.approx([np.exp(-2)] * 3, rel=1e-5)
    grid = [restitution(xi, tension=False) for xi in np.linspace(0.0, 5.0, 101)]
    assert np.all(np.diff(grid) < 0.0)


@settings(deadline=None)
@given(st.floats(1e-3, 1.0), st.booleans())
def test_damping_ratio_is_the_inverse_of_restitution(epsilon, tension):
    xi = damping_ratio(epsilon, tension=tension)
    assert xi >= 0.0
    assert restitution(xi, tension=tension) == pytest.approx(epsilon, rel=1e-9)
    assert restitution(1.01 * xi + 0.01, tension=tension) < epsilon


def test_numbers_of_the_paper():
    # Equation 4 for ε = 0.687; a floor of 3014 t against a wall at 0.163 m/s (domain page, B8).
    assert damping_ratio(0.687) == pytest.approx(0.1187, abs=5e-5)
    law = kelvin_voigt(1e11, 0.12, 3014e3)
    assert law.epsilon == pytest.approx(0.68404, abs=5e-6)
    assert law.duration == pytest.approx(17.373e-3, abs=5e-7)
    assert law.onset_force_per_speed * 0.163 == pytest.approx(21.5e6, rel=2e-3)
    assert law.parameters[:2] == pytest.approx([1e11, 2 * 0.12 * np.sqrt(1e11 * 3014e3)])
    assert law.mass == 3014e3 and law.xi == 0.12


def test_effective_mass():
    assert effective_mass(3.0, 6.0) == pytest.approx(2.0)
    assert effective_mass(3.0, float("inf")) == 3.0
    assert effective_mass(5.0, 5.0) == pytest.approx(2.5)


def test_forces_by_hand():
    assert law_force(KELVIN_VOIGT, PARAMETERS, 1e-3, 0.1) == pytest.approx((1.4e6, K, C))
    assert law_force(KELVIN_VOIGT_NO_TENSION, PARAMETERS, 1e-3, 0.1) == pytest.approx((1.4e6, K, C))
    # Parting faster than the spring follows: one law pulls, the other lets go.
    assert law_force(KELVIN_VOIGT, PARAMETERS, 1e-3, -0.5)[0] == pytest.approx(-1e6)
    assert law_force(KELVIN_VOIGT_NO_TENSION, PARAMETERS, 1e-3, -0.5) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("code", [KELVIN_VOIGT, KELVIN_VOIGT_NO_TENSION])
def test_no_force_without_penetration(code):
    assert law_force(code, PARAMETERS, 0.0, 10.0) == (0.0, 0.0, 0.0)
    assert law_force(code, PARAMETERS, -1e-9, 10.0) == (0.0, 0.0, 0.0)
    assert law_force(code, PARAMETERS, 1e-300, 10.0)[0] == pytest.approx(4e7)


@settings(deadline=None)
@given(
    st.sampled_from([KELVIN_VOIGT, KELVIN_VOIGT_NO_TENSION]),
    st.floats(1e-5, 1e-2),
    st.floats(-1.0, 1.0),
)
def test_derivatives_against_finite_differences(code, p, v):
    if abs(K * p + C * v) < 2e-5 * (K * p + C * abs(v)):
        return  # at the kink of the law without tension
    _, k, c = law_force(code, PARAMETERS, p, v)
    h = 1e-6
    for slope, dp, dv in ((k, h * p, 0.0), (c, 0.0, h * (abs(v) + p))):
        up = law_force(code, PARAMETERS, p + dp, v + dv)[0]
        down = law_force(code, PARAMETERS, p - dp, v - dv)[0]
        assert (up - down) / (2 * (dp + dv)) == pytest.approx(slope, rel=1e-4, abs=1e-3)


def test_the_interpreted_law_is_the_compiled_one():
    for p, v in ((1e-3, 0.2), (1e-3, -0.9), (-1.0, 0.0)):
        for code in (KELVIN_VOIGT, KELVIN_VOIGT_NO_TENSION):
            assert law_force.py_func(code, PARAMETERS, p, v) == law_force(code, PARAMETERS, p, v)
