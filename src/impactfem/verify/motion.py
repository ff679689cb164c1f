"""Records in the agencies' layouts read back, and ordinates of the standards' spectra.

The layouts, in the folder `records`, are those of files that ESM, CESMD and NIED publish, seen
among the test data of the USGS program gmprocess and on NIED's page on the K-NET format; the
content is made up.
"""

from collections.abc import Callable, Iterable, Sequence
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt

from impactfem.motion.design_spectrum import decree_spectrum, eurocode_spectrum
from impactfem.records import read_record
from impactfem.records.accelerogram import STANDARD_GRAVITY, Accelerogram
from impactfem.records.csv import write_csv
from impactfem.system.log import quiet
from impactfem.verify.row import Rows, benchmark

UNITS = (("acceleration", 1.0, "cm/sec2"), ("velocity", 3.0, "cm/sec"), ("displacement", 2.0, "cm"))
"""Of the blocks of a channel, and a factor that tells one from the other."""


def _layout(name: str, **values: Any) -> str:
    """A header with its values, without the end of its last line."""
    text = files("impactfem.verify").joinpath("records", f"{name}.txt").read_text("utf-8")
    return text.removesuffix("\n").format(**values)


def _block(values: Iterable[Any], per_line: int, written: Callable[[Any], str]) -> str:
    cells = [written(value) for value in values]
    return "\n".join("".join(cells[i : i + per_line]) for i in range(0, len(cells), per_line))


def _fixed(value: float) -> str:
    """A number as the agencies print it in F10.5: without the zero before the point."""
    text = f"{abs(value):.5f}".removeprefix("0")
    return (f"-{text}" if f"{value:.5f}".startswith("-") else text).rjust(10)


def at2_text(samples: npt.ArrayLike, step: float) -> str:
    """A PEER AT2 file of samples in g: 5 a line in columns of 15 characters."""
    header = _layout("at2", n=np.size(samples), step=step)
    return f"{header}\n{_block(np.asarray(samples), 5, '{:15.7E}'.format)}\n"


def esm_text(samples: npt.ArrayLike, step: float) -> str:
    """An ESM file of samples in cm/s2: 64 lines of header, then one sample a line."""
    a = np.asarray(samples, dtype=np.float64)
    k = int(np.argmax(np.abs(a)))
    values = {"duration": a.size * step, "pga": a[k], "time": k * step}
    return f"{_layout('esm', n=a.size, step=step, **values)}\n{_block(a, 1, '{:.6f}'.format)}\n"


def cosmos_text(
    channels: Sequence[tuple[str, str, npt.ArrayLike]],
    step: float,
    *,
    unit: str = "cm/sec2",
    unit_code: int = 4,
    columns: str = "(8F10.5)",
    integrals: bool = True,
) -> str:
    """A COSMOS 1.20 file of the orientation, code and samples of each channel, at steps in s.

    The unit has a number in COSMOS table 2; columns are "(8F10.5)" or "(1E15.6)". With integrals a
    velocity and a displacement follow each acceleration, the first with a header of its own, the
    second without.
    """
    lines: list[str] = []
    for number, (orientation, code, samples) in enumerate(channels, start=1):
        a = np.asarray(samples, dtype=np.float64)
        for kind, factor, units in UNITS if integrals else UNITS[:1]:
            if kind == "acceleration":
                units, in_table = f"{unit}({unit_code:02d})", unit_code
            else:
                in_table = 5 if kind == "velocity" else 0
                units = f"{units}({in_table or 6:02d})"
            if in_table:
                integers, reals = [-999] * 100, [-999.0] * 100
                integers[:4], integers[49] = [2, 1, in_table, 120], number
                # The raw record had other intervals.
                reals[33], reals[61:63] = 0.5 * step, [1e3 * step, a.size * step]
                if kind == "acceleration":
                    reals[63] = a[np.argmax(np.abs(a))]
                of_channel = {"number": number, "orientation": orientation, "code": code}
                numbers = {
                    "integers": _block(integers, 10, "{:8d}".format),
                    "reals": _block(reals, 5, "{:15.6f}".format),
                }
                lines.append(_layout("cosmos", what=kind, **of_channel, **numbers))
            seconds = f"approx {a.size * step:4.0f} secs"
            lines.append(f"{a.size:8d} {kind} pts, {seconds}, units={units},Format={columns}")
            per_line, written = (8, _fixed) if columns == "(8F10.5)" else (1, "{:15.6e}".format)
            lines.append(_block(factor * a, per_line, written))
            lines.append(f"End-of-data for Chan{number:3d} {kind}")
    return "\n".join([*lines, ""])


