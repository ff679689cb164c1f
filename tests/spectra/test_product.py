from dataclasses import replace

import numpy as np
import pytest

from impactfem.spectra import FloorSpectrumSet, Station, broaden, rg_1_122_frequencies
from impactfem.spectra.design import clip_peaks
from impactfem.system.errors import ImpactfemError

F = rg_1_122_frequencies(100.0, 20)
STATIONS = (
    Station("A", "1", ("west corner",), 3.0),
    Station("A", "1", ("east corner",), 3.0),
    Station("A", "2", ("west corner",), 6.0),
    Station("B", "1", ("west corner",), 3.5),
)


def peak(frequency, height, zpa):
    """A narrow peak on a spectrum that ends at the zero-period acceleration."""
    return zpa + height / (1.0 + (12.0 * (F / frequency - 1.0)) ** 2)


@pytest.fixture
def spectra():
    rng = np.random.default_rng(0)
    psa = np.empty((3, 2, 4, 2, F.size))
    zpa = rng.uniform(1.0, 2.0, (3, 4, 2))
    for m, d, s, x in np.ndindex(*psa.shape[:-1]):
        psa[m, d, s, x] = peak(rng.uniform(3.0, 20.0), 10.0 / (1 + d), zpa[m, s, x])
    return FloorSpectrumSet(
        frequency=F,
        damping=np.array([0.02, 0.10]),
        stations=STATIONS,
        directions=("x", "y"),
        psa=psa,
        zpa=zpa,
        motions=("1", "2", "3"),
        title="three motions",
        method="made up",
    )


def test_design_is_the_broadened_envelope(spectra):
    design = spectra.design()
    raw = spectra.psa.max(axis=0)
    np.testing.assert_array_equal(design.raw, raw)
    np.testing.assert_array_equal(design.zpa, spectra.zpa.max(axis=0))
    np.testing.assert_array_equal(design.psa, broaden(F, raw, 0.15, design.frequency))
    assert design.frequency.size > F.size
    listed = np.isin(design.frequency, F)
    np.testing.assert_array_equal(design.computed[..., listed], raw)
    assert np.isnan(design.computed[..., ~listed]).all()


def test_other_statistics_and_ratios(spectra):
    envelope = spectra.design(0.15)
    assert np.all(spectra.design(0.15, statistic="mean").raw < envelope.raw)
    np.testing.assert_allclose(
        spectra.design(0.15, statistic=0.5).raw, np.median(spectra.psa, axis=0)
    )
    one_sided = spectra.design((0.1, 0.0))
    assert "-10 % and +0 %" in one_sided.broadening_text
    wide = spectra.design(0.1).broadening_text
    assert "±10 %" in wide
    plain = spectra.design(0.0)
    np.testing.assert_array_equal(plain.frequency, F)
    np.testing.assert_allclose(plain.psa, plain.raw, rtol=1e-13)
    assert plain.broadening_text == "peaks not broadened"


def test_clipping_below_ten_percent_damping_only(spectra):
    clipped, plain = spectra.design(clipping=True), spectra.design()
    assert clipped.clipped
    assert {index[0] for index in clipped.clipped} == {0}
    np.testing.assert_array_equal(clipped.psa[1].max(axis=-1), plain.psa[1].max(axis=-1))
    assert np.all(clipped.psa[0].max(axis=-1) <= plain.psa[0].max(axis=-1))
    d, s, x = next(iter(clipped.clipped))
    f, ordinates, peaks = clip_peaks(F, clipped.raw[d, s, x], float(clipped.zpa[s, x]))
    assert peaks == clipped.clipped[d, s, x]
    np.testing.assert_array_equal(
        clipped.psa[d, s, x], broaden(f, ordinates, 0.15, clipped.frequency)
    )
    # The computed spectrum stays what it is.
    np.testing.assert_array_equal(clipped.raw, plain.raw)
    assert plain.clipped == {}
    assert "15 %" in clipped.broadening_text


def test_words(spectra):
    assert spectra.design().motions_text == "3 motions, envelope"
    assert spectra.design(statistic=0.84).motions_text == "3 motions, 84 % fractile"
    one = replace(spectra, psa=spectra.psa[:1], zpa=spectra.zpa[:1], motions=("only",))
    assert one.design().motions_text == "1 motion (only)"


@pytest.mark.parametrize(
    "change",
    [
        {"motions": ("1",)},
        {"damping": np.array([0.05])},
        {"directions": ("x",)},
        {"stations": ()},
        {"zpa": np.ones((3, 4))},
    ],
)
def test_shapes_that_do_not_fit(spectra, change):
    with pytest.raises(ImpactfemError, match="need shape"):
        replace(spectra, **change)


def test_arguments_refused(spectra):
    with pytest.raises(ImpactfemError, match="at least 0"):
        spectra.design(1.5)
    with pytest.raises(ImpactfemError, match="probability"):
        spectra.design(statistic=84)
    with pytest.raises(ImpactfemError, match="ascending"):
        replace(spectra, frequency=F[::-1])
