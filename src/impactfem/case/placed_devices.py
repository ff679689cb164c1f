"""Devices beside the rest of the case: their tables, their floors, and what does not fit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from impactfem.case.device_analysis import STEPS, DeviceAnalysis
from impactfem.case.device_matrices import DeviceMatrices, DeviceMatricesEntry
from impactfem.case.device_modes import DeviceMode
from impactfem.case.device_support import DeviceSupport, unknown_patterns
from impactfem.case.devices import DeviceEntry, DeviceSetup
from impactfem.case.file_mesh import FileMesh
from impactfem.case.generated_mesh import GeneratedMeshEntry
from impactfem.case.given_spectra import GivenSpectra
from impactfem.case.members import TOUCH
from impactfem.case.place import Place, value_at
from impactfem.case.probe import Probe
from impactfem.case.source import Source
from impactfem.case.structure import StructureEntry
from impactfem.system.errors import Fault


@dataclass(frozen=True)
class DeviceTables:
    """What the files of the devices hold, by the names of the files in the case file.

    Args:
        modes: Tables of modes.
        spectra: Floor spectra.
        matrices: Matrices, by the files of mass and stiffness.
    """

    modes: Mapping[Path, tuple[DeviceMode, ...]]
    spectra: Mapping[Path, GivenSpectra]
    matrices: Mapping[tuple[Path, Path], DeviceMatrices]

    def matrices_of(self, entry: DeviceMatricesEntry | None) -> DeviceMatrices | None:
        """The matrices of a device; None where it has none, or they could not be read."""
        return None if entry is None else self.matrices.get((entry.mass, entry.stiffness))


def resolve_device(
    entry: DeviceEntry, tables: DeviceTables, levels: Mapping[int, float], building: str
) -> DeviceSetup:
    """The device with its tables and its floor.

    Args:
        entry: The device as written.
        tables: What its files hold.
        levels: Elevation of each floor [m] by its number.
        building: Name of the building it stands in.
    """
    shared = {name: getattr(entry, name) for name in DeviceEntry.model_fields}
    floors = [_nearest(levels, one.point[2]) for one in entry.anchors]
    given = None if entry.spectra is None else tables.spectra[entry.spectra].at(building, floors)
    return DeviceSetup(
        **shared
        | {
            "spectra": given,
            "modes": None if entry.modes is None else tables.modes[entry.modes],
            "matrices": tables.matrices_of(entry.matrices),
            "floor": floors[0],
        }
    )


def resolve_analysis(analysis: DeviceAnalysis | None, time_step: float) -> DeviceAnalysis:
    """The analysis of the devices with its time step, or the default of it all.

    Args:
        analysis: The section as written, or None.
        time_step: Of the response of the 3D model in time [s].
    """
    found = analysis or DeviceAnalysis()
    return found.model_copy(update={"time_step": found.time_step or time_step / STEPS})


def lacks_of_devices(source: Source) -> Iterator[Fault]:
    """What devices do without that they need, from the file as it stands.

    Args:
        source: The case file.
    """
    if "devices" in source.raw:
        needed = {
            "structure": "the 3D model of their building",
            "transient": "the response of that model in time",
        }
        lacking = [f"[{name}]: {what}" for name, what in needed.items() if name not in source.raw]
        if lacking:
            expected = f"expected beside them {', and '.join(lacking)}"
            yield source.fault(("devices",), None, expected)
    elif "device_analysis" in source.raw:
        expected = "expected [[devices]] beside it: the devices to analyse"
        yield source.fault(("device_analysis",), None, expected)


def device_faults(
    source: Source,
    devices: Sequence[DeviceEntry],
    tables: DeviceTables,
    structure: StructureEntry,
    levels: Mapping[int, float],
    probes: Sequence[Probe],
) -> Iterator[Fault]:
    """Devices beside the building, tables that lack something, probes that there are not.

    Args:
        source: The case file.
        devices: The devices as written.
        tables: What their files hold, as far as they could be read.
        structure: The 3D model. Of a mesh from a file the plan is not known yet.
        levels: Elevation of each floor [m] by its number; empty when not known.
        probes: The probes of the case.
    """
    for index, device in enumerate(devices):
        for place, anchor in zip(_places(index, device), device.anchors, strict=True):
            if not isinstance(structure.mesh, FileMesh):
                wrong = "; ".join(_misplaced(anchor, structure.mesh, levels))
                if wrong:
                    where = (*place, "point")
                    yield source.fault(where, value_at(where, source.raw), wrong)
            unknown = list(unknown_patterns(anchor.envelope, probes, list(levels)))
            if unknown:
                expected = (
                    "expected names of probes of [transient], or patterns of such names: there is "
                    f"none for {', '.join(unknown)}"
                )
                where = (*place, "envelope")
                yield source.fault(where, value_at(where, source.raw), expected)
        yield from _table_faults(source, index, device, tables, structure.building, levels)


def _places(index: int, device: DeviceEntry) -> list[Place]:
    """Where the anchors of a device stand in the file."""
    if not device.supports:
        return [("devices", index)]
    return [("devices", index, "supports", k) for k in range(len(device.supports))]


def _table_faults(
    source: Source,
    index: int,
    device: DeviceEntry,
    tables: DeviceTables,
    building: str,
    levels: Mapping[int, float],
) -> Iterator[Fault]:
    """What a device does not find in its tables."""
    anchors = device.anchors
    rows = tables.modes.get(device.modes) if device.modes is not None else None
    if device.damping is None and any(row.damping is None for row in rows or ()):
        expected = f"missing; expected a damping, as {device.modes} has no column damping"
        yield source.fault(("devices", index, "damping"), None, expected)
    matrices = tables.matrices_of(device.matrices)
    for lacking in matrices.lacks(len(anchors)) if matrices is not None else ():
        yield source.fault(("devices", index, "matrices"), None, lacking)
    given = tables.spectra.get(device.spectra) if device.spectra is not None else None
    if given is not None and levels:
        floors = [_nearest(levels, one.point[2]) for one in anchors]
        lacking = "; ".join(given.lacks(building, floors))
        if lacking:
            place = ("devices", index, "spectra")
            yield source.fault(place, value_at(place, source.raw), lacking)


def analysis_faults(
    source: Source, analysis: DeviceAnalysis | None, time_step: float
) -> Iterator[Fault]:
    """A step longer than that of the motion it follows; an envelope over no dampings.

    Args:
        source: The case file.
        analysis: The section as written, or None.
        time_step: Of the response of the 3D model in time [s].
    """
    step = None if analysis is None else analysis.time_step
    if step is not None and step > time_step * (1.0 + 1e-9):
        expected = f"expected at most the time step of [transient], {time_step:g} s"
        place = ("device_analysis", "time_step")
        yield source.fault(place, value_at(place, source.raw), expected)
    if analysis is not None and analysis.envelope_dampings and "damping_cases" not in source.raw:
        expected = "expected [[damping_cases]] beside it: there is one damping only"
        yield source.fault(("device_analysis", "envelope_dampings"), True, expected)


def _misplaced(
    device: DeviceSupport, mesh: GeneratedMeshEntry, levels: Mapping[int, float]
) -> Iterator[str]:
    """What is wrong with the point of a device in a generated mesh, in words."""
    x, y, z = device.point
    inside = -TOUCH <= x <= mesh.length + TOUCH and -TOUCH <= y <= mesh.width + TOUCH
    if not inside:
        yield (
            f"outside the building; expected x from 0 to {mesh.length:g} m and y from 0 to "
            f"{mesh.width:g} m"
        )
    if levels:
        floor = _nearest(levels, z)
        within = mesh.slab_thickness / 2.0
        if abs(levels[floor] - z) > within + TOUCH:
            yield (
                f"at the level of no floor; expected z within half of the slab's thickness, "
                f"{within:g} m, of a floor: the nearest, floor {floor}, is at {levels[floor]:g} m"
            )


def _nearest(levels: Mapping[int, float], z: float) -> int:
    return min(levels, key=lambda floor: abs(levels[floor] - z))
