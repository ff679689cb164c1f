"""Verdicts of devices: bolts, qualification spectra and ZPA, by the small store."""

from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.case import DeviceSetup
from impactfem.case.capacities import AnchorBolts, QualificationCurve, QualificationSpectrum
from impactfem.spectra import response_spectra
from impactfem.stages.device import capacity
from impactfem.stages.device.capacity import device_verdicts
from impactfem.system.errors import SolutionError

from .device_store import FREQUENCY, TIME, device_folder

# Debian's h5py on the NumPy 1.26 of the virtual environment.
pytestmark = pytest.mark.filterwarnings("ignore:`product` is deprecated:DeprecationWarning")

BOLTS = AnchorBolts(
    count=4, circle=0.8, first_angle=np.pi / 4, area=245e-6, tension=141e3, shear=94e3, exponent=2
)


def building_with(**capacities):
    """A building of which a device has these capacities."""
    setup = DeviceSetup.model_construct(
        name="pump", point=(0.0, 0.0, 0.0), radius=0.5, **capacities
    )
    spectra = SimpleNamespace(frequency_values=FREQUENCY, points_per_cycle=20.0, method="upsampled")
    return SimpleNamespace(
        numbered_devices=((0, setup),),
        case=SimpleNamespace(spectra=spectra),
        device_analysis=SimpleNamespace(broadening=0.0),
    )


def flat(acceleration, axes="xyz", first=1.0, last=100.0):
    """A spectrum with one ordinate at all frequencies."""
    both = (acceleration, acceleration)
    curve = QualificationCurve(axes=axes, frequency=(first, last), acceleration=both)
    return QualificationSpectrum.model_construct(file=(curve,), damping=0.05)


@pytest.fixture
def found(tmp_path):
    """The verdicts of a device with these capacities, by their ids."""
    folder = device_folder(tmp_path)

    def verdicts(**capacities):
        return {one.id: one for one in device_verdicts(building_with(**capacities), folder)}

    return verdicts


def test_bolts_by_hand(found):
    """66 kN along y and 15 kN of weight: no bolt is in tension, each has a quarter of the shear."""
    verdicts = found(anchors=BOLTS)
    shear, tension = verdicts["device.anchor_shear"], verdicts["device.anchor_tension"]
    assert (shear.demand, shear.capacity) == (pytest.approx(16.5e3, rel=1e-6), 94e3)
    assert shear.demand_without_impact == pytest.approx(2.5e3, rel=1e-6)
    assert tension.demand == pytest.approx(0.0, abs=1e-6) and tension.passed
    interaction = verdicts["device.anchor_interaction"]
    assert interaction.ratio == pytest.approx((16.5 / 94.0) ** 2, rel=1e-6)
    assert interaction.key == "devices[0].anchors" and interaction.place == "pump, floor 3 of one"


def test_weak_bolts_are_exceeded(found):
    weak = BOLTS.model_copy(update={"shear": 16e3})
    verdicts = found(anchors=weak)
    assert verdicts["device.anchor_shear"].passed is False
    assert verdicts["device.anchor_interaction"].ratio == pytest.approx(
        (16.5 / 16.0) ** 2, rel=1e-6
    )


def test_bolts_that_cannot_balance_the_forces(found, monkeypatch):
    def fails(*_):
        raise SolutionError("no equilibrium")

    monkeypatch.setattr(capacity, "bolt_demand", fails)
    one = found(anchors=BOLTS)["device.anchor_interaction"]
    assert one.demand is None and one.passed is None and one.detail


def test_without_capacities_the_keys_are_named(found):
    verdicts = found()
    assert {one.key: one.passed for one in verdicts.values()} == {
        "devices[0].anchors": None,
        "devices[0].required_spectrum": None,
        "devices[0].zpa_limit": None,
    }
    assert all(one.demand is not None for one in verdicts.values())


@pytest.mark.parametrize("kind", ["required_spectrum", "test_spectrum"])
def test_floor_spectrum_against_a_qualification_spectrum(found, kind):
    pulse = np.exp(-(((TIME - 1.2) / 0.2) ** 2)) * np.cos(2 * np.pi * 30.0 * (TIME - 1.2))
    grid = np.unique([*FREQUENCY, 1.0, 100.0])
    psa = response_spectra(66e3 / 5e3 * pulse, 1e-3, grid, [0.05]).psa[0, 0]
    band = (grid >= 1.0) & (grid <= 100.0)
    largest = psa[band].max()
    one = found(**{kind: flat(largest / 1.25)})[f"device.{kind}"]
    assert one.ratio == pytest.approx(1.25, rel=2e-3) and one.passed is False
    assert one.frequency == pytest.approx(grid[band][psa[band].argmax()])
    assert one.band == (1.0, 100.0)
    assert one.demand_without_impact == pytest.approx(one.demand * 10.0 / 66.0, rel=1e-5)
    assert found(**{kind: flat(largest / 0.99)})[f"device.{kind}"].passed


def test_axes_and_frequencies_that_are_not_compared(found):
    one = found(required_spectrum=flat(1.0, axes="x"))["device.required_spectrum"]
    assert one.ratio == pytest.approx(0.0, abs=1e-9) and "y, z" in one.detail
    above = found(required_spectrum=flat(1.0, first=2e3, last=3e3))["device.required_spectrum"]
    assert above.demand is None and above.passed is None


def test_zpa_of_the_axis_with_the_largest_ratio(found):
    peak = 66e3 / 5e3  # of the history in the store
    one = found(zpa_limit=(1.0, 2.0 * peak, 1.0))["device.zpa"]
    # Nothing moves along x and z.
    assert (one.demand, one.ratio) == (pytest.approx(peak), pytest.approx(0.5))
    assert found(zpa_limit=(1.0, 0.9 * peak, 1.0))["device.zpa"].passed is False
