import math

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from impactfem.case import unit
from impactfem.case.unit import KINDS, UnitError, scale, si_factor, to_si


@pytest.mark.parametrize(
    ("text", "kind", "factor"),
    [
        ("cm", unit.LENGTH, 1e-2),
        ("t", unit.MASS, 1e3),
        ("g", unit.MASS, 1e-3),
        ("g", unit.ACCELERATION, 9.80665),
        ("GPa", unit.STRESS, 1e9),
        ("N/mm2", unit.STRESS, 1e6),
        ("kHz", unit.FREQUENCY, 1e3),
        ("ms", unit.TIME, 1e-3),
        ("µs", unit.TIME, 1e-6),
        ("min", unit.TIME, 60.0),
        ("1/s", unit.RATE, 1.0),
        ("s-1", unit.RATE, 1.0),
        ("s⁻¹", unit.RATE, 1.0),
        ("1/min", unit.RATE, 1.0 / 60.0),
        ("MN/m", unit.STIFFNESS, 1e6),
        ("kN s", unit.IMPULSE, 1e3),
        ("kN·s", unit.IMPULSE, 1e3),
        ("N.m", unit.ENERGY, 1.0),
        ("kN m/rad", unit.ROTATIONAL_STIFFNESS, 1e3),
        ("kN m/deg", unit.ROTATIONAL_STIFFNESS, 180e3 / math.pi),
        ("N mm2", unit.BENDING_STIFFNESS, 1e-6),
        ("MN", unit.SECTION_STIFFNESS, 1e6),
        ("g/cm3", unit.DENSITY, 1e3),
        ("t m2", unit.INERTIA, 1e3),
        ("mm4", unit.SECOND_MOMENT, 1e-12),
        ("1/t", unit.ACCELERANCE, 1e-3),
        ("m/s2/N", unit.ACCELERANCE, 1.0),
        ("kN/mm^1.5", unit.HERTZ_STIFFNESS, 1e3 * 1e3**1.5),
        ("MN/m^1.5", unit.HERTZ_STIFFNESS, 1e6),
    ],
)
def test_factor(text, kind, factor):
    assert si_factor(text, kind) == pytest.approx(factor, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "kind", "factor"),
    [
        *((text, unit.ACCELERATION, 0.01) for text in ("gal", "Gal", "GAL", "cm/s/s", "CM/SEC^2")),
        ("cm/s²", unit.ACCELERATION, 0.01),
        ("m·s⁻²", unit.ACCELERATION, 1.0),
        ("mg", unit.ACCELERATION, 9.80665e-3),
        ("%g", unit.ACCELERATION, 9.80665e-2),
        ("G", unit.ACCELERATION, 9.80665),
        *((text, unit.ROTATIONAL_STIFFNESS, 1e3) for text in ("kN-m/rad", "kNm/rad", "kN.m/rad")),
        ("kip-in/rad", unit.ROTATIONAL_STIFFNESS, 112.98482902761668),
        *((text, unit.ENERGY, 1.0) for text in ("Nm", "N-m", "N·m", "kN mm", "kN.mm", "kNmm")),
        ("psf", unit.STRESS, 47.88025898033584),
        ("ksf", unit.STRESS, 47880.25898033584),
        ("ksi", unit.STRESS, 6894757.293168361),
        ("kgf/cm2", unit.STRESS, 98066.5),
        ("kp/cm2", unit.STRESS, 98066.5),
        ("pcf", unit.DENSITY, 16.018463373960142),
        ("kcf", unit.DENSITY, 16018.463373960142),
        ("klf", unit.STIFFNESS, 14593.90293720636),
        ("kt", unit.MASS, 1e6),
        ("lb", unit.MASS, 0.45359237),
        ("lbm", unit.MASS, 0.45359237),
        ("kip-sec2/in", unit.MASS, 175126.83524647637),
        ("tf s2/m", unit.MASS, 9806.65),
        ("tm2", unit.INERTIA, 1e3),
        ("kg-m2", unit.INERTIA, 1.0),
        ("kNs", unit.IMPULSE, 1e3),
        ("N/m^(3/2)", unit.HERTZ_STIFFNESS, 1.0),
        ("1/(kN/mm)", unit.FLEXIBILITY, 1e-6),
        ("sqft", unit.AREA, 0.09290304),
        ("in.", unit.LENGTH, 0.0254),
        ("cps", unit.FREQUENCY, 1.0),
    ],
)
def test_spellings_of_engineers(text, kind, factor):
    assert si_factor(text, kind) == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "kind", "write"),
    [
        *((text, unit.FORCE, "write 'tf'") for text in ("tonf", "Tonf", "force_ton")),
        *((text, unit.MASS, "write 't'") for text in ("mt", "Mt", "MT", "T")),
        ("kt", unit.VELOCITY, "is a mass"),
        ("k", unit.FORCE, "write 'kip'"),
        ("k/in", unit.STIFFNESS, "write 'kip'"),
        ("K-ft", unit.ENERGY, "write 'kip'"),
        ("mN", unit.FORCE, "write 'MN'"),
        ("mPa", unit.STRESS, "write 'MPa'"),
        ("Mm", unit.LENGTH, "write 'mm'"),
        ("mils", unit.LENGTH, "write 'in'"),
        ("gr", unit.MASS, "write 'g'"),
        ("sq ft", unit.AREA, "write 'ft2'"),
        ("M", unit.LENGTH, "did you mean 'm'?"),
        ("S", unit.TIME, "did you mean 's'?"),
        ("Kgf", unit.FORCE, "did you mean 'kgf'?"),
        ("kg/cm2", unit.STRESS, "write 'kgf/cm2'"),
        ("t/m2", unit.STRESS, "write 'tf/m2'"),
        ("lb/in2", unit.STRESS, "write 'lbf/in2'"),
        ("lb", unit.FORCE, "write 'lbf'"),
        ("ft-lb", unit.ENERGY, "write 'ft-lbf'"),
        ("lb-s2/in", unit.MASS, "write 'lbf-s2/in'"),
        ("tf", unit.MASS, "write 't'"),
        ("kN", unit.MASS, "divide weights by 9.81 m/s2"),
        ("kN/m3", unit.DENSITY, "divide weights by 9.81 m/s2"),
        ("pcs", unit.LENGTH, "not a unit known here"),
        ("Nm/(s", unit.FORCE, "cannot be read as a unit"),
    ],
)
def test_the_unit_to_type(text, kind, write):
    with pytest.raises(UnitError) as caught:
        si_factor(text, kind)
    assert write in str(caught.value)


