"""The case file: what is studied, read from TOML and CSV with units, checked as a whole."""

from impactfem.case.analysis import FrequencyGrid, Pounding, Spectra
from impactfem.case.buildings import (
    BeamGroup,
    Building,
    FileMesh,
    FrequencyFit,
    GeneratedMesh,
    Parapet,
    ShellGroup,
    Structure,
    structure_files,
)
from impactfem.case.calibration import Calibration, Target, WallImpactSetup
from impactfem.case.contacts import (
    Contact,
    ContactLaw,
    ContactPoint,
    HertzDampLaw,
    HertzLaw,
    HuntCrossleyLaw,
    JankowskiLaw,
    KelvinVoigtLaw,
    UnilateralLaw,
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
from impactfem.case.floors import Floor, Material
from impactfem.case.load import load_case
from impactfem.case.members import Bay, Beam, Column, Wall
from impactfem.case.model import Case
from impactfem.case.motions import Ensemble, Motion, RecordMotion, SyntheticMotion, motion_files
from impactfem.case.report import Published
from impactfem.case.transient import Probe, Transient, transient_files

__all__ = [
    "BaseStiffness",
    "Bay",
    "Beam",
    "BeamGroup",
    "Building",
    "Calibration",
    "Case",
    "Column",
    "Contact",
    "ContactLaw",
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
    "Ensemble",
    "EurocodeSpectrum",
    "FileMesh",
    "Floor",
    "FrequencyFit",
    "FrequencyGrid",
    "GeneratedMesh",
    "HertzDampLaw",
    "HertzLaw",
    "HuntCrossleyLaw",
    "JankowskiLaw",
    "KelvinVoigtLaw",
    "Material",
    "Motion",
    "Parapet",
    "Pounding",
    "Probe",
    "Published",
    "RecordMotion",
    "ShellGroup",
    "Spectra",
    "Structure",
    "SyntheticMotion",
    "TableSpectrum",
    "Target",
    "Transient",
    "UnilateralLaw",
    "Wall",
    "WallImpactSetup",
    "load_case",
    "motion_files",
    "structure_files",
    "transient_files",
]
