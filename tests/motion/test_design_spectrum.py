import numpy as np
import pytest

from impactfem.motion import DesignSpectrum, TableSpectrum, decree_spectrum, eurocode_spectrum
from impactfem.motion.design_spectrum import HORIZONTAL
from impactfem.system.errors import ImpactfemError

SPECTRUM = DesignSpectrum(2.3, (0.05, 0.25, 2.5))


@pytest.mark.parametrize(
    ("period", "ordinate"),
    [
        (0.025, 2.3 * 1.75),  # halfway up: 1 + 0.5 (2.5 - 1)
        (0.05, 5.75),
        (0.1, 5.75),
        (0.25, 5.75),
        (0.5, 2.875),
        (2.5, 0.575),
        (5.0, 0.14375),  # 5.75 · 0.25 · 2.5 / 25
    ],
)
def test_ordinates_by_hand(period, ordinate):
    assert SPECTRUM.pseudo_acceleration(1 / period) == pytest.approx(ordinate, rel=1e-12)


def test_zero_period():
    assert SPECTRUM.pseudo_acceleration(np.inf) == 2.3


@pytest.mark.parametrize(
    ("damping", "eta"), [(0.05, 1.0), (0.02, np.sqrt(10 / 7)), (0.1, np.sqrt(10 / 15)), (0.6, 0.55)]
)
def test_damping_correction(damping, eta):
    spectrum = DesignSpectrum(2.3, (0.05, 0.25, 2.5), damping=damping)
    assert spectrum.damping_correction == pytest.approx(eta)
    assert spectrum.pseudo_acceleration(5.0) == pytest.approx(5.75 * eta)
    assert spectrum.pseudo_acceleration(np.inf) == 2.3  # no correction at zero period


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, (0.05, 0.25, 2.5)), "ground acceleration must be positive"),
        ((2.3, (0.25, 0.05, 2.5)), "T_B <= T_C"),
        ((2.3, (0.0, 0.25, 2.5)), "T_B <= T_C"),
        ((2.3, (0.05, 0.25, 2.5), 0.5), "amplification must be at least 1"),
        ((2.3, (0.05, 0.25, 2.5), 2.5, 5.0), "damping must be"),
    ],
)
def test_bad_spectra_are_refused(arguments, message):
    with pytest.raises(ImpactfemError, match=message):
        DesignSpectrum(*arguments)


def test_frequency_zero_is_refused():
    with pytest.raises(ImpactfemError, match="must be positive"):
        SPECTRUM.pseudo_acceleration([1.0, 0.0])


def test_eurocode_level_and_shape():
    spectrum = eurocode_spectrum(1, "B", 2.0, importance_factor=1.4)
    assert spectrum.ground_acceleration == pytest.approx(2.0 * 1.4 * 1.2)
    assert spectrum.corner_periods == (0.15, 0.5, 2.0)
    assert spectrum.pseudo_acceleration(4.0) == pytest.approx(2.5 * 3.36)


def test_vertical_is_the_same_on_all_grounds():
    spectra = [eurocode_spectrum(1, ground, 1.0, vertical=True) for ground in "ABCDE"]
    assert len(set(spectra)) == 1
    assert spectra[0].pseudo_acceleration([np.inf, 10.0]) == pytest.approx([0.9, 2.7])
    assert len({eurocode_spectrum(1, ground, 1.0) for ground in "ABCDE"}) == 5


@pytest.mark.parametrize("kind", [1, 2])
def test_softer_ground_never_lowers_the_long_periods(kind):
    # Grounds A, B, C, D: at 1 s the ordinates ascend, in both types.
    ordinates = [
        float(eurocode_spectrum(kind, ground, 1.0).pseudo_acceleration(1.0)) for ground in "ABCD"
    ]
    assert ordinates == sorted(ordinates)
    assert set(HORIZONTAL[kind]) == set("ABCDE")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((3, "A", 1.0), "type of an EN 1998-1 spectrum is 1 or 2, got 3"),
        ((1, "F", 1.0), "type of ground is one of A, B, C, D, E, got 'F'"),
        ((1, "A", 0.0), "reference acceleration must be positive"),
        ((1, "A", float("nan")), "reference acceleration must be positive"),
    ],
)
def test_eurocode_refused(arguments, message):
    with pytest.raises(ImpactfemError, match=message):
        eurocode_spectrum(*arguments)
    with pytest.raises(ImpactfemError, match="importance factor must be positive"):
        eurocode_spectrum(1, "A", 1.0, importance_factor=-1.0)


