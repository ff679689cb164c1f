"""Gap, floor acceleration and storey drift of a run against their limits."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.case import Building, Case
from impactfem.case.capacities import GapRule
from impactfem.stages.stores import names_of, open_store
from impactfem.stages.verdict import Verdict, pair_words
from impactfem.system.arrays import Array

LEVEL = 0.1
"""Largest difference of the elevations of floors that are level [m]."""
LEVEL_FACTOR = 0.7
"""Factor on the gap of buildings with level floors: EN 1998-1, 4.4.2.7(3)."""
RULES = {"en1998": "EN 1998-1, 4.4.2.7", "asce7": "ASCE 7, 12.12.3"}


def code_gap(rule: GapRule, a: float, b: float, *, level: bool) -> float:
    """Return the gap that a code requires between two buildings [m].

    EN 1998-1, 4.4.2.7(2)b and (3): the root of the sum of the squares of the largest horizontal
    displacements, times 0.7 for level floors. ASCE 7, equation 12.12-2: the same root of the
    maximum inelastic displacements δ_M = C_d δ_max / I_e. The displacements of an elastic time
    history are not reduced by a behaviour factor: d_s and δ_M are these displacements.

    Args:
        rule: The code.
        a: Largest displacement of one building at the level of the pair [m].
        b: Largest displacement of the other building; 0 for a wall [m].
        level: Whether the floors of both buildings are level.
    """
    factor = LEVEL_FACTOR if level and rule == "en1998" else 1.0
    return factor * math.hypot(a, b)


def level_floors(a: Building, b: Building) -> bool:
    """Return True if both buildings have the same floor elevations up to the lower roof."""
    levels = [sorted(one.levels.values()) for one in (a, b)]
    count = min(map(len, levels))
    pairs = zip(levels[0][:count], levels[1][:count], strict=True)
    if not all(abs(low - high) <= LEVEL for low, high in pairs):
        return False
    higher = max(levels, key=len)
    return len(higher) == count or higher[count] > min(one[-1] for one in levels) + LEVEL


def pounding_verdicts(case: Case, folder: Path) -> list[Verdict]:
    """Return the verdicts of the stage, from `pounding.nc` of a run's folder."""
    with open_store(folder / "pounding.nc") as store:
        return verdicts_of(case, store)


def verdicts_of(case: Case, store: xr.Dataset) -> list[Verdict]:
    """Return the verdicts of a case, from results as in `pounding.nc`."""
    gaps = _gaps(case, store) if store.sizes.get("pair") else []
    return [*gaps, *_accelerations(case, store), _drift(case, store)]


def _gaps(case: Case, store: xr.Dataset) -> list[Verdict]:
    """Gap of the pair with the largest ratio, by the time history and by the code."""
    gaps = store["pair_rest_gap"].values
    pairs = names_of(store, "pair")

    def worst(required: Array) -> int:
        with np.errstate(divide="ignore", invalid="ignore"):
            return int(np.nan_to_num(required / gaps, posinf=np.inf).argmax())

    required = store["pair_required_separation"].values
    k = worst(required)
    found = [
        Verdict(
            "pounding.required_gap",
            "gap required to avoid contact",
            "m",
            pair_words(pairs[k]),
            float(required[k]),
            float(gaps[k]),
            detail="by the time history without contact",
        )
    ]
    rule = case.limits.gap
    if rule is None:
        none = Verdict(
            "pounding.code_gap",
            "gap required by the code",
            "m",
            pair_words(pairs[k]),
            None,
            key="limits.gap",
        )
        return [*found, none]
    moved = np.nan_to_num([store[f"pair_displacement_{end}"].values for end in "ab"])
    buildings = {one.name: one for one in case.buildings}
    level = [
        a in buildings and level_floors(buildings[a], buildings[b])
        for a, b in (_buildings(case, name) for name in pairs)
    ]
    by_code = np.array(
        [code_gap(rule, *ends, level=one) for ends, one in zip(moved.T, level, strict=True)]
    )
    k = worst(by_code)
    factor = f"; factor {LEVEL_FACTOR:g} for level floors" if rule == "en1998" and level[k] else ""
    a, b = 1e3 * moved[:, k]
    detail = f"{RULES[rule]}: displacements without contact {a:.3g} and {b:.3g} mm{factor}"
    code = Verdict(
        "pounding.code_gap",
        "gap required by the code",
        "m",
        pair_words(pairs[k]),
        float(by_code[k]),
        float(gaps[k]),
        "limits.gap",
        detail=detail,
    )
    return [*found, code]


def _buildings(case: Case, pair: str) -> tuple[str, str]:
    """Return the names of the buildings of a pair; "" for a wall."""
    names = next((one.buildings for one in case.contacts if one.name == pair), ())
    return (names[0], names[1]) if len(names) > 1 else ("", "")


def _accelerations(case: Case, store: xr.Dataset) -> list[Verdict]:
    """Largest zero-period acceleration of a floor, in the resolved band."""
    zpa = store["zpa"].load()
    if not zpa.size:
        return []
    at = zpa.isel(zpa.argmax(...))
    place = f"{at['station_building'].item()}, floor {at['station_floor'].item()}"
    return [
        floor_acceleration(
            "pounding.floor_acceleration",
            case,
            f"{place}, direction {at['direction'].item()}",
            at,
            store["zpa_free"],
            float(store.attrs["resolved_frequency"]),
        )
    ]


def floor_acceleration(
    id: str, case: Case, place: str, zpa: xr.DataArray, free: xr.DataArray | None, end: float
) -> Verdict:
    """Return the verdict of the ZPA of a floor, with the ZPA of all floors without impact.

    `end` is the end of the resolved band [Hz].
    """
    return Verdict(
        id,
        "floor acceleration (ZPA)",
        "m/s2",
        place,
        float(zpa),
        case.limits.floor_acceleration,
        "limits.floor_acceleration",
        demand_without_impact=None if free is None else float(free.max()),
        band=(0.0, end),
    )


def _drift(case: Case, store: xr.Dataset) -> Verdict:
    drift = store["storey_drift"]
    at = drift.isel(station=int(drift.values.argmax()))
    return Verdict(
        "pounding.storey_drift",
        "storey drift / storey height",
        "-",
        f"{at['station_building'].item()}, storey below floor {at['station_floor'].item()}",
        float(at),
        case.limits.storey_drift,
        "limits.storey_drift",
        demand_without_impact=float(store["storey_drift_no_contact"].max()),
    )
