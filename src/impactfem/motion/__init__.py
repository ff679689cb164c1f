"""Ground motion: treatment of records, design spectra, synthesis, acceptance."""

from impactfem.motion.acceptance import (
    CORRELATION_LIMIT,
    Acceptance,
    Criteria,
    Misfit,
    Verdict,
    acceptance,
    pair_correlation,
    spectral_misfit,
)
from impactfem.motion.design_spectrum import (
    DesignSpectrum,
    TableSpectrum,
    Target,
    decree_spectrum,
    eurocode_spectrum,
)
from impactfem.motion.power_spectrum import (
    compatible_power_spectrum,
    power_spectrum,
    rg160_power_spectrum,
    strong_phase,
)
from impactfem.motion.synthesis import SyntheticMotion, synthesise
from impactfem.motion.treatment import Treatment, resampled
from impactfem.records import read_record
from impactfem.records.accelerogram import STANDARD_GRAVITY, Accelerogram, Measures, measures
from impactfem.records.csv import write_csv

__all__ = [
    "CORRELATION_LIMIT",
    "STANDARD_GRAVITY",
    "Accelerogram",
    "Acceptance",
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
