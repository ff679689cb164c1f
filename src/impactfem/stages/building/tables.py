"""Tables of the stage `building`, from its store: bending modes, all modes, floor masses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import xarray as xr

from impactfem.case.bays import Bay
from impactfem.plot.table import Cell, Table
from impactfem.stages.stores import open_store
from impactfem.system.log import LOGGER


def building_tables(
    folder: Path, published: Mapping[str, float], bays: Sequence[Bay] = ()
) -> list[Path]:
    """Write the tables of the stage into `tables/` and into the log.

    Args:
        folder: The run's folder, with `building.nc`.
        published: Published values in SI by the name of the result.
        bays: The openings in the walls of a generated mesh.

    Returns:
        The files.
    """
    with open_store(folder / "building.nc") as store:
        tables = [_bending(store, published), _modes(store), _floors(store, published)]
    if bays:
        tables.append(_bays(bays))
    target = folder / "tables"
    target.mkdir(exist_ok=True)
    for table in tables:
        LOGGER.debug("\n%s", table.as_text())
    return [table.write_csv(target) for table in tables]


def _bays(bays: Sequence[Bay]) -> Table:
    """Table 1 of the paper: each size of opening, and how often it occurs."""
    counts = Counter((bay.bay, bay.storey, bay.width, bay.height) for bay in bays)
    return Table(
        "building_bays",
        "Openings in the walls",
        (
            ("bay", ""),
            ("storey", ""),
            ("width", "cm"),
            ("height", "cm"),
            ("area", "m2"),
            ("number", "-"),
        ),
        tuple(
            (name, storey, 100.0 * width, 100.0 * height, width * height, number)
            for (name, storey, width, height), number in counts.items()
        ),
    )


def _bending(store: xr.Dataset, published: Mapping[str, float]) -> Table:
    """Tables 2 and 3 of the paper, columns of the 3D mesh."""
    direction = str(store.attrs["bending_direction"])
    rows: list[tuple[Cell, ...]] = []
    for number, mode in enumerate(store["bending_mode"].values, start=1):
        one = store.sel(mode=int(mode))
        frequency = float(one["frequency"])
        mass = float(one["effective_mass"].sel(direction=direction))
        theirs = published.get(f"building.frequency.{number}")
        their_mass = published.get(f"building.effective_mass.{number}")
        rows.append(
            (
                number,
                int(mode),
                frequency,
                theirs,
                None if theirs is None else 100.0 * (frequency / theirs - 1.0),
                mass / 1e3,
                None if their_mass is None else their_mass / 1e3,
                None if their_mass is None else 100.0 * (mass / their_mass - 1.0),
            )
        )
    return Table(
        "building_bending_modes",
        f"Bending modes of the 3D building {store.attrs['building']} that move along {direction}",
        (
            ("bending mode", ""),
            ("mode of all", ""),
            ("frequency", "Hz"),
            ("published frequency", "Hz"),
            ("difference of frequency", "%"),
            ("effective mass", "t"),
            ("published effective mass", "t"),
            ("difference of mass", "%"),
        ),
        tuple(rows),
    ).comparing(
        {
            *("published frequency", "difference of frequency"),
            *("published effective mass", "difference of mass"),
        }
    )


def _modes(store: xr.Dataset) -> Table:
    total = store["total_mass"].values
    rows: list[tuple[Cell, ...]] = []
    for mode in store["mode"].values:
        one = store.sel(mode=int(mode))
        shares = 100.0 * one["effective_mass"].values / total
        rows.append((int(mode), float(one["frequency"]), *(float(share) for share in shares)))
    directions = [str(name) for name in store["direction"].values]
    return Table(
        "building_modes",
        "Modes of the 3D building and their effective masses, as parts of the whole; rotations "
        "about the middle of the base",
        (("mode", ""), ("frequency", "Hz"), *((f"effective mass {d}", "%") for d in directions)),
        tuple(rows),
    )


def _floors(store: xr.Dataset, published: Mapping[str, float]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for floor in store["floor"].values:
        one = store.sel(floor=int(floor))
        mass, added = float(one["floor_mass"]), float(one["floor_added_mass"])
        theirs = published.get(f"building.floor_mass.{int(floor)}")
        rows.append(
            (
                int(floor),
                (mass - added) / 1e3,
                added / 1e3,
                mass / 1e3,
                None if theirs is None else theirs / 1e3,
            )
        )
    return Table(
        "building_floor_masses",
        "Masses of the floors of the 3D building: of its parts, added, and together",
        (
            ("floor", ""),
            ("parts", "t"),
            ("added", "t"),
            ("mass", "t"),
            ("published mass", "t"),
        ),
        tuple(rows),
    ).comparing({"published mass"})
