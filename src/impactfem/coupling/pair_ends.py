"""What the pairs of a force history are between: buildings, floors, heights and normals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.system.errors import Fault

Array = NDArray[np.float64]
AXES = ["x", "y", "z"]
UNIT_TOLERANCE = 1e-6  # of the length of a normal


@dataclass(frozen=True)
class PairEnds:
    """What the pairs of a force history are between, as far as its file says so.

    Each is None where the file does not have it.

    Args:
        building_a: Names of the first buildings.
        building_b: Names of the second ones; empty for a rigid wall.
        floor_a: Numbers of the floors on the first buildings, or of those above the storeys.
        floor_b: The same on the second ones; without meaning for a rigid wall.
        relative_height_a: Heights in the storeys, 0 to 1, nan on the floors themselves; shape (m,).
        relative_height_b: The same on the second buildings.
        normal: Unit vectors from a to b, shape (m, 3).
    """

    building_a: tuple[str, ...] | None = None
    building_b: tuple[str, ...] | None = None
    floor_a: tuple[int, ...] | None = None
    floor_b: tuple[int, ...] | None = None
    relative_height_a: Array | None = None
    relative_height_b: Array | None = None
    normal: Array | None = None

    def of(self, columns: Sequence[int]) -> PairEnds:
        """Those of some of the pairs, by their indices."""
        return PairEnds(
            building_a=_chosen(self.building_a, columns),
            building_b=_chosen(self.building_b, columns),
            floor_a=_chosen(self.floor_a, columns),
            floor_b=_chosen(self.floor_b, columns),
            relative_height_a=_rows(self.relative_height_a, columns),
            relative_height_b=_rows(self.relative_height_b, columns),
            normal=_rows(self.normal, columns),
        )


def read_ends(path: Path, dataset: xr.Dataset, faults: list[Fault]) -> PairEnds:
    """Read what the pairs are between from `forces.nc` (see `force_history`).

    Args:
        path: The file.
        dataset: Its content.
        faults: What is there and wrong is appended here.
    """

    def read(name: str, good: Callable[[Array], Any], expected: str) -> Array | None:
        """Numbers of the pairs; nothing when there are none or they are at fault."""
        values = _of_pairs(path, dataset, name, faults)
        if values is None:
            return None
        numbers = np.array(values, dtype=float)
        if not np.all(good(numbers)):
            faults.append(Fault(path, name, numbers.tolist(), expected))
            return None
        return numbers

    def names(name: str) -> tuple[str, ...] | None:
        values = _of_pairs(path, dataset, name, faults)
        return None if values is None else tuple(str(value) for value in values)

    def floors(name: str) -> tuple[int, ...] | None:
        numbers = read(name, lambda x: np.isfinite(x) & (x == np.round(x)), "whole numbers")
        return None if numbers is None else tuple(int(number) for number in numbers)

    def heights(name: str) -> Array | None:
        return read(name, lambda x: np.isnan(x) | ((x >= 0.0) & (x <= 1.0)), "0 to 1, or nan")

    if "axis" in dataset.variables and [str(word) for word in dataset["axis"].values] != AXES:
        found = [str(word) for word in dataset["axis"].values]
        faults.append(Fault(path, "axis", found, "x, y, z"))
    return PairEnds(
        building_a=names("building_a"),
        building_b=names("building_b"),
        floor_a=floors("floor_a"),
        floor_b=floors("floor_b"),
        relative_height_a=heights("relative_height_a"),
        relative_height_b=heights("relative_height_b"),
        normal=read(
            "normal",
            lambda n: np.abs(np.linalg.norm(n, axis=1) - 1.0) < UNIT_TOLERANCE,
            "a unit vector (x, y, z) for each pair",
        ),
    )


def _of_pairs(path: Path, dataset: xr.Dataset, name: str, faults: list[Fault]) -> Any:
    """The values of a variable over the pairs; None when it is not there or over anything else."""
    if name not in dataset.variables:
        return None
    found = dataset[name].dims
    wanted = ("pair", "axis") if name == "normal" else ("pair",)
    if found != wanted or (name == "normal" and dataset.sizes["axis"] != len(AXES)):
        words = "(pair, axis), of x, y, z" if name == "normal" else "(pair)"
        faults.append(Fault(path, name, found, f"expected the dimensions {words}"))
        return None
    return dataset[name].values


def _chosen(values: tuple[Any, ...] | None, columns: Sequence[int]) -> Any:
    return None if values is None else tuple(values[j] for j in columns)


def _rows(values: Array | None, columns: Sequence[int]) -> Array | None:
    return None if values is None else values[list(columns)]
