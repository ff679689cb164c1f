import mpmath
import numpy as np
import pytest

from impactfem.spectra.recurrence import phi_functions, step_coefficients
from impactfem.system.errors import ImpactfemError


@pytest.mark.parametrize("size", [1e-12, 1e-6, 1e-3, 0.3, 0.999, 1.001, 3.0, 40.0, 600.0])
@pytest.mark.parametrize("damping", [0.0, 0.05, 0.7, 0.999])
def test_phi_functions_keep_both_parts_to_round_off(size, damping):
    y = size * complex(-damping, np.sqrt(1.0 - damping**2))
    phi1, phi2 = phi_functions(np.array([y]))
    with mpmath.workdps(60):
        ym = mpmath.mpc(y)
        exact1 = (mpmath.exp(ym) - 1) / ym
        exact2 = (mpmath.exp(ym) - 1 - ym) / ym**2
    # A zero of φ1 on the imaginary axis (y = 2πik) allows no relative bound of its own.
    for got, exact in ((phi1[0], complex(exact1)), (phi2[0], complex(exact2))):
        assert got.real == pytest.approx(exact.real, rel=1e-13, abs=1e-15 * abs(exact))
        tight = 0.0 if size < 1.0 else 1e-15 * abs(exact)
        assert got.imag == pytest.approx(exact.imag, rel=2e-13, abs=tight)


def test_the_naive_form_would_not_pass_that_check():
    y = 1e-6j
    naive = (np.exp(y) - 1.0 - y) / y**2
    assert abs(naive - phi_functions(np.array([y]))[1][0]) > 1e-6


def test_undamped_free_vibration_neither_grows_nor_decays():
    c = step_coefficients(0.01, [0.01, 1.0, 30.0, 400.0], [0.0])
    assert np.abs(c.propagator) == pytest.approx(1.0, abs=4e-16)


def test_dampings_are_outside_and_frequencies_inside():
    c = step_coefficients(0.01, [1.0, 2.0, 3.0], [0.0, 0.5])
    assert c.xi.tolist() == [0.0, 0.0, 0.0, 0.5, 0.5, 0.5]
    assert c.omega / (2 * np.pi) == pytest.approx([1, 2, 3, 1, 2, 3])


@pytest.mark.parametrize(
    ("step", "frequency", "damping", "message"),
    [
        (0.0, 1.0, 0.05, "time step must be positive"),
        (-0.01, 1.0, 0.05, "time step must be positive"),
        (float("nan"), 1.0, 0.05, "time step must be positive"),
        (0.01, 0.0, 0.05, "positive finite numbers in Hz"),
        (0.01, float("inf"), 0.05, "positive finite numbers in Hz"),
        (0.01, [], 0.05, "positive finite numbers in Hz"),
        (0.01, 1.0, 1.0, "over-damped"),
        (0.01, 1.0, 5.0, "0 <= ratio < 1"),
        (0.01, 1.0, -0.01, "0 <= ratio < 1"),
        (0.01, 1.0, float("nan"), "0 <= ratio < 1"),
    ],
)
def test_out_of_range_is_refused(step, frequency, damping, message):
    with pytest.raises(ImpactfemError, match=message):
        step_coefficients(step, frequency, damping)
