"""Ordinates of the modes, from response spectrum analyses of given spectra."""

from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.equipment.analysis import SpectrumChoice
from impactfem.equipment.ordinates import ordinate_variables

PLAIN = SpectrumChoice("srss", rotations=False, broadened=False)
TURNED = SpectrumChoice("srss", rotations=True, broadened=False)


def response(**ordinates):
    columns = {"x": 0, "y": 1, "rx": 3}
    return SimpleNamespace(
        inputs=[SimpleNamespace(ordinate=np.array(values)) for values in ordinates.values()],
        columns=[columns[name] for name in ordinates],
    )


def result(factor, *ordinates):
    y, rx = (factor * np.array(values) for values in ordinates)
    return SimpleNamespace(by_spectrum={PLAIN: response(y=y), TURNED: response(y=y, rx=rx)})


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
    dims, values, attributes = ordinate_variables(study(), TURNED, 3)["mode_psa"]
    assert dims == ("case", "impact", "device", "component", "mode")
    assert values.shape == (2, 2, 2, 6, 3) and attributes["units"] == "m/s2"
    assert values[0, 0, 0, 1].tolist() == [1.0, 2.0, 3.0]
    assert values[1, 1, 0, 3].tolist() == [80.0, 100.0, 120.0]
    # Beyond the modes of a device, and of what is no input.
    assert values[0, 1, 1, 1] == pytest.approx([70.0, np.nan, np.nan], nan_ok=True)
    assert np.isnan(values[..., [0, 2, 4, 5], :]).all()


def test_without_rotations():
    values = ordinate_variables(study(), PLAIN, 3)["mode_psa"][1]
    assert np.isnan(values[..., 3, :]).all() and np.isfinite(values[0, 0, 0, 1]).all()
