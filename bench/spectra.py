"""Speed of the response spectra: oscillators against a plain loop and a library."""

from __future__ import annotations

from bench.figure import Figure
from bench.throughput import measure_throughput


def spectrum_figures() -> list[Figure]:
    """Measure the kernel and what it is compared with."""
    rates = measure_throughput()
    unit = "record·frequency·sample/s"
    return [
        Figure("oscillator kernel, one core", rates.kernel, unit, 1.5e9, at_most=False),
        Figure("plain compiled scalar loop, one core", rates.plain_loop, unit),
        Figure("scipy lfilter, one core", rates.lfilter, unit),
        Figure("kernel over plain loop", rates.kernel / rates.plain_loop, "-"),
        Figure("kernel over lfilter", rates.kernel / rates.lfilter, "-"),
    ]
