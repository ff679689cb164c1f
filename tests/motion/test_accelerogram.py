import numpy as np
import pytest

from impactfem.motion import Accelerogram
from impactfem.system.errors import ImpactfemError


def test_constant_acceleration():
    record = Accelerogram(0.1, np.full(21, 3.0))
    t = record.time
    assert record.duration == pytest.approx(2.0)
    assert record.velocity == pytest.approx(3.0 * t)
    assert record.displacement == pytest.approx(1.5 * t**2)


def test_linear_acceleration_is_integrated_exactly():
    record = Accelerogram(0.25, 2.0 * np.arange(9) * 0.25)
    t = record.time
    assert record.velocity == pytest.approx(t**2, abs=1e-15)
    assert record.displacement == pytest.approx(t**3 / 3, abs=1e-15)


def test_quadratic_acceleration_is_not_exact():
    # The negative twin: the integrals belong to the piecewise-linear curve, not to a parabola.
    record = Accelerogram(0.25, (np.arange(9) * 0.25) ** 2)
    assert record.velocity[-1] - record.duration**3 / 3 > 0.01


def test_between_samples_it_is_linear_and_outside_zero():
    record = Accelerogram(0.5, [1.0, 3.0, -1.0])
    assert record.at([-0.1, 0.0, 0.25, 0.5, 0.75, 1.0, 1.1]).tolist() == [0, 1, 2, 3, 1, -1, 0]


def test_scaling():
    record = Accelerogram(0.5, [0.0, -4.0, 2.0], "ny", "record x.csv")
    assert record.scaled(0.5).acceleration.tolist() == [0.0, -2.0, 1.0]
    assert record.scaled_to_pga(1.0).acceleration.tolist() == [0.0, -1.0, 0.5]
    assert record.scaled(0.5).origin == "record x.csv; scaled by 0.5"
    assert record.scaled(0.5).name == "ny"


def test_refining_keeps_the_samples():
    record = Accelerogram(0.02, np.sin(np.arange(50)), "", "a file")
    fine = record.refined(4)
    assert fine.time_step == pytest.approx(0.005)
    assert fine.acceleration[::4] == pytest.approx(record.acceleration, abs=1e-14)
    assert fine.duration == pytest.approx(record.duration)
    assert "refined 4 times" in fine.origin


def test_it_cannot_be_changed_from_outside():
    samples = np.array([0.0, 1.0])
    record = Accelerogram(0.1, samples)
    samples[0] = 9.0
    assert record.acceleration[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        record.acceleration[0] = 1.0


@pytest.mark.parametrize(
    ("step", "samples", "message"),
    [
        (0.0, [0.0, 1.0], "time step must be positive"),
        (float("nan"), [0.0, 1.0], "time step must be positive"),
        (0.1, [1.0], "at least 2 samples"),
        (0.1, [[1.0, 2.0]], "at least 2 samples"),
        (0.1, [0.0, float("inf")], "sample 1 .* not a finite number"),
    ],
)
def test_bad_records_are_refused(step, samples, message):
    with pytest.raises(ImpactfemError, match=message):
        Accelerogram(step, samples)


def test_bad_scales_are_refused():
    record = Accelerogram(0.1, [0.0, 1.0])
    with pytest.raises(ImpactfemError, match="must not be 0"):
        record.scaled(0.0)
    with pytest.raises(ImpactfemError, match="cannot be scaled"):
        record.scaled_to_pga(-1.0)
    with pytest.raises(ImpactfemError, match="cannot be scaled"):
        Accelerogram(0.1, [0.0, 0.0]).scaled_to_pga(1.0)
