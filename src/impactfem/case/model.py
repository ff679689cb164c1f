"""The case: as written in its file, as the stages use it, and its buildings with a 3D model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import Field

from impactfem.case.analysis import Pounding, Spectra
from impactfem.case.base import Section, Written
from impactfem.case.buildings import Building, Structure
from impactfem.case.calibration import Calibration, WallImpactSetup
from impactfem.case.capacities import Limits
from impactfem.case.contacts import (
    Contact,
    ContactEntry,
    ContactLawEntry,
    ContactSearch,
    expand,
)
from impactfem.case.damping import DampingCase, DampingEntry
from impactfem.case.devices import DeviceAnalysis, DeviceSetup
from impactfem.case.equipment import EQUIPMENT_FILE, Equipment
from impactfem.case.floors import Material
from impactfem.case.leaf import File, Key, OneOrMore, Text
from impactfem.case.motions import Ensemble, FloorForces, Motion, MotionEntry, WavePassage
from impactfem.case.report import PUBLISHED_FILE, Published, Report
from impactfem.case.sections import MemberSection
from impactfem.case.sensitivity import Sensitivity
from impactfem.case.transient import Probe, Transient
from impactfem.system.scalar import alone

Condition = Literal["gap", "depth", "overlap", "period", "steps", "direction", "stick"]
CONDITIONS: tuple[str, ...] = get_args(Condition)


class CaseFile(Section):
    """A case of impactfem: buildings side by side, a ground motion, and what is computed."""

    extends: File | None = None
    """Another case file that this one extends; state only the differences."""
    title: Text
    """Title of the case, for the report and the figures."""
    allow: Annotated[tuple[Condition, ...], OneOrMore()] = ()
    """Conditions that are errors without it and warnings with it: "gap", gaps that differ from axes
    and offsets by more than 1 mm (the gap is used); "depth", pairs of floors whose depths do not
    overlap; "overlap", buildings that overlap in plan; "period", a first period outside 0.02 to
    0.5 s a storey; "steps", fewer than 16 time steps in an impact; "direction", ground motion along
    no contact normal; "stick", a stick stiffer than the 3D model of its building by more than 20 %
    in the period."""
    published: Annotated[dict[str, Published], PUBLISHED_FILE] = Field(default={})
    """Table of published values (CSV), compared with the results in summary.json."""
    materials: dict[Key, Material]
    """Materials by name."""
    sections: dict[Key, MemberSection] = Field(default={})
    """Sections of beams and columns by name, in addition to the rolled sections."""
    damping: DampingEntry
    """Damping of all buildings without their own."""
    damping_cases: tuple[DampingCase, ...] = ()
    """Further dampings of all buildings, each a repetition of the study."""
    buildings: tuple[Building, ...] = Field(min_length=1)
    """The buildings."""
    calibration: Calibration | None = None
    """Calibration of the sticks; without it, the sticks are used as given."""
    wall_impact: WallImpactSetup | None = None
    """Impact of the 3D model on a rigid wall; requires [buildings.structure]."""
    transient: Transient | None = None
    """Time history of the 3D model; requires [buildings.structure]."""
    devices: tuple[DeviceSetup, ...] = ()
    """Devices on floors of the 3D model; require [buildings.structure] and [transient]."""
    device_analysis: DeviceAnalysis | None = None
    """Analysis of the forces on their anchors."""
    equipment: Annotated[tuple[Equipment, ...], EQUIPMENT_FILE] = ()
    """Equipment list (CSV): items on floors of sticks and 3D models, one row each, without effect
    on the buildings. `devices = "equipment.csv"` is the same."""
    motions: Annotated[tuple[Motion, ...], Written(tuple[MotionEntry, ...], tuple)] = ()
    """The ground motions, one for each direction; optional with [[loads]]."""
    wave_passage: WavePassage | None = None
    """Delay of the ground motion between buildings; without it, all move alike."""
    loads: tuple[FloorForces, ...] = ()
    """Forces on floors in addition to the ground motion."""
    contact_laws: dict[Key, ContactLawEntry] = Field(default={})
    """Laws of the contact force by name."""
    contacts: Annotated[tuple[Contact, ...], Written(tuple[ContactEntry, ...], expand)] = ()
    """Contact pairs; without any and without [contact_search], the buildings do not pound."""
    contact_search: ContactSearch | None = None
    """Contact pairs from plans, levels and depths."""
    pounding: Pounding
    """Models in contact and time integration."""
    spectra: Spectra
    """Response spectra of the floors."""
    limits: Limits = Field(default_factory=Limits)
    """Limits of gap, floor acceleration and storey drift, for the verdicts of the report."""
    ensemble: Ensemble | None = None
    """Ensemble of motions."""
    sensitivity: Sensitivity = Field(default_factory=Sensitivity)
    """Sensitivity of the verdicts to single parameters."""
    report: Report = Field(default_factory=Report)
    """Author, assumptions and published reference of the report."""


class Case(CaseFile):
    """A case that was read and found free of faults: SI values, names resolved, tables read.

    Files are relative to the working folder. With loads alone there is one motion, of ground at
    rest; without devices there is no device_analysis; published values know by the reference of
    the report how ours relate to them.

    The stages of a 3D model take a building of `modelled`.

    Args:
        structure: The 3D model of the first building with one, or None.
        further_structures: The 3D models of further buildings.
        path: The case file.
        digest: SHA-256 of the case text, of those it extends and of all files they name, as
            hexadecimal digits.
        input_files: SHA-256 of each of these texts and files by its name there.
        model_sticks: Sticks that a run took from 3D models, by building; a stage adds them.
        reference_of: Name of the file below this one that names the reference of the report; ""
            where the case file does itself, or there is none.
        changes: Keys in which the case differs from that file, with dots.
    """

    structure: Structure | None
    further_structures: tuple[Structure, ...] = ()
    path: Path
    digest: str
    input_files: dict[str, str] = Field(default={}, exclude=True)
    model_sticks: dict[str, Any] = Field(default={}, exclude=True)
    reference_of: str = ""
    changes: tuple[str, ...] = ()

    @property
    def structures(self) -> tuple[Structure, ...]:
        """All 3D models."""
        return () if self.structure is None else (self.structure, *self.further_structures)

    @property
    def modelled(self) -> dict[str, Building3D]:
        """The buildings with a 3D model by name, in the order of the case."""
        return {one.building: Building3D.of(self, one) for one in self.structures}

    @property
    def in_time(self) -> tuple[BuildingInTime, ...]:
        """The buildings whose 3D model is computed in time."""
        return tuple(BuildingInTime(**vars(b)) for b in self.modelled.values() if b.transient)

    @property
    def at_wall(self) -> tuple[BuildingAtWall, ...]:
        """The buildings whose 3D model hits the rigid wall."""
        return tuple(BuildingAtWall(**vars(b)) for b in self.modelled.values() if b.wall_impact)

    @property
    def pounding_in_3d(self) -> tuple[str, ...]:
        """Names of the buildings whose 3D models pound."""
        models = self.pounding.models
        return tuple(one.name for one in self.buildings if models.get(one.name) == "structure")

    @property
    def sticks_on_models(self) -> tuple[str, ...]:
        """Names of the buildings whose sticks have the stiffness of their 3D models."""
        modelled = {one.building for one in self.structures}
        targets = () if self.calibration is None else self.calibration.targets
        fitted = {target.building for target in targets}
        default = {name: "own" if name in fitted else "structure" for name in modelled}
        return tuple(
            one.name
            for one in self.buildings
            if (one.stick or default.get(one.name)) == "structure" and one.name in modelled
        )

    def touches_in_3d(self, contact: Contact) -> bool:
        """Return True if a contact is along edges: of a building whose 3D model pounds."""
        return not {*contact.buildings}.isdisjoint(self.pounding_in_3d)

    @property
    def delays(self) -> dict[str, float]:
        """By building how much later the waves reach it than the first one that they reach [s]."""
        passage = self.wave_passage
        if passage is None:
            return {}
        (x, y), c = passage.direction, passage.apparent_velocity
        along = {one.name: (x * one.axis[0] + y * one.axis[1]) / c for one in self.buildings}
        return {name: at - min(along.values()) for name, at in along.items()}

    def computed_time(self, longest: float) -> float:
        """Time of the pounding [s]; by default the longest motion [s] ends under all buildings."""
        return self.pounding.duration or longest + max(self.delays.values(), default=0.0)

    def content_hash(self) -> str:
        """SHA-256 of the case texts and of every file they name, as they were when read."""
        return self.digest

    @property
    def shown_direction(self) -> str:
        """The direction "x", "y" or "z" of the motions that results are reported along.

        The one in which the buildings pound: that of the motion most along a normal of the
        contacts; without contacts, or among equals, that of the first motion.
        """

        def along(direction: str) -> float:
            axis = "xyz".index(direction)
            return max((abs(contact.normal[axis]) for contact in self.contacts), default=0.0)

        return max((motion.direction for motion in self.motions), key=along)

    def building(self, name: str) -> Building:
        """The building of a name; KeyError where there is no such building."""
        for building in self.buildings:
            if building.name == name:
                return building
        raise KeyError(name)


@dataclass(frozen=True)
class Building3D:
    """A building with a 3D model, and what the case says of this building alone.

    Args:
        case: The case.
        structure: Its 3D model.
        part: Its name in the names of its files and results; "" for the first building with a 3D
            model, whose names are short.
        transient: The section [transient] with the floors and probes of this building.
        wall_impact: The section [wall_impact], if this building hits the wall.
        devices: Its devices.
        device_analysis: The section [device_analysis], if it has devices.
    """

    case: Case
    structure: Structure
    part: str
    transient: Transient | None
    wall_impact: WallImpactSetup | None
    devices: tuple[DeviceSetup, ...]
    device_analysis: DeviceAnalysis | None

    @classmethod
    def of(cls, case: Case, structure: Structure) -> Building3D:
        """The building with this 3D model of a case."""
        name, wall, transient = structure.building, case.wall_impact, case.transient
        devices = tuple(device for device in case.devices if device.building == name)
        if transient is not None:
            floors = transient.floors
            probes = [one for one in transient.probes if one.building in ("", name)]
            # By its name, as where it has the only 3D model: what was computed then is reused.
            own = {
                "floors": floors.get(name) if isinstance(floors, dict) else floors,
                "probes": tuple(one.model_copy(update={"building": name}) for one in probes),
            }
            transient = transient.model_copy(update=own)
        return cls(
            case=case,
            structure=structure,
            part="" if name == case.structures[0].building else name,
            transient=transient,
            wall_impact=wall if wall is not None and wall.building == name else None,
            devices=devices,
            device_analysis=case.device_analysis if devices else None,
        )

    @property
    def name(self) -> str:
        """Its name."""
        return self.structure.building

    @property
    def entry(self) -> Building:
        """Its entry in the table [[buildings]]."""
        return self.case.building(self.name)

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """The contact pairs that touch it."""
        return tuple(one for one in self.case.contacts if self.name in one.buildings)

    @property
    def pounds(self) -> bool:
        """Whether its 3D model pounds, not its stick."""
        return self.name in self.case.pounding_in_3d

    @property
    def published(self) -> Mapping[str, Published]:
        """The published values of its results, by their names without that of the building."""
        known = {alone(key, self.part): value for key, value in self.case.published.items()}
        return {key: value for key, value in known.items() if key is not None}

    @property
    def with_sections(self) -> Case:
        """The case with what the building has in the place of whole sections, for hashes."""
        own = ("structure", "transient", "wall_impact", "devices", "device_analysis", "published")
        return self.case.model_copy(update={name: getattr(self, name) for name in own})

    def folder(self, run: Path) -> Path:
        """Its folder within that of the run."""
        return run / self.part

    def run_folder(self, folder: Path) -> Path:
        """The folder of the run that its folder is in."""
        return folder.parent if self.part else folder

    @property
    def numbered_probes(self) -> tuple[tuple[int, Probe], ...]:
        """Its probes with their indices in the case file."""
        every = () if self.case.transient is None else self.case.transient.probes
        return tuple((k, one) for k, one in enumerate(every) if one.building in ("", self.name))

    @property
    def numbered_devices(self) -> tuple[tuple[int, DeviceSetup], ...]:
        """Its devices with their indices in the case file."""
        every = enumerate(self.case.devices)
        return tuple((k, one) for k, one in every if one.building == self.name)

    @property
    def wave_floor(self) -> int:
        """The floor in which waves are evaluated: the highest that may be struck.

        Without contacts it is the top floor.
        """
        ends = [end for contact in self.contacts for end, _ in contact.ends]
        struck = [one.floor for one in ends if one.building == self.name and one.floor]
        return max(struck, default=self.entry.floors[-1].floor)


@dataclass(frozen=True)
class BuildingInTime(Building3D):
    """A building whose 3D model is computed in time."""

    transient: Transient


@dataclass(frozen=True)
class BuildingAtWall(Building3D):
    """A building whose 3D model hits the rigid wall."""

    wall_impact: WallImpactSetup
