"""Spectra of standards and tables; their ordinates by hand are rows of `verify` (motion)."""

from functools import partial

import numpy as np
import pytest

from impactfem.motion.design_spectrum import (
    DesignSpectrum,
    TableSpectrum,
    decree_spectrum,
    eurocode_spectrum,
)
from impactfem.system.errors import ImpactfemError

CORNERS = (0.05, 0.25, 2.5)
SPECTRUM = DesignSpectrum(2.3, CORNERS)
TABLE = TableSpectrum([1.0, 10.0, 100.0], [2.0, 8.0, 4.0], 0.02)


def test_ordinates_by_hand():
    period = np.array([0.025, 0.05, 0.1, 0.25, 0.5, 2.5, 5.0])
    # Halfway up 1 + 0.5 (2.5 - 1); at the end 5.75 · 0.25 · 2.5 / 25.
    expected = [2.3 * 1.75, 5.75, 5.75, 5.75, 2.875, 0.575, 0.14375]
    assert SPECTRUM.pseudo_acceleration(1 / period) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("damping", "eta"), [(0.05, 1.0), (0.02, np.sqrt(10 / 7)), (0.1, np.sqrt(10 / 15)), (0.6, 0.55)]
)
def test_damping_correction(damping, eta):
    spectrum = DesignSpectrum(2.3, CORNERS, damping=damping)
    assert spectrum.damping_correction == pytest.approx(eta)
    assert spectrum.pseudo_acceleration(5.0) == pytest.approx(5.75 * eta)
    assert spectrum.pseudo_acceleration(np.inf) == 2.3  # no correction at zero period


def test_vertical_is_the_same_on_all_grounds():
    spectra = [eurocode_spectrum(1, ground, 1.0, vertical=True) for ground in "ABCDE"]
    assert len(set(spectra)) == 1
    assert spectra[0].pseudo_acceleration([np.inf, 10.0]) == pytest.approx([0.9, 2.7])
    assert len({eurocode_spectrum(1, ground, 1.0) for ground in "ABCDE"}) == 5


def test_zones_and_texts_of_the_decrees():
    """Zone 5 is type 1 of the Eurocode; with special risk so is zone 4, and no other changes."""
    for ground in "ABCDE":
        assert decree_spectrum(5, ground) == eurocode_spectrum(1, ground, 3.0)
    for zone in (1, 2, 3, 5):
        assert decree_spectrum(zone, "C", text="special") == decree_spectrum(zone, "C")
    special = decree_spectrum(4, "C", text="special")
    assert special != decree_spectrum(4, "C")
    assert special.corner_periods == decree_spectrum(5, "C").corner_periods
    vertical = decree_spectrum(2, "D", vertical=True)
    assert vertical.ground_acceleration == pytest.approx(0.56)
    assert vertical == decree_spectrum(2, "A", vertical=True)
    assert decree_spectrum(5, "A", vertical=True).corner_periods == (0.15, 0.4, 2.0)


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
    f, between = np.geomspace(0.1, 100.0, 3000), np.geomspace(0.11, 99.0, 777)
    table = TableSpectrum(f, SPECTRUM.pseudo_acceleration(f))
    expected = SPECTRUM.pseudo_acceleration(between)
    assert table.pseudo_acceleration(between) == pytest.approx(expected, rel=1e-3)


SHAPE = partial(DesignSpectrum, 2.3)
DECREE = partial(decree_spectrum, 4, "B")
DAMPING, POINTS = "damping must be", "at least 2 points"
ASCEND, POSITIVE = "must be positive and ascend", "accelerations of a table spectrum must be posit"
FACTOR = "importance factor must be positive"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (partial(DesignSpectrum, 0.0, CORNERS), "ground acceleration must be positive"),
        (partial(SHAPE, (0.25, 0.05, 2.5)), "T_B <= T_C"),
        (partial(SHAPE, (0.0, 0.25, 2.5)), "T_B <= T_C"),
        (partial(SHAPE, CORNERS, 0.5), "amplification must be at least 1"),
        (partial(SHAPE, CORNERS, 2.5, 5.0), DAMPING),
        (partial(SPECTRUM.pseudo_acceleration, [1.0, 0.0]), "must be positive"),
        (partial(TABLE.pseudo_acceleration, [1.0, 0.0]), "must be positive"),
        (partial(TableSpectrum, [1.0], [1.0]), POINTS),
        (partial(TableSpectrum, [1.0, 2.0], [1.0]), POINTS),
        (partial(TableSpectrum, [2.0, 1.0], [1.0, 1.0]), ASCEND),
        (partial(TableSpectrum, [0.0, 1.0], [1.0, 1.0]), ASCEND),
        (partial(TableSpectrum, [1.0, np.inf], [1.0, 1.0]), ASCEND),
        (partial(TableSpectrum, [1.0, 2.0], [1.0, 0.0]), POSITIVE),
        (partial(TableSpectrum, [1.0, 2.0], [1.0, np.nan]), POSITIVE),
        (partial(TableSpectrum, [1.0, 2.0], [1.0, 1.0], 5.0), DAMPING),
        (partial(eurocode_spectrum, 3, "A", 1.0), "type of an EN 1998-1 spectrum is 1 or 2, got 3"),
        (
            partial(eurocode_spectrum, 1, "F", 1.0),
            "type of ground is one of A, B, C, D, E, got 'F'",
        ),
        (partial(eurocode_spectrum, 1, "A", 0.0), "reference acceleration must be positive"),
        (partial(eurocode_spectrum, 1, "A", np.nan), "reference acceleration must be positive"),
        (partial(eurocode_spectrum, 1, "A", 1.0, importance_factor=-1.0), FACTOR),
        (partial(decree_spectrum, 0, "B"), "zone of seismicity is 1 to 5, got 0"),
        (partial(decree_spectrum, 6, "B"), "zone of seismicity is 1 to 5, got 6"),
        (partial(decree_spectrum, 4, "b"), "type of ground is one of"),
        (partial(DECREE, text="nuclear"), "the text is 'ordinary' or 'special', got 'nuclear'"),
        (partial(DECREE, importance_factor=0.0), FACTOR),
    ],
)
def test_refused(make, message):
    with pytest.raises(ImpactfemError, match=message):
        make()
