"""Forces on an anchor as scalars: those of the analyses that were done."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from impactfem.stages.device.analysis import DeviceResult
from impactfem.stages.device.scalars import _forces, tension_by_spectrum
from impactfem.stages.device.spectrum_choice import SpectrumChoice
from impactfem.stages.device.support import Support

SUPPORT = Support(0, 2, "pipe_2", several=True)
PLAIN = SpectrumChoice("srss", rotations=False, broadened=False)
DONE = {
    PLAIN: 80.0,
    SpectrumChoice("srss", True, False): 90.0,
    SpectrumChoice("srss", False, False, "envelope"): 110.0,
    SpectrumChoice("srss", False, False, "given"): 130.0,
    SpectrumChoice("srss", False, True, "envelope"): 140.0,
    SpectrumChoice("srss", False, False, rigid="lindley-yow"): 99.0,
}


WEIGHT = 300.0  # kg, on the second anchor
RADIUS = 0.5


def answer(value):
    """Along y at the second of two anchors; a fiftieth of it in every other component."""
    name = "force y at anchor 2"
    inputs = [
        SimpleNamespace(
            spectrum=SimpleNamespace(component="y"), modal=np.array([[60.0, 30.0]]), missing=[-2.0]
        ),
        SimpleNamespace(
            spectrum=SimpleNamespace(component="x"), modal=np.array([[9.0, 9.0]]), missing=[0.0]
        ),
    ]
    return SimpleNamespace(
        value=lambda asked: value if asked == name else value / 50.0,
        quantities=SimpleNamespace(names=[name]),
        inputs=inputs,
    )


def history():
    """Three instants: the second lifts, the third overturns."""
    force = np.zeros((6, 3))
    force[1] = 1.0, -100.0, 2.0
    force[2] = 0.0, 4000.0, 1000.0
    force[3], force[4] = (0.0, 30.0, -600.0), (0.0, 40.0, 800.0)
    return SimpleNamespace(force=force, largest=np.abs(force).max(axis=1))


def study_of(weight=WEIGHT):
    J = np.zeros((12, 12))
    J[8, 8] = weight
    plan = SimpleNamespace(
        rules={("srss", "none"): None, ("srss", "lindley-yow"): None, ("cqc", "none"): None},
        device=SimpleNamespace(J=J),
    )
    anchors = [SimpleNamespace(radius=1.0), SimpleNamespace(radius=RADIUS)]
    return SimpleNamespace(
        direction=1,
        supports=[SUPPORT],
        prepared=SimpleNamespace(plans=[plan]),
        case=SimpleNamespace(
            devices=[SimpleNamespace(anchors=anchors)],
            spectra=SimpleNamespace(frequency_values=(1.0, 20.0, 300.0)),
        ),
    )


def result_of():
    return DeviceResult(
        support=SUPPORT,
        detailed=history(),
        anchor=np.array([[1.0, -2.0], [-7.0, 5.0], [0.0, 0.0]]),
        covering=(),
        shown=np.array([[9.0, 9.0, 9.0], [1.0, 7.5, 3.0], [9.0, 9.0, 9.0]]),
        by_spectrum={choice: answer(value) for choice, value in DONE.items()},
    )


def found_of(study):
    result = result_of()
    case = SimpleNamespace(no_impact=[result], impact=[result])
    return {s.name: s.value for s in _forces(study, "device.pipe_2", ".light", case, 0)}


def test_forces_of_the_analyses_that_were_done():
    found, result = found_of(study_of()), result_of()
    for load in ("impact", "no_impact"):
        end = f"{load}.light"
        assert found[f"device.pipe_2.fy.detailed.{end}"] == 100.0
        assert found[f"device.pipe_2.relative_difference.{end}"] == pytest.approx(0.2)
        assert found[f"device.pipe_2.pfa.{end}"] == 7.0
        assert found[f"device.pipe_2.fy.algebraic.{end}"] == 88.0
        assert found[f"device.pipe_2.frs.peak.{end}"] == 7.5
        assert found[f"device.pipe_2.frs.peak_frequency.{end}"] == 20.0
        words = {"rotations": 90.0, "envelope": 110.0, "given": 130.0, "lindley_yow": 99.0}
        for word, value in words.items():
            assert found[f"device.pipe_2.fy.rsa_{word}.{end}"] == value
    assert not any("dampings" in name for name in found)
    assert np.isnan(result.value(SpectrumChoice("cqc", False, False), "force y"))


def test_every_component_by_both_analyses():
    found = found_of(study_of())
    largest = {"fx": 0.0, "fz": 4000.0, "mx": 600.0, "my": 800.0, "mz": 0.0}
    for component, value in largest.items():
        assert found[f"device.pipe_2.{component}.detailed.impact.light"] == value
        assert found[f"device.pipe_2.{component}.rsa.impact.light"] == pytest.approx(1.6)


def test_net_tension_by_hand():
    """2942 N of weight: lifted by 1058 N at one instant, pulled by 1000 + 4000 - 2942 N later."""
    weight = WEIGHT * 9.80665
    found = found_of(study_of())
    assert found["device.pipe_2.net_uplift.impact.light"] == pytest.approx(4000.0 - weight)
    tension = 1000.0 - weight + 2.0 * 1000.0 / RADIUS
    assert found["device.pipe_2.net_tension.impact.light"] == pytest.approx(tension)
    # All at one instant: a fiftieth of 80 N in each component.
    whole = 1.6 - weight + 2.0 * np.hypot(1.6, 1.6) / RADIUS
    by_spectrum = tension_by_spectrum(study_of(), 0, result_of(), PLAIN)
    assert by_spectrum == pytest.approx(whole)
    assert np.isnan(tension_by_spectrum(study_of(), 0, result_of(), replace(PLAIN, broadened=True)))


def test_no_tension_without_a_weight():
    """A table of modes along y says nothing of what presses on the floor."""
    found = found_of(study_of(weight=0.0))
    assert found["device.pipe_2.net_tension.impact.light"] is None
    assert found["device.pipe_2.net_uplift.impact.light"] is None
    assert np.isnan(tension_by_spectrum(study_of(weight=0.0), 0, result_of(), PLAIN))
