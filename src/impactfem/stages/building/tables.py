"""Tables of the stage `building`: modes, masses and inertias of floors, sections of storeys."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.building.floor_properties import UNITS
from impactfem.case.floors import Floor
from impactfem.case.members import Bay
from impactfem.plot.table import Table, columns_of, heads, variables, write_tables
from impactfem.stages.stores import open_store

BESIDE_FLOOR_TABLE = (
    (
        "building_floor_inertias",
        "Inertias of the floors of the 3D building about their mass centres, walls and columns by "
        "the lever rule, next to those of the floor table, which the sticks have",
        "floor",
        ("Jx", "Jy", "Jz"),
    ),
    (
        "building_storey_sections",
        "Sections of the storeys of the 3D building where openings leave the least area, next to "
        "those of the floor table, which the sticks have",
        "storey",
        ("A", "Avy", "Avx", "Ix", "Iy"),
    ),
)
"""Name, title and first column of the tables beside the floor table, and what they compare."""


def building_tables(
    folder: Path,
    published: Mapping[str, float],
    floors: Sequence[Floor] = (),
    bays: Sequence[Bay] = (),
) -> list[Path]:
    """Write the tables of `building.nc`, and of the bays, into `tables/` and into the log.

    Inertias and sections stand next to those of the rows of the floor table.

    Published values are in SI by the name of the result.
    """
    with open_store(folder / "building.nc") as store:
        tables = [_bending(store, published), _modes(store), _floors(store, published)]
        for name, title, what, quantities in BESIDE_FLOOR_TABLE if floors else ():
            if getattr(floors[0], quantities[0]) is None:
                continue  # storeys by their stiffness have no section
            columns = [(what, "")]
            values: list[list[float]] = [[floor.floor for floor in floors]]
            for quantity in quantities:
                given = [float(getattr(floor, quantity)) for floor in floors]
                found = [float(one) for one in store[f"floor_{quantity}"].values]
                off = [100.0 * (a / b - 1.0) for a, b in zip(found, given, strict=True)]
                symbol, unit = f"{quantity[0]}_{quantity[1:]}".rstrip("_"), UNITS[quantity]
                columns += [(symbol, unit), (f"{symbol} of the table", unit)]
                columns.append((f"difference of {symbol}", "%"))
                values += [found, given, off]
            rows = tuple(zip(*values, strict=True))
            tables.append(Table(name, title, tuple(columns), rows))
    if bays:
        # Table 1 of the paper: each size of opening, and how often it occurs.
        counts = Counter((bay.bay, bay.storey, bay.width, bay.height) for bay in bays)
        sizes = tuple(
            (name, storey, 100.0 * width, 100.0 * height, width * height, number)
            for (name, storey, width, height), number in counts.items()
        )
        header = heads("bay; storey; width [cm]; height [cm]; area [m2]; number [-]")
        tables.append(Table("building_bays", "Openings in the walls", header, sizes))
    return write_tables(folder, tables)


def _bending(store: xr.Dataset, published: Mapping[str, float]) -> Table:
    """Tables 2 and 3 of the paper, columns of the 3D mesh."""
    direction = str(store.attrs["bending_direction"])
    modes = store.sel(mode=store["bending_mode"], direction=direction)
    numbers = list(range(1, modes.sizes["bending"] + 1))
    for name in ("frequency", "effective_mass"):
        reference = [published.get(f"building.{name}.{number}", np.nan) for number in numbers]
        modes[f"published_{name}"] = ("bending", reference)
        modes[f"{name}_difference"] = modes[name] / modes[f"published_{name}"] - 1.0
    return columns_of(
        modes.assign(number=("bending", numbers)),
        "building_bending_modes",
        f"Bending modes of the 3D building {store.attrs['building']} that move along {direction}",
        variables(
            "number as bending mode; mode as mode of all; frequency [Hz]; published_frequency as "
            "published frequency [Hz]; frequency_difference as difference of frequency [%]; "
            "effective_mass as effective mass [t]; published_effective_mass as published effective "
            "mass [t]; effective_mass_difference as difference of mass [%]"
        ),
    ).comparing(
        {"published frequency", "difference of frequency", "published effective mass"}
        | {"difference of mass"}
    )


def _modes(store: xr.Dataset) -> Table:
    directions = [str(name) for name in store["direction"].values]
    share = store["effective_mass"] / store["total_mass"]
    shares = {f"share_{d}": share.sel(direction=d, drop=True) for d in directions}
    columns = "; ".join(f"share_{d} as effective mass {d} [%]" for d in directions)
    return columns_of(
        store.assign(shares),
        "building_modes",
        "Modes of the 3D building and their effective masses, as parts of the whole; rotations "
        "about the middle of the base",
        variables(f"mode; frequency [Hz]; {columns}"),
    )


def _floors(store: xr.Dataset, published: Mapping[str, float]) -> Table:
    reference = [published.get(f"building.floor_mass.{k}", np.nan) for k in store["floor"].values]
    return columns_of(
        store.assign(
            parts=store["floor_mass"] - store["floor_added_mass"], published=("floor", reference)
        ),
        "building_floor_masses",
        "Masses of the floors of the 3D building: of its parts, added, and together; e from the "
        "node of the floor to its centre of mass",
        variables(
            "floor; parts [t]; floor_added_mass as added [t]; floor_mass as mass [t]; floor_ex as "
            "e_x [m]; floor_ey as e_y [m]; published as published mass [t]"
        ),
    ).comparing({"published mass"})
