"""The case: as written in its file, and as the stages use it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from impactfem.case.analysis import Pounding, Spectra
from impactfem.case.base import Section, Written
from impactfem.case.buildings import Building
from impactfem.case.calibration import Calibration
from impactfem.case.contacts import Contact, ContactEntry, ContactLawEntry, expand
from impactfem.case.damping import Damping, DampingCase
from impactfem.case.device_analysis import DeviceAnalysis
from impactfem.case.devices import DeviceSetup
from impactfem.case.ensemble import Ensemble
from impactfem.case.floors import Material
from impactfem.case.leaf import File, Key, Text
from impactfem.case.loads import FloorForces
from impactfem.case.motions import Motion, MotionEntry
from impactfem.case.report import PUBLISHED_FILE, Published, Report
from impactfem.case.structure import Structure
from impactfem.case.transient import Transient
from impactfem.case.wall_impact import WallImpactSetup


class CaseFile(Section):
    """A case of impactfem: buildings side by side, a ground motion, and what is computed."""

    extends: File | None = None
    """Another case file, which this one is laid over: it says only what differs."""
    title: Text
    """Title of the case, for the report and the figures."""
    published: Annotated[dict[str, Published], PUBLISHED_FILE] = Field(default={})
    """Table of published values (CSV), put beside the results in summary.json."""
    materials: dict[Key, Material]
    """Materials by name."""
    damping: Damping
    """Rayleigh damping of all buildings without their own."""
    damping_cases: tuple[DampingCase, ...] = ()
    """Further dampings of all buildings; none: the study is done once."""
    buildings: tuple[Building, ...] = Field(min_length=1)
    """The buildings."""
    calibration: Calibration | None = None
    """Calibration of the sticks; left out, they are taken as given."""
    wall_impact: WallImpactSetup | None = None
    """The impact of the 3D model on a rigid wall, which needs a [buildings.structure]; left out,
    there is none."""
    transient: Transient | None = None
    """The response of the 3D model in time, which needs a [buildings.structure]; left out, it is
    not computed."""
    devices: tuple[DeviceSetup, ...] = ()
    """Devices on floors of the 3D model, which need a [buildings.structure] and [transient]."""
    device_analysis: DeviceAnalysis | None = None
    """How the forces on their anchors are computed."""
    motions: Annotated[tuple[Motion, ...], Written(tuple[MotionEntry, ...], tuple)] = ()
    """The ground motions, one a direction; with [[loads]] they may be left out, and the ground
    rests."""
    loads: tuple[FloorForces, ...] = ()
    """Forces on floors in addition to the ground motion."""
    contact_laws: dict[Key, ContactLawEntry] = Field(default={})
    """Laws of the contact force by name."""
    contacts: Annotated[tuple[Contact, ...], Written(tuple[ContactEntry, ...], expand)] = ()
    """Pairs of points that may touch; none: the buildings never pound."""
    pounding: Pounding
    """Time integration of the sticks."""
    spectra: Spectra
    """Response spectra of the floors."""
    ensemble: Ensemble | None = None
    """Ensemble of motions; left out, there is none."""
    report: Report = Field(default_factory=Report)
    """What the report of the run says beside the results."""


class Case(CaseFile):
    """A case that was read and found free of faults: SI values, names resolved, tables read.

    Files are relative to the working folder. With loads alone there is one motion, of ground at
    rest; without devices there is no device_analysis; published values know by the reference of
    the report what ours are beside them.

    Args:
        structure: The 3D model of a building, or None.
        path: The case file.
        digest: SHA-256 of the case text, of those it extends and of all files they name, as
            hexadecimal digits.
    """

    structure: Structure | None
    path: Path
    digest: str

    def content_hash(self) -> str:
        """SHA-256 of the case texts and of every file they name, as they were when read."""
        return self.digest

    @property
    def shown_direction(self) -> str:
        """The direction "x", "y" or "z" of the motions that results are told along.

        The one in which the buildings pound: that of the motion most along a normal of the
        contacts; without contacts, or among equals, that of the first motion.
        """

        def along(direction: str) -> float:
            axis = "xyz".index(direction)
            return max((abs(contact.normal[axis]) for contact in self.contacts), default=0.0)

        return max((motion.direction for motion in self.motions), key=along)

    @property
    def wave_floor(self) -> int:
        """The floor of the 3D model that waves are looked at in: the highest that may be struck.

        Without contacts it is the top floor.

        Raises:
            ValueError: The case has no structure.
        """
        if self.structure is None:
            raise ValueError("the case has no structure")
        name = self.structure.building
        ends = [end for contact in self.contacts for end in (contact.a, contact.b)]
        struck = [end.floor for end in ends if end.building == name and end.floor is not None]
        return max(struck, default=self.building(name).floors[-1].floor)

    def building(self, name: str) -> Building:
        """The building of a name.

        Raises:
            KeyError: There is no such building.
        """
        for building in self.buildings:
            if building.name == name:
                return building
        raise KeyError(name)
