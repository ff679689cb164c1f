import numpy as np
import pytest
import scipy.integrate
import scipy.special
from hypothesis import given, settings
from hypothesis import strategies as st

from impactfem.coupling import restitution as relations
from impactfem.coupling.impacts import impacts
from impactfem.coupling.laws import (
    LAWS,
    Hertz,
    HertzDamp,
    HuntCrossley,
    Jankowski,
    KelvinVoigt,
    effective_mass,
)
from impactfem.verify.contact import collision

K, C = 1e9, 4e6
XI = C / (2.0 * np.sqrt(K * 1e6))
SOME = {
    "kelvin-voigt": KelvinVoigt(K, XI, mass=1e6),
    "without tension": KelvinVoigt(K, XI, tension=False, mass=1e6),
    "hunt-crossley": HuntCrossley(2e10, 1.0 - 0.8 / 1.5, mass=1e6),  # χ = 0.8
    "jankowski": Jankowski(2e10, 0.6, mass=1e6),
}
M1, M2, BETA = 1574e3, 3014e3, 1.4e12
MASS = effective_mass(M1, M2)
DAMPED = (HertzDamp, HuntCrossley, Jankowski)


def two_masses(law, m1, m2, speed, *, tension):
    """Speeds and time at the end of an impact, by adaptive integration and event detection."""
    k, c = law.stiffness, law.dashpot

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


def computed(law, speed=0.3, steps=300.3):
    """The one impact of two free masses by the program's own time loop."""
    dt = law.duration(speed) / steps
    (impact,) = impacts(collision(law, M1, M2, speed, dt, phase=0.4))
    return impact


ASKED = {True: (0.0, 0.05, 0.12, 0.6), False: (0.0, 0.05, 0.12, 0.6, 1.0, 1.7)}


@pytest.mark.parametrize(
    ("xi", "tension"), [(xi, tension) for tension, values in ASKED.items() for xi in values]
)
def test_kelvin_voigt_of_two_masses(xi, tension):
    m1, m2, speed = 3.0, 5.0, 0.4
    law = KelvinVoigt(200.0, xi, mass=effective_mass(m1, m2), tension=tension)
    y, time = two_masses(law, m1, m2, speed, tension=tension)
    assert (y[3] - y[2]) / speed == pytest.approx(law.epsilon, rel=1e-7)
    assert law.epsilon == law.target_restitution == relations.kelvin_voigt(xi, tension=tension)
    assert time == pytest.approx(law.duration(speed), rel=1e-7)
    assert law.duration(speed) == law.duration(0.01)
    if xi > 0.0:  # the two laws differ, and not by little
        other = KelvinVoigt(200.0, xi, mass=law.mass, tension=not tension)
        assert abs(other.epsilon - law.epsilon) > 1e-3
        assert abs(other.duration(speed) - law.duration(speed)) > 1e-2 * law.duration(speed)


def test_numbers_of_the_paper():
    # A floor of 3014 t against a wall at 0.163 m/s (domain page, B8).
    law = KelvinVoigt(1e11, 0.12, mass=3014e3)
    assert law.epsilon == pytest.approx(0.68404, abs=5e-6)
    assert law.duration(0.163) == pytest.approx(17.373e-3, abs=5e-7)
    assert KelvinVoigt(K, 1.0, mass=1e3).duration(1.0) == np.inf
    assert law.onset_force(0.163) == pytest.approx(21.5e6, rel=2e-3)
    assert law.parameters[:2] == pytest.approx([1e11, 2 * 0.12 * np.sqrt(1e11 * 3014e3)])
    assert (law.mass, law.xi, law.stiffness) == (3014e3, 0.12, 1e11)
    assert effective_mass(3.0, 6.0) == pytest.approx(2.0)
    assert effective_mass(3.0, float("inf")) == 3.0


@pytest.mark.parametrize(
    ("make", "published"), [(HertzDamp, 0.7016), (HuntCrossley, 0.6197), (Jankowski, 0.3930)]
)
def test_published_relation_does_not_at_small_restitution(make, published):
    law = make(BETA, 0.4, mass=MASS)
    assert law.target_restitution == 0.4 and law.epsilon == pytest.approx(published, abs=1e-4)
    found = computed(law).restitution
    assert found == pytest.approx(law.epsilon, abs=5e-4)
    assert abs(found - 0.4) > 5e-3
    # Near 1 it does.
    assert make(BETA, 0.95, mass=MASS).epsilon == pytest.approx(0.95, abs=4e-3)