def csmip_text(channels: Sequence[tuple[str, npt.ArrayLike]], step: float) -> str:
    """A CSMIP V2 file of samples in cm/s2: orientation and samples of each channel."""
    lines = []
    seconds = f"{step:.4f}".rstrip("0").removeprefix("0")
    for number, (orientation, samples) in enumerate(channels, start=1):
        a = np.asarray(samples, dtype=np.float64)
        where = f"Chan {number:2d}: {orientation}"
        lines.append(_layout("csmip", n=a.size, where=where, seconds=seconds))
        lines.append(_block([-999] * 100, 16, "{:5d}".format))
        lines.append(_block([-999.0] * 100, 8, "{:.5f}".format))
        for kind, factor, unit in UNITS:
            layout = f"equally spaced at  {seconds} sec, in {unit}. (8f10.5)"
            lines.append(f" {a.size:5d} points of {kind[:5]} data {layout}")
            lines.append(_block(factor * a, 8, _fixed))
        lines.append(f"/&  ----------  End of data for channel {number:2d}  ----------")
    return "\n".join([*lines, ""])


def knet_text(counts: Sequence[int], frequency: int, *, direction: str = "N-S") -> str:
    """A K-NET file: 17 lines of header, then eight whole numbers a line in columns of 9.

    The samples are whole seconds, at a frequency in Hz; a count is 3920/6182761 gal.
    """
    a = np.asarray(counts, dtype=np.float64)
    peak = np.abs(a - a.mean()).max() * 3920.0 / 6182761.0
    values = {"duration": len(counts) // frequency, "direction": direction, "peak": peak}
    header = _layout("knet", frequency=frequency, **values)
    samples = _block(counts, 8, "{:9d}".format).replace("\n", " \n")
    return f"{header}\n{samples} \n"


@benchmark(source="the samples the file was written with")
def record_formats(rows: Rows) -> None:
    """Each format round trip: a file in the agency's layout with samples known, read back."""
    step = 0.005
    gal = np.round(100.0 * np.random.default_rng(11).standard_normal(400), 5)
    counts = [int(c) for c in np.round(1e4 * np.random.default_rng(5).standard_normal(400)) - 10704]
    known = np.array(counts) * (3920.0 / 6182761.0)
    g = np.round(gal / 980.0, 6)
    channels = [("90 deg", "HNE", -gal), ("360 deg", "HNN", gal)]
    csmip = csmip_text([(orientation, samples) for orientation, _, samples in channels], step)
    with TemporaryDirectory() as folder, quiet():
        for name, file, text, component, expected in (
            ("AT2", "a.AT2", at2_text(g, step), None, g * STANDARD_GRAVITY),
            ("ESM", "a.ASC", esm_text(gal, step), None, 0.01 * gal),
            ("COSMOS", "a.V2c", cosmos_text(channels, step), "HNN", 0.01 * gal),
            ("CSMIP", "a.V2", csmip, "2", 0.01 * gal),
            ("K-NET", "a.NS", knet_text(counts, 200), None, 0.01 * (known - known.mean())),
            ("CSV", "a.csv", None, None, 0.01 * gal),
        ):
            path = Path(folder) / file
            if text is None:
                write_csv(Accelerogram(step, 0.01 * gal), path)
            else:
                path.write_text(text, encoding="utf-8")
            record = read_record(path, component=component)
            error = np.abs(record.acceleration - expected).max()
            rows.name = f"{name} round trip"
            rows.add("largest error of a sample", 0.0, error, "m/s2", 1e-12)
            rows.add("time step", step, record.time_step, "s", 1e-12)


@benchmark("EN 1998-1", "EN 1998-1:2004, 3.2.2.2, tables 3.2 and 3.3")
def eurocode_ordinates(rows: Rows) -> None:
    """EN 1998-1: ordinates at 0, T_B, T_C, T_D and 2 T_D from the standard's tables.

    With a_gR = 1 m/s2 and γ_I = 1: S, 2.5 S, 2.5 S, 2.5 S T_C/T_D, a quarter of that.
    """
    # Type, ground, S, T_C/T_D from tables 3.2 and 3.3; corner periods [s].
    hand = [
        (1, "A", 1.0, (0.15, 0.4, 2.0), 0.2), (1, "B", 1.2, (0.15, 0.5, 2.0), 0.25),
        (1, "C", 1.15, (0.2, 0.6, 2.0), 0.3), (1, "D", 1.35, (0.2, 0.8, 2.0), 0.4),
        (1, "E", 1.4, (0.15, 0.5, 2.0), 0.25), (2, "A", 1.0, (0.05, 0.25, 1.2), 25 / 120),
        (2, "B", 1.35, (0.05, 0.25, 1.2), 25 / 120), (2, "C", 1.5, (0.1, 0.25, 1.2), 25 / 120),
        (2, "D", 1.8, (0.1, 0.3, 1.2), 0.25), (2, "E", 1.6, (0.05, 0.25, 1.2), 25 / 120),
    ]  # fmt: skip
    for kind, ground, S, periods, falls in hand:
        spectrum = eurocode_spectrum(kind, ground, 1.0)
        T_B, T_C, T_D = periods
        frequency = np.array([np.inf, 1.0 / T_B, 1.0 / T_C, 1.0 / T_D, 0.5 / T_D])
        ordinates = spectrum.pseudo_acceleration(frequency)
        expected = S * np.array([1.0, 2.5, 2.5, 2.5 * falls, 0.625 * falls])
        error = np.abs(ordinates / expected - 1.0).max()
        quantity = f"type {kind}, ground {ground}: largest error at 0, T_B, T_C, T_D, 2 T_D"
        rows.add(quantity, 0.0, error, "-", 1e-12)
    damped = eurocode_spectrum(1, "B", 2.0, importance_factor=1.4, damping=0.1)
    plateau = damped.pseudo_acceleration(1.0 / 0.3)
    quantity = "plateau, type 1 B, a_gR 2 m/s2, γ_I 1.4, 10 %: 2 x 1.4 x 1.2 x 2.5 √(10/15)"
    rows.add(quantity, 6.858571279, plateau, "m/s2", 1e-9)
    source = "EN 1998-1:2004, 3.2.2.3, table 3.4"
    for kind, level in ((1, 0.9), (2, 0.45)):
        found = eurocode_spectrum(kind, "C", 1.0, vertical=True).pseudo_acceleration(10.0)
        quantity = f"vertical plateau, type {kind}: 3 x {level:g}"
        rows.add(quantity, 3.0 * level, found, "m/s2", 1e-12, source)


@benchmark("French decrees")
def decree_ordinates(rows: Rows) -> None:
    """The French decrees: plateaus and ordinates at 1 s in closed form."""
    ordinary = "arrêté of 22 October 2010, article 4"
    special = "arrêté of 4 October 2010, article 12-3"
    # Zone, ground, γ_I, text, vertical, period [s], ordinate by hand [m/s2], how, source.
    hand = [
        (1, "A", 1.0, "ordinary", False, 0.1, 1.0, "0.4 x 2.5", ordinary),
        (2, "E", 1.0, "ordinary", False, 1.0, 1.4175, "0.7 x 1.8 x 2.5 x 0.45", ordinary),
        (3, "D", 1.0, "ordinary", False, 0.3, 4.4, "1.1 x 1.6 x 2.5", ordinary),
        (4, "B", 1.2, "ordinary", False, 0.2, 6.48, "1.6 x 1.2 x 1.35 x 2.5", ordinary),
        (4, "C", 1.4, "ordinary", False, 1.0, 3.36, "1.6 x 1.4 x 1.5 x 2.5 x 0.4", ordinary),
        (5, "B", 1.0, "ordinary", False, 1.0, 4.5, "3.0 x 1.2 x 2.5 x 0.5", ordinary),
        (4, "B", 1.2, "special", False, 0.2, 5.76, "1.6 x 1.2 x 1.2 x 2.5", special),
        (4, "A", 1.0, "ordinary", True, 0.1, 3.84, "1.6 x 0.8 x 3", ordinary),
        (5, "A", 1.0, "ordinary", True, 0.2, 8.1, "3.0 x 0.9 x 3", ordinary),
    ]
    for zone, ground, factor, text, vertical, period, ordinate, how, source in hand:
        spectrum = decree_spectrum(
            zone, ground, importance_factor=factor, text=text, vertical=vertical
        )
        way = "vertical" if vertical else f"ground {ground}"
        quantity = f"zone {zone}, {way}, {text}, at {period:g} s: {how}"
        found = spectrum.pseudo_acceleration(1.0 / period)
        rows.add(quantity, ordinate, found, "m/s2", 1e-12, source)
