import numpy as np
import pytest

from impactfem.motion import STANDARD_GRAVITY, Accelerogram, measures


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