def test_published_relations_by_hand():
    assert HertzDamp(BETA, 0.6, mass=MASS).parameters[1] == pytest.approx(0.48)
    assert HuntCrossley(BETA, 0.6, mass=MASS).parameters[1] == pytest.approx(0.6)
    law = Jankowski(BETA, 0.6, mass=MASS)
    # 4.5 √5 · 0.75 / (0.5 (0.5 (9π - 16) + 16)) at ε = 0.5.
    by_hand = 7.546731 / (0.5 * (0.5 * 12.274334 + 16.0))
    assert Jankowski(BETA, 0.5, mass=MASS).xi == pytest.approx(by_hand, rel=1e-6)
    assert law.parameters[1] == pytest.approx(2.0 * law.xi * np.sqrt(BETA * MASS))
    one, other = (make(BETA, 0.6, "exact", mass=MASS) for make in (HertzDamp, HuntCrossley))
    assert one.parameters == other.parameters


@pytest.mark.parametrize("make", [HertzDamp, HuntCrossley])
def test_slowest_approach(make):
    # Below it the damping counts with it: χ v₀ / slowest is left of χ.
    law = make(BETA, 0.5, "exact", 0.2, mass=MASS)
    assert computed(law, 0.2).restitution == pytest.approx(0.5, abs=1e-3)
    left = relations.damped_hertz(0.25 * law.parameters[1])
    assert computed(law, 0.05).restitution == pytest.approx(left, abs=1e-3)
    assert left > 0.7
    # A contact that begins at rest has a bounded force.
    assert law.at(1e-3, 0.1, (0.0,))[0] == pytest.approx(
        BETA * 1e-3**1.5 * (1.0 + law.parameters[1] / 2.0)
    )


@pytest.mark.parametrize("speed", [0.05, 0.3, 2.0])
def test_elastic_hertz_in_closed_form(speed):
    law = Hertz(BETA, mass=MASS)
    depth = (1.25 * MASS * speed**2 / BETA) ** 0.4
    # 2 p_max / v₀ ∫ dx / √(1 - x^2.5) from 0 to 1, with the gamma function and by quadrature.
    gamma = scipy.special.gamma
    number = 2.0 * np.sqrt(np.pi) * gamma(1.4) / gamma(0.9)
    integral, _ = scipy.integrate.quad(lambda s: 4.0 * s / np.sqrt(1 - (1 - s * s) ** 2.5), 0, 1)
    assert number == pytest.approx(integral, rel=1e-8)
    assert law.duration(speed) == pytest.approx(number * depth / speed, rel=5e-5)
    impact = computed(law, speed)
    assert impact.duration == pytest.approx(law.duration(speed), rel=1e-3)
    assert impact.penetration == pytest.approx(depth, rel=1e-4)
    assert impact.peak_force == pytest.approx(BETA * depth**1.5, rel=1e-4)
    assert impact.restitution == pytest.approx(1.0, rel=1e-5)
    assert law.duration(32.0 * speed) == pytest.approx(0.5 * law.duration(speed))


@pytest.mark.parametrize("epsilon", [0.3, 0.6, 0.9])
@pytest.mark.parametrize("make", DAMPED)
def test_damped_hertz_lasts_about_as_long_as_the_elastic_one(make, epsilon):
    elastic = Hertz(BETA, mass=MASS)
    law = make(BETA, epsilon, "exact", mass=MASS)
    assert law.duration(0.3) == elastic.duration(0.3)
    ratio = computed(law).duration / elastic.duration(0.3)
    assert ratio > (0.98 if make is Jankowski else 1.0)
    assert ratio < 1.0 + (1.0 - epsilon) / epsilon


def test_onset_force():
    # A dashpot beside a spring jumps to C v₀; the laws of Hertz begin from nothing.
    linear = [KelvinVoigt(K, 0.2, mass=1e3, tension=tension) for tension in (True, False)]
    for law in linear:
        jump = 2.0 * 0.2 * np.sqrt(K * 1e3) * 0.7
        assert law.onset_force(0.7) == pytest.approx(jump) == 2.0 * law.onset_force(0.35)
    for law in (Hertz(BETA, mass=MASS), *(make(BETA, 0.3, mass=MASS) for make in DAMPED)):
        assert 0.0 <= law.onset_force(0.7) < 1e-30


def test_what_a_law_says_of_itself():
    soft = KelvinVoigt(1e11, 0.12, mass=3014e3)
    assert soft.dashpot == soft.parameters[1] and soft.name == "kelvin-voigt"
    assert soft.describe() == (
        "kelvin-voigt: stiffness 1e+11 N/m, restitution requested 0.684043, of two free masses "
        "0.684043, effective mass 3014000 kg"
    )
    assert KelvinVoigt(1e11, 0.12, mass=1.0, tension=False).name == "kelvin-voigt without tension"
    assert Hertz(BETA, mass=MASS).duration(0.0) == Hertz(BETA, mass=MASS).duration(-1e-9) == np.inf
    names = ["hertz-damp", "hunt-crossley", "jankowski"]
    for make, name in zip(DAMPED, names, strict=True):
        law = make(BETA, 0.4, mass=MASS)
        assert law.name == name and np.isnan(law.dashpot) and law.stiffness == BETA
        words = law.describe()
        assert words.startswith(
            f"{name}: stiffness 1.4e+12 N/m^1.5, restitution requested 0.4, of two"
        )
        assert f"{law.epsilon:.6g}" in words and "0.4, effective" not in words
        assert np.isnan(law.xi) == (make is not Jankowski)
    elastic = Hertz(BETA, mass=MASS)
    assert elastic.target_restitution == elastic.epsilon == 1.0


