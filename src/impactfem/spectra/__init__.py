"""Oscillators on a moving base, response spectra, and floor response spectra as a product."""

from impactfem.spectra.design import broaden, clip_peaks, corner_frequencies, rigid_frequency
from impactfem.spectra.frequency_list import (
    at_common_frequencies,
    interpolate_damping,
    interpolate_frequency,
    logarithmic_frequencies,
    merged_frequencies,
    rg_1_122_frequencies,
)
from impactfem.spectra.oscillator import oscillator_response
from impactfem.spectra.product import FloorSpectrumSet, Station
from impactfem.spectra.response_spectrum import (
    Method,
    ResponseSpectra,
    response_spectra,
    sampling_loss,
)
from impactfem.spectra.statistics import combine, fractile

__all__ = [
    "FloorSpectrumSet",
    "Method",
    "ResponseSpectra",
    "Station",
    "at_common_frequencies",
    "broaden",
    "clip_peaks",
    "combine",
    "corner_frequencies",
    "fractile",
    "interpolate_damping",
    "interpolate_frequency",
    "logarithmic_frequencies",
    "merged_frequencies",
    "oscillator_response",
    "response_spectra",
    "rg_1_122_frequencies",
    "rigid_frequency",
    "sampling_loss",
]
