"""What the store and the scalars of the stage take from its results."""

from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.stages.device.analysis import DeviceResult, SpectrumChoice, Support
from impactfem.stages.device.store import load_scalars, pulls

from .device_store import WantedDevice, device_store

PLAIN = SpectrumChoice("srss")
TURNED = SpectrumChoice("srss", rotations=True)
PUMP = Support(0, 1, "pump", several=False)
COLUMNS = {"x": 0, "y": 1, "rx": 3, "second_y": 7}


def response(**ordinates):
    inputs = [SimpleNamespace(ordinate=np.array(values)) for values in ordinates.values()]
    return SimpleNamespace(inputs=inputs, columns=[COLUMNS[name] for name in ordinates])


def result(y, rx, support=PUMP):
    by_spectrum = {PLAIN: response(y=y, second_y=rx), TURNED: response(y=y, rx=rx)}
    return DeviceResult(support, None, np.zeros((6, 1)), (), None, by_spectrum)


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


def test_net_tension_by_hand():
    """2942 N of weight: lifted by 1058 N at one instant, pulled by 1000 + 4000 - 2942 N later.

    The second device has a table of modes along y, which says nothing of what presses on the floor.
    """
    force = np.zeros((1, 1, 2, 6, 3))
    force[..., 1, :] = 1.0, -100.0, 2.0
    force[..., 2, :] = 0.0, 4000.0, 1000.0
    force[..., 3, :], force[..., 4, :] = (0.0, 30.0, -600.0), (0.0, 40.0, 800.0)
    weight, radius = 300.0 * 9.80665, 0.5
    own = np.array([[0.0, 0.0, -weight, 0.0, 0.0, 0.0], np.zeros(6)])
    # All at one instant, and an analysis that was not done.
    by_spectrum = np.full((1, 1, 2, 2, 6), 1.6)
    by_spectrum[..., 1, :] = np.nan
    found = {
        name: values[0, 0]
        for name, values in pulls(force, by_spectrum, own, np.full(2, radius)).items()
    }
    assert found["net_uplift"] == pytest.approx([4000.0 - weight, np.nan], nan_ok=True)
    tension = 1000.0 - weight + 2.0 * 1000.0 / radius
    assert found["net_tension"] == pytest.approx([tension, np.nan], nan_ok=True)
    whole = 1.6 - weight + 2.0 * np.hypot(1.6, 1.6) / radius
    assert found["spectrum_tension"].ravel() == pytest.approx([whole, *3 * [np.nan]], nan_ok=True)
    # What has no sign adds to the moments that the weight has itself.
    own[0, 3:5] = 30.0, -40.0
    turned = pulls(force, by_spectrum, own, np.full(2, radius))["spectrum_tension"][0, 0, 0, 0]
    assert turned == pytest.approx(1.6 - weight + 2.0 * np.hypot(31.6, 41.6) / radius)


SHARES = {
    "srss": (0.8, 0.8),
    "srss.rotations": (0.9, 0.9),
    "srss.envelope": (1.1, 1.1),
    "srss.given": (1.3, 1.3),
    "srss.envelope.broadened": (1.4, 1.4),
    "srss.lindley-yow": (0.99, 0.99),
}


def scalars(**wanted):
    """By name, with impacts: 66 kN along y at the second anchor of a pipe."""
    store = device_store(WantedDevice(choices=SHARES, dampings=1, **wanted))
    along = [("y", [60.0, 30.0], -2.0), ("x", [9.0, 9.0], 0.0)]
    inputs = [
        SimpleNamespace(
            spectrum=SimpleNamespace(component=c), modal=np.array([modal]), missing=[missing]
        )
        for c, modal, missing in along
    ]
    names = ["force y at anchor 2"]
    answer = SimpleNamespace(quantities=SimpleNamespace(names=names), inputs=inputs)
    done = [PLAIN, TURNED, SpectrumChoice("srss", False, True, "envelope")]
    done += [SpectrumChoice("srss", source="envelope"), SpectrumChoice("srss", source="given")]
    done.append(SpectrumChoice("srss", rigid="lindley-yow"))
    rules = [("srss", "none"), ("srss", "lindley-yow"), ("cqc", "none")]
    one = DeviceResult(
        support=Support(0, 2, "pipe_2", several=True),
        detailed=None,
        anchor=np.array([[1.0, -2.0], [-7.0, 5.0], [0.0, 0.0]]),
        covering=(),
        shown=None,
        by_spectrum=dict.fromkeys(done, answer),
    )
    assert np.isnan(one.values(SpectrumChoice("cqc"))).all()
    of = store.isel(device=0, case=0, impact=1)
    return {s.name: s for s in load_scalars(of, SimpleNamespace(rules=dict.fromkeys(rules)), one)}


def test_scalars_of_the_analyses_that_were_done():
    found = {name: scalar.value for name, scalar in scalars().items()}
    peak = 3.0 * 66e3 / 5e3
    assert found == pytest.approx(
        {
            "fy.detailed": 66e3,
            "fy.rsa": 0.8 * 66e3,
            "relative_difference": 0.2,
            "fy.rsa_rotations": 0.9 * 66e3,
            "fy.rsa_envelope": 1.1 * 66e3,
            "fy.rsa_given": 1.3 * 66e3,
            "fy.rsa_lindley_yow": 0.99 * 66e3,
            "fy.algebraic": 88.0,
            **{f"{c}.detailed": 33e3 for c in ("fx", "fz", "mx", "my", "mz")},
            **{f"{c}.rsa": 6.6e3 for c in ("fx", "fz", "mx", "my", "mz")},
            "net_uplift": -21e3,
            "net_tension": -1e3,
            "pfa": 7.0,
            "frs.peak": pytest.approx(peak, rel=0.01),
            "frs.peak_frequency": pytest.approx(40.0, rel=0.1),
        }
    )


def test_scalars_without_a_weight():
    found = scalars(pulls=(np.nan, np.nan))
    for name in ("net_tension", "net_uplift"):
        assert found[name].value is None and "the weight is not known" in found[name].note
    assert found["net_tension"].unit == "N" and found["mx.rsa"].unit == "N m"
