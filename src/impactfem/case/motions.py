"""Loading: ground motions, ensembles of them, forces on floors."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, StrictBool, ValidationInfo, field_validator

from impactfem.case.base import Section, ascending, either, nearest, refuse, rule, step_within
from impactfem.case.contacts import unit_vector
from impactfem.case.design_spectrum import SpectrumEntry, TableSpectrum
from impactfem.case.floors import floors_of
from impactfem.case.leaf import File, FileName, Whole, Words
from impactfem.case.quantity import (
    Acceleration,
    Duration,
    Frequency,
    Number,
    PositiveSpeed,
    PositiveTime,
    Si,
    Time,
    TimeStep,
)
from impactfem.case.reading import TableFile, reading_of
from impactfem.case.table import name_and_unit, read_numbers, unit_of_column
from impactfem.records import AMBIGUOUS_ENDINGS, FORMAT_OF_ENDING, FORMATS, RecordFormat
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault

MIN_STEPS, MIN_STRONG = 16, 32  # of a synthetic motion, and of its strong phase
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
            raise refuse(f"expected {self.phrase}", kind="text")
        return str(value).strip()

    def schema(self) -> dict[str, Any]:
        """The JSON schema of either."""
        either = [{"type": "string", "minLength": 1}, {"type": "integer", "minimum": 1}]
        return {"anyOf": either, "x-accepts": self.phrase}


class _Motion(Section):
    """Keys of all ground motions."""

    direction: Direction
    """Direction of the ground motion; one motion for each direction."""


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
    """Begin and end of the strong phase, in which the envelope is constant; 32 time steps at
    least."""
    iterations: Annotated[int, Whole(1, 10_000)] = 30
    """Number of iterations that match the motion to the spectrum."""
    damping: Annotated[float, Si("-", gt=0, lt=1)] = 0.05
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

    @rule("strong_phase", "time_step")
    @staticmethod
    def _phase_of_steps(phase: tuple[float, float], step: float) -> Iterator[str]:
        if 0.0 < phase[1] - phase[0] < MIN_STRONG * step * (1.0 - 1e-9):
            yield f"expected at least {MIN_STRONG} time steps, {MIN_STRONG * step:g} s"


class RecordMotion(_Motion):
    """A motion read from a file.

    Processing order: ``baseline`` "mean" or "linear", ``taper``, ``filter``, ``resample``,
    ``baseline`` "rest", ``scale`` or ``pga``. Each is logged.
    """

    type: Literal["record"]
    """Read from a file."""
    file: Annotated[Path, FileName("a record")]
    """The record: CSV with units in its header, PEER NGA (.AT2), ESM or ITACA (.ASC), COSMOS (.V2c)
    or CSMIP (.V2) of CESMD, K-NET or KiK-net (.EW, .NS2, ...)."""
    format: RecordFormat | None = Field(default=None, validate_default=True)
    """Format of the file; default by its ending, and by its first lines for .asc, .txt and .v2."""
    component: Annotated[str, Component()] | None = None
    """Component of a file with several: name of a column, or number, orientation or code of a
    channel."""
    baseline: Literal["none", "mean", "linear", "rest"] = "none"
    """Baseline correction: subtracts the mean or the least-squares line; 'rest' sets final velocity
    and displacement to zero."""
    taper: PositiveTime | None = None
    """Duration of the half-cosine taper at both ends."""
    filter: tuple[Frequency, Frequency] | None = None
    """Low and high corner of a Butterworth band-pass of order 4, run forward and backward."""
    resample: TimeStep | None = None
    """Time step after band-limited resampling; the motion is linear between samples. Default: a
    step above 0.55 ms is divided by an integer until linear interpolation keeps 99.8 % of the
    amplitude up to the Nyquist frequency or 100 Hz. The step of the record keeps linear
    interpolation between its samples."""
    scale: Annotated[float, Si("-")] = 1.0
    """Factor on the accelerations, not zero; -1 reverses the direction."""
    pga: Acceleration | None = None
    """Peak ground acceleration after scaling, in place of scale; a scale of -1 reverses the
    direction."""

    independent: StrictBool = False
    """true for a record that was chosen separately: it is not compared with other directions and
    begins at time 0. Otherwise records of different events, stations or sensors are refused, and a
    later start in the header is kept."""

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
            expected = f"missing; expected {known}: the ending '{file.suffix}' is of none of them"
            if ending in ("vt2", "dt2"):
                what = "velocity" if ending == "vt2" else "displacement"
                expected = (
                    f"'{file.name}' is a PEER {what} record; expected the acceleration record "
                    f"'{file.with_suffix('.AT2').name}' of the same motion"
                )
            raise refuse(expected, kind="missing")
        return None

    _band = ascending("filter", "expected the low corner frequency before the high one")

    @rule("scale")
    @staticmethod
    def _not_zero(scale: float) -> Iterator[str]:
        if scale == 0.0:
            yield "expected a factor that is not 0; -1 turns the direction of the record round"

    @rule("pga", "scale")
    @staticmethod
    def _scale_or_pga(pga: float | None, scale: float) -> Iterator[str]:
        if pga is not None and abs(scale) != 1.0:
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


class WavePassage(Section):
    """Waves that reach one building after the other.

    The ground under a building has the motion of the first building that the waves reach, delayed
    by the distance of their axes along the direction over the apparent velocity. A base moves as
    the ground under its axis; rotation and averaging along the base are neglected.
    """

    apparent_velocity: PositiveSpeed
    """Apparent velocity along the surface."""
    direction: tuple[Number, Number]
    """Direction (x, y) in plan in which the waves travel, of any length."""

    @field_validator("direction")
    @classmethod
    def _unit(cls, value: tuple[float, float]) -> tuple[float, float]:
        return unit_vector((*value, 0.0))[:2]


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
    """Number of synthetic motions; motion i has the seed first_seed + i, and a further component
    another seed."""
    first_seed: Annotated[int, Whole(0)] = 0
    """Seed of the first member."""
    records: File | None = Field(default=None, validate_default=True)
    """In place of motions: a folder of records. Each replaces the file of the case's motion, with
    the same scale, component and processing."""

    structure_motions: Annotated[int, Whole(0, 100_000)] = 0
    """Number of motions, from the first, that also run in the 3D model of [transient] and the
    devices, for statistics of design spectra and anchor forces. Statistics need at least two."""

    @rule("structure_motions")
    @staticmethod
    def _some(count: int) -> Iterator[str]:
        if count == 1:
            yield "expected 0, or at least 2: statistics of one motion there are none"

    _either = either("motions", "records", "motions or records")

    def files(self) -> tuple[Path, ...]:
        """The records of the folder in the order of their names; none for synthetic motions."""
        return tuple(path for path in self.entries() if path.is_file())

    def of_records(self, motions: Sequence[Motion]) -> tuple[RecordMotion, ...]:
        """The one motion of the case with each record of the folder in place of its file."""
        return tuple(
            motion.model_copy(update={"file": file, "format": None})
            for motion in motions
            if isinstance(motion, RecordMotion)
            for file in self.files()
        )

    def entries(self) -> tuple[Path, ...]:
        """Entries of the folder without hidden ones, in the order of their names."""
        # That there is no such folder is a fault of the case.
        if self.records is None or not self.records.is_dir():
            return ()
        return tuple(sorted(p for p in self.records.iterdir() if not p.name.startswith(".")))


TABLE = "a table of forces (CSV) with the header time [s],<building>.floor_<k> [N]"

MOST_TIMES = 1_000_000
"""Largest number of times in a table."""

_FLOOR = re.compile(r"([A-Za-z].*)\.floor_([1-9][0-9]{0,8})")


def _read_forces(path: Path, faults: list[Fault], info: ValidationInfo) -> ForceTable | None:
    """Read a table whose columns are floors of the buildings of the case file."""
    table = read_force_table(path, faults)
    names = reading_of(info).names("buildings") or ()  # where not known, any may be
    before = len(faults)
    for building, floor in table.floors if table is not None and names else ():
        column = f"column {building}.floor_{floor}"
        known = [one.floor for one in floors_of(building, info)]
        if building not in names:
            expected = f"expected a building of the case; {nearest(building, list(names))}"
            faults.append(Fault(path, column, building, expected, "forces"))
        elif known and floor not in known:
            numbers = ", ".join(map(str, known))
            expected = f"{building} has no floor {floor}; its floors are {numbers}"
            faults.append(Fault(path, column, floor, expected, "forces"))
    return table if len(faults) == before else None


class FloorForces(Section):
    """Forces on floors in time, in addition to the ground motion.

    In the sticks they act on the mass centres. In the 3D model they act as line loads on the edges
    of the floors that face the other building, at right angles to these, with the eccentricity of
    [transient].
    """

    file: Annotated[
        Path, TableFile("a table of forces (CSV)", _read_forces, sited=True, as_path=True)
    ]
    """Table of the forces (CSV): `time [s]`, then a column `<building>.floor_<k> [MN]` for each
    floor; straight between its times, zero outside of them."""
    direction: tuple[Number, Number, Number]
    """Direction (x, y, z) of positive forces, of any length."""

    _unit = field_validator("direction")(unit_vector)


@dataclass(frozen=True, eq=False)
class ForceTable:
    """The forces of a file."""

    time: Array  #: increasing, shape (n,) [s]
    floors: tuple[tuple[str, int], ...]  #: building and floor of each column
    force: Array  #: shape (n, m) [N]

    def at(self, time: Array) -> Array:
        """The forces at any times, zero outside of the table's, shape (n_t, m) [N]."""
        # A time that rounding puts behind the last one still is that one.
        end = self.time[-1]
        inside = np.where(np.abs(time - end) <= 1e-9 * max(end, 1.0), end, time)
        columns = [np.interp(inside, self.time, f, left=0.0, right=0.0) for f in self.force.T]
        return np.column_stack(columns)

    def early_ends(self, path: Path, duration: float) -> Iterator[Fault]:
        """A table of a file that ends with a force, before the end of what is computed [s]."""
        if self.time[-1] < duration * (1.0 - 1e-9) and self.force[-1].any():
            expected = (
                f"expected forces up to {duration:g} s, which is computed, or a last line of zeros"
            )
            yield Fault(path, "time", f"up to {self.time[-1]:g} s", expected)


