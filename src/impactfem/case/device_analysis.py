"""How the forces on the anchors of the devices are computed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, get_args

from pydantic import Field, StrictBool

from impactfem.case.base import Section, once, rule
from impactfem.case.leaf import OneOrMore
from impactfem.case.quantity import DampingRatio, Duration, Frequency, TimeStep

Combination = Literal["abs", "srss", "cqc", "dsc", "dsc-abs", "ten-percent", "grouping"]

SupportRule = Literal["srss", "abs", "algebraic", "envelope"]

RigidMethod = Literal["none", "gupta", "lindley-yow"]

ModeRule = tuple[Combination, RigidMethod]
"""How modes are combined: their periodic parts, and what of them is rigid."""

STEPS = 8
"""Steps of the coupled integration in one of the transient stage, when the case names no step."""


def _of_gupta(frequency: float | None, methods: tuple[str, ...]) -> Iterator[str]:
    if frequency is not None and "gupta" not in methods:
        yield "expected no frequency, only with method 'gupta'"


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

    _f1_of_gupta = rule("f1", "method")(_of_gupta)
    _f2_of_gupta = rule("f2", "method")(_of_gupta)

    @rule("f2", "f1")
    @staticmethod
    def _above_f1(f2: float | None, f1: float | None) -> Iterator[str]:
        if f2 is not None and f1 is not None and f2 <= f1:
            yield f"expected a frequency above f1, {f1:g} Hz"


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
    broadening: DampingRatio = 0.15
    """How far the peaks of the spectra are broadened, of their frequency to either side, for a
    result beside that of the spectra as computed; 0 for none."""
    time_step: TimeStep | None = None
    """Time step of the 3D model with the devices; default an eighth of that of [transient]."""

    _combinations_once = once("combination", "combination")
    _rules_once = once("supports", "combination")

    @rule("duration", "combination")
    @staticmethod
    def _for_the_double_sum(duration: float | None, combination: tuple[str, ...]) -> Iterator[str]:
        if duration is None and {"dsc", "dsc-abs"} & set(combination):
            yield "missing; expected the duration of the strong motion for the double sum"
