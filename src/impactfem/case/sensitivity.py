"""Sensitivity of the verdicts to single parameters."""

from typing import Annotated, Literal, get_args

from pydantic import StrictBool

from impactfem.case.base import Section, once
from impactfem.case.leaf import OneOrMore

Parameter = Literal[
    "contact_stiffness", "restitution", "damping", "gap", "motion", "time_step", "model"
]


class Sensitivity(Section):
    """How the demands of the verdicts change with single parameters.

    The stage runs for a case with a 3D model in reduced order. Each variation is the case with one
    changed parameter, on the same reduced model and in the same resolved band.
    """

    active: StrictBool = True
    """false leaves the stage out."""
    parameters: Annotated[tuple[Parameter, ...], OneOrMore()] = get_args(Parameter)
    """Parameters: "contact_stiffness" (half, double), "restitution" (plus and minus 0.1), "damping"
    (above 20 Hz constant, or proportional to the frequency where the case has it constant), "gap"
    (plus and minus 50 %), "motion" (the one at the 84th percentile of the impact force in
    [ensemble]), "time_step" (half, of [pounding], [transient] and [device_analysis]) and "model"
    (sticks in place of 3D models that pound). Default all."""

    _each_once = once("parameters", "parameter")
