"""Ground motion: accelerograms, their measures, records, design spectra, synthesis, acceptance."""

from impactfem.motion.accelerogram import Accelerogram
from impactfem.motion.acceptance import Acceptance, Criteria, Verdict, acceptance
from impactfem.motion.correlation import Correlation, pair_correlation
from impactfem.motion.csv_record import write_csv
from impactfem.motion.decree import decree_spectrum
from impactfem.motion.design_spectrum import DesignSpectrum
from impactfem.motion.eurocode import eurocode_spectrum
from impactfem.motion.measures import STANDARD_GRAVITY, Measures, measures
from impactfem.motion.misfit import Misfit, spectral_misfit
from impactfem.motion.power_spectrum import (
    compatible_power_spectrum,
    power_spectrum,
    rg160_power_spectrum,
    strong_phase,
)
from impactfem.motion.record import read_record
from impactfem.motion.resampling import resampled
from impactfem.motion.synthesis import SyntheticMotion, synthesise
from impactfem.motion.table_spectrum import TableSpectrum
from impactfem.motion.target import Target
from impactfem.motion.treatment import Treatment

__all__ = [
    "STANDARD_GRAVITY",
    "Accelerogram",
    "Acceptance",
    "Correlation",
    "Criteria",
    "DesignSpectrum",
    "Measures",
    "Misfit",
    "SyntheticMotion",
    "TableSpectrum",
    "Target",
    "Treatment",
    "Verdict",
    "acceptance",
    "compatible_power_spectrum",
    "decree_spectrum",
    "eurocode_spectrum",
    "measures",
    "pair_correlation",
    "power_spectrum",
    "read_record",
    "resampled",
    "rg160_power_spectrum",
    "spectral_misfit",
    "strong_phase",
    "synthesise",
    "write_csv",
]
