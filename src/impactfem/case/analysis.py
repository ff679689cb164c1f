"""How the pounding is integrated, and which response spectra are made of it."""

from __future__ import annotations

import itertools
import math
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, ValidationInfo, field_validator

from impactfem.case.base import Section, present
from impactfem.case.leaf import DampingRatio, Frequency, PositiveTime, Whole, refuse


class Pounding(Section):
    """Time integration of the sticks with contact: Newmark, average acceleration."""

    duration: PositiveTime | None = Field(
        default=None, description="Time that is computed; default that of the longest motion."
    )
    time_step: PositiveTime = Field(description="Time step.")
    update: Literal["implicit", "lagged"] = Field(
        default="implicit",
        description="'implicit' takes the contact force at the new time; 'lagged' at the old one, "
        "as equation 2 of the paper is printed, which raises the restitution.",
    )
    points_per_impact: Annotated[int, Whole(1)] = Field(
        default=16, description="Least number of steps in an impact; fewer are reported."
    )

    @field_validator("time_step")
    @classmethod
    def _step_in_duration(cls, value: float, info: ValidationInfo) -> float:
        duration = info.data.get("duration")
        if duration is not None and value >= duration:
            raise refuse(f"expected a time below the duration, {duration:g} s")
        return value


class FrequencyGrid(Section):
    """Frequencies at equal distances on a logarithmic scale."""

    minimum: Frequency = Field(description="Lowest frequency.")
    maximum: Frequency = Field(description="Highest frequency.")
    per_decade: Annotated[int, Whole(1)] = Field(
        description="Number of frequencies in a decade, at least."
    )

    @field_validator("maximum")
    @classmethod
    def _ordered(cls, value: float, info: ValidationInfo) -> float:
        if present(info, ["minimum"]) and value <= info.data["minimum"]:
            raise refuse(f"expected a frequency above minimum, {info.data['minimum']:g} Hz")
        return value

    @property
    def values(self) -> tuple[float, ...]:
        """The frequencies [Hz], from minimum to maximum, both included."""
        decades = math.log10(self.maximum / self.minimum)
        # The bound is below one interval in 1e9: 3 decades of 100 are 300 intervals, not 301.
        intervals = max(1, math.ceil(decades * self.per_decade - 1e-9))
        inner = (
            self.minimum * 10.0 ** (decades * index / intervals) for index in range(1, intervals)
        )
        return (self.minimum, *inner, self.maximum)


def _form(value: Any) -> str:
    return "list" if isinstance(value, list | tuple) else "grid"


class Spectra(Section):
    """Floor response spectra: their dampings, frequencies and accuracy."""

    damping: tuple[DampingRatio, ...] = Field(
        min_length=1, description="Damping ratios of the oscillators."
    )
    frequencies: Annotated[
        Annotated[FrequencyGrid, Tag("grid")]
        | Annotated[tuple[Frequency, ...], Field(min_length=1), Tag("list")],
        Discriminator(_form),
    ] = Field(description="Frequencies of the oscillators: a grid, or a list of frequencies.")
    points_per_cycle: Annotated[int, Whole(2)] = Field(
        default=20, description="Least number of samples in a cycle of the highest frequency."
    )
    method: Literal["upsampled", "in-step"] = Field(
        default="upsampled",
        description="'upsampled' makes the record finer once, band-limited; 'in-step' looks for "
        "the maximum inside each step of the record as it is.",
    )

    @field_validator("frequencies")
    @classmethod
    def _increasing(
        cls, value: FrequencyGrid | tuple[float, ...]
    ) -> FrequencyGrid | tuple[float, ...]:
        if isinstance(value, tuple) and any(b <= a for a, b in itertools.pairwise(value)):
            raise refuse("expected increasing frequencies")
        return value

    @property
    def frequency_values(self) -> tuple[float, ...]:
        """The frequencies of the oscillators [Hz], increasing."""
        if isinstance(self.frequencies, FrequencyGrid):
            return self.frequencies.values
        return self.frequencies
