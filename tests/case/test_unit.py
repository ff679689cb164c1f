import math

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from impactfem.case.unit import KINDS, UnitError, scale, si_factor, to_si


@pytest.mark.parametrize(
    ("text", "kind", "factor"),
    [
        ("cm", "m", 1e-2),
        ("t", "kg", 1e3),
        ("g", "kg", 1e-3),
        ("g", "m/s2", 9.80665),
        ("GPa", "Pa", 1e9),
        ("N/mm2", "Pa", 1e6),
        ("kHz", "Hz", 1e3),
        ("ms", "s", 1e-3),
        ("µs", "s", 1e-6),
        ("min", "s", 60.0),
        ("1/s", "1/s", 1.0),
        ("s-1", "1/s", 1.0),
        ("s⁻¹", "1/s", 1.0),
        ("1/min", "1/s", 1.0 / 60.0),
        ("MN/m", "N/m", 1e6),
        ("kN s", "N s", 1e3),
        ("kN·s", "N s", 1e3),
        ("N.m", "J", 1.0),
        ("kN m/rad", "N m/rad", 1e3),
        ("kN m/deg", "N m/rad", 180e3 / math.pi),
        ("N mm2", "N m2", 1e-6),
        ("MN", "N", 1e6),
        ("g/cm3", "kg/m3", 1e3),
        ("t m2", "kg m2", 1e3),
        ("mm4", "m4", 1e-12),
        ("1/t", "1/kg", 1e-3),
        ("m/s2/N", "1/kg", 1.0),
        ("kN/mm^1.5", "N/m^1.5", 1e3 * 1e3**1.5),
        ("MN/m^1.5", "N/m^1.5", 1e6),
    ],
)
def test_factor(text, kind, factor):
    assert si_factor(text, kind) == pytest.approx(factor, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "kind", "factor"),
    [
        *((text, "m/s2", 0.01) for text in ("gal", "Gal", "GAL", "cm/s/s", "CM/SEC^2")),
        ("cm/s²", "m/s2", 0.01),
        ("m·s⁻²", "m/s2", 1.0),
        ("mg", "m/s2", 9.80665e-3),
        ("%g", "m/s2", 9.80665e-2),
        ("G", "m/s2", 9.80665),
        *((text, "N m/rad", 1e3) for text in ("kN-m/rad", "kNm/rad", "kN.m/rad")),
        ("kip-in/rad", "N m/rad", 112.98482902761668),
        *((text, "J", 1.0) for text in ("Nm", "N-m", "N·m", "kN mm", "kN.mm", "kNmm")),
        ("psf", "Pa", 47.88025898033584),
        ("ksf", "Pa", 47880.25898033584),
        ("ksi", "Pa", 6894757.293168361),
        ("kgf/cm2", "Pa", 98066.5),
        ("kp/cm2", "Pa", 98066.5),
        ("pcf", "kg/m3", 16.018463373960142),
        ("kcf", "kg/m3", 16018.463373960142),
        ("klf", "N/m", 14593.90293720636),
        ("kt", "kg", 1e6),
        ("lb", "kg", 0.45359237),
        ("lbm", "kg", 0.45359237),
        ("kip-sec2/in", "kg", 175126.83524647637),
        ("tf s2/m", "kg", 9806.65),
        ("tm2", "kg m2", 1e3),
        ("kg-m2", "kg m2", 1.0),
        ("kNs", "N s", 1e3),
        ("N/m^(3/2)", "N/m^1.5", 1.0),
        ("1/(kN/mm)", "m/N", 1e-6),
        ("sqft", "m2", 0.09290304),
        ("in.", "m", 0.0254),
        ("cps", "Hz", 1.0),
    ],
)
def test_spellings_of_engineers(text, kind, factor):
    assert si_factor(text, kind) == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "kind", "write"),
    [
        *((text, "N", "write 'tf'") for text in ("tonf", "Tonf", "force_ton")),
        *((text, "kg", "write 't'") for text in ("mt", "Mt", "MT", "T")),
        ("kt", "m/s", "is a mass"),
        ("k", "N", "write 'kip'"),
        ("k/in", "N/m", "write 'kip'"),
        ("K-ft", "J", "write 'kip'"),
        ("mN", "N", "write 'MN'"),
        ("mPa", "Pa", "write 'MPa'"),
        ("Mm", "m", "write 'mm'"),
        ("mils", "m", "write 'in'"),
        ("gr", "kg", "write 'g'"),
        ("sq ft", "m2", "write 'ft2'"),
        ("M", "m", "did you mean 'm'?"),
        ("S", "s", "did you mean 's'?"),
        ("Kgf", "N", "did you mean 'kgf'?"),
        ("kg/cm2", "Pa", "write 'kgf/cm2'"),
        ("t/m2", "Pa", "write 'tf/m2'"),
        ("lb/in2", "Pa", "write 'lbf/in2'"),
        ("lb", "N", "write 'lbf'"),
        ("ft-lb", "J", "write 'ft-lbf'"),
        ("lb-s2/in", "kg", "write 'lbf-s2/in'"),
        ("tf", "kg", "write 't'"),
        ("kN", "kg", "divide weights by 9.81 m/s2"),
        ("kN/m3", "kg/m3", "divide weights by 9.81 m/s2"),
        ("pcs", "m", "not a unit known here"),
        ("Nm/(s", "N", "cannot be read as a unit"),
    ],
)
def test_the_unit_to_type(text, kind, write):
    with pytest.raises(UnitError) as caught:
        si_factor(text, kind)
    assert write in str(caught.value)