@pytest.mark.parametrize("text", ["kg m2", "kg*m2", "kg·m²", "kg m^2", "kg m**2", "kg . m2"])
def test_spellings_of_one_unit(text):
    assert si_factor(text, unit.INERTIA) == 1.0


@pytest.mark.parametrize("text", ["m/s2", "m/s^2", "m/s**2", "m/s²", "m s-2", "m / s2", "m/s/s"])
def test_spellings_of_one_quotient(text):
    assert si_factor(text, unit.ACCELERATION) == 1.0


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        ("GPa", unit.LENGTH, "'GPa' is a stress"),
        ("g", unit.LENGTH, "'g' is a mass"),
        ("rad/s", unit.FREQUENCY, "'rad/s' is not accepted as a unit of a frequency; write 'Hz'"),
        ("1/s", unit.FREQUENCY, "'1/s' is a rate"),
        ("Hz", unit.RATE, "'Hz' is a frequency"),
        ("N m", unit.ROTATIONAL_STIFFNESS, "'N m' is an energy"),
        ("N m/rad", unit.STIFFNESS, "'N m/rad' is a rotational stiffness"),
        ("rad", unit.LENGTH, "'rad' is a number without dimension"),
        ("kg m7", unit.LENGTH, "'kg m7' is a quantity of another dimension"),
        ("ton", unit.MASS, "write 't' (1000 kg) or 'short_ton'"),
        ("kton*m2", unit.INERTIA, "write 't' (1000 kg)"),
        ("ton_force", unit.FORCE, "write 'tf' (1000 kgf)"),
        ("parsnip", unit.LENGTH, "'parsnip' is not a unit known here"),
        ("Gpa", unit.STRESS, "'Gpa' is not a unit known here; did you mean 'GPa'?"),
        ("kn", unit.FORCE, "write 'kN'"),
        ("MS", unit.TIME, "; did you mean 'ms'?"),
        ("m//s", unit.VELOCITY, "'m//s' cannot be read as a unit"),
        ("m+s", unit.VELOCITY, "cannot be read as a unit"),
        ("", unit.LENGTH, "cannot be read as a unit"),
        ("2 m", unit.LENGTH, "cannot be read as a unit"),
        ("m*", unit.LENGTH, "cannot be read as a unit"),
        ("__import__('os')", unit.LENGTH, "cannot be read as a unit"),
        ("degC2", unit.LENGTH, "cannot be used as a unit here"),
        ("m9999", unit.LENGTH, "cannot be read as a unit"),
    ],
)
def test_refused(text, kind, message):
    with pytest.raises(UnitError) as caught:
        si_factor(text, kind)
    assert message in str(caught.value)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_kind_knows_its_own_unit_and_example(kind):
    number, text = kind.example.split(" ", 1)
    assert float(number) > 0
    assert si_factor(kind.unit, kind) == 1.0
    assert to_si(1.0, kind.unit) == (1.0, kind.unit)
    assert si_factor(text, kind) > 0
    assert kind.example in kind.phrase


def test_factors_agree_with_pint():
    registry = pint.UnitRegistry()
    for text in ("inch", "ft", "mile", "nmi", "yd", "um"):
        assert si_factor(text, unit.LENGTH) == pytest.approx(
            registry.Quantity(1.0, text).m_as("m"), rel=1e-15
        )


@pytest.mark.parametrize(
    ("value", "text", "expected"),
    [
        (121, "MN", (121e6, "N")),
        (1.2, "mm", (1.2e-3, "m")),
        (37, "m/s2", (37.0, "m/s2")),
        (9165, "t", (9165e3, "kg")),
        (829, "kN·s", (829e3, "N s")),
        (3, "kN m", (3e3, "J")),
        (30, "MN m/rad", (3e7, "N m/rad")),
        (66, "kN", (66e3, "N")),
        (36, "-", (36, "-")),
        (36, "", (36, "-")),
        (5, "%", (0.05, "-")),
    ],
)
def test_to_si_names_the_unit(value, text, expected):
    converted, name = to_si(value, text)
    assert name == expected[1]
    assert converted == pytest.approx(expected[0], rel=1e-15)


def test_to_si_refuses_what_it_cannot_name():
    with pytest.raises(UnitError, match="measures no kind"):
        to_si(1.0, "kg m7")


@given(st.integers(min_value=-(10**6), max_value=10**6), st.sampled_from(["cm", "mm", "um", "nm"]))
def test_decimal_submultiples_round_once(number, text):
    exponent = {"cm": -2, "mm": -3, "um": -6, "nm": -9}[text]
    nearest = float(f"{number}e{exponent}")
    assert scale(number, si_factor(text, unit.LENGTH)) == nearest


@given(st.floats(allow_nan=False, allow_infinity=False, width=32), st.floats(1e-12, 1e12))
def test_scale_is_a_product(value, factor):
    assert math.isclose(scale(value, factor), value * factor, rel_tol=1e-15)
