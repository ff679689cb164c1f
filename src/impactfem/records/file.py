"""What the readers of records share: lines and faults of a file, channels, units, numbers."""

import math
import re
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NoReturn

import numpy as np

from impactfem.records.accelerogram import STANDARD_GRAVITY, Accelerogram
from impactfem.records.recording import Recording
from impactfem.system.errors import Fault, InputError
from impactfem.system.files import read_bytes
from impactfem.system.log import LOGGER

LARGEST = 100_000_000
"""Size of the largest file of a record [byte]: 72 channels of 4 min are half of it."""
_MOST_FAULTS = 20
_MOST_NOTED = 1000  # faults that are kept; further ones are counted
_PLAIN = re.compile(r"[-+.\deE\s]*", re.ASCII)
_TOLERANCE = 0.01  # of a peak or duration from that of the header

# The units accelerograms come in. A general unit parser would read "g" as the gram and "gal" as
# the gallon, and does not know the "cm/sec2" of the agencies' files.
ACCELERATION_UNITS = {
    "m/s2": 1.0,
    "cm/s2": 0.01,
    "mm/s2": 0.001,
    "in/s2": 0.0254,
    "ft/s2": 0.3048,
    "g": STANDARD_GRAVITY,
    "mg": 0.001 * STANDARD_GRAVITY,
    "%g": 0.01 * STANDARD_GRAVITY,
    "gal": 0.01,
}
LONGEST = 300
"""Characters of a line of header that are looked at; those of all formats have 80."""
TIME_UNITS = {"s": 1.0, "ms": 0.001, "min": 60.0}

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"


def plain_unit(text: str) -> str:
    """Bring the spellings of a unit to one: ``cm/sec^2``, ``CM/S/S`` and ``cm s-2`` are cm/s2."""
    unit = text[:LONGEST].strip().lower().replace("²", "2").replace("**", "").replace("^", "")
    unit = re.sub(r"sec(onds?)?(?=\W|\d|$)", "s", unit)
    unit = re.sub(r"\s*/\s*", "/", unit)
    unit = re.sub(r"/\(?s[\s*/.·]?s\)?$", "/s2", unit)
    return re.sub(r"[\s.*·]s-2$", "/s2", unit)


def read_number(text: str) -> float | None:
    """Read a plain finite decimal number; None for all else (``nan``, ``1_000``, ``1e999``)."""
    value = float(text) if re.fullmatch(NUMBER, text.strip()) else math.nan
    return value if math.isfinite(value) else None


def fixed_columns(line: str, width: int) -> list[str]:
    """Cut a line of fixed columns into its cells; a blank rest at the end is left out."""
    text = line.rstrip()
    return [text[i : i + width].strip() for i in range(0, len(text), width)]


def same_name(name: str, other: str) -> bool:
    """Whether two names of a component agree, whatever their case and spaces."""
    return "".join(name.split()).casefold() == "".join(other.split()).casefold()


class RecordFile:
    """The lines of a record's file, what is expected of it, and the faults that its reader notes.

    Bytes that are not UTF-8, as of names in a header, are taken as ISO 8859-1: numbers have none. A
    file that cannot be read, is no text, is empty or too large is refused.
    """

    def __init__(self, path: Path, expected: str) -> None:
        content = read_bytes(path, expected, LARGEST)
        if isinstance(content, Fault):
            raise InputError([content])
        if b"\0" in content or content.startswith((b"\xff\xfe", b"\xfe\xff")):
            words = "not a text file in UTF-8: save it as UTF-8"
            raise InputError([Fault(path, "", None, f"{words}; expected {expected}")])
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = content.decode("latin-1")
        self.path, self.expected = path, expected
        self.lines: list[str] = re.split(r"\r*\n|\r", text.rstrip("\x1a\r\n"))
        self.faults: list[Fault] = []
        self._more = 0

    def note(self, line: int | None, value: str | None, expected: str) -> None:
        """Note a fault of a line, counted from 1, or of the file as a whole (None)."""
        if len(self.faults) < _MOST_NOTED:
            self.faults.append(Fault(self.path, f"line {line}" if line else "", value, expected))
        else:
            self._more += 1

    def error(self) -> InputError:
        """The error that carries the faults: the first 20, and the number of the others."""
        faults, more = self.faults, len(self.faults) + self._more - _MOST_FAULTS
        if more > 0:
            rest = Fault(self.path, "", None, f"and {more} more faults of this kind or another")
            faults = [*faults[:_MOST_FAULTS], rest]
        return InputError(faults)

    def fail(self, line: int | None, value: str | None, expected: str) -> NoReturn:
        """Note a fault behind which nothing can be read, and raise all of them."""
        self.note(line, value, expected)
        raise self.error()

    def samples(
        self,
        lines: Iterable[int],
        cells: Callable[[str], Sequence[str]],
        expected: str,
        read: Callable[[str], float | None] = read_number,
    ) -> list[float]:
        """The numbers in the cells of lines, counted from 0; cells that hold none are noted."""
        found = [(i, cells(self.lines[i])) for i in lines]
        plain = [cell for _, row in found for cell in row]
        # Nearly all files: without a cell that the rules of `read` would refuse, converted at once.
        if read is read_number and _PLAIN.fullmatch(" ".join(plain)):
            with suppress(ValueError):
                numbers = [float(cell) for cell in plain]
                if np.isfinite(numbers).all():
                    return numbers
        samples = []
        for i, row in found:
            for cell in row:
                value = read(cell)
                if value is None:
                    self.note(i + 1, cell, expected)
                else:
                    samples.append(value)
        return samples

    def check_component(self, component: str | None, names: tuple[str, ...]) -> None:
        """Refuse another component than that of the file, whose names may be unknown.

        Raises:
            InputError: Another component is requested, or the file does not say which it holds.
        """
        if component is None or any(same_name(component, name) for name in names):
            return
        expected = (
            f"the file holds one component, {names[0]}; leave component out or give that one"
            if names
            else "the file holds one component and does not name it; leave component out"
        )
        raise InputError([Fault(self.path, "component", component, expected)])

    def choose(self, component: str | None, names: Sequence[tuple[str, ...]], known: str) -> int:
        """Index of the component requested, by any of its names; `known` lists all, for messages.

        Raises:
            InputError: None or several have that name, or none of several is requested.
        """
        if component is None and len(names) == 1:
            return 0
        if component is None:
            expected = f"the file holds {len(names)} components, choose one by component: {known}"
            raise InputError([Fault(self.path, "component", None, expected)])
        matches = [k for k, of in enumerate(names) if any(same_name(component, n) for n in of)]
        if len(matches) == 1:
            return matches[0]
        which = f"{len(matches)} components are called so" if matches else "no such component"
        expected = f"{which}; the file holds {known}"
        raise InputError([Fault(self.path, "component", component, expected)])

    def compare_peak(self, peak: float, announced: str, unit: str, rounding: float = 0.0) -> None:
        """Warn of a peak that is not the header's: samples, scale or unit may have been changed.

        Nothing is compared where the header has no number or zero; `rounding` is that of the
        header's, in addition to 1 % of the peak.
        """
        value = read_number(announced)
        if value and abs(peak - abs(value)) > _TOLERANCE * peak + rounding:
            text = f"warning: %s: the largest sample is %.6g {unit}, the header has %.6g {unit}"
            LOGGER.warning(text, self.path, peak, value)

    def compare_duration(self, step: float, count: int, duration: float) -> None:
        """Warn of samples that take another time than the header has, by 1 % or by a second.

        Nothing is compared where that is not a number.
        """
        if abs(count * step - duration) > max(_TOLERANCE * duration, 1.0):
            text = "warning: %s: %d samples at %.6g s take %.6g s, the header has %.6g s"
            LOGGER.warning(text, self.path, count, step, count * step, duration)


