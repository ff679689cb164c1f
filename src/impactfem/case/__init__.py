"""The case file: what is studied, read from TOML and CSV with units, checked as a whole."""

from impactfem.case.analysis import FrequencyGrid, Spectra
from impactfem.case.buildings import Building, FileMesh, GeneratedMesh, structure_files
from impactfem.case.calibration import WallImpactSetup
from impactfem.case.contacts import (
    Contact,
    ContactPoint,
    HertzDampLaw,
    HertzLaw,
    HuntCrossleyLaw,
    JankowskiLaw,
    KelvinVoigtLaw,
)
from impactfem.case.damping import Damping, DampingCase
from impactfem.case.design_spectrum import (
    DecreeSpectrum,
    DesignSpectrum,
    EurocodeSpectrum,
    TableSpectrum,
)
from impactfem.case.device_tables import DeviceMode
from impactfem.case.devices import BaseStiffness, Cylinder, DeviceAnalysis, DeviceBeam, DeviceSetup
from impactfem.case.load import load_case
from impactfem.case.model import Case
from impactfem.case.motions import Motion, RecordMotion, SyntheticMotion, motion_files
from impactfem.case.report import Published
from impactfem.case.transient import Probe, Transient, transient_files

__all__ = [
    "BaseStiffness",
    "Building",
    "Case",
    "Contact",
    "ContactPoint",
    "Cylinder",
    "Damping",
    "DampingCase",
    "DecreeSpectrum",
    "DesignSpectrum",
    "DeviceAnalysis",
    "DeviceBeam",
    "DeviceMode",
    "DeviceSetup",
    "EurocodeSpectrum",
    "FileMesh",
    "FrequencyGrid",
    "GeneratedMesh",
    "HertzDampLaw",
    "HertzLaw",
    "HuntCrossleyLaw",
    "JankowskiLaw",
    "KelvinVoigtLaw",
    "Motion",
    "Probe",
    "Published",
    "RecordMotion",
    "Spectra",
    "SyntheticMotion",
    "TableSpectrum",
    "Transient",
    "WallImpactSetup",
    "load_case",
    "motion_files",
    "structure_files",
    "transient_files",
]
