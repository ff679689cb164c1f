"""What the stores of a run found, and what its stages handed over to one another."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import xarray as xr

from impactfem.stages.open_store import open_store
from impactfem.system.scalar import from_json

STORES = ("motion", "building", "calibrate", "pounding", "ensemble", "transient", "device")
MAIN = "pounding.main_impact_force"
SAME = 1e-9
"""Relative difference of a value that was handed over from the one that was found."""


@dataclass(frozen=True, eq=False)
class Found:
    """What the stores of a run hold.

    Args:
        values: Scalars by name.
        stores: Names of the stores.
        direction: The one that is shown; "" before any stage knows it.
        devices: Names of the devices.
        stiffness: Contact stiffness of the pairs of points [N/m].
        targets: Frequencies that the sticks are fitted to [Hz].
        main_pair: Which pair has the largest impact force; "" where nothing touched.
    """

    values: Mapping[str, float]
    stores: frozenset[str]
    direction: str
    devices: tuple[str, ...]
    stiffness: tuple[float, ...] = ()
    targets: tuple[float, ...] = ()
    main_pair: str = ""

    def numbers(self, pattern: str) -> dict[str, float]:
        """Scalars whose whole name matches, by the first group of the pattern."""
        found = ((re.fullmatch(pattern, name), v) for name, v in self.values.items())
        return {match[1]: value for match, value in found if match is not None}

    def hands_over(self, start: str, end: str) -> bool:
        """Whether a step used what another one found, rather than values that the case gives."""
        if (start, end) == ("wall", "pounding"):
            ours = self.values.get("calibration.K_Ceq", math.nan)
            return any(math.isclose(ours, value, rel_tol=SAME) for value in self.stiffness)
        if (start, end) == ("building", "sticks"):
            modes = self.numbers(r"building\.frequency\.(\d+)").values()
            return any(math.isclose(a, b, rel_tol=SAME) for a in modes for b in self.targets)
        return True


def read_found(folder: Path) -> Found:
    """What the stores of a folder hold; scalars without a value are left out."""
    values: dict[str, float] = {}
    stores: set[str] = set()
    devices: tuple[str, ...] = ()
    stiffness: tuple[float, ...] = ()
    targets: tuple[float, ...] = ()
    direction = main_pair = ""
    for name in STORES:
        path = folder / f"{name}.nc"
        if not path.is_file():
            continue
        stores.add(name)
        with open_store(path) as store:
            scalars = from_json(store.attrs.get("scalars", "[]"))
            values |= {s.name: s.value for s in scalars if s.value is not None}
            direction = str(store.attrs.get("shown_direction", direction))
            if name == "pounding":
                main_pair = next(
                    (s.note for s in scalars if s.name == MAIN and s.value is not None), ""
                )
                stiffness, targets = (
                    _list(store, "pair_stiffness"),
                    _list(store, "target_frequency"),
                )
            if name == "device":
                devices = tuple(str(device) for device in store["device"].values)
    return Found(values, frozenset(stores), direction, devices, stiffness, targets, main_pair)


def _list(store: xr.Dataset, name: str) -> tuple[float, ...]:
    return tuple(float(value) for value in store[name].values) if name in store else ()
