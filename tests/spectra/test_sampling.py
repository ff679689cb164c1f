import numpy as np
import pytest

from impactfem.spectra import response_spectra, sampling_loss

FREQUENCY, DAMPING = 10.0, 0.02


def resonant_loss(n: float, phase: float) -> float:
    """Loss of the steady peak 1 / 2ζ under a sine of amplitude one with n samples in a cycle."""
    time = np.arange(int(100 * n)) / (n * FREQUENCY)
    record = np.sin(2.0 * np.pi * FREQUENCY * time + phase)
    record *= np.minimum(1.0, time * FREQUENCY / 30.0)
    # The free vibration behind the record is exact: it must not hold the peak.
    record *= np.minimum(1.0, np.maximum(0.0, time[-1] - time) * FREQUENCY / 30.0)
    found = response_spectra(record, time[1], [FREQUENCY], [DAMPING], points_per_cycle=2.0)
    return 1.0 - float(found.psa[0, 0, 0]) * 2.0 * DAMPING


@pytest.mark.parametrize("n", [4.0, 8.0, 20.0])
def test_no_phase_loses_more(n: float) -> None:
    losses = [resonant_loss(n, phase) for phase in np.linspace(0.0, 2.0 * np.pi / n, 9)]
    steady = 0.02  # of the peak is not reached within the record
    assert max(losses) <= float(sampling_loss(n)) + steady
    # Nor much less in the worst phase: cos(π/n) alone is no bound.
    assert max(losses) >= float(sampling_loss(n)) - 0.02
    if n < 5.0:
        assert max(losses) > 1.0 - np.cos(np.pi / n) + 0.05


def test_ends() -> None:
    assert sampling_loss([2.0, 1.0]) == pytest.approx([1.0, 1.0])
    assert float(sampling_loss(1e4)) == pytest.approx(0.0, abs=1e-6)
