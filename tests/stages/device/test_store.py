"""What the store and the scalars of the stage take from its results."""

from dataclasses import fields
from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.stages.device.analysis import DeviceResult, Support
from impactfem.stages.device.anchor import Anchor
from impactfem.stages.device.choice import SpectrumChoice
from impactfem.stages.device.store import device_scalars, differences

from .device_store import MASSES, WantedDevice, device_store

PLAIN = SpectrumChoice("srss")
TURNED = SpectrumChoice("srss", rotations=True)
PUMP = Support(0, 1, "pump", several=False)
COLUMNS = {"x": 0, "y": 1, "rx": 3, "second_y": 7}


def response(**ordinates):
    inputs = [SimpleNamespace(ordinate=np.array(values)) for values in ordinates.values()]
    return SimpleNamespace(inputs=inputs, columns=[COLUMNS[name] for name in ordinates])


def result(y, rx, support=PUMP):
    by_spectrum = {PLAIN: response(y=y, second_y=rx), TURNED: response(y=y, rx=rx)}
    known = {"support": support, "by_spectrum": by_spectrum}
    return DeviceResult(**dict.fromkeys(field.name for field in fields(DeviceResult)) | known)


def test_ordinates_by_component_and_mode():
    """A device with two modes, of three that another one has; and a component that is no input."""
    pump = result([1.0, 2.0], [4.0, 5.0])
    values, nan = pump.ordinates(TURNED, 3), np.nan
    assert values[1] == pytest.approx([1.0, 2.0, nan], nan_ok=True)
    assert values[3] == pytest.approx([4.0, 5.0, nan], nan_ok=True)
    assert np.isnan(values[[0, 2, 4, 5]]).all()
    straight = pump.ordinates(PLAIN, 3)
    assert np.isnan(straight[3]).all() and np.isfinite(straight[1, :2]).all()


def test_ordinates_of_each_of_two_anchors():
    first, second = (Support(0, k, f"pipe_{k}", several=True) for k in (1, 2))
    values = [result([1.0], [4.0], one).ordinates(PLAIN, 1)[:, 0] for one in (first, second)]
    assert (values[0][1], values[1][1]) == (1.0, 4.0) and np.isfinite(values).sum() == 2


def anchor(weight_force):
    """An anchor with nothing but a weight, on a circle of 0.5 m."""
    names = [field.name for field in fields(Anchor)]
    weight = -weight_force[2] if weight_force[2] else None
    known = {"weight": weight, "weight_force": weight_force, "radius": 0.5}
    return Anchor(**dict.fromkeys(names) | known)


def test_net_tension_by_hand():
    """2942 N of weight: lifted by 1058 N at one instant, pulled by 1000 + 4000 - 2942 N later."""
    force = np.zeros((6, 3))
    force[1] = 1.0, -100.0, 2.0
    force[2] = 0.0, 4000.0, 1000.0
    force[3:5] = [[0.0, 30.0, -600.0], [0.0, 40.0, 800.0]]
    weight, radius = 300.0 * 9.80665, 0.5
    own = np.array([0.0, 0.0, -weight, 0.0, 0.0, 0.0])
    # All at one instant, and an analysis that was not done.
    peaks = np.array([np.abs(force).max(axis=1), np.full(6, 1.6), np.full(6, np.nan)])
    uplift, tension = anchor(own).pulls(force, peaks)
    assert uplift == pytest.approx([4000.0 - weight, 1.6 - weight, np.nan], nan_ok=True)
    detailed = 1000.0 - weight + 2.0 * 1000.0 / radius
    whole = 1.6 - weight + 2.0 * np.hypot(1.6, 1.6) / radius
    assert tension == pytest.approx([detailed, whole, np.nan], nan_ok=True)
    # What has no sign adds to the moments that the weight has itself.
    own[3:5] = 30.0, -40.0
    turned = anchor(own).pulls(force, peaks)[1, 1]
    assert turned == pytest.approx(1.6 - weight + 2.0 * np.hypot(31.6, 41.6) / radius)


def test_net_tension_without_a_weight():
    """A table of modes along y says nothing of the weight."""
    assert np.isnan(anchor(np.zeros(6)).pulls(np.ones((6, 3)), np.ones((2, 6)))).all()


def test_differences():
    force = np.array([[100.0, 80.0, np.nan], [0.0, 0.0, 0.0]])
    nan = np.nan
    expected = np.array([[nan, 0.2, nan], [nan, nan, nan]])
    np.testing.assert_allclose(differences(force), expected)


CHOICES = {
    "srss": (0.8, 0.8),
    "srss, rotations": (0.9, 0.9),
    "srss, envelope": (1.1, 1.1),
    "srss, lindley-yow": (np.nan, 0.99),
}


LOADS = """
fy.detailed.no_impact fy.detailed.impact fy.rsa.no_impact fy.rsa.impact fy.rsa_lindley_yow.impact
relative_difference.no_impact relative_difference.impact
frs.peak.no_impact frs.peak.impact frs.peak_frequency.no_impact frs.peak_frequency.impact
"""
OWN = """
frequency.1 frequency.2 frequency.3 frequency.4
effective_mass.1 effective_mass.2 effective_mass.3 effective_mass.4 weight
net_uplift.no_impact net_uplift.impact net_tension.no_impact net_tension.impact
pfa.no_impact pfa.impact
"""


def test_scalars():
    """Those of further dampings are details; a method that was not done has no scalar."""
    store = device_store(WantedDevice(choices=CHOICES, dampings=2, devices=("pump", "fan")))
    found = {scalar.name: scalar for scalar in device_scalars(store)}
    first = {name for name in found if not name.startswith("device.fan.")}
    further = {f"device.{name}.under-damped" for name in LOADS.split()}
    assert first == further | {f"device.{name}" for name in (OWN + LOADS).split()}
    assert {name for name in first if found[name].detail} == further
    assert len(found) == 2 * len(first) + 2  # a fifth mode of the second device
    force = found["device.fan.fy.rsa_lindley_yow.impact.under-damped"]
    assert (force.value, force.unit) == (pytest.approx(2.0 * 0.99 * 116e3), "N")
    assert found["device.relative_difference.impact"].value == pytest.approx(0.2)
    assert found["device.effective_mass.3"].value == MASSES[1]


def test_scalars_without_a_weight():
    found = device_scalars(device_store(WantedDevice(pulls=(np.nan, np.nan))))
    assert not any("net_" in scalar.name for scalar in found)
