"""The case file: what is studied, read from TOML and CSV with units, checked as a whole."""

from impactfem.case.analysis import FrequencyGrid, Pounding, Spectra
from impactfem.case.buildings import Building
from impactfem.case.calibration import Calibration
from impactfem.case.contacts import (
    Contact,
    ContactLaw,
    ContactPoint,
    HertzDampLaw,
    HertzLaw,
    HuntCrossleyLaw,
    JankowskiLaw,
    KelvinVoigtLaw,
)
from impactfem.case.damping import Damping
from impactfem.case.design_spectrum import (
    DecreeSpectrum,
    DesignSpectrum,
    EurocodeSpectrum,
    TableSpectrum,
)
from impactfem.case.ensemble import Ensemble
from impactfem.case.floors import Floor
from impactfem.case.load import load_case
from impactfem.case.materials import Material
from impactfem.case.model import Case
from impactfem.case.motions import Motion, RecordMotion, SyntheticMotion, motion_files
from impactfem.case.published import Published
from impactfem.case.targets import Target

__all__ = [
    "Building",
    "Calibration",
    "Case",
    "Contact",
    "ContactLaw",
    "ContactPoint",
    "Damping",
    "DecreeSpectrum",
    "DesignSpectrum",
    "Ensemble",
    "EurocodeSpectrum",
    "Floor",
    "FrequencyGrid",
    "HertzDampLaw",
    "HertzLaw",
    "HuntCrossleyLaw",
    "JankowskiLaw",
    "KelvinVoigtLaw",
    "Material",
    "Motion",
    "Pounding",
    "Published",
    "RecordMotion",
    "Spectra",
    "SyntheticMotion",
    "TableSpectrum",
    "Target",
    "load_case",
    "motion_files",
]
