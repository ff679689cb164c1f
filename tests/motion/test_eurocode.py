import numpy as np
import pytest

from impactfem.motion import decree_spectrum, eurocode_spectrum
from impactfem.motion.eurocode import HORIZONTAL
from impactfem.system.errors import ImpactfemError


def test_level_and_shape():
    spectrum = eurocode_spectrum(1, "B", 2.0, importance_factor=1.4)
    assert spectrum.ground_acceleration == pytest.approx(2.0 * 1.4 * 1.2)
    assert spectrum.corner_periods == (0.15, 0.5, 2.0)
    assert spectrum.pseudo_acceleration(4.0) == pytest.approx(2.5 * 3.36)


def test_damping_correction():
    plateau = eurocode_spectrum(2, "A", 1.0, damping=0.02).pseudo_acceleration(10.0)
    assert plateau == pytest.approx(2.5 * np.sqrt(10.0 / 7.0))
    least = eurocode_spectrum(2, "A", 1.0, damping=0.5).pseudo_acceleration(10.0)
    assert least == pytest.approx(2.5 * 0.55)


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
def test_refused(arguments, message):
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
