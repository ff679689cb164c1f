"""The case file: what is studied, read from TOML and CSV with units, checked as a whole."""

from impactfem.case.analysis import FrequencyGrid, Pounding, Spectra
from impactfem.case.bays import Bay
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
from impactfem.case.damping_cases import DampingCase
from impactfem.case.design_spectrum import (
    DecreeSpectrum,
    DesignSpectrum,
    EurocodeSpectrum,
    TableSpectrum,
)
from impactfem.case.device_analysis import DeviceAnalysis
from impactfem.case.device_modes import DeviceMode
from impactfem.case.device_stiffness import BaseStiffness, DeviceBeam
from impactfem.case.devices import Cylinder, DeviceSetup
from impactfem.case.ensemble import Ensemble
from impactfem.case.file_mesh import BeamGroup, FileMesh, ShellGroup
from impactfem.case.floors import Floor
from impactfem.case.generated_mesh import Acroterion, GeneratedMesh
from impactfem.case.load import load_case
from impactfem.case.materials import Material
from impactfem.case.members import Beam, Column, Wall
from impactfem.case.model import Case
from impactfem.case.motions import Motion, RecordMotion, SyntheticMotion, motion_files
from impactfem.case.probe import Probe
from impactfem.case.published import Published
from impactfem.case.structure import FrequencyFit, Structure, structure_files
from impactfem.case.targets import Target
from impactfem.case.transient import Transient, transient_files
from impactfem.case.wall_impact import WallImpactSetup

__all__ = [
    "Acroterion",
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
    "Wall",
    "WallImpactSetup",
    "load_case",
    "motion_files",
    "structure_files",
    "transient_files",
]
