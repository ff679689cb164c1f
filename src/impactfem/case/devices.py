"""Devices anchored to a floor of the 3D model: as written in the case file, and resolved."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section, present
from impactfem.case.damping import Damping
from impactfem.case.device_analysis import STEPS, DeviceAnalysis
from impactfem.case.device_modes import DeviceMode
from impactfem.case.device_stiffness import RIGID, BaseStiffness, DeviceBeam
from impactfem.case.file_mesh import FileMesh
from impactfem.case.generated_mesh import GeneratedMeshEntry
from impactfem.case.leaf import (
    File,
    Frequency,
    Length,
    Mass,
    Name,
    PositiveLength,
    Quantity,
    refuse,
)
from impactfem.case.members import TOUCH
from impactfem.case.place import value_at
from impactfem.case.source import Source
from impactfem.case.unit import INERTIA
from impactfem.errors import Fault

_Moment = Annotated[float, Quantity(INERTIA, at_least=0)]
_BESIDE_MODES = "expected nothing here beside modes: the table says how the device moves"


class Cylinder(Section):
    """A solid upright cylinder, from whose mass and size its moments of inertia follow."""

    type: Literal["cylinder"] = Field(description="A solid upright cylinder.")
    radius: PositiveLength = Field(description="Its radius.")
    length: PositiveLength = Field(description="Its height.")


class _Device(Section):
    """What a device has in common before and after its table is read.

    The field that differs stands here too, for the order of all fields.
    """

    name: Name = Field(description="Name of the device, unique in the file.")
    point: tuple[Length, Length, Length] = Field(
        description="Its anchor (x, y, z), on a floor of the building of [structure]."
    )
    radius: PositiveLength = Field(
        description="Radius around the anchor within which the nodes of the floor are tied to it, "
        "as to a rigid plate."
    )
    modes: Path | tuple[DeviceMode, ...] | None
    mass: Mass | None = Field(
        default=None,
        validate_default=True,
        description="Mass of the body; beside modes that of the whole device, whose rest follows "
        "the anchor.",
    )
    mass_height: Length | None = Field(
        default=None,
        validate_default=True,
        description="Height of the mass centre above the anchor.",
    )
    inertia: tuple[_Moment, _Moment, _Moment] | None = Field(
        default=None,
        description="Moments of inertia of the body about x, y, z through its mass centre.",
    )
    shape: Cylinder | None = Field(
        default=None,
        validate_default=True,
        description="In place of inertia: the shape it follows from.",
    )
    stiffness: BaseStiffness | None = Field(
        default=None,
        validate_default=True,
        description="Springs between the base of the device and its anchor.",
    )
    beam: DeviceBeam | None = Field(
        default=None,
        validate_default=True,
        description="Beam from the base to the body, which sits on its upper end; left out, base "
        "and body are one.",
    )
    damping: Damping | None = Field(
        default=None,
        validate_default=True,
        description="Damping of the device alone, of its mass and stiffness; not needed where "
        "each row of modes has its own.",
    )
    maximum_frequency: Frequency = Field(
        default=1000.0,
        description="Modes of the device above it follow the anchor rigidly.",
    )

    @field_validator("mass")
    @classmethod
    def _something_moves(cls, value: float | None, info: ValidationInfo) -> float | None:
        if value is None and present(info, ["modes"]) and info.data["modes"] is None:
            raise refuse("missing; expected the mass of a body, or modes: the table of a device")
        return value

    @field_validator("mass_height")
    @classmethod
    def _with_mass(cls, value: float | None, info: ValidationInfo) -> float | None:
        if present(info, ["mass"]) and (info.data["mass"] is None) != (value is None):
            raise refuse("expected mass and mass_height together")
        return value

    @field_validator("inertia")
    @classmethod
    def _of_the_mass(cls, value: Any, info: ValidationInfo) -> Any:
        if value is not None and present(info, ["mass"]) and info.data["mass"] is None:
            raise refuse("expected a mass beside it")
        return value

    @field_validator("shape")
    @classmethod
    def _one_inertia(cls, value: Cylinder | None, info: ValidationInfo) -> Cylinder | None:
        if not present(info, ["mass", "inertia"]):
            return value
        if info.data["mass"] is None:
            if value is not None:
                raise refuse("expected a mass beside it")
        elif (info.data["inertia"] is None) == (value is None):
            both = "" if value is None else ", not both"
            raise refuse(f"expected either inertia or shape beside mass{both}")
        return value

    @field_validator("stiffness")
    @classmethod
    def _on_springs(cls, value: BaseStiffness | None, info: ValidationInfo) -> BaseStiffness | None:
        if present(info, ["modes"]) and info.data["modes"] is None and value is None:
            raise refuse(
                "missing; expected the springs of the base, or modes: the table of a device"
            )
        if value is not None and info.data.get("modes") is not None:
            raise refuse(_BESIDE_MODES)
        return value

    @field_validator("beam")
    @classmethod
    def _moves(cls, value: DeviceBeam | None, info: ValidationInfo) -> DeviceBeam | None:
        if value is not None and info.data.get("modes") is not None:
            raise refuse(_BESIDE_MODES)
        springs = info.data.get("stiffness")
        if value is None and springs is not None and all(k == RIGID for _, k in springs):
            raise refuse(
                "missing; expected a beam, as nothing moves on a base that is rigid all over"
            )
        return value

    @field_validator("damping")
    @classmethod
    def _of_a_body(cls, value: Damping | None, info: ValidationInfo) -> Damping | None:
        if value is None and present(info, ["modes"]) and info.data["modes"] is None:
            raise refuse("missing; expected the damping of the device")
        return value


class DeviceEntry(_Device):
    """A device on a floor of the building of [structure]: a rigid body on springs, or modes.

    Either ``mass``, ``mass_height``, ``inertia`` or ``shape``, ``stiffness`` and ``damping``, with
    a ``beam`` where it has one; or ``modes``. With a beam, too, the mass centre is counted from the
    anchor.
    """

    modes: File | None = Field(
        default=None,
        description="Table of the modes of the device (CSV), in place of springs and beam.",
    )


class DeviceSetup(_Device):
    """A device with its table read, and the floor it stands on.

    Args:
        floor: Number of the floor that is nearest to the point.
    """

    modes: tuple[DeviceMode, ...] | None
    floor: int


def resolve_device(
    entry: DeviceEntry, modes: Mapping[Path, tuple[DeviceMode, ...]], levels: Mapping[int, float]
) -> DeviceSetup:
    """The device with its table and its floor.

    Args:
        entry: The device as written.
        modes: The tables of modes by the file name in the case file.
        levels: Elevation of each floor [m] by its number.
    """
    shared = {name: getattr(entry, name) for name in DeviceEntry.model_fields}
    table = None if entry.modes is None else modes[entry.modes]
    return DeviceSetup(**shared | {"modes": table, "floor": _nearest(levels, entry.point[2])})


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
    modes: Mapping[Path, tuple[DeviceMode, ...]],
    mesh: GeneratedMeshEntry | FileMesh,
    levels: Mapping[int, float],
) -> Iterator[Fault]:
    """Devices beside the building, and tables that say no damping.

    Args:
        source: The case file.
        devices: The devices as written.
        modes: The tables of modes by the file name in the case file, as far as they could be read.
        mesh: The mesh of the structure. Of one from a file the plan is not known yet.
        levels: Elevation of each floor [m] by its number; empty when not known.
    """
    for index, device in enumerate(devices):
        if not isinstance(mesh, FileMesh):
            wrong = "; ".join(_misplaced(device, mesh, levels))
            if wrong:
                place = ("devices", index, "point")
                yield source.fault(place, value_at(place, source.raw), wrong)
        rows = modes.get(device.modes) if device.modes is not None else None
        if device.damping is None and any(row.damping is None for row in rows or ()):
            expected = f"missing; expected a damping, as {device.modes} has no column damping"
            yield source.fault(("devices", index, "damping"), None, expected)


def analysis_faults(
    source: Source, analysis: DeviceAnalysis | None, time_step: float
) -> Iterator[Fault]:
    """A step of the coupled integration that is longer than that of the motion it follows.

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


def _misplaced(
    device: DeviceEntry, mesh: GeneratedMeshEntry, levels: Mapping[int, float]
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
