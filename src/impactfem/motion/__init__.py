"""Ground motion: accelerograms, their measures, records, design spectra, synthesis."""

from impactfem.motion.accelerogram import Accelerogram
from impactfem.motion.csv_record import write_csv
from impactfem.motion.design_spectrum import DesignSpectrum
from impactfem.motion.measures import STANDARD_GRAVITY, Measures, measures
from impactfem.motion.misfit import Misfit, spectral_misfit
from impactfem.motion.record import read_record
from impactfem.motion.synthesis import SyntheticMotion, synthesise

__all__ = [
    "STANDARD_GRAVITY",
    "Accelerogram",
    "DesignSpectrum",
    "Measures",
    "Misfit",
    "SyntheticMotion",
    "measures",
    "read_record",
    "spectral_misfit",
    "synthesise",
    "write_csv",
]
