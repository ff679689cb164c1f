"""The case: as written in its file, and as the stages use it."""

from __future__ import annotations

from pathlib import Path

from pydantic import Field, field_validator

from impactfem.case.analysis import Pounding, Spectra
from impactfem.case.base import Section
from impactfem.case.buildings import Building, BuildingEntry
from impactfem.case.calibration import Calibration, CalibrationEntry
from impactfem.case.contacts import Contact, ContactEntry, ContactLaw, ContactLawEntry, expand
from impactfem.case.damping import Damping
from impactfem.case.damping_cases import DampingCase
from impactfem.case.device_analysis import DeviceAnalysis
from impactfem.case.devices import DeviceEntry, DeviceSetup
from impactfem.case.ensemble import Ensemble
from impactfem.case.leaf import File, Key, Text, refuse
from impactfem.case.loads import FloorForces
from impactfem.case.materials import Material
from impactfem.case.motions import Motion, MotionEntry
from impactfem.case.published import Published
from impactfem.case.report import Report, ReportEntry
from impactfem.case.structure import Structure, StructureEntry
from impactfem.case.transient import Transient
from impactfem.case.wall_impact import WallImpactEntry, WallImpactSetup


class CaseFile(Section):
    """A case of impactfem: buildings side by side, a ground motion, and what is computed."""

    extends: File | None = Field(
        default=None,
        description="Another case file, which this one is laid over: it says only what differs.",
    )
    title: Text = Field(description="Title of the case, for the report and the figures.")
    published: File | None = Field(
        default=None,
        description="Table of published values (CSV), put beside the results in summary.json.",
    )
    materials: dict[Key, Material] = Field(description="Materials by name.")
    damping: Damping = Field(description="Rayleigh damping of all buildings without their own.")
    damping_cases: tuple[DampingCase, ...] = Field(
        default=(), description="Further dampings of all buildings; none: the study is done once."
    )
    buildings: tuple[BuildingEntry, ...] = Field(min_length=1, description="The buildings.")
    calibration: CalibrationEntry | None = Field(
        default=None, description="Calibration of the sticks; left out, they are taken as given."
    )
    structure: StructureEntry | None = Field(
        default=None, description="The 3D model of one building; left out, there is none."
    )
    wall_impact: WallImpactEntry | None = Field(
        default=None,
        description="The impact of the 3D model on a rigid wall, which needs [structure]; left "
        "out, there is none.",
    )
    transient: Transient | None = Field(
        default=None,
        description="The response of the 3D model in time, which needs [structure]; left out, it "
        "is not computed.",
    )
    devices: tuple[DeviceEntry, ...] = Field(
        default=(),
        description="Devices on floors of the 3D model, which need [structure] and [transient].",
    )
    device_analysis: DeviceAnalysis | None = Field(
        default=None, description="How the forces on their anchors are computed."
    )
    motions: tuple[MotionEntry, ...] = Field(
        default=(),
        description="The ground motions, one a direction; with [[loads]] they may be left out, "
        "and the ground rests.",
    )
    loads: tuple[FloorForces, ...] = Field(
        default=(), description="Forces on floors in addition to the ground motion."
    )
    contact_laws: dict[Key, ContactLawEntry] = Field(
        default={}, description="Laws of the contact force by name."
    )
    contacts: tuple[ContactEntry, ...] = Field(
        default=(), description="Pairs of points that may touch; none: the buildings never pound."
    )
    pounding: Pounding = Field(description="Time integration of the sticks.")
    spectra: Spectra = Field(description="Response spectra of the floors.")
    ensemble: Ensemble | None = Field(
        default=None, description="Ensemble of motions; left out, there is none."
    )
    report: ReportEntry | None = Field(
        default=None, description="What the report of the run says beside the results."
    )

    @field_validator("contacts")
    @classmethod
    def _each_pair_once(cls, value: tuple[ContactEntry, ...]) -> tuple[ContactEntry, ...]:
        """The same two points twice would double the stiffness of their contact unseen."""
        seen = set()
        for contact in expand(value):
            points = (contact.a, contact.b)
            if points in seen:
                raise refuse(
                    f"expected each pair of points once, found {contact.a.label} and "
                    f"{contact.b.label} twice"
                )
            seen.add(points)
        return value


class Case(Section):
    """A case that was read and found free of faults: SI values, names resolved, tables read.

    Args:
        path: The case file.
        title: Title of the case.
        materials: Materials by name.
        damping: Damping of the case; each building carries the one that holds for it.
        damping_cases: Further dampings, each of all buildings. A restitution "calibrated" in a case
            without wall impact stands for those of the contact laws.
        buildings: The buildings with their material, floors and damping.
        calibration: The calibration with its targets, or None.
        structure: The 3D model of one building, or None.
        wall_impact: Its impact on a rigid wall, or None.
        transient: Its response in time, or None; the forces are relative to the working folder.
        devices: The devices on its floors, with their tables.
        device_analysis: How the forces on their anchors are computed; None without devices.
        motions: The ground motions; a record's file is relative to the working folder. With loads
            alone there is one of ground at rest.
        loads: Forces on floors; their files are relative to the working folder.
        contact_laws: Contact laws by name.
        contacts: One contact for each pair of points.
        pounding: Time integration.
        spectra: Response spectra.
        ensemble: The ensemble of motions, or None.
        report: What the report says beside the results.
        published: Published values in SI by the name of the result.
        digest: SHA-256 of the case text, of those it extends and of all files they name, as
            hexadecimal digits.
    """

    path: Path
    title: str
    materials: dict[str, Material]
    damping: Damping
    damping_cases: tuple[DampingCase, ...]
    buildings: tuple[Building, ...]
    calibration: Calibration | None
    structure: Structure | None
    wall_impact: WallImpactSetup | None
    transient: Transient | None
    devices: tuple[DeviceSetup, ...]
    device_analysis: DeviceAnalysis | None
    motions: tuple[Motion, ...]
    loads: tuple[FloorForces, ...]
    contact_laws: dict[str, ContactLaw]
    contacts: tuple[Contact, ...]
    pounding: Pounding
    spectra: Spectra
    ensemble: Ensemble | None
    report: Report
    published: dict[str, Published]
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
