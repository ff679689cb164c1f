"""A channel of a file that holds several: what it is called, and where its samples stand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from impactfem.motion.accelerogram import Accelerogram
from impactfem.motion.record_text import fixed_columns, input_error, number, same_name
from impactfem.system.errors import Fault, InputError


@dataclass(frozen=True)
class Channel:
    """An acceleration of a file with fixed columns.

    Args:
        number: Its number at the station, as text.
        orientation: Its direction in the file's words ("90 Deg", "Up"); may be empty.
        code: Its code in the network ("HNE"); may be empty.
        title: What it is a record of, for the origin of the accelerogram.
        announced: Line number of the line that announces the samples, from 1.
        count: Number of samples announced.
        time_step: Step h [s].
        factor: From the file's unit to m/s2.
        width: Characters in a column.
        stop: Line number behind the last line of samples.
    """

    number: str
    orientation: str
    code: str
    title: str
    announced: int
    count: int
    time_step: float
    factor: float
    width: int
    stop: int

    @property
    def names(self) -> tuple[str, ...]:
        """What it may be asked for by."""
        return tuple(name for name in (self.number, self.orientation, self.code) if name)

    @property
    def label(self) -> str:
        """All its names, for a message."""
        rest = ", ".join(name for name in (self.orientation, self.code) if name)
        return f"{self.number} ({rest})" if rest else self.number


def chosen_channel(path: Path, channels: Sequence[Channel], component: str | None) -> Channel:
    """Choose the channel asked for.

    Args:
        path: The file.
        channels: Its channels, in its order.
        component: Number, orientation or code of a channel, whatever the case; may be None when
            there is only one.

    Raises:
        InputError: There is no channel, none or several answer, or there are several to choose
            from and none was asked for.
    """
    known = "; ".join(channel.label for channel in channels)
    if not channels:
        raise InputError([Fault(path, "", None, "the file holds no acceleration")])
    if component is None:
        if len(channels) == 1:
            return channels[0]
        expected = f"the file holds {len(channels)} components, choose one by component: {known}"
        raise InputError([Fault(path, "component", None, expected)])
    found = [c for c in channels if any(same_name(component, name) for name in c.names)]
    if len(found) == 1:
        return found[0]
    which = "no such component" if not found else f"{len(found)} components are called so"
    raise InputError([Fault(path, "component", component, f"{which}; the file holds {known}")])


def read_channel(path: Path, lines: Sequence[str], channel: Channel) -> Accelerogram:
    """Read the samples of a channel.

    Args:
        path: The file.
        lines: All its lines.
        channel: The channel.

    Returns:
        The accelerogram in m/s2, named after the file and the channel.

    Raises:
        InputError: Samples are not numbers, or not as many as announced.
    """
    faults: list[Fault] = []
    samples: list[float] = []
    for i in range(channel.announced, channel.stop - 1):
        for cell in fixed_columns(lines[i], channel.width):
            value = number(cell)
            if value is None:
                expected = f"expected finite numbers in columns of {channel.width} characters"
                faults.append(Fault(path, f"line {i + 1}", cell, expected))
            else:
                samples.append(value)
    if not faults and (len(samples) != channel.count or channel.count < 2):
        expected = (
            f"{channel.count} samples are announced, {len(samples)} follow; expected these"
            " numbers to agree, at least 2"
        )
        line = lines[channel.announced - 1].strip()
        faults.append(Fault(path, f"line {channel.announced}", line, expected))
    if faults:
        raise input_error(path, faults)
    origin = f"record {path.name}, channel {channel.label}"
    return Accelerogram(
        channel.time_step,
        np.array(samples) * channel.factor,
        f"{path.stem}_{channel.code or channel.number}",
        f"{origin}: {channel.title}" if channel.title else origin,
    )
