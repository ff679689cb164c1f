import mpmath
import numpy as np
import pytest

from impactfem.spectra.oscillator import oscillator_response, phi, step_coefficients


@pytest.mark.parametrize("size", [1e-12, 1e-6, 1e-3, 0.3, 0.999, 1.001, 3.0, 40.0, 600.0])
@pytest.mark.parametrize("damping", [0.0, 0.05, 0.7, 0.999])
def test_phi_functions_keep_both_parts_to_round_off(size, damping):
    y = size * complex(-damping, np.sqrt(1.0 - damping**2))
    with mpmath.workdps(60):
        ym = mpmath.mpc(y)
        exact1 = (mpmath.exp(ym) - 1) / ym
        exact2 = (mpmath.exp(ym) - 1 - ym) / ym**2
    # A zero of φ1 on the imaginary axis (y = 2πik) allows no relative bound of its own.
    for got, exact in ((phi(y, 1), complex(exact1)), (phi(y, 2), complex(exact2))):
        assert got.real == pytest.approx(exact.real, rel=1e-13, abs=1e-15 * abs(exact))
        tight = 0.0 if size < 1.0 else 1e-15 * abs(exact)
        assert got.imag == pytest.approx(exact.imag, rel=2e-13, abs=tight)


def test_the_naive_form_would_not_pass_that_check():
    y = 1e-6j
    naive = (np.exp(y) - 1.0 - y) / y**2
    assert abs(naive - phi(y, 2)) > 1e-6


def test_dampings_are_outside_and_frequencies_inside():
    c = step_coefficients(0.01, [1.0, 2.0, 300.0], [0.0, 0.5])
    assert c.xi.tolist() == [0.0, 0.0, 0.0, 0.5, 0.5, 0.5]
    assert c.omega / (2 * np.pi) == pytest.approx([1, 2, 300, 1, 2, 300])
    # Undamped free vibration neither grows nor decays.
    assert np.abs(c.propagator[:3]) == pytest.approx(1.0, abs=4e-16)


def exact_history(a, h, frequency, damping):
    """x, x', x''+a with 40 digits: the exponential of the system augmented by the ramp."""
    with mpmath.workdps(40):
        w = 2 * mpmath.pi * mpmath.mpf(frequency)
        xi = mpmath.mpf(damping)
        system = mpmath.matrix(
            [[0, 1, 0, 0], [-(w**2), -2 * xi * w, -1, 0], [0, 0, 0, 1], [0, 0, 0, 0]]
        )
        e = mpmath.expm(system * mpmath.mpf(h), method="taylor")
        x, v, rows = mpmath.mpf(0), mpmath.mpf(0), []
        for i, ai in enumerate(a):
            rows.append((x, v, -2 * xi * w * v - w**2 * x))
            slope = (mpmath.mpf(a[i + 1]) - mpmath.mpf(ai)) / mpmath.mpf(h) if i + 1 < len(a) else 0
            y = e * mpmath.matrix([x, v, mpmath.mpf(ai), slope])
            x, v = y[0], y[1]
        return np.array(rows, dtype=float).T


@pytest.mark.parametrize("frequency", [1e-4, 0.1, 5.0, 95.0, 430.0])
@pytest.mark.parametrize("damping", [0.0, 0.05, 0.7, 0.999])
def test_exact_on_piecewise_linear_input(frequency, damping):
    h = 0.005
    a = np.random.default_rng(3).standard_normal(60)
    response = oscillator_response(a, h, [frequency], [damping])
    names = ("relative_displacement", "relative_velocity", "absolute_acceleration")
    for name, reference in zip(names, exact_history(a, h, frequency, damping), strict=True):
        got = getattr(response, name)
        assert got.shape == (1, 1, a.size)
        assert np.abs(got[0, 0] - reference).max() <= 1e-12 * np.abs(reference).max()


def test_a_central_difference_would_not_pass_that_check():
    h, w = 0.005, 2 * np.pi * 5.0
    a = np.random.default_rng(3).standard_normal(60)
    x = np.zeros(a.size)
    for i in range(1, a.size - 1):
        x[i + 1] = 2 * x[i] - x[i - 1] - h**2 * (a[i] + w**2 * x[i])
    exact = exact_history(a, h, 5.0, 0.0)[0]
    assert np.abs(x - exact).max() > 1e-3 * np.abs(exact).max()


def test_step_of_the_base():
    w, xi, h = 2 * np.pi * 3.0, 0.1, 0.02
    response = oscillator_response(np.full(200, 1.5), h, [3.0], [xi])
    t = response.time
    wd = w * np.sqrt(1 - xi**2)
    decay = np.exp(-xi * w * t)
    x = -1.5 / w**2 * (1 - decay * (np.cos(wd * t) + xi * w / wd * np.sin(wd * t)))
    v = -1.5 / wd * decay * np.sin(wd * t)
    assert response.relative_displacement[0, 0] == pytest.approx(x, abs=1e-15)
    assert response.relative_velocity[0, 0] == pytest.approx(v, abs=1e-14)


def test_resonant_sine_in_steady_state():
    # Harmonic base motion at resonance: |x| = a / (2 ξ ω²), |x'' + a| = a √(1 + 1/(4ξ²)).
    xi, f, h = 0.05, 2.0, 1e-4
    t = np.arange(int(40.0 / h)) * h
    response = oscillator_response(np.sin(2 * np.pi * f * t), h, [f], [xi])
    late = t > 36.0
    w = 2 * np.pi * f
    x = np.abs(response.relative_displacement[0, 0, late]).max()
    a = np.abs(response.absolute_acceleration[0, 0, late]).max()
    assert x == pytest.approx(1 / (2 * xi * w**2), rel=1e-6)
    assert a == pytest.approx(np.sqrt(1 + 1 / (4 * xi**2)), rel=1e-6)
