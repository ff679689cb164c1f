"""Ordinates of the modes, from response spectrum analyses of given spectra."""

from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.stages.device.spectrum_choice import SpectrumChoice
from impactfem.stages.device.store import mode_ordinates
from impactfem.stages.device.support import Support

PLAIN = SpectrumChoice("srss", rotations=False, broadened=False)
PUMP = Support(0, 1, "pump", several=False)
TURNED = SpectrumChoice("srss", rotations=True, broadened=False)


def response(**ordinates):
    columns = {"x": 0, "y": 1, "rx": 3, "second_y": 7}
    return SimpleNamespace(
        inputs=[SimpleNamespace(ordinate=np.array(values)) for values in ordinates.values()],
        columns=[columns[name] for name in ordinates],
    )


def result(factor, *ordinates, support=PUMP):
    y, rx = (factor * np.array(values) for values in ordinates)
    by_spectrum = {PLAIN: response(y=y, second_y=rx), TURNED: response(y=y, rx=rx)}
    return SimpleNamespace(support=support, by_spectrum=by_spectrum)


def study():
    pump = ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0])
    fan = ([7.0], [8.0])
    return [
        SimpleNamespace(
            no_impact=[result(k, *pump), result(k, *fan)],
            impact=[result(10.0 * k, *pump), result(10.0 * k, *fan)],
        )
        for k in (1.0, 2.0)
    ]


def test_ordinates_by_component_and_mode():
    values = mode_ordinates(study(), TURNED, 3)
    assert values.shape == (2, 2, 2, 6, 3)
    assert values[0, 0, 0, 1].tolist() == [1.0, 2.0, 3.0]
    assert values[1, 1, 0, 3].tolist() == [80.0, 100.0, 120.0]
    # Beyond the modes of a device, and of what is no input.
    assert values[0, 1, 1, 1] == pytest.approx([70.0, np.nan, np.nan], nan_ok=True)
    assert np.isnan(values[..., [0, 2, 4, 5], :]).all()


def test_each_of_two_anchors_has_its_own():
    first, second = (Support(0, k, f"pipe_{k}", several=True) for k in (1, 2))
    one = result(1.0, [1.0], [4.0], support=first)
    other = result(1.0, [1.0], [4.0], support=second)
    cases = [SimpleNamespace(no_impact=[one, other], impact=[one, other])]
    values = mode_ordinates(cases, PLAIN, 1)[0, 0, :, :, 0]
    assert values[0, 1] == 1.0 and values[1, 1] == 4.0 and np.isfinite(values).sum() == 2


def test_without_rotations():
    values = mode_ordinates(study(), PLAIN, 3)
    assert np.isnan(values[..., 3, :]).all() and np.isfinite(values[0, 0, 0, 1]).all()
