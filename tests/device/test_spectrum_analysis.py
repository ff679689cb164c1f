from dataclasses import replace

import numpy as np
import pytest

from impactfem.device.anchor_force import anchor_force, anchor_forces, own_motions
from impactfem.device.combination import Gupta, Rules
from impactfem.device.modes import device_modes
from impactfem.device.parts import Beam
from impactfem.device.spectrum import AnchorSpectrum, NotRigidError
from impactfem.device.spectrum_analysis import spectrum_analysis
from impactfem.spectra import response_spectra
from impactfem.system.errors import ImpactfemError


def spectrum(component="y", zpa=4.0, peak=20.0, anchor=1, displacement=0.0):
    return AnchorSpectrum(
        component,
        np.array([0.5, 5.0, 20.0, 50.0, 500.0]),
        np.array([0.0, 0.2]),
        np.array([[1.0, peak, peak, zpa, zpa], [0.5, 0.8 * peak, 0.8 * peak, zpa, zpa]]),
        zpa,
        anchor,
        displacement,
    )


def test_shear_is_effective_mass_times_ordinate(pump):
    device = pump()
    modes = device_modes(device)
    found = spectrum_analysis(device, [spectrum()], Rules(modes="srss"))
    parts = modes.effective_mass[1] * found.inputs[0].ordinate
    assert found.inputs[0].modal[1] == pytest.approx(-parts, rel=1e-9)
    assert found.value("force y") == pytest.approx(np.sqrt(np.sum(parts**2)), rel=1e-9)
    moment = parts @ np.nan_to_num(modes.height)
    absolute = spectrum_analysis(device, [spectrum()], Rules(modes="abs"))
    assert abs(found.inputs[0].modal[3].sum()) == pytest.approx(moment, rel=1e-9)
    assert absolute.value("moment x") > moment


def test_a_blocked_direction_feels_the_zero_period_acceleration(pump):
    found = spectrum_analysis(pump(), [spectrum("z", zpa=3.0)])
    assert found.value("force z") == pytest.approx(1500.0 * 3.0)
    assert found.value("force y") == pytest.approx(0.0, abs=1e-6)
    without = spectrum_analysis(pump(), [spectrum("z", zpa=3.0)], Rules(missing_mass=False))
    assert without.value("force z") == pytest.approx(0.0, abs=1e-9)


def test_a_component_that_hardly_moves_does_not_forbid_gupta(pump):
    """Along x a ten-thousandth of the motion, whose spectrum ends before it is rigid."""
    short = replace(spectrum("x", zpa=4e-4, peak=20e-4), zpa=3e-4)
    rules = Rules(modes="srss", rigid=Gupta())
    found = spectrum_analysis(pump(), [spectrum(), short], rules)
    alone = spectrum_analysis(pump(), [spectrum()], rules)
    assert found.value("force y") == pytest.approx(alone.value("force y"), rel=1e-12)
    assert found.inputs[1].rigid_fraction.max() == 0.0 < found.inputs[0].rigid_fraction.max()
    (note,) = (one for one in found.notes if "periodic" in one)
    assert note.startswith("the spectrum along x at anchor 1, below 0.001 of the largest, ends")
    with pytest.raises(NotRigidError, match=r"along x .*before"):
        spectrum_analysis(pump(), [spectrum(), replace(short, zpa=0.3)], rules)


def test_fewer_modes_and_missing_mass(pump):
    device = pump()
    modes = device_modes(device)
    found = spectrum_analysis(device, [spectrum()], Rules(maximum_frequency=50.0))
    kept = modes.frequency < 50.0
    assert found.modes.frequency.size == kept.sum() == 2
    missing = modes.effective_mass[1, ~kept].sum() * 4.0
    assert abs(found.inputs[0].missing[1]) == pytest.approx(missing, rel=1e-9)
    kept_part = (modes.effective_mass[1, kept] * found.inputs[0].ordinate).sum()
    assert found.value("force y") == pytest.approx(np.hypot(kept_part, missing), rel=1e-6)
    assert not found.notes
    bare = spectrum_analysis(
        device, [spectrum()], Rules(maximum_frequency=50.0, missing_mass=False)
    )
    assert bare.value("force y") == pytest.approx(kept_part, rel=1e-6)
    assert len(bare.notes) == 1 and bare.notes[0].startswith("2 modes")


def test_directions_and_rotations(pump):
    device = pump()
    inputs = [spectrum("x"), spectrum("y"), spectrum("rx", zpa=2.0, peak=9.0)]
    alone = [spectrum_analysis(device, [s]) for s in inputs]
    q = anchor_forces(device).names.index("moment x")
    y, rx = alone[1].total[q], alone[2].total[q]
    assert spectrum_analysis(device, inputs).total[q] == pytest.approx(np.hypot(y, rx))
    step = spectrum_analysis(device, inputs, Rules(rotations="abs")).total[q]
    assert step == pytest.approx(y + rx)
    x = alone[0].value("force x")
    forty = spectrum_analysis(device, inputs, Rules(directions="100-40-40"))
    assert forty.value("force x") == pytest.approx(x)
    whole = forty.by_component
    pair = np.hypot(whole["y"], whole["rx"])
    large, small = np.maximum(pair, whole["x"]), np.minimum(pair, whole["x"])
    assert forty.inertial == pytest.approx(large + 0.4 * small)


