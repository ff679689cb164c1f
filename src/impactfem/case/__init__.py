"""The case file: what is studied, read from TOML and CSV with units, checked as a whole."""

from impactfem.case.analysis import Spectra
from impactfem.case.buildings import Building, FileMesh
from impactfem.case.contacts import Contact, ContactPoint, KelvinVoigtLaw
from impactfem.case.damping import DampingCase, DampingEntry, RayleighDamping
from impactfem.case.devices import DeviceAnalysis, DeviceSetup
from impactfem.case.load import load_case
from impactfem.case.model import Building3D, BuildingAtWall, BuildingInTime, Case
from impactfem.case.motions import Motion, RecordMotion, SyntheticMotion, motion_files
from impactfem.case.report import Published

__all__ = [
    "Building",
    "Building3D",
    "BuildingAtWall",
    "BuildingInTime",
    "Case",
    "Contact",
    "ContactPoint",
    "DampingCase",
    "DampingEntry",
    "DeviceAnalysis",
    "DeviceSetup",
    "FileMesh",
    "KelvinVoigtLaw",
    "Motion",
    "Published",
    "RayleighDamping",
    "RecordMotion",
    "Spectra",
    "SyntheticMotion",
    "load_case",
    "motion_files",
]
