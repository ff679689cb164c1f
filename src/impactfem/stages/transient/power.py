"""Power spectral densities of records and of single impacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Array = NDArray[np.float64]

SEGMENT = 1.0
"""Length of the segments of a record [s]."""
SILENT = 1e-6
"""Part of the largest force below which nothing acts any more."""
RESOLUTION = 0.5
"""Spacing of the frequencies of an impact's spectrum, which is smooth [Hz]."""


@dataclass(frozen=True, eq=False)
class ForceSpectra:
    """Power spectral densities of the main impacts.

    Args:
        frequency: Shape (n_f,) [Hz].
        density: One-sided, shape (n_forces, n_f) [N²/Hz].
        duration: Over which the power is taken [s].
    """

    frequency: Array
    density: Array
    duration: float


def power_spectrum(record: Array, time_step: float) -> tuple[Array, Array]:
    """One-sided power spectral density by Welch's method, Hann windows that overlap by half.

    Args:
        record: Shape (n,).
        time_step: Δt [s].

    Returns:
        Frequencies [Hz] and densities [unit of the record squared per Hz].
    """
    frequency, density = signal.welch(
        record,
        fs=1.0 / time_step,
        window="hann",
        nperseg=min(len(record), round(SEGMENT / time_step)),
        detrend=False,
    )
    return np.asarray(frequency), np.asarray(density)


def force_spectra(force: Array, time_step: float) -> ForceSpectra:
    """Spectra of the main impact of each force, alone and over the same duration.

    S(f) = 2 |Δt Σ_n F_n e^(−2πi f n Δt)|² / T, with the duration T of the longest of the impacts:
    so the densities of the forces can be compared.

    Args:
        force: Shape (n_t, n_forces) [N].
        time_step: Δt [s].
    """
    impacts = [main_impact(column) for column in force.T]
    longest = max(last - first for first, last in impacts)
    count = max(longest, round(1.0 / (RESOLUTION * time_step)))
    densities = []
    frequency = np.fft.rfftfreq(count, time_step)
    for (first, last), column in zip(impacts, force.T, strict=True):
        alone = np.zeros(longest)
        alone[: last - first] = column[first:last]
        frequency, density = signal.periodogram(
            alone, fs=1.0 / time_step, window="boxcar", nfft=count, detrend=False
        )
        densities.append(density)
    return ForceSpectra(np.asarray(frequency), np.array(densities), longest * time_step)


def main_impact(force: Array) -> tuple[int, int]:
    """First sample, and the one behind the last, of the impact with the largest force.

    Args:
        force: Positive in compression; the impact ends where nothing acts, tension included,
            shape (n_t,) [N].
    """
    peak = int(np.argmax(np.abs(force)))
    silent = np.flatnonzero(np.abs(force) <= SILENT * abs(force[peak]))
    before, after = silent[silent < peak], silent[silent > peak]
    first = int(before[-1]) + 1 if before.size else 0
    last = int(after[0]) if after.size else len(force)
    return first, last