@dataclass(frozen=True)
class Format:
    """A format of records."""

    name: str  #: what case files call it
    expected: str  #: what a file of it looks like, for messages
    endings: tuple[str, ...]  #: of the files that have this format alone, lower case, without dot
    sign: re.Pattern[str]  #: what one of the first lines has, and no file of another format
    #: Reads a component (None: the only one), in m/s2; raises the file's error with every fault.
    read: Callable[[RecordFile, str | None], Accelerogram]


@dataclass(frozen=True)
class Channel:
    """An acceleration of a file that holds several, in fixed columns."""

    number: str  #: at the station, as text; "?" where the file does not say it
    orientation: str  #: in the file's words ("90 Deg", "Up"); may be empty
    code: str  #: in the network ("HNE"); may be empty
    title: str  #: what it is a record of, for the origin of the accelerogram
    time_step: float
    recording: Recording = field(default_factory=Recording)  #: event, station, sensor and component
    announced: int = 0  #: number of the line that announces the samples, from 1
    count: int = 0  #: of the samples announced
    factor: float = math.nan  #: from the file's unit to m/s2
    width: int = 0  #: characters in a column
    stop: int = 0  #: number of the line behind the last one of samples
    duration: float = math.nan  #: as the header has it [s]; nan where it does not
    peak: float = math.nan  #: the same of the largest sample, in the file's unit

    @property
    def names(self) -> tuple[str, ...]:
        """What it may be requested by."""
        return tuple(filter(None, (self.number, self.orientation, self.code)))

    @property
    def label(self) -> str:
        """All its names, for a message."""
        rest = ", ".join(self.names[1:])
        return f"{self.number} ({rest})" if rest else self.number


def read_channel(
    file: RecordFile, channels: Sequence[Channel], component: str | None
) -> Accelerogram:
    """The channel requested by number, orientation or code, None for the only one, in m/s2.

    Raises:
        InputError: There is no such channel, samples are not numbers, or not as many as announced.
    """
    if not channels:
        file.fail(None, None, "the file holds no acceleration")
    numbers = {channel.number for channel in channels}
    if len(numbers) < len(channels) or "?" in numbers:  # the place in the file counts then
        channels = [replace(one, number=str(k)) for k, one in enumerate(channels, start=1)]
    known = "; ".join(channel.label for channel in channels)
    channel = channels[file.choose(component, [channel.names for channel in channels], known)]
    samples = file.samples(
        range(channel.announced, channel.stop - 1),
        lambda line: fixed_columns(line, channel.width),
        f"expected finite numbers in columns of {channel.width} characters",
    )
    if not file.faults and (len(samples) != channel.count or channel.count < 2):
        expected = (
            f"{channel.count} samples are announced, {len(samples)} follow; expected these"
            " numbers to agree, at least 2"
        )
        file.note(channel.announced, file.lines[channel.announced - 1].strip(), expected)
    if file.faults:
        raise file.error()
    origin = f"record {file.path.name}, channel {channel.label}"
    a = np.array(samples) * channel.factor
    file.compare_duration(channel.time_step, len(a), channel.duration)
    if math.isfinite(channel.peak):
        peak = 100.0 * channel.factor * channel.peak
        file.compare_peak(100.0 * float(np.abs(a).max()), str(peak), "cm/s2", rounding=5e-4)
    return Accelerogram(
        channel.time_step,
        a,
        f"{file.path.stem}_{channel.code or channel.number}",
        f"{origin}: {channel.title}" if channel.title else origin,
        recording=channel.recording,
    )
