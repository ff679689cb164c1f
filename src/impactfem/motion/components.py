"""Records along different directions: whether they are of one place and event, and their clock."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from impactfem.case import Motion, RecordMotion
from impactfem.records.accelerogram import Accelerogram
from impactfem.records.file import same_name
from impactfem.system.errors import Fault
from impactfem.system.log import LOGGER

SKEW = 5.0
"""Angle between two horizontal components that may be off a right angle [degree]."""


def _pairs(
    motions: Sequence[Motion], records: Mapping[int, Accelerogram]
) -> Iterator[tuple[RecordMotion, RecordMotion, Accelerogram, Accelerogram]]:
    """Yield each two records that are compared, with their motions."""
    for i, j in combinations(records, 2):
        a, b = motions[i], motions[j]
        related = not (getattr(a, "independent", False) or getattr(b, "independent", False))
        if isinstance(a, RecordMotion) and isinstance(b, RecordMotion) and related:
            yield a, b, records[i], records[j]


def conflicts(motions: Sequence[Motion], records: Mapping[int, Accelerogram]) -> list[Fault]:
    """Compare the headers of records: event, station, sensor, and whether they overlap in time.

    The records by the index of their motions. What a header does not state is not compared, nor
    are motions that are `independent`.
    """
    found = list[Fault]()
    for motion, other, record, later in _pairs(motions, records):
        a, b = record.recording, later.recording
        words = (
            "the components would not be one motion of the ground. Give records of one {0}, or "
            "independent = true in [[motions]] for records that were chosen separately"
        )
        before = len(found)
        for name in ("event", "station", "sensor"):
            x, y = getattr(a, name), getattr(b, name)
            same = not (x and y) or same_name(x, y)
            if not same and len(found) == before:
                text = (
                    f"along {motion.direction} the {name} is {x!r} ({motion.file.name}): "
                    f"{words.format(name)}"
                )
                found.append(Fault(other.file, name, y, text))
        if len(found) == before and a.start and b.start:
            apart = (b.start - a.start).total_seconds()
            if not -later.duration < apart < record.duration:
                text = (
                    f"along {motion.direction} the first sample is at {a.start} "
                    f"({motion.file.name}): they do not overlap in time, and "
                    f"{words.format('event')}"
                )
                found.append(Fault(other.file, "start", str(b.start), text))
    return found


def aligned(
    motions: Sequence[Motion], records: Mapping[int, Accelerogram], *, report: bool = False
) -> dict[int, Accelerogram]:
    """Give records one clock: one that begins later by its header is at rest before its start.

    To the nearest sample. Records without a start, and motions that are `independent`, begin at
    time 0. The records by the index of their motions; with `report` shifts are logged.
    """
    clocks = {
        i: record.recording.start
        for i, record in records.items()
        if record.recording.start is not None and not getattr(motions[i], "independent", False)
    }
    result = dict(records)
    first = min(clocks, key=lambda i: clocks[i], default=None)
    for i, start in clocks.items():
        record = records[i]
        later = 0.0 if first is None else (start - clocks[first]).total_seconds()
        n = round(later / record.time_step)
        if n == 0 or first is None:
            continue
        note = f"begins {n * record.time_step:.6g} s later than {records[first].name}"
        samples = np.pad(record.acceleration, (n, 0))
        result[i] = replace(record, acceleration=samples, origin=f"{record.origin}; {note}")
        if report:
            LOGGER.info(
                "%s: its first sample is at %s, that of %s at %s: it begins %.6g s later, with "
                "the ground at rest before",
                record.name,
                start,
                records[first].name,
                clocks[first],
                later,
            )
    return result


def same_directions(
    motions: Sequence[Motion], records: Mapping[int, Accelerogram]
) -> Iterator[Fault]:
    """Yield warnings of two horizontal components that are not perpendicular."""
    for motion, other, record, second in _pairs(motions, records):
        a, b = record.recording, second.recording
        horizontal = {motion.direction, other.direction} == {"x", "y"}
        if not horizontal or (motion.file, motion.component) == (other.file, other.component):
            continue
        if a.orientation is None or b.orientation is None:
            continue
        x, y = a.orientation.azimuth, b.orientation.azimuth
        same = a.component and same_name(a.component, b.component)
        if x is not None and y is not None:
            skew = abs((y - x) % 180.0 - 90.0)
            if skew <= SKEW:
                continue
            what = f"its azimuth is {y:g} degrees, that along {motion.direction} is {x:g} degrees"
        elif same and not a.orientation.vertical:
            what = f"it is the component of the record along {motion.direction}, too"
        else:
            continue
        text = (
            f"{what} ({motion.file.name}): the ground would move along one line of the site, and "
            "motions across it are left out; give two perpendicular components of the record"
        )
        yield Fault(other.file, "direction", other.direction, text)
