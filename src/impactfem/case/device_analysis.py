"""How the forces on the anchors of the devices are computed."""

from __future__ import annotations

from typing import Annotated, Literal, get_args

from pydantic import Field, StrictBool, ValidationInfo, field_validator

from impactfem.case.base import Section, each_once, present, refuse
from impactfem.case.leaf import OneOrMore
from impactfem.case.quantity import Duration, Frequency, Ratio, TimeStep

Combination = Literal["abs", "srss", "cqc", "dsc", "dsc-abs", "ten-percent", "grouping"]

SupportRule = Literal["srss", "abs", "algebraic", "envelope"]

RigidMethod = Literal["none", "gupta", "lindley-yow"]

ModeRule = tuple[Combination, RigidMethod]
"""How modes are combined: their periodic parts, and what of them is rigid."""

STEPS = 8
"""Steps of the coupled integration in one of the transient stage, when the case names no step."""


class RigidPart(Section):
    """The part of a mode's response that follows the anchor rigidly (Regulatory Guide 1.92)."""

    method: Annotated[tuple[RigidMethod, ...], OneOrMore(get_args(RigidMethod))]
    """'gupta' by two frequencies; 'lindley-yow' by the zero-period acceleration; 'none': all is
    periodic. Of a list there is a result each; the first one is reported where only one is, further
    ones are left out where a spectrum says too little for them."""
    f1: Frequency | None = None
    """Of 'gupta': below it nothing is rigid; default by the spectrum."""
    f2: Frequency | None = Field(default=None, validate_default=True)
    """Of 'gupta': above it all is rigid; default by the spectrum."""

    @field_validator("f1", "f2")
    @classmethod
    def _of_gupta(cls, value: float | None, info: ValidationInfo) -> float | None:
        if value is not None and "gupta" not in info.data.get("method", ("gupta",)):
            raise refuse("expected no frequency, only with method 'gupta'")
        low = info.data.get("f1")
        if info.field_name == "f2" and value is not None and low is not None and value <= low:
            raise refuse(f"expected a frequency above f1, {low:g} Hz")
        return value


class DeviceAnalysis(Section):
    """The response spectrum analysis of all devices, and how the detailed one is done."""

    solver: Literal["reduced", "full"] = "reduced"
    """Of the 3D model with the devices in it: 'reduced' on a basis of few vectors; 'full'
    integrates all unknowns, without and with impacts, with the building's own damping only, which
    takes much longer. The response spectrum analyses and [[damping_cases]] have the basis either
    way, which is then held against the full order."""

    combination: tuple[Combination, ...] = Field(default=("srss", "cqc"), min_length=1)
    """Combinations of the modes, a result each: sum of absolute values, root of the sum of squares,
    complete quadratic, double sum with signs ('dsc') and without, 10 %, grouping."""
    duration: Duration | None = Field(default=None, validate_default=True)
    """Duration of the strong motion, for 'dsc' and 'dsc-abs'."""
    rigid: RigidPart | None = None
    """Rigid part of the modes; left out, all is periodic."""
    missing_mass: StrictBool = True
    """Whether what the modes up to maximum_frequency do not carry is added, with the zero-period
    acceleration."""
    directions: Literal["srss", "100-40-40"] = "srss"
    """Combination of the directions."""
    supports: tuple[SupportRule, ...] = Field(default=("srss", "abs", "envelope"), min_length=1)
    """Of devices with several supports: combination of the responses to the supports, a result
    each. 'srss' and 'abs' take them as independent, 'algebraic' as moving in step, 'envelope' lets
    all move in step by the envelope of their spectra."""
    displacements: Literal["srss", "abs"] = "abs"
    """Combination of the forces by displacements of the supports against each other, among
    themselves and with the rest."""
    envelope_dampings: StrictBool = False
    """Whether the analysis is also done with the envelope of the spectra over all
    [[damping_cases]], with those of envelope where a device has any."""
    rotations: StrictBool = True
    """Whether the analysis is also done with the spectra of the anchor's rotations as further
    input."""
    broadening: Annotated[float, Ratio(at_least=0, below=1)] = 0.15
    """How far the peaks of the spectra are broadened, of their frequency to either side, for a
    result beside that of the spectra as computed; 0 for none."""
    time_step: TimeStep | None = None
    """Time step of the 3D model with the devices; default an eighth of that of [transient]."""

    @field_validator("combination", "supports")
    @classmethod
    def _each_once(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        return each_once(value, "combination")

    @field_validator("duration")
    @classmethod
    def _for_the_double_sum(cls, value: float | None, info: ValidationInfo) -> float | None:
        asked = info.data.get("combination", ())
        if value is None and present(info, ["combination"]) and {"dsc", "dsc-abs"} & set(asked):
            raise refuse("missing; expected the duration of the strong motion for the double sum")
        return value
