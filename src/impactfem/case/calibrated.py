"""Values that a case file gives, or leaves to the calibration with the word "calibrated"."""

from __future__ import annotations

from typing import Annotated, Any, Literal, get_args

from impactfem.case import unit as units
from impactfem.case.either import OrWord
from impactfem.case.leaf import Quantity, Ratio, refuse

Word = Literal["calibrated"]
(CALIBRATED,) = get_args(Word)
"""Stands for the value that the stage `calibrate` finds."""


def refuse_word(value: Any) -> Any:
    """Refuse the word for a law that takes no other values than those of the case file."""
    if value == CALIBRATED:
        raise refuse("expected a value: only a law of type 'kelvin-voigt' is calibrated")
    return value


CalibratedStiffness = Annotated[
    float | Word, OrWord(Quantity(units.STIFFNESS, above=0), CALIBRATED)
]
CalibratedRestitution = Annotated[float | Word, OrWord(Ratio(above=0, at_most=1), CALIBRATED)]
