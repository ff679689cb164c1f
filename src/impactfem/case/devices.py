"""Devices anchored to a floor of the 3D model: as written in the case file, and resolved."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section, present
from impactfem.case.damping import Damping
from impactfem.case.device_matrices import DeviceMatrices, DeviceMatricesEntry
from impactfem.case.device_modes import DeviceMode
from impactfem.case.device_stiffness import RIGID, BaseStiffness, DeviceBeam
from impactfem.case.device_support import (
    DeviceSupport,
    ProbePattern,
    once,
)
from impactfem.case.given_spectra import GivenSpectrum
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
from impactfem.case.unit import INERTIA

_Moment = Annotated[float, Quantity(INERTIA, at_least=0)]
_BESIDE_MODES = "expected nothing here beside modes: the table says how the device moves"
_BESIDE_MATRICES = "expected nothing here beside matrices: they say how the device moves"


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
    supports: tuple[DeviceSupport, ...] = Field(
        default=(),
        description="In place of point and radius: several anchors, of a device with matrices.",
    )
    point: tuple[Length, Length, Length] | None = Field(
        default=None,
        validate_default=True,
        description="Its anchor (x, y, z), on a floor of the building of [structure].",
    )
    radius: PositiveLength | None = Field(
        default=None,
        validate_default=True,
        description="Radius around the anchor within which the nodes of the floor are tied to it, "
        "as to a rigid plate.",
    )
    envelope: tuple[ProbePattern, ...] = Field(
        default=(),
        description="Probes of [transient] whose spectra, with those of the anchor, make an "
        "envelope for further response spectrum analyses: names, or patterns with * and ?.",
    )
    spectra: Path | tuple[GivenSpectrum, ...] | None
    modes: Path | tuple[DeviceMode, ...] | None
    matrices: DeviceMatricesEntry | DeviceMatrices | None
    mass: Mass | None = Field(
        default=None,
        validate_default=True,
        description="Mass of the body, with mass_height and either inertia or shape; beside modes "
        "that of the whole device, whose rest follows the anchor.",
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

    @property
    def anchors(self) -> tuple[DeviceSupport, ...]:
        """Where it is anchored: one place or several."""
        if self.point is None or self.radius is None:
            return self.supports
        return (DeviceSupport(point=self.point, radius=self.radius, envelope=self.envelope),)

    @field_validator("supports")
    @classmethod
    def _apart(cls, value: tuple[DeviceSupport, ...]) -> tuple[DeviceSupport, ...]:
        for index, one in enumerate(value):
            if any(math.dist(one.point, other.point) < TOUCH for other in value[:index]):
                x, y, z = one.point
                raise refuse(
                    f"expected supports at different points, found two at ({x:g}, {y:g}, {z:g}) m"
                )
        return value

    @field_validator("point", "radius")
    @classmethod
    def _one_place(cls, value: Any, info: ValidationInfo) -> Any:
        if not present(info, ["supports"]):
            return value
        if value is None and not info.data["supports"]:
            what = "anchor (x, y, z)" if info.field_name == "point" else "radius of the anchor"
            raise refuse(f"missing; expected the {what}, or supports: several anchors")
        if value is not None and info.data["supports"]:
            raise refuse("expected nothing here beside supports: each has a point and a radius")
        return value

    @field_validator("envelope")
    @classmethod
    def _of_one_anchor(cls, value: tuple[str, ...], info: ValidationInfo) -> tuple[str, ...]:
        if value and info.data.get("supports"):
            raise refuse("expected nothing here beside supports: each may have an envelope")
        return once(value)

    @field_validator("modes")
    @classmethod
    def _modes_of_one_anchor(cls, value: Any, info: ValidationInfo) -> Any:
        if value is not None and len(info.data.get("supports", ())) > 1:
            raise refuse("expected matrices for a device with several supports")
        return value

    @field_validator("matrices")
    @classmethod
    def _one_model(cls, value: Any, info: ValidationInfo) -> Any:
        if value is not None and info.data.get("modes") is not None:
            raise refuse(_BESIDE_MODES)
        several = len(info.data.get("supports", ())) > 1 and info.data.get("modes") is None
        if value is None and several and present(info, ["modes"]):
            raise refuse("missing; expected the matrices of a device with several supports")
        return value

    @field_validator("mass")
    @classmethod
    def _something_moves(cls, value: float | None, info: ValidationInfo) -> float | None:
        if value is None and _on_base(info):
            raise refuse(
                "missing; expected the mass of a body, or modes: the table of a device, or matrices"
            )
        if value is not None and info.data.get("matrices") is not None:
            raise refuse(_BESIDE_MATRICES)
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
        if value is None and _on_base(info):
            raise refuse(
                "missing; expected the springs of the base, or modes: the table of a device, or "
                "matrices"
            )
        _refuse_beside(value, info)
        return value

    @field_validator("beam")
    @classmethod
    def _moves(cls, value: DeviceBeam | None, info: ValidationInfo) -> DeviceBeam | None:
        _refuse_beside(value, info)
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
    """A device on a floor of the building of [structure]: a rigid body on springs, or a table.

    Either ``mass``, ``mass_height``, ``inertia`` or ``shape``, ``stiffness`` and ``damping``, with
    a ``beam`` where it has one; or ``modes``; or ``matrices``. With a beam, too, the mass centre is
    counted from the anchor.
    """

    spectra: File | None = Field(
        default=None,
        description="Floor spectra (CSV) that a further response spectrum analysis is done with: "
        "frequency, acceleration, direction, damping, and support where the device has several; "
        "or products/floor_spectra.csv of a run, whose broadened spectra of the floor are taken.",
    )
    modes: File | None = Field(
        default=None,
        description="Table of the modes of the device (CSV), in place of springs and beam.",
    )
    matrices: DeviceMatricesEntry | None = Field(
        default=None,
        validate_default=True,
        description="Mass and stiffness matrices of the device, in place of springs and beam.",
    )


class DeviceSetup(_Device):
    """A device with its tables read, and the floor it stands on.

    Args:
        floor: Number of the floor that is nearest to the point, or to the first support.
    """

    spectra: tuple[GivenSpectrum, ...] | None = None
    modes: tuple[DeviceMode, ...] | None
    matrices: DeviceMatrices | None = None
    floor: int


def _on_base(info: ValidationInfo) -> bool:
    """Whether the device is a body on springs, as it has neither modes nor matrices."""
    return present(info, ["modes", "matrices"]) and (
        info.data["modes"] is None and info.data["matrices"] is None
    )


def _refuse_beside(value: Any, info: ValidationInfo) -> None:
    """Refuse a part of a body on springs beside modes or matrices."""
    for name, fault in (("modes", _BESIDE_MODES), ("matrices", _BESIDE_MATRICES)):
        if value is not None and info.data.get(name) is not None:
            raise refuse(fault)
