"""Oscillators on a moving base: exact histories, response spectra, frequency lists."""

from impactfem.spectra.frequency_list import logarithmic_frequencies
from impactfem.spectra.oscillator import OscillatorResponse, oscillator_response
from impactfem.spectra.response_spectrum import Method, ResponseSpectra, response_spectra

__all__ = [
    "Method",
    "OscillatorResponse",
    "ResponseSpectra",
    "logarithmic_frequencies",
    "oscillator_response",
    "response_spectra",
]