@pytest.mark.parametrize("text", ["kg m2", "kg*m2", "kg·m²", "kg m^2", "kg m**2", "kg . m2"])
def test_spellings_of_one_unit(text):
    assert si_factor(text, "kg m2") == 1.0


@pytest.mark.parametrize("text", ["m/s2", "m/s^2", "m/s**2", "m/s²", "m s-2", "m / s2", "m/s/s"])
def test_spellings_of_one_quotient(text):
    assert si_factor(text, "m/s2") == 1.0


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        ("GPa", "m", "'GPa' is a stress"),
        ("g", "m", "'g' is a mass"),
        ("rad/s", "Hz", "'rad/s' is not accepted as a unit of a frequency; write 'Hz'"),
        ("1/s", "Hz", "'1/s' is a rate"),
        ("Hz", "1/s", "'Hz' is a frequency"),
        ("N m", "N m/rad", "'N m' is an energy"),
        ("N m/rad", "N/m", "'N m/rad' is a rotational stiffness"),
        ("rad", "m", "'rad' is an angle"),
        ("kg m7", "m", "'kg m7' is a quantity of another dimension"),
        ("ton", "kg", "write 't' (1000 kg) or 'short_ton'"),
        ("kton*m2", "kg m2", "write 't' (1000 kg)"),
        ("ton_force", "N", "write 'tf' (1000 kgf)"),
        ("parsnip", "m", "'parsnip' is not a unit known here"),
        ("Gpa", "Pa", "'Gpa' is not a unit known here; did you mean 'GPa'?"),
        ("kn", "N", "write 'kN'"),
        ("MS", "s", "; did you mean 'ms'?"),
        ("m//s", "m/s", "'m//s' cannot be read as a unit"),
        ("m+s", "m/s", "cannot be read as a unit"),
        ("", "m", "cannot be read as a unit"),
        ("2 m", "m", "cannot be read as a unit"),
        ("m*", "m", "cannot be read as a unit"),
        ("__import__('os')", "m", "cannot be read as a unit"),
        ("degC2", "m", "cannot be used as a unit here"),
        ("m9999", "m", "cannot be read as a unit"),
    ],
)
def test_refused(text, kind, message):
    with pytest.raises(UnitError) as caught:
        si_factor(text, kind)
    assert message in str(caught.value)


@pytest.mark.parametrize("unit", KINDS)
def test_kind_knows_its_own_unit_and_example(unit):
    number, text = KINDS[unit].example.split(" ", 1)
    assert float(number) > 0
    assert si_factor(unit, unit) == 1.0
    assert to_si(1.0, unit) == (1.0, unit)
    assert si_factor(text, unit) > 0


def test_factors_agree_with_pint():
    registry = pint.UnitRegistry()
    for text in ("inch", "ft", "mile", "nmi", "yd", "um"):
        assert si_factor(text, "m") == pytest.approx(
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
    assert scale(number, si_factor(text, "m")) == nearest


@given(st.floats(allow_nan=False, allow_infinity=False, width=32), st.floats(1e-12, 1e12))
def test_scale_is_a_product(value, factor):
    assert math.isclose(scale(value, factor), value * factor, rel_tol=1e-15)
