"""The case: as written in its file, and as the stages use it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from impactfem.case.analysis import Pounding, Spectra
from impactfem.case.base import Section, Written
from impactfem.case.buildings import Building, Structure
from impactfem.case.calibration import Calibration, WallImpactSetup
from impactfem.case.contacts import Contact, ContactEntry, ContactLawEntry, expand
from impactfem.case.damping import DampingCase, DampingEntry
from impactfem.case.devices import DeviceAnalysis, DeviceSetup
from impactfem.case.floors import Material
from impactfem.case.leaf import File, Key, Text
from impactfem.case.motions import Ensemble, FloorForces, Motion, MotionEntry, WavePassage
from impactfem.case.report import PUBLISHED_FILE, Published, Report
from impactfem.case.transient import Probe, Transient
from impactfem.system.scalar import alone


class CaseFile(Section):
    """A case of impactfem: buildings side by side, a ground motion, and what is computed."""

    extends: File | None = None
    """Another case file that this one extends; state only the differences."""
    title: Text
    """Title of the case, for the report and the figures."""
    published: Annotated[dict[str, Published], PUBLISHED_FILE] = Field(default={})
    """Table of published values (CSV), compared with the results in summary.json."""
    materials: dict[Key, Material]
    """Materials by name."""
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
    motions: Annotated[tuple[Motion, ...], Written(tuple[MotionEntry, ...], tuple)] = ()
    """The ground motions, one for each direction; optional with [[loads]]."""
    wave_passage: WavePassage | None = None
    """Delay of the ground motion between buildings; without it, all move alike."""
    loads: tuple[FloorForces, ...] = ()
    """Forces on floors in addition to the ground motion."""
    contact_laws: dict[Key, ContactLawEntry] = Field(default={})
    """Laws of the contact force by name."""
    contacts: Annotated[tuple[Contact, ...], Written(tuple[ContactEntry, ...], expand)] = ()
    """Contact pairs; without any, the buildings do not pound."""
    pounding: Pounding
    """Models in contact and time integration."""
    spectra: Spectra
    """Response spectra of the floors."""
    ensemble: Ensemble | None = None
    """Ensemble of motions."""
    report: Report = Field(default_factory=Report)
    """Author, assumptions and published reference of the report."""


class Case(CaseFile):
    """A case that was read and found free of faults: SI values, names resolved, tables read.

    Files are relative to the working folder. With loads alone there is one motion, of ground at
    rest; without devices there is no device_analysis; published values know by the reference of
    the report how ours relate to them.

    A stage of a 3D model works on a view of the case for its building: `structure` is that of the
    building, with the devices, the impact on the wall and the probes that belong to it.

    Args:
        structure: The 3D model: of a view that of its building, else the first one, or None.
        further_structures: The 3D models of further buildings; of a view none.
        path: The case file.
        digest: SHA-256 of the case text, of those it extends and of all files they name, as
            hexadecimal digits.
        input_files: SHA-256 of each of these texts and files by its name there.
        reference_of: Name of the file below this one that names the reference of the report; ""
            where the case file does itself, or there is none.
        changes: Keys in which the case differs from that file, with dots.
        part: Of a view of a further building its name, by which its files and results are known;
            those of the first one have the short names that they have alone.
        complete: Of a view the whole case.
    """

    structure: Structure | None
    further_structures: tuple[Structure, ...] = ()
    path: Path
    digest: str
    input_files: dict[str, str] = Field(default={}, exclude=True)
    reference_of: str = ""
    changes: tuple[str, ...] = ()
    part: str = Field(default="", exclude=True)
    complete: Case | None = Field(default=None, exclude=True, repr=False)

    @property
    def structures(self) -> tuple[Structure, ...]:
        """All 3D models."""
        return () if self.structure is None else (self.structure, *self.further_structures)

    @property
    def whole(self) -> Case:
        """The case of which this is a view; the case itself where it is none."""
        return self.complete or self

    @property
    def views(self) -> tuple[Case, ...]:
        """The case for each of its buildings with a 3D model; of one it is the case itself."""
        if not self.further_structures:
            return () if self.structure is None else (self,)
        return tuple(self._view(one, index > 0) for index, one in enumerate(self.structures))

    def _view(self, structure: Structure, further: bool) -> Case:
        name, wall, transient = structure.building, self.wall_impact, self.transient
        devices = tuple(device for device in self.devices if device.building == name)
        if transient is not None:
            floors = transient.floors
            probes = [one for one in transient.probes if one.building in ("", name)]
            # By its name, as where it has the only 3D model: what was computed then is reused.
            own = {
                "floors": floors.get(name) if isinstance(floors, dict) else floors,
                "probes": tuple(one.model_copy(update={"building": name}) for one in probes),
            }
            transient = transient.model_copy(update=own)
        update = {
            "structure": structure,
            "further_structures": (),
            "devices": devices,
            "device_analysis": self.device_analysis if devices else None,
            "wall_impact": wall if wall is not None and wall.building == name else None,
            "transient": transient,
            "complete": self,
        }
        if further:
            known = {alone(key, name): value for key, value in self.published.items()}
            update |= {"part": name, "published": {k: v for k, v in known.items() if k is not None}}
        return self.model_copy(update=update)

    @property
    def pounding_in_3d(self) -> tuple[str, ...]:
        """Names of the buildings whose 3D models pound."""
        models = self.pounding.models
        return tuple(one.name for one in self.buildings if models.get(one.name) == "structure")

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

    @property
    def numbered_probes(self) -> tuple[tuple[int, Probe], ...]:
        """The probes of [transient] with their indices in the case file."""
        transient = self.whole.transient
        every = () if transient is None else transient.probes
        names = {"", *(one.building for one in self.structures)}
        return tuple((k, one) for k, one in enumerate(every) if one.building in names)

    @property
    def numbered_devices(self) -> tuple[tuple[int, DeviceSetup], ...]:
        """The devices with their indices in the case file."""
        return tuple((k, one) for k, one in enumerate(self.whole.devices) if one in self.devices)

    def folder(self, run: Path) -> Path:
        """The folder of what belongs to the building of a view, within that of the run."""
        return run / self.part

    def run_folder(self, folder: Path) -> Path:
        """The folder of the run that the folder of a view is in."""
        return folder.parent if self.part else folder

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

    @property
    def wave_floor(self) -> int:
        """The floor of the 3D model in which waves are evaluated: the highest that may be struck.

        Without contacts it is the top floor. ValueError where the case has no structure.
        """
        building = self.modelled_building
        ends = [end for contact in self.contacts for end, _ in contact.ends]
        struck = [one.floor for one in ends if one.building == building.name and one.floor]
        return max(struck, default=building.floors[-1].floor)

    @property
    def modelled(self) -> Structure:
        """The 3D model; ValueError where the case has no structure."""
        if self.structure is None:
            raise ValueError("the case has no structure")
        return self.structure

    @property
    def modelled_building(self) -> Building:
        """The building with the 3D model; ValueError where the case has no structure."""
        return self.building(self.modelled.building)

    def building(self, name: str) -> Building:
        """The building of a name; KeyError where there is no such building."""
        for building in self.buildings:
            if building.name == name:
                return building
        raise KeyError(name)