def test_forces_by_hand():
    def at(name, p, v, v0=1.0):
        return SOME[name].at(p, v, (v0,))

    assert at("kelvin-voigt", 1e-3, 0.1) == pytest.approx((1.4e6, K, C))
    assert at("without tension", 1e-3, 0.1) == pytest.approx((1.4e6, K, C))
    # Parting faster than the spring follows: one law pulls, the other lets go.
    assert at("kelvin-voigt", 1e-3, -0.5)[0] == pytest.approx(-1e6)
    assert at("without tension", 1e-3, -0.5) == (0.0, 0.0, 0.0)
    # 2e10 · 1e-3 (1 + 0.8 v / v₀) at p = 1 cm.
    assert at("hunt-crossley", 1e-2, 0.1, 0.4)[0] == pytest.approx(2e7 * 1.2)
    assert at("hunt-crossley", 1e-2, -0.1, 0.4)[0] == pytest.approx(2e7 * 0.8)
    assert at("hunt-crossley", 1e-2, -0.6, 0.4) == (0.0, 0.0, 0.0)
    # 2e10 · 1e-6 + c · 0.1 v at p = 0.1 mm, without the second part where they part.
    c = SOME["jankowski"].parameters[1]
    assert at("jankowski", 1e-4, 0.02)[0] == pytest.approx(2e4 + 2e-3 * c)
    assert at("jankowski", 1e-4, -0.02)[0] == pytest.approx(2e4)


@pytest.mark.parametrize("name", SOME)
def test_no_force_without_penetration(name):
    law = SOME[name]
    assert law.at(0.0, 10.0, (10.0,)) == (0.0, 0.0, 0.0)
    assert law.at(-1e-9, 10.0, (10.0,)) == (0.0, 0.0, 0.0)
    assert law.at(1e-9, 10.0, (10.0,))[0] > 0.0
    jump = 4e7 if law.jumps else 0.0
    assert law.at(1e-300, 10.0, (10.0,))[0] == pytest.approx(jump, rel=1e-12, abs=1e-30)


@settings(deadline=None, max_examples=200)
@given(
    st.sampled_from(list(SOME)),
    st.floats(1e-5, 1e-2),
    st.floats(-1.0, 1.0),
    st.floats(0.01, 1.0),
)
def test_derivatives_against_finite_differences(name, p, v, v0):
    law = SOME[name]
    F, k, c = law.at(p, v, (v0,))
    h = 1e-6
    steps = ((k, h * p, 0.0), (c, 0.0, h * (abs(v) + p)))
    for slope, dp, dv in steps:
        up = law.at(p + dp, v + dv, (v0,))[0]
        down = law.at(p - dp, v - dv, (v0,))[0]
        before, after = (F - down) / (dp + dv), (up - F) / (dp + dv)
        rounding = 1e-9 * max(abs(F), abs(up)) / (dp + dv)
        if abs(after - before) > 1e-4 * (abs(after) + abs(before)) + rounding:
            continue  # a kink between: where the force ends, or approach turns into parting
        assert (before + after) / 2 == pytest.approx(slope, rel=1e-4, abs=rounding + 1e-3)


def test_the_interpreted_law_is_the_compiled_one():
    for p, v in ((1e-3, 0.2), (1e-3, -0.9)):
        for law in SOME.values():
            found = type(law).force(np.array(law.parameters), p, v, np.array([0.4]))
            assert found == pytest.approx(law.at(p, v, (0.4,)))


@pytest.mark.parametrize("law", [*SOME.values(), Hertz(BETA, mass=MASS)], ids=lambda law: law.name)
def test_every_law_passes_the_check_of_laws(law):
    law.check()
    assert law.restitution_at(0.3) == pytest.approx(law.epsilon, rel=1e-6)
    assert LAWS[law.type] is type(law)


@pytest.mark.parametrize("law", SOME.values(), ids=lambda law: law.name)
def test_a_part_of_the_area_has_a_part_of_the_force(law):
    part = law.part(0.25)
    assert part.at(1e-3, 0.1, (0.3,)) == pytest.approx(
        [0.25 * x for x in law.at(1e-3, 0.1, (0.3,))]
    )
    assert part.epsilon == pytest.approx(law.epsilon, rel=1e-12)
    assert part.duration(0.3) == pytest.approx(law.duration(0.3), rel=1e-12)
