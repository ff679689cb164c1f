"""Texts of record files in the layouts of the agencies, for tests of the readers.

The layouts, in the folder `records`, are those of files that ESM, CESMD and NIED publish, seen
among the test data of the USGS program gmprocess and on NIED's page on the K-NET format; the
content is made up.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib.resources import files
from typing import Any

import numpy as np
import numpy.typing as npt

_UNSPECIFIED = -999


def _layout(name: str, **values: Any) -> str:
    """A header with its values, without the end of its last line."""
    text = files("impactfem.verify").joinpath("records", f"{name}.txt").read_text("utf-8")
    return text.removesuffix("\n").format(**values)


def at2_text(samples: npt.ArrayLike, step: float) -> str:
    """A PEER AT2 file of samples in g: 5 a line in columns of 15 characters."""
    g = np.asarray(samples, dtype=np.float64)
    rows = _columns((f"{value:15.7E}" for value in g), 5)
    return "\n".join([_layout("at2", n=g.size, step=step), *rows, ""])


def esm_text(samples: npt.ArrayLike, step: float, stream: str = "HNN") -> str:
    """An ESM file of samples in cm/s2: 64 lines of header, then one sample a line."""
    a = np.asarray(samples, dtype=np.float64)
    k = int(np.argmax(np.abs(a)))
    values = {"duration": a.size * step, "stream": stream, "pga": a[k], "time": k * step}
    header = _layout("esm", n=a.size, step=step, **values)
    return "\n".join([header, *(f"{value:.6f}" for value in a), ""])


def cosmos_text(
    channels: Sequence[tuple[str, str, npt.ArrayLike]],
    step: float,
    *,
    unit: str = "cm/sec2",
    unit_code: int = 4,
    columns: str = "(8F10.5)",
    integrals: bool = True,
) -> str:
    """A COSMOS 1.20 file.

    Args:
        channels: Orientation, code and samples of each channel.
        step: Time step [s].
        unit: Of the samples.
        unit_code: Its number in COSMOS table 2.
        columns: "(8F10.5)" or "(1E15.6)".
        integrals: Whether a velocity and a displacement follow each acceleration, the first with a
            header of its own, the second without.
    """
    lines: list[str] = []
    kinds = [("acceleration", 1.0, f"{unit}({unit_code:02d})", unit_code)]
    if integrals:
        kinds += [("velocity", 3.0, "cm/sec(05)", 5), ("displacement", 2.0, "cm(06)", 0)]
    for number, (orientation, code, samples) in enumerate(channels, start=1):
        a = np.asarray(samples, dtype=np.float64)
        for kind, factor, units, code_of_unit in kinds:
            if code_of_unit:
                header = kind, number, orientation, code, step, code_of_unit
                lines.append(_cosmos_header(*header))
            seconds = f"approx {a.size * step:4.0f} secs"
            lines.append(f"{a.size:8d} {kind} pts, {seconds}, units={units},Format={columns}")
            if columns == "(8F10.5)":
                lines += _columns([_fixed(factor * value) for value in a], 8)
            else:
                lines += [f"{factor * value:15.6e}" for value in a]
            lines.append(f"End-of-data for Chan{number:3d} {kind}")
    return "\n".join([*lines, ""])


def _cosmos_header(
    what: str, number: int, orientation: str, code: str, step: float, unit_code: int
) -> str:
    integers, reals = [_UNSPECIFIED] * 100, [float(_UNSPECIFIED)] * 100
    integers[:4] = [2, 1, unit_code, 120]
    integers[49] = number
    reals[33] = step
    return _layout(
        "cosmos",
        what=what,
        number=number,
        orientation=orientation,
        code=code,
        integers="\n".join(_columns((f"{value:8d}" for value in integers), 10)),
        reals="\n".join(_columns((f"{value:15.6f}" for value in reals), 5)),
    )


def csmip_text(channels: Sequence[tuple[str, npt.ArrayLike]], step: float) -> str:
    """A CSMIP V2 file of samples in cm/s2: orientation and samples of each channel."""
    lines = []
    seconds = f"{step:.4f}".rstrip("0").removeprefix("0")
    for number, (orientation, samples) in enumerate(channels, start=1):
        a = np.asarray(samples, dtype=np.float64)
        where = f"Chan {number:2d}: {orientation}"
        lines.append(_layout("csmip", n=a.size, where=where, seconds=seconds))
        lines += _columns([f"{_UNSPECIFIED:5d}"] * 100, 16)
        lines += _columns(["-999.00000"] * 100, 8)
        for kind, unit, factor in (
            ("accel", "cm/sec2", 1.0),
            ("veloc", "cm/sec", 3.0),
            ("displ", "cm", 2.0),
        ):
            layout = f"equally spaced at  {seconds} sec, in {unit}. (8f10.5)"
            lines.append(f" {a.size:5d} points of {kind} data {layout}")
            lines += _columns((_fixed(factor * value) for value in a), 8)
        lines.append(f"/&  ----------  End of data for channel {number:2d}  ----------")
    return "\n".join([*lines, ""])


def knet_text(
    counts: Sequence[int],
    frequency: int,
    *,
    direction: str = "N-S",
    scale: str = "3920(gal)/6182761",
) -> str:
    """A K-NET file: 17 lines of header, then eight whole numbers a line in columns of 9.

    Args:
        counts: The samples, whole seconds of them.
        frequency: Sampling frequency [Hz].
        direction: Of the component.
        scale: Gal over counts.
    """
    numerator, denominator = scale.replace("(gal)", "").split("/")
    a = np.asarray(counts, dtype=np.float64)
    peak = np.abs(a - a.mean()).max() * float(numerator) / float(denominator)
    values = {"duration": len(counts) // frequency, "direction": direction, "scale": scale}
    header = _layout("knet", frequency=frequency, peak=peak, **values)
    rows = [f"{row} " for row in _columns((f"{c:9d}" for c in counts), 8)]
    return "\n".join([header, *rows, ""])


def _columns(cells: Iterable[str], per_line: int) -> list[str]:
    cells = list(cells)
    return ["".join(cells[i : i + per_line]) for i in range(0, len(cells), per_line)]


def _fixed(value: float) -> str:
    """A number as the agencies print it in F10.5: without the zero before the point."""
    text = f"{abs(value):.5f}".removeprefix("0")
    return (f"-{text}" if f"{value:.5f}".startswith("-") else text).rjust(10)
