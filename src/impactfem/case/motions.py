"""Ground motions: synthesised to a design spectrum, or read from a record."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section, present
from impactfem.case.leaf import (
    Acceleration,
    File,
    PositiveFactor,
    PositiveTime,
    Ratio,
    Time,
    Whole,
    refuse,
)

MIN_STEPS = 16  # of a synthetic motion


class DesignSpectrum(Section):
    """Elastic design spectrum in the form of Eurocode 8, which a synthetic motion is matched to."""

    ground_acceleration: Acceleration = Field(
        description="Level of the spectrum at zero period: a_g S, the ground acceleration on the "
        "soil of the site."
    )
    amplification: PositiveFactor = Field(
        default=2.5, description="Ratio of the plateau to the level, at 5 % damping."
    )
    corner_periods: tuple[PositiveTime, PositiveTime, PositiveTime] = Field(
        description="Corner periods T_B < T_C < T_D: the plateau lies between the first two, "
        "constant velocity between the last two."
    )

    @field_validator("corner_periods")
    @classmethod
    def _increasing(cls, value: tuple[float, float, float]) -> tuple[float, float, float]:
        if not value[0] < value[1] < value[2]:
            raise refuse("expected increasing corner periods T_B < T_C < T_D")
        return value


class _Motion(Section):
    """What all ground motions have."""

    direction: Literal["x", "y", "z"] = Field(
        description="Direction in which the ground moves; one motion a direction."
    )


class SyntheticMotion(_Motion):
    """A motion synthesised to a design spectrum, with random phases and an envelope."""

    type: Literal["synthetic"] = Field(description="Synthesised to a design spectrum.")
    seed: Annotated[int, Whole(0)] = Field(description="Seed of the random phases.")
    pga: Acceleration = Field(description="Peak ground acceleration of the motion.")
    duration: PositiveTime = Field(description="Duration of the motion.")
    time_step: PositiveTime = Field(description="Time step of the motion.")
    strong_phase: tuple[Time, Time] = Field(
        description="Begin and end of the strong phase, in which the envelope is constant."
    )
    iterations: Annotated[int, Whole(1)] = Field(
        default=30, description="Number of iterations that match the motion to the spectrum."
    )
    damping: Annotated[float, Ratio(above=0, below=1)] = Field(
        default=0.05, description="Damping ratio of the spectrum that is matched."
    )
    spectrum: DesignSpectrum = Field(description="The design spectrum that is matched.")

    @field_validator("time_step")
    @classmethod
    def _step_in_duration(cls, value: float, info: ValidationInfo) -> float:
        if present(info, ["duration"]) and value >= info.data["duration"]:
            raise refuse(f"expected a time below the duration, {info.data['duration']:g} s")
        if present(info, ["duration"]):
            steps = info.data["duration"] / value
            if abs(steps - round(steps)) > 1e-6 * steps or round(steps) < MIN_STEPS:
                raise refuse(
                    f"the duration of {info.data['duration']:g} s is {steps:.6g} steps of it; "
                    f"expected a whole number of at least {MIN_STEPS}"
                )
        return value

    @field_validator("strong_phase")
    @classmethod
    def _phase_in_duration(
        cls, value: tuple[float, float], info: ValidationInfo
    ) -> tuple[float, float]:
        if value[0] >= value[1]:
            raise refuse("expected the begin of the strong phase before its end")
        if present(info, ["duration"]) and value[1] > info.data["duration"]:
            raise refuse(f"expected a phase within the duration, {info.data['duration']:g} s")
        return value


class RecordMotion(_Motion):
    """A motion read from a file."""

    type: Literal["record"] = Field(description="Read from a file.")
    file: File = Field(description="The record: CSV with units in its header, or PEER NGA (.AT2).")
    format: Literal["csv", "at2"] | None = Field(
        default=None,
        validate_default=True,
        description="Format of the file; default by its ending.",
    )
    scale: Annotated[float, Ratio(above=0)] = Field(
        default=1.0, description="Factor on the accelerations of the record."
    )
    pga: Acceleration | None = Field(
        default=None,
        description="Peak ground acceleration the record is scaled to, in place of scale.",
    )

    @field_validator("format")
    @classmethod
    def _by_ending(cls, value: str | None, info: ValidationInfo) -> str | None:
        file: Path | None = info.data.get("file")
        if value is not None or file is None:
            return value
        ending = file.suffix.lower().lstrip(".")
        if ending not in {"csv", "at2"}:
            raise refuse(
                "missing; expected 'csv' or 'at2', the ending of the file is neither of them"
            )
        return ending

    @field_validator("pga")
    @classmethod
    def _scale_or_pga(cls, value: float | None, info: ValidationInfo) -> float | None:
        if value is not None and info.data.get("scale", 1.0) != 1.0:
            raise refuse("expected either scale or pga, not both")
        return value


Motion = SyntheticMotion | RecordMotion
MotionEntry = Annotated[Motion, Field(discriminator="type")]