def test_the_modes_of_a_motion_are_exact(pump, shaking):
    """Ordinates at the modes of a motion: each mode's part is its largest value in time."""
    device, motion = pump(), np.zeros((6, 1200))
    motion[1, :1000] = shaking(1000)[1]
    modes = device_modes(device)
    s = AnchorSpectrum.of_motion(
        "y", motion[1], 2e-4, modes.frequency, modes.damping, method="in-step"
    )
    found = spectrum_analysis(device, [s])
    run = anchor_force(device, motion, 2e-4)
    parts = np.abs(run.modal).max(axis=1) * modes.omega**2 * np.abs(modes.participation[1])
    mine = modes.effective_mass[1] > 1.0
    assert np.abs(found.inputs[0].modal[1])[mine] == pytest.approx(parts[mine], rel=2e-3)
    assert (
        run.largest[1] < spectrum_analysis(device, [s], Rules(modes="abs")).value("force y") * 1.01
    )


def test_displacements_beside_forces(pump):
    device = pump()
    q = own_motions(device) + anchor_forces(device)
    found = spectrum_analysis(device, [spectrum()], Rules(modes="srss"), q)
    # The spring along y carries the shear force.
    assert found.value("displacement base y") == pytest.approx(found.value("force y") / 1.2e8)


def test_what_was_assumed_is_told(pump):
    short = AnchorSpectrum(
        "y", np.array([1.0, 40.0]), np.array([0.0, 0.2]), np.full((2, 2), 4.0), 4.0
    )
    found = spectrum_analysis(pump(), [short])
    assert len(found.notes) == 1 and "ends at 40 Hz" in found.notes[0]
    assert spectrum_analysis(pump(), [spectrum()]).notes == ()


HIGH = AnchorSpectrum("y", np.array([35.0, 500.0]), np.array([0.0, 0.2]), np.ones((2, 2)), 1.0)


@pytest.mark.parametrize(
    ("spectra", "rules", "beam", "words"),
    [
        ([], None, None, r"at least one spectrum.*got none"),
        ([spectrum(), spectrum()], None, None, "one for a component of an anchor"),
        ([spectrum(anchor=2)], None, None, "no component 'y' of anchor 2"),
        ([HIGH], None, None, "begins at 35 Hz and does not reach the mode"),
        ([spectrum()], Rules(supports="max"), None, "one of srss, abs, 100-40-40: got 'max'"),
        ([spectrum()], None, Beam(0.46, 8e7, 8e7, mass=45.9), "is damped by"),
    ],
)
def test_bad_inputs_are_refused(pump, spectra, rules, beam, words):
    with pytest.raises(ImpactfemError, match=words):
        spectrum_analysis(pump(beam), spectra, rules)


def test_only_what_moves_a_mode_must_reach_it(pump):
    """A vertical mode at 400 Hz does not concern the spectrum along y."""
    device = pump(z=1500.0 * (2 * np.pi * 400.0) ** 2)
    short = AnchorSpectrum(
        "y", np.array([1.0, 100.0]), np.array([0.0, 0.2]), np.full((2, 2), 5.0), 2.0
    )
    assert spectrum_analysis(device, [short]).value("force y") > 0.0
    with pytest.raises(ImpactfemError, match="mode at 400 Hz"):
        spectrum_analysis(device, [replace(short, component="z")])


def test_nothing_acts_along_x_under_y(pump):
    """But round-off."""
    response = spectrum_analysis(pump(), [spectrum()])
    assert response.value("force x") < 1e-9 * response.value("force y")
    with pytest.raises(ImpactfemError, match="quantity 'weight' was"):
        response.value("weight")


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
    with pytest.raises(ImpactfemError, match=r"anchor 1: .* 0\.02 to 0\.05; 0\.1"):
        SPECTRUM.at(np.array([10.0]), np.array([0.1]))
    assert SPECTRUM.rigid_from(0.05) == 10.0
    with pytest.raises(ImpactfemError, match="before it comes"):
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
    with pytest.raises(ImpactfemError, match="anchor 1 ends at 100"):
        open_ended.at(np.array([400.0]), np.array([0.02]))
    with pytest.raises(ImpactfemError, match=r"reach .* at 0\.5 Hz"):
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
    with pytest.raises(ImpactfemError, match="spectrum along y"):
        AnchorSpectrum.envelope([SPECTRUM, replace(other, component="x")])
    with pytest.raises(ImpactfemError, match="at least one"):
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
