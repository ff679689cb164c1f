import numpy as np
import pytest

from impactfem.motion import DesignSpectrum, TableSpectrum
from impactfem.system.errors import ImpactfemError

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
def test_refused(f, a, damping, message):
    with pytest.raises(ImpactfemError, match=message):
        TableSpectrum(f, a, damping)


def test_frequencies_must_be_positive():
    with pytest.raises(ImpactfemError, match="must be positive"):
        TABLE.pseudo_acceleration([1.0, 0.0])
