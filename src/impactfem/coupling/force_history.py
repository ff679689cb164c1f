"""The impact-force history: what the pounding hands to the 3D model (`forces.nc`, or CSV).

`forces.nc` is NetCDF 4 with the dimensions `time`, `pair` and `axis` (x, y, z):

- `time` (time) [s], uniform, from 0
- `force` (time, pair) [N], positive in compression: building a feels -F n, building b feels +F n
- `pair` (pair): unique names
- `building_a`, `building_b` (pair): names; an empty `building_b` is a rigid wall
- `floor_a`, `floor_b` (pair): floor numbers
- `relative_height_a`, `relative_height_b` (pair): 0 to 1 in the storey below that floor, nan for a
  point of the floor itself
- `offset_a`, `offset_b` (pair, axis) [m]: from the building's axis at that height
- `normal` (pair, axis): unit vector n from a to b
- `hat_a`, `hat_b` (pair, place) [m], of points along which 3D models touch: where on the struck
  side the line load of the force begins, is highest and ends; three times where it acts inside a
  storey, and on the floor that meets a column there; of a line contact on a storey begin, middle
  and end of its part of the strip. nan for other pairs
- `line` (pair): the pair of the case along whose line the point is; empty for other pairs
- `gap` (pair) [m], `law` (pair): the contact law in words and numbers
- attributes `title`, `case_hash`, and `inputs`, the hash of what the stage depends on

A file of another program needs `time`, `force` and `pair`; of the rest what is there is read and
must be whole.

A CSV file has the columns `time [s]` and one `<pair name> [N]` for each pair, or other units of
time and force; points and normals come from the case file then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from impactfem.case.table import name_and_unit, read_numbers, unit_of_column
from impactfem.coupling.pounding import End, Pair, Response
from impactfem.system.arrays import Array
from impactfem.system.errors import Fault, InputError
from impactfem.system.executor import read_in_own_process
from impactfem.system.files import LARGEST_FORCES, atomic, unreadable, write_netcdf
from impactfem.system.scalar import words

AXES = ["x", "y", "z"]
UNIT_TOLERANCE = 1e-6  # of the length of a normal


class Side(NamedTuple):
    """Part of a building that several pairs push together."""

    floor: int  #: number of the floor, or of the one above the storey
    relative_height: float | None  #: in the storey; None for the floor itself
    outward: tuple[float, ...]  #: the normal from this building to the other one
    other: str  #: name of the other building; empty for a rigid wall


@dataclass(frozen=True)
class PairEnds:
    """Ends of the pairs of a force history, if its file gives them.

    Each is None where the file does not have it.
    """

    building_a: tuple[str, ...] | None = None  #: names of the first buildings
    building_b: tuple[str, ...] | None = None  #: names of the second ones; empty for a rigid wall
    #: Numbers of the floors on the first buildings, or of those above the storeys.
    floor_a: tuple[int, ...] | None = None
    #: Floors of the second ones; no meaning for a rigid wall.
    floor_b: tuple[int, ...] | None = None
    #: Heights in the storeys, 0 to 1, nan on the floors themselves; shape (m,).
    relative_height_a: Array | None = None
    relative_height_b: Array | None = None  #: on the second buildings
    offset_a: Array | None = None  #: from the axes of the first buildings, shape (m, 3) [m]
    offset_b: Array | None = None  #: on the second buildings
    normal: Array | None = None  #: unit vectors from a to b, shape (m, 3)
    hat_a: Array | None = None  #: of line loads on the first buildings, shape (m, 3) [m]
    hat_b: Array | None = None  #: on the second buildings
    line: tuple[str, ...] | None = None  #: lines that they are points of; empty for pairs

    @classmethod
    def of_pairs(cls, pairs: Sequence[Pair]) -> PairEnds:
        """Return the ends of pairs."""
        content: dict[str, Any] = {
            "normal": np.array([pair.normal for pair in pairs]).reshape(-1, 3)
        }
        if any(pair.line for pair in pairs):
            content["line"] = tuple(pair.line for pair in pairs)
        hats_known = any(pair.hats is not None for pair in pairs)
        for k, side in enumerate("ab"):
            # A rigid wall has no name.
            ends = [getattr(pair, side) or End("", 0, (0.0, 0.0, 0.0), 0) for pair in pairs]
            heights = [np.nan if e.relative_height is None else e.relative_height for e in ends]
            content[f"building_{side}"] = tuple(end.building for end in ends)
            content[f"floor_{side}"] = tuple(end.floor for end in ends)
            content[f"relative_height_{side}"] = np.array(heights, dtype=float)
            content[f"offset_{side}"] = np.array([end.offset for end in ends]).reshape(-1, 3)
            if hats_known:
                hats = [np.full(3, np.nan) if p.hats is None else p.hats[k] for p in pairs]
                content[f"hat_{side}"] = np.array(hats)
        return cls(**content)

    def of(self, columns: Sequence[int]) -> PairEnds:
        """Return the ends of some of the pairs, by their indices."""
        chosen: dict[str, Any] = {}
        for name, values in vars(self).items():
            if isinstance(values, tuple):
                chosen[name] = tuple(values[j] for j in columns)
            elif values is not None:
                chosen[name] = values[list(columns)]
        return PairEnds(**chosen)

    def sides(self, building: str) -> dict[Side, list[int]]:
        """The pairs that touch each side of each floor of a building, by their indices.

        Those on one side, as at the corners of a floor or along a line, push it together.
        ValueError where the ends of the pairs are not known.
        """
        found: dict[Side, list[int]] = {}
        ends = (
            (1.0, self.building_a, self.floor_a, self.relative_height_a, self.building_b),
            (-1.0, self.building_b, self.floor_b, self.relative_height_b, self.building_a),
        )
        for sign, own, floors, heights, others in ends:
            if own is None or floors is None or heights is None or others is None:
                raise ValueError("it is not known what the pairs are between")
            for j in np.flatnonzero([name == building for name in own]):
                height = None if np.isnan(heights[j]) else float(heights[j])
                outward = tuple((sign * np.asarray(self.normal)[j] + 0.0).tolist())
                side = Side(floors[j], height, outward, others[j])
                found.setdefault(side, []).append(int(j))
        return found

    @classmethod
    def read(cls, path: Path, dataset: xr.Dataset, faults: list[Fault]) -> PairEnds:
        """Read the ends of the pairs from `forces.nc`; an invalid variable is a fault.

        Variables that are not there, or are at fault, stay None.
        """
        content: dict[str, Any] = {}
        if "axis" in dataset.variables and [str(word) for word in dataset["axis"].values] != AXES:
            found = [str(word) for word in dataset["axis"].values]
            faults.append(Fault(path, "axis", found, "x, y, z"))
        for name in vars(cls()):
            if name not in dataset.variables:
                continue
            values, expected = dataset[name].values, "(pair)"
            dims: tuple[str, ...] = ("pair",)
            vector = name == "normal" or name.startswith("offset")
            if vector:
                dims, expected = ("pair", "axis"), "(pair, axis), of x, y, z"
            if name.startswith("hat"):
                dims, expected = ("pair", "place"), "(pair, place), of three places"
            over = dataset[name].dims
            if over != dims or values.shape[1:] not in ((), (len(AXES),)):
                faults.append(Fault(path, name, over, f"expected the dimensions {expected}"))
                continue
            if name.startswith(("building", "line")):
                content[name] = tuple(str(value) for value in values)
                continue
            x = np.array(values, dtype=float)
            if name.startswith("floor"):
                good, expected = np.isfinite(x) & (x == np.round(x)), "whole numbers"
            elif name == "normal":
                good = np.abs(np.linalg.norm(x, axis=1) - 1.0) < UNIT_TOLERANCE
                expected = "a unit vector (x, y, z) for each pair"
            elif vector:
                good, expected = np.isfinite(x), "finite lengths [m]"
            elif name.startswith("hat"):
                good = np.isnan(x).all(axis=1) | (np.diff(x, axis=1) >= 0.0).all(axis=1)
                expected = "three ascending positions [m] for each pair, or nan"
            else:
                good, expected = np.isnan(x) | ((x >= 0.0) & (x <= 1.0)), "0 to 1, or nan"
            if not np.all(good):
                faults.append(Fault(path, name, x.tolist(), expected))
            else:
                content[name] = tuple(map(int, x)) if name.startswith("floor") else x
        return cls(**content)


FORCES = "a force history (NetCDF or CSV)"
OTHER_FORCES = "forces_other_step.nc"
"""File of the forces of a run with another time step, which shows what the step changes."""
REQUIRED = {"time": "s", "force": "N"}
MOST_STEPS = 10_000_000
"""Largest number of rows of a CSV file."""
PRESSES = 0.01
"""Part of the largest force above which an impact presses."""


def around_peak(force: Array, part: float = PRESSES) -> tuple[int, int]:
    """First sample, and the one behind the last, about the largest of a force in size.

    Between them the force has the sense of the largest one, and more than a part of its size. The
    samples next to an impact, in which resampled forces alternate, are outside.
    """
    peak = int(np.argmax(np.abs(force)))
    rest = np.flatnonzero(force / force[peak] <= part)
    first = int(rest[rest < peak].max(initial=-1)) + 1
    return first, int(rest[rest > peak].min(initial=len(force)))


@dataclass(frozen=True)
class ForceHistory:
    """Impact forces over time."""

    time: Array  #: times, uniform, shape (n_t,) [s]
    pairs: tuple[str, ...]  #: unique names of the pairs
    force: Array  #: forces, positive in compression, shape (n_t, m) [N]
    case_hash: str = ""  #: hash of the case that made them; empty where unknown
    inputs: str = ""  #: hash of what the stage that made them depends on; empty where unknown
    #: Ends of the pairs, if the file gives them.
    ends: PairEnds = field(default_factory=PairEnds)

    @classmethod
    def of_response(cls, response: Response) -> ForceHistory:
        """The forces of a response, of pairs of points or of the points of lines."""
        pairs, force = response.exerted
        names = tuple(pair.name for pair in pairs)
        return cls(response.time, names, force, ends=PairEnds.of_pairs(pairs))

    def of(self, columns: Sequence[int]) -> ForceHistory:
        """Return the history of some of the pairs, by their indices."""
        pairs, force = tuple(self.pairs[j] for j in columns), self.force[:, list(columns)]
        return replace(self, pairs=pairs, force=force, ends=self.ends.of(columns))

    def write_csv(self, path: Path) -> None:
        """Write it as CSV with units in the header."""
        with atomic(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as stream:
            stream.write(",".join(["time [s]", *(f"{name} [N]" for name in self.pairs)]) + "\n")
            formats = ["%.17g"] + ["%.9g"] * len(self.pairs)
            lines: Any = stream  # text; NumPy's stubs disagree on what it may be
            np.savetxt(lines, np.column_stack([self.time, self.force]), formats, ",")


def write_forces(path: Path, response: Response, case_hash: str, key: str = "") -> None:
    """Write the forces of a response as `forces.nc` (see the module) in one piece.

    The key, the attribute `inputs`, is the hash of what the stage depends on.
    """
    pairs, force = response.exerted
    of_force = {"units": "N", "long_name": "contact force, positive in compression"}
    data: dict[str, tuple[object, ...]] = {
        "force": (("time", "pair"), force, of_force),
        "gap": ("pair", np.array([pair.gap for pair in pairs]), {"units": "m"}),
        "law": ("pair", words(pair.law.describe() for pair in pairs)),
    }
    for name, values in vars(PairEnds.of_pairs(pairs)).items():
        if name.startswith(("building", "line")) and values is not None:
            data[name] = "pair", words(values)
        elif name.startswith(("offset", "hat")) and values is not None:
            second = "place" if name.startswith("hat") else "axis"
            data[name] = ("pair", second), values, {"units": "m"}
        elif values is not None:
            data[name] = ("pair", "axis") if name == "normal" else "pair", np.array(values)
    dataset = xr.Dataset(
        data,
        coords={
            "time": ("time", response.time, {"units": "s"}),
            "pair": ("pair", words(pair.name for pair in pairs)),
            "axis": ("axis", words(AXES)),
        },
        attrs={"title": "impact forces between buildings", "case_hash": case_hash, "inputs": key},
    )
    write_netcdf(path, dataset)


def check_forces(path: Path) -> ForceHistory:
    """Read a force history that is given, and see that `read_forces` can. Not collective.

    HDF5 may crash on a damaged file of NetCDF: a separate process reads it first.

    Raises:
        InputError: As `read_forces`; or HDF5 crashed.
    """
    if path.suffix.lower() == ".csv":
        return read_forces(path)
    return read_in_own_process(read_forces, path, FORCES)


def read_forces(path: Path) -> ForceHistory:
    """Read `forces.nc` or a CSV of the same content, from this program or another.

    Raises:
        InputError: The file cannot be read, or lacks something, or holds values that are not
            finite, or its time is not uniform.
    """
    fault = unreadable(path, FORCES, LARGEST_FORCES)
    if fault is not None:
        raise InputError([fault])
    try:
        history = _read_csv(path) if path.suffix.lower() == ".csv" else _read_netcdf(path)
    except (OSError, ValueError) as error:
        raise InputError(
            [Fault(path, "", None, f"expected a readable force history (NetCDF or CSV): {error}")]
        ) from error
    faults = []
    steps = np.diff(history.time)
    if history.time.size < 2 or not np.all(steps > 0.0):
        faults.append(Fault(path, "time", None, "expected at least two times, ascending"))
    elif np.abs(steps - steps.mean()).max() > 1e-6 * steps.mean():
        k, usual = int(np.abs(steps - steps.mean()).argmax()), float(np.median(steps))
        expected = f"expected a uniform time step, {usual:.9g} s (with enough digits)"
        key = f"time, between {history.time[k]:.9g} and {history.time[k + 1]:.9g} s"
        faults.append(Fault(path, key, None, expected))
    elif abs(history.time[0]) > 1e-6 * steps.mean():
        faults.append(Fault(path, "time", float(history.time[0]), "expected a first time of 0 s"))
    if not (np.isfinite(history.time).all() and np.isfinite(history.force).all()):
        faults.append(Fault(path, "force", "nan", "expected finite values only"))
    if len(set(history.pairs)) < len(history.pairs):
        expected = "expected a unique name for each pair"
        faults.append(Fault(path, "pair", list(history.pairs), expected))
    if faults:
        raise InputError(faults)
    return history


def _read_netcdf(path: Path) -> ForceHistory:
    with xr.open_dataset(path, engine="netcdf4") as dataset:
        faults = []
        for name, unit in REQUIRED.items():
            if name not in dataset.variables:
                expected = f"expected a variable of this name in {unit}"
                faults.append(Fault(path, name, None, expected))
            elif dataset[name].attrs.get("units") != unit:
                found = dataset[name].attrs.get("units")
                faults.append(Fault(path, f"{name}.units", found, f"expected the unit {unit!r}"))
        if "pair" not in dataset.variables:
            faults.append(Fault(path, "pair", None, "expected the names of the contact pairs"))
        elif not faults and dataset["force"].dims != ("time", "pair"):
            found = dataset["force"].dims
            faults.append(Fault(path, "force", found, "expected the dimensions (time, pair)"))
        ends = PairEnds() if faults else PairEnds.read(path, dataset, faults)
        if faults:
            raise InputError(faults)
        return ForceHistory(
            time=np.array(dataset["time"], dtype=float),
            pairs=tuple(str(name) for name in dataset["pair"].values),
            force=np.array(dataset["force"], dtype=float),
            case_hash=str(dataset.attrs.get("case_hash", "")),
            inputs=str(dataset.attrs.get("inputs", "")),
            ends=ends,
        )


def _read_csv(path: Path) -> ForceHistory:
    faults, example = list[Fault](), "time [s],<pair name> [N]"
    what = f"a force history (CSV) with the header {example}"
    table = read_numbers(path, what, example, faults, MOST_STEPS, LARGEST_FORCES)
    if table is None:
        raise InputError(faults)
    number, header = table.header
    if name_and_unit(header[0])[0] != "time":
        expected = "expected the first column 'time [s]'"
        raise InputError([Fault(path, f"line {number}", header[0] or None, expected)])
    factors = []
    for k, cell in enumerate(header):
        factor = unit_of_column(cell, "N" if k else "s")
        if isinstance(factor, str):
            faults.append(Fault(path, f"line {number}, column {cell}", None, factor))
        else:
            factors.append(factor)
    if len(header) < 2:
        expected = "expected a column '<pair name> [N]' for each pair"
        faults.append(Fault(path, f"line {number}", None, expected))
    if len(table.values) < 2:
        faults.append(
            Fault(path, "", None, "expected at least two lines of values below the header")
        )
    if faults:
        raise InputError(faults)
    values = table.values * np.array(factors)
    names = tuple(name_and_unit(cell)[0] for cell in header[1:])
    return ForceHistory(values[:, 0], names, values[:, 1:])