def read_force_table(path: Path, faults: list[Fault]) -> ForceTable | None:
    """Read a table of forces; None, and what is wrong with it, when there are faults."""
    table = read_numbers(path, TABLE, TABLE, faults, MOST_TIMES)
    if table is None:
        return None
    before, (number, headers) = len(faults), table.header
    factors, floors = np.ones(len(headers)), dict[int, tuple[str, int]]()
    names = [name_and_unit(header)[0] for header in headers]
    for k, (header, name) in enumerate(zip(headers, names, strict=True)):
        place = _FLOOR.fullmatch(name)
        expected = ""
        if name in names[:k]:
            expected = "duplicate column"
        elif place is None and name != "time":
            expected = "expected '<building>.floor_<k> [N]', or 'time [s]'"
        else:
            factor = unit_of_column(header, "s" if place is None else "N")
            factors[k], expected = (1.0, factor) if isinstance(factor, str) else (factor, "")
        if place is not None:
            floors[k] = place[1], int(place[2])
        if expected:
            faults.append(Fault(path, f"line {number}, column {header}", None, expected, "forces"))
    if "time" not in names:
        faults.append(
            Fault(path, f"line {number}", None, "missing column; expected 'time [s]'", "forces")
        )
    if not floors:
        expected = "expected a column '<building>.floor_<k> [N]' besides the time"
        faults.append(Fault(path, f"line {number}", None, expected, "forces"))
    if len(table.values) < 2:
        faults.append(Fault(path, "", None, "expected at least two lines of values", "forces"))
    if len(faults) > before:
        return None
    values = table.values * factors
    time = values[:, names.index("time")]
    late = np.flatnonzero(np.diff(time, prepend=-1e-12) <= 0.0)
    if late.size:
        expected = "expected times that increase, from 0 s or later"
        key = f"line {table.lines[late[0]]}, column {headers[names.index('time')]}"
        faults.append(Fault(path, key, float(time[late[0]]), expected, "forces"))
        return None
    return ForceTable(time, tuple(floors.values()), values[:, list(floors)])
