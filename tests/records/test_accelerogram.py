import numpy as np
import pytest

from impactfem.records.accelerogram import STANDARD_GRAVITY, Accelerogram, measures
from impactfem.system.errors import ImpactfemError


def test_linear_acceleration_is_integrated_exactly():
    record = Accelerogram(0.25, 3.0 + 2.0 * np.arange(9) * 0.25)
    t = record.time
    assert record.duration == 2.0
    assert record.velocity == pytest.approx(3.0 * t + t**2, abs=1e-15)
    assert record.displacement == pytest.approx(1.5 * t**2 + t**3 / 3, abs=1e-15)
    # The negative twin: the integrals belong to the piecewise-linear curve, not to a parabola.
    record = Accelerogram(0.25, t**2)
    assert record.velocity[-1] - record.duration**3 / 3 > 0.01


def test_scaling():
    record = Accelerogram(0.5, [0.0, -4.0, 2.0], "ny", "record x.csv")
    assert record.scaled(0.5).acceleration.tolist() == [0.0, -2.0, 1.0]
    assert record.scaled_to_pga(1.0).acceleration.tolist() == [0.0, -1.0, 0.5]
    assert record.scaled(0.5).origin == "record x.csv; scaled by 0.5"
    assert record.scaled(0.5).name == "ny"


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


def test_ten_cycles_of_a_sine():
    # Arias: π/(2g) A² T/2. Velocity A/ω (1 - cos ωt). Displacement A/ω (t - sin(ωt)/ω).
    A, f, T, h = 2.0, 1.0, 10.0, 1e-3
    t = np.arange(round(T / h) + 1) * h
    m = measures(Accelerogram(h, A * np.sin(2 * np.pi * f * t)))
    omega = 2 * np.pi * f
    assert m.pga == pytest.approx(A, rel=1e-5)
    assert m.time_of_pga == pytest.approx(0.25, abs=h)
    assert m.pgv == pytest.approx(2 * A / omega, rel=1e-5)
    assert m.pgd == pytest.approx(A / omega * T, rel=1e-5)
    assert m.arias == pytest.approx(np.pi / (2 * STANDARD_GRAVITY) * A**2 * T / 2, rel=1e-5)
    assert m.end_velocity == pytest.approx(0.0, abs=1e-9)
    assert m.end_displacement == pytest.approx(m.pgd)


def test_constant_acceleration_has_nine_tenths_of_its_duration():
    m = measures(Accelerogram(0.1, np.full(101, -3.0)))
    assert m.duration_5_95 == pytest.approx(9.0)
    assert m.arias == pytest.approx(np.pi / (2 * STANDARD_GRAVITY) * 9.0 * 10.0)
    assert m.pga == 3.0
    assert m.end_velocity == pytest.approx(-30.0)
    assert m.end_displacement == pytest.approx(-150.0)


def test_arias_of_a_ramp_is_exact_in_one_step():
    # ∫ (2t)² dt over 0..1 = 4/3; the trapezoidal rule would give 2.
    m = measures(Accelerogram(1.0, [0.0, 2.0]))
    assert m.arias == pytest.approx(np.pi / (2 * STANDARD_GRAVITY) * 4 / 3, rel=1e-14)


def test_silence_has_no_strength():
    m = measures(Accelerogram(0.1, np.zeros(5)))
    assert (m.pga, m.pgv, m.arias, m.duration_5_95) == (0.0, 0.0, 0.0, 0.0)