def test_decree_zone_5_is_type_1_of_the_eurocode():
    for ground in "ABCDE":
        assert decree_spectrum(5, ground) == eurocode_spectrum(1, ground, 3.0)


def test_decree_special_risk_differs_from_ordinary_in_zone_4_only():
    for zone in (1, 2, 3, 5):
        assert decree_spectrum(zone, "C", text="special") == decree_spectrum(zone, "C")
    special = decree_spectrum(4, "C", text="special")
    assert special != decree_spectrum(4, "C")
    assert special.corner_periods == decree_spectrum(5, "C").corner_periods


def test_decree_of_the_paper_s_site():
    # Zone 4, γ_I 1.2, ground B of the special-risk text: 2.304 m/s2, near the paper's 2.32 m/s2.
    assert decree_spectrum(4, "B", importance_factor=1.2, text="special").ground_acceleration == (
        pytest.approx(2.304)
    )


def test_decree_vertical():
    assert decree_spectrum(2, "D", vertical=True).ground_acceleration == pytest.approx(0.56)
    assert decree_spectrum(2, "D", vertical=True) == decree_spectrum(2, "A", vertical=True)
    assert decree_spectrum(5, "A", vertical=True).corner_periods == (0.15, 0.4, 2.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"zone": 0}, "zone of seismicity is 1 to 5, got 0"),
        ({"zone": 6}, "zone of seismicity is 1 to 5, got 6"),
        ({"ground": "b"}, "type of ground is one of"),
        ({"text": "nuclear"}, "the text is 'ordinary' or 'special', got 'nuclear'"),
        ({"importance_factor": 0.0}, "importance factor must be positive"),
    ],
)
def test_decree_refused(arguments, message):
    with pytest.raises(ImpactfemError, match=message):
        decree_spectrum(**{"zone": 4, "ground": "B"} | arguments)


TABLE = TableSpectrum([1.0, 10.0, 100.0], [2.0, 8.0, 4.0], 0.02)


def test_straight_on_logarithmic_axes():
    assert TABLE.pseudo_acceleration([1.0, 10.0, 100.0]) == pytest.approx([2.0, 8.0, 4.0])
    assert TABLE.pseudo_acceleration(np.sqrt(10.0)) == pytest.approx(4.0)  # geometric mean
    assert TABLE.pseudo_acceleration(5.5) != pytest.approx(5.0, rel=0.05)  # not linear
    assert TABLE.range == (1.0, 100.0)


def test_outside_it_keeps_acceleration_above_and_displacement_below():
    assert TABLE.pseudo_acceleration([200.0, np.inf]) == pytest.approx([4.0, 4.0])
    f = np.array([0.1, 0.5, 1.0])
    assert TABLE.pseudo_acceleration(f) / f**2 == pytest.approx(2.0)


def test_a_dense_table_is_the_spectrum_it_was_made_from():
    design = DesignSpectrum(2.3, (0.05, 0.25, 2.5))
    f = np.geomspace(0.1, 100.0, 3000)
    table = TableSpectrum(f, design.pseudo_acceleration(f))
    between = np.geomspace(0.11, 99.0, 777)
    expected = design.pseudo_acceleration(between)
    assert table.pseudo_acceleration(between) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    ("f", "a", "damping", "message"),
    [
        ([1.0], [1.0], 0.05, "at least 2 points"),
        ([1.0, 2.0], [1.0], 0.05, "at least 2 points"),
        ([2.0, 1.0], [1.0, 1.0], 0.05, "must be positive and ascend"),
        ([0.0, 1.0], [1.0, 1.0], 0.05, "must be positive and ascend"),
        ([1.0, np.inf], [1.0, 1.0], 0.05, "must be positive and ascend"),
        ([1.0, 2.0], [1.0, 0.0], 0.05, "accelerations of a table spectrum must be positive"),
        ([1.0, 2.0], [1.0, np.nan], 0.05, "accelerations of a table spectrum must be positive"),
        ([1.0, 2.0], [1.0, 1.0], 5.0, "damping must be"),
    ],
)
def test_bad_tables_are_refused(f, a, damping, message):
    with pytest.raises(ImpactfemError, match=message):
        TableSpectrum(f, a, damping)


def test_frequencies_of_a_table_must_be_positive():
    with pytest.raises(ImpactfemError, match="must be positive"):
        TABLE.pseudo_acceleration([1.0, 0.0])
