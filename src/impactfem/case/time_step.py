"""The time step of an analysis and its duration."""

from __future__ import annotations

from pydantic import ValidationInfo

from impactfem.case.leaf import refuse


def step_fault(time_step: float, duration: float) -> str | None:
    """What is wrong with a time step [s] for a duration [s], in words; None when nothing is."""
    if time_step > duration / 2.0:
        return f"expected at most half of the duration, {duration:g} s"
    return None


def half_of_duration(value: float, info: ValidationInfo) -> float:
    """A time step, where the `duration` of the same section has room for two of them.

    Raises:
        PydanticCustomError: It has not.
    """
    duration = info.data.get("duration")
    fault = step_fault(value, duration) if duration is not None else None
    if fault is not None:
        raise refuse(fault)
    return value
