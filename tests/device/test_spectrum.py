from dataclasses import replace

import numpy as np
import pytest

from impactfem.device.spectrum import AnchorSpectrum
from impactfem.spectra import response_spectra
from impactfem.system.errors import ImpactfemError

SPECTRUM = AnchorSpectrum(
    "y",
    np.array([1.0, 10.0, 100.0]),
    np.array([0.02, 0.05]),
    np.array([[1.0, 16.0, 4.0], [1.0, 4.0, 4.0]]),
    4.0,
)


def test_between_frequencies_and_dampings():
    found, notes = SPECTRUM.at(np.array([np.sqrt(10.0), 10.0]), np.array([0.02, 0.035]))
    # Half-way on logarithmic axes, and half-way in the damping of the logarithm.
    assert found == pytest.approx([4.0, 8.0])
    assert notes == ()
    assert SPECTRUM.at(np.zeros(0), np.zeros(0))[0].size == 0
    with pytest.raises(ImpactfemError, match=r"along y at anchor 1: .* 0\.02 to 0\.05; 0\.1 was"):
        SPECTRUM.at(np.array([10.0]), np.array([0.1]))
    assert SPECTRUM.rigid_from(0.05) == 10.0
    with pytest.raises(ImpactfemError, match="before it comes down"):
        replace(SPECTRUM, zpa=2.0).rigid_from(0.05)
    assert SPECTRUM.curve(0.05) == pytest.approx([1.0, 4.0, 4.0])


def test_above_a_spectrum_that_has_come_down():
    found, notes = SPECTRUM.at(np.array([10.0, 400.0]), np.array([0.02, 0.02]))
    assert found == pytest.approx([16.0, 4.0])
    assert len(notes) == 1 and "ends at 100 Hz" in notes[0] and "400 Hz" in notes[0]
    # The larger of the two is taken within the tolerance.
    above = replace(SPECTRUM, zpa=3.9)
    assert above.at(np.array([400.0]), np.array([0.02]))[0] == pytest.approx([4.0])


def test_a_spectrum_that_does_not_reach_a_mode_is_refused():
    open_ended = replace(SPECTRUM, zpa=2.0)
    with pytest.raises(
        ImpactfemError, match=r"along y at anchor 1 ends at 100 Hz .* mode at 400 Hz"
    ):
        open_ended.at(np.array([400.0]), np.array([0.02]))
    with pytest.raises(ImpactfemError, match=r"begins at 1 Hz and does not reach .* at 0\.5 Hz"):
        SPECTRUM.at(np.array([0.5, 10.0]), np.array([0.02, 0.02]))
    assert open_ended.at(np.array([100.0]), np.array([0.02]))[0] == pytest.approx([4.0])


def test_of_a_motion():
    a = np.random.default_rng(3).standard_normal(500)
    a[0] = 0.0
    found = AnchorSpectrum.of_motion("rx", a, 0.005, [20.0, 5.0], [0.05, 0.02], anchor=2)
    wanted = response_spectra(a, 0.005, [5.0, 20.0], [0.02, 0.05])
    assert found.psa == pytest.approx(wanted.psa[:, 0])
    assert found.zpa == pytest.approx(wanted.zpa_interpolated[0])
    assert (found.component, found.anchor) == ("rx", 2)
    straight = AnchorSpectrum.of_motion("rx", a, 0.005, [5.0, 20.0], [0.02], method="in-step")
    assert straight.zpa == pytest.approx(np.abs(a).max())


def test_envelope_and_broadening():
    other = replace(
        SPECTRUM,
        frequency=np.array([1.0, 20.0, 100.0]),
        psa=np.array([[1.0, 9.0, 5.0], [1.0, 3.0, 5.0]]),
        zpa=5.0,
        displacement=0.01,
    )
    both = AnchorSpectrum.envelope([SPECTRUM, other])
    assert both.frequency.tolist() == [1.0, 10.0, 20.0, 100.0]
    assert both.psa[0, [1, 3]] == pytest.approx([16.0, 5.0])
    assert (both.zpa, both.displacement) == (5.0, 0.01)
    wide = SPECTRUM.broadened(0.15)
    assert wide.at(np.array([8.5, 11.5]), np.array([0.02, 0.02]))[0] == pytest.approx([16.0, 16.0])
    assert SPECTRUM.at(np.array([8.5]), np.array([0.02]))[0][0] < 15.0
    with pytest.raises(ImpactfemError, match="no envelope of the spectrum along y"):
        AnchorSpectrum.envelope([SPECTRUM, replace(other, component="x")])
    with pytest.raises(ImpactfemError, match="at least one spectrum"):
        AnchorSpectrum.envelope([])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"component": "w"}, "a spectrum of component 'w'"),
        ({"anchor": 0}, "of anchor 0: expected"),
        ({"zpa": -1.0}, "must not be negative"),
        ({"displacement": float("nan")}, "must not be negative"),
        ({"frequency": np.array([1.0, 1.0, 2.0])}, "ascending"),
        ({"damping": np.array([0.05, 0.02])}, "must ascend"),
        ({"psa": np.ones((2, 2))}, "as many ordinates"),
    ],
)
def test_bad_spectra_are_refused(change, words):
    with pytest.raises(ImpactfemError, match=words):
        replace(SPECTRUM, **change)
