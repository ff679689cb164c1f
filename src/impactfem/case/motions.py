"""Ground motions, synthesised to a design spectrum or read from a record, and ensembles of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator

from impactfem.case.base import Section, ascending, refuse, rule, step_within
from impactfem.case.design_spectrum import SpectrumEntry, TableSpectrum
from impactfem.case.leaf import File, FileName, Whole, Words
from impactfem.case.quantity import (
    Acceleration,
    Duration,
    Frequency,
    PositiveFactor,
    PositiveTime,
    Ratio,
    Time,
    TimeStep,
)
from impactfem.records import AMBIGUOUS_ENDINGS, FORMAT_OF_ENDING, FORMATS, RecordFormat

MIN_STEPS = 16  # of a synthetic motion
Direction = Literal["x", "y", "z"]
DIRECTIONS: tuple[Direction, ...] = ("x", "y", "z")


@dataclass(frozen=True)
class Component(Words):
    """The name or the number of a component of a record; held as text."""

    words: str = "the name of a component in quotes, or its number"

    def check(self, value: Any, info: ValidationInfo) -> str:
        """A number counts from 1."""
        number = isinstance(value, int) and not isinstance(value, bool) and value > 0
        if not number and not (isinstance(value, str) and value.strip()):
            raise refuse(f"expected {self.phrase}")
        return str(value).strip()

    def schema(self) -> dict[str, Any]:
        """The JSON schema of either."""
        either = [{"type": "string", "minLength": 1}, {"type": "integer", "minimum": 1}]
        return {"anyOf": either, "x-accepts": self.phrase}


class _Motion(Section):
    """What all ground motions have."""

    direction: Direction
    """Direction in which the ground moves; one motion a direction."""


class SyntheticMotion(_Motion):
    """A motion synthesised to a design spectrum, with random phases and an envelope."""

    type: Literal["synthetic"]
    """Synthesised to a design spectrum."""
    seed: Annotated[int, Whole(0)]
    """Seed of the random phases."""
    pga: Acceleration
    """Peak ground acceleration of the motion."""
    duration: Duration
    """Duration of the motion."""
    time_step: TimeStep
    """Time step of the motion."""
    strong_phase: tuple[Time, Time]
    """Begin and end of the strong phase, in which the envelope is constant."""
    iterations: Annotated[int, Whole(1, 10_000)] = 30
    """Number of iterations that match the motion to the spectrum."""
    damping: Annotated[float, Ratio(above=0, below=1)] = 0.05
    """Damping ratio of the spectrum that is matched."""
    spectrum: SpectrumEntry
    """The design spectrum that is matched."""

    _step_in_duration = step_within("duration")

    @rule("time_step", "duration")
    @staticmethod
    def _whole_steps(step: float, duration: float) -> Iterator[str]:
        steps = duration / step
        if abs(steps - round(steps)) > 1e-6 * steps or round(steps) < MIN_STEPS:
            yield (
                f"the duration of {duration:g} s is {steps:.6g} steps of it; "
                f"expected a whole number of at least {MIN_STEPS}"
            )

    _in_order = ascending("strong_phase", "expected the begin of the strong phase before its end")

    @rule("strong_phase", "duration")
    @staticmethod
    def _phase_in_duration(phase: tuple[float, float], duration: float) -> Iterator[str]:
        if phase[1] > duration:
            yield f"expected a phase within the duration, {duration:g} s"


class RecordMotion(_Motion):
    """A motion read from a file.

    What is done to it, in this order: ``baseline`` "mean" or "linear", ``taper``, ``filter``,
    ``resample``, ``baseline`` "rest", ``scale`` or ``pga``. Each is logged.
    """

    type: Literal["record"]
    """Read from a file."""
    file: Annotated[Path, FileName("a record")]
    """The record: CSV with units in its header, PEER NGA (.AT2), ESM or ITACA (.ASC), COSMOS (.V2c)
    or CSMIP (.V2) of CESMD, K-NET or KiK-net (.EW, .NS2, ...)."""
    format: RecordFormat | None = Field(default=None, validate_default=True)
    """Format of the file; default by its ending, and by its first lines for .asc, .txt and .v2."""
    component: Annotated[str, Component()] | None = None
    """Which component of a file that holds several: the name of a column, the number, orientation
    or code of a channel."""
    baseline: Literal["none", "mean", "linear", "rest"] = "none"
    """Baseline correction: the mean or the straight line of least squares is taken out; 'rest'
    brings end velocity and displacement to zero."""
    taper: PositiveTime | None = None
    """Time over which half a cosine takes either end to zero."""
    filter: tuple[Frequency, Frequency] | None = None
    """Low and high corner of a Butterworth band-pass of order 4, run forward and backward."""
    resample: TimeStep | None = None
    """Time step that the record is brought to, band-limited."""
    scale: PositiveFactor = 1.0
    """Factor on the accelerations of the record."""
    pga: Acceleration | None = None
    """Peak ground acceleration the record is scaled to, in place of scale."""

    @field_validator("format")
    @classmethod
    def _by_ending(cls, value: RecordFormat | None, info: ValidationInfo) -> RecordFormat | None:
        file: Path | None = info.data.get("file")
        if value is not None or file is None:
            return value
        ending = file.suffix.lower().lstrip(".")
        if ending in FORMAT_OF_ENDING:
            return FORMAT_OF_ENDING[ending]
        if ending not in AMBIGUOUS_ENDINGS:
            known = " or ".join(f"'{name}'" for name in FORMATS)
            raise refuse(f"missing; expected {known}, the ending of the file is of none of them")
        return None

    _band = ascending("filter", "expected the low corner frequency before the high one")

    @rule("pga", "scale")
    @staticmethod
    def _scale_or_pga(pga: float | None, scale: float) -> Iterator[str]:
        if pga is not None and scale != 1.0:
            yield "expected either scale or pga, not both"


class RestMotion(_Motion):
    """Ground that does not move: that of a case with loads alone, which names no motion.

    Args:
        type: "rest".
        duration: As long as the loads last [s].
        time_step: That of the sticks [s].
    """

    type: Literal["rest"]
    duration: float
    time_step: float


Motion = SyntheticMotion | RecordMotion | RestMotion
MotionEntry = Annotated[SyntheticMotion | RecordMotion, Field(discriminator="type")]


def motion_files(motion: Motion) -> tuple[Path, ...]:
    """The files a motion is made from: its record, or the table of its design spectrum."""
    if isinstance(motion, RecordMotion):
        return (motion.file,)
    if isinstance(motion, RestMotion):
        return ()
    return (motion.spectrum.file,) if isinstance(motion.spectrum, TableSpectrum) else ()


class Ensemble(Section):
    """Many motions through the sticks: other seeds of the synthetic motions, or other records."""

    motions: Annotated[int, Whole(2, 100_000)] | None = None
    """Number of members with synthetic motions; member i takes the seed first_seed + i, and a
    further component a seed of its own."""
    first_seed: Annotated[int, Whole(0)] = 0
    """Seed of the first member."""
    records: File | None = Field(default=None, validate_default=True)
    """In place of motions: a folder of records, each in place of the file of the case's one motion,
    with the same scale, component and treatment."""

    structure_motions: Annotated[int, Whole(0, 100_000)] = 0
    """Number of members, from the first, that are carried through the 3D model of [transient] and
    the devices, with their impact forces: statistics of design spectra and of forces on anchors. 0
    carries none; statistics need at least two."""

    @rule("structure_motions")
    @staticmethod
    def _some(count: int) -> Iterator[str]:
        if count == 1:
            yield "expected 0, or at least 2: statistics of one motion there are none"

    @rule("records", "motions")
    @staticmethod
    def _either(records: Path | None, motions: int | None) -> Iterator[str]:
        if (records is None) == (motions is None):
            yield "expected either motions or records"

    def files(self) -> tuple[Path, ...]:
        """The records of the folder in the order of their names; none for synthetic motions."""
        return tuple(path for path in self.entries() if path.is_file())

    def entries(self) -> tuple[Path, ...]:
        """What is in the folder, files and others, but hidden ones, in the order of the names."""
        if self.records is None:
            return ()
        return tuple(sorted(p for p in self.records.iterdir() if not p.name.startswith(".")))
