"""Forces on an anchor as scalars: those of the analyses that were done."""

from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.equipment.analysis import DeviceResult
from impactfem.equipment.scalars import _forces
from impactfem.equipment.spectrum_choice import SpectrumChoice
from impactfem.equipment.support import Support

PLAIN = SpectrumChoice("srss", rotations=False, broadened=False)
DONE = {
    PLAIN: 80.0,
    SpectrumChoice("srss", True, False): 90.0,
    SpectrumChoice("srss", False, False, "envelope"): 110.0,
    SpectrumChoice("srss", False, False, "given"): 130.0,
    SpectrumChoice("srss", False, True, "envelope"): 140.0,
}


def answer(value):
    """Along y at the second of two anchors."""
    values = {"force y at anchor 2": value}
    return SimpleNamespace(value=lambda name: values[name])


def test_forces_of_the_analyses_that_were_done():
    result = DeviceResult(
        support=Support(0, 2, "pipe_2", several=True),
        detailed=SimpleNamespace(largest=np.array([1.0, 100.0, 2.0, 0.0, 0.0, 0.0])),
        anchor=np.array([[1.0, -2.0], [-7.0, 5.0], [0.0, 0.0]]),
        covering=(),
        shown=np.zeros((3, 1)),
        by_spectrum={choice: answer(value) for choice, value in DONE.items()},
    )
    plan = SimpleNamespace(rules={"srss": None})
    study = SimpleNamespace(direction=1, prepared=SimpleNamespace(plans=[plan]))
    case = SimpleNamespace(no_impact=[result], impact=[result])
    found = {s.name: s.value for s in _forces(study, "device.pipe_2", ".light", case, 0)}
    for load in ("impact", "no_impact"):
        end = f"{load}.light"
        assert found[f"device.pipe_2.fy.detailed.{end}"] == 100.0
        assert found[f"device.pipe_2.relative_difference.{end}"] == pytest.approx(0.2)
        assert found[f"device.pipe_2.pfa.{end}"] == 7.0
        for word, value in (("rotations", 90.0), ("envelope", 110.0), ("given", 130.0)):
            assert found[f"device.pipe_2.fy.rsa_{word}.{end}"] == value
    assert not any("dampings" in name for name in found)
    assert np.isnan(result.value(SpectrumChoice("cqc", False, False), "force y"))
