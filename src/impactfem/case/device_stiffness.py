"""What holds a device: the springs of its base, and the beam between them and its body."""

from __future__ import annotations

from typing import Annotated, Literal, get_args

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case import unit as units
from impactfem.case.base import Section
from impactfem.case.either import OneOrTwo, OrWord
from impactfem.case.leaf import PositiveLength, Quantity, Whole, refuse

Rigid = Literal["rigid"]
(RIGID,) = get_args(Rigid)
"""Stands for a stiffness without bound."""

_BENDING = Quantity(units.BENDING_STIFFNESS, above=0)
_SECTION = Quantity(units.SECTION_STIFFNESS, above=0)

# Zero is told below with the motion that nothing holds.
_Spring = Annotated[float | Rigid, OrWord(Quantity(units.STIFFNESS, at_least=0), RIGID)]
_TurningSpring = Annotated[
    float | Rigid, OrWord(Quantity(units.ROTATIONAL_STIFFNESS, at_least=0), RIGID)
]


class BaseStiffness(Section):
    """The springs between the base of a device and its anchor, one a motion; none may be zero."""

    x: _Spring = Field(description="Stiffness along x; 'rigid' lets the base move with the anchor.")
    y: _Spring = Field(description="Stiffness along y.")
    z: _Spring = Field(description="Stiffness along z.")
    rx: _TurningSpring = Field(description="Stiffness about x.")
    ry: _TurningSpring = Field(description="Stiffness about y.")
    rz: _TurningSpring = Field(description="Stiffness about z.")

    @field_validator("x", "y", "z", "rx", "ry", "rz")
    @classmethod
    def _no_mechanism(cls, value: float | Rigid, info: ValidationInfo) -> float | Rigid:
        if value == 0.0:
            name = info.field_name or ""
            motion = f"rotation about {name[1]}" if name.startswith("r") else f"motion along {name}"
            raise refuse(
                f"a mechanism: no stiffness holds the {motion} of the base; expected a stiffness "
                f"above 0, or '{RIGID}'"
            )
        return value


class DeviceBeam(Section):
    """An upright beam from the base of a device to its body."""

    length: PositiveLength = Field(description="Length of the beam.")
    bending: Annotated[tuple[float, float], OneOrTwo(_BENDING)] = Field(
        description="Bending stiffness E I; of two, the first one bends about x, which moves along "
        "y, the second one about y."
    )
    shear: Annotated[tuple[float | Rigid, float | Rigid], OneOrTwo(OrWord(_SECTION, RIGID))] = (
        Field(
            default=(RIGID, RIGID),
            description="Shear stiffness G A_v; of two, along x and along y.",
        )
    )
    stretching: Annotated[float | Rigid, OrWord(_SECTION, RIGID)] = Field(
        default=RIGID, description="Stiffness E A along the beam."
    )
    twisting: Annotated[float | Rigid, OrWord(_BENDING, RIGID)] = Field(
        default=RIGID, description="Torsional stiffness G J."
    )
    mass: Annotated[float, Quantity(units.MASS, at_least=0)] = Field(
        default=0.0, description="Mass of the whole beam, evenly distributed."
    )
    elements: Annotated[int, Whole(1, 1000)] = Field(default=4, description="Number of elements.")
