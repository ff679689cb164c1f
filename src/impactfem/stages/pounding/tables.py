"""Tables of the stage `pounding`: modes, contact parameters, impacts, separation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.plot.table import Cell, Table
from impactfem.stages.stores import open_store
from impactfem.system.log import LOGGER


def stick_tables(folder: Path) -> list[Path]:
    """Write the tables of the stage into `tables/` and its checks into the log.

    Args:
        folder: The run's folder, with `pounding.nc`.

    Returns:
        The files.
    """
    with open_store(folder / "pounding.nc") as store:
        tables = [_modes(store), _contact(store), _impacts(store), _checks(store), _gaps(store)]
        if "target" in store.dims:
            tables.append(_calibration(store))
        if "facing" in store.dims:
            tables.append(_facing(store))
    target = folder / "tables"
    target.mkdir(exist_ok=True)
    for table in tables:
        LOGGER.debug("\n%s", table.as_text())
    return [table.write_csv(target) for table in tables]


def _cells(values: xr.DataArray, factor: float = 1.0) -> list[Cell]:
    array = np.asarray(values)
    if array.dtype.kind not in "fi":
        return [str(value) for value in array]
    return [float(value) * factor if np.isfinite(value) else None for value in array]


def _columns(*columns: list[Cell]) -> tuple[tuple[Cell, ...], ...]:
    return tuple(zip(*columns, strict=True))


def _modes(store: xr.Dataset) -> Table:
    """Tables 2 to 4 of the paper: modes of each building by family."""
    rows: list[tuple[Cell, ...]] = []
    for index, building in enumerate(store["building"].values):
        one = store.isel(building=index)
        families = [str(name) for name in one["mode_family"].values]
        counts: dict[str, int] = {}
        total = float(np.nansum(one["mode_effective_mass"].values[0]))
        for k, family in enumerate(families):
            if not family:
                continue
            counts[family] = counts.get(family, 0) + 1
            mass = one["mode_effective_mass"].isel(mode=k).values
            rows.append(
                (
                    str(building),
                    family,
                    counts[family],
                    float(one["mode_frequency"].values[k]),
                    # What is left of rounding is zero.
                    *(float(value) / 1e3 if value > 1e-9 * total else 0.0 for value in mass[:3]),
                )
            )
    return Table(
        "modes",
        "Modes of the sticks",
        (
            ("building", ""),
            ("family", ""),
            ("number in family", ""),
            ("frequency", "Hz"),
            ("effective mass x", "t"),
            ("effective mass y", "t"),
            ("effective mass z", "t"),
        ),
        tuple(rows),
    )


def _contact(store: xr.Dataset) -> Table:
    """Table 5 of the paper, with the step rule of its equation 7."""
    dt = float(store["time"].values[1] - store["time"].values[0])
    duration = store["pair_law_duration"]
    return Table(
        "contact_parameters",
        "Contact parameters; durations of the laws with the effective mass of the pair",
        (
            ("pair", ""),
            ("E", "GPa"),
            ("nu", "-"),
            ("law", ""),
            ("restitution asked", "-"),
            ("of the law", "-"),
            ("damping ratio", "-"),
            ("stiffness", "N/m, N/m^1.5"),
            ("dashpot", "N s/m"),
            ("onset force", "MN"),
            ("effective mass", "t"),
            ("gap", "mm"),
            ("duration of the law", "ms"),
            ("time step", "ms"),
            ("steps in it", "-"),
        ),
        _columns(
            _cells(store["pair"]),
            _cells(store["pair_young_modulus"], 1e-9),
            _cells(store["pair_poisson_ratio"]),
            _cells(store["pair_law"]),
            _cells(store["pair_asked"]),
            _cells(store["pair_restitution"]),
            _cells(store["pair_damping_ratio"]),
            _cells(store["pair_stiffness"]),
            _cells(store["pair_dashpot"]),
            _cells(store["pair_onset_force"], 1e-6),
            _cells(store["pair_effective_mass"], 1e-3),
            _cells(store["pair_rest_gap"], 1e3),
            _cells(duration, 1e3),
            [1e3 * dt] * store.sizes["pair"],
            _cells(duration / dt),
        ),
    )


def _impacts(store: xr.Dataset) -> Table:
    columns = (
        ("peak_time", "peak at", "s", 1.0),
        ("peak_force", "peak force", "MN", 1e-6),
        ("impulse", "impulse", "kN s", 1e-3),
        ("duration", "duration", "ms", 1e3),
        ("approach", "approach", "m/s", 1.0),
        ("separation", "separation", "m/s", 1.0),
        ("restitution", "restitution", "-", 1.0),
        ("penetration", "penetration", "mm", 1e3),
        ("steps", "steps", "-", 1.0),
    )
    return Table(
        "impacts",
        "Impacts",
        (("pair", ""), *((name, unit) for _, name, unit, _ in columns)),
        _columns(
            _cells(store["impact_pair"]),
            *(_cells(store[f"impact_{key}"], factor) for key, _, _, factor in columns),
        ),
    )


def _checks(store: xr.Dataset) -> Table:
    """Is linear analysis still meant? And what the time stepping did to the contact's energy."""
    columns = (
        ("peak_time", "peak at", "s", 1.0),
        ("bearing_pressure", "mean bearing pressure", "MPa", 1e-6),
        ("bearing_ratio", "over strength", "-", 1.0),
        ("storey_shear", "largest storey shear", "MN", 1e-6),
        ("shear_stress", "shear stress", "MPa", 1e-6),
        ("cracking_ratio", "over tensile strength", "-", 1.0),
        ("dissipated", "energy dissipated", "kJ", 1e-3),
        ("defect", "defect of the scheme", "kJ", 1e-3),
    )
    return Table(
        "impact_checks",
        "What each impact asks of the buildings; linear analysis needs ratios below 1",
        (("pair", ""), *((name, unit) for _, name, unit, _ in columns)),
        _columns(
            _cells(store["impact_pair"]),
            *(_cells(store[f"impact_{key}"], factor) for key, _, _, factor in columns),
        ),
    )


def _gaps(store: xr.Dataset) -> Table:
    return Table(
        "separation",
        "Required separation: largest approach without contact",
        (("pair", ""), ("gap", "mm"), ("required", "mm"), ("margin", "mm"), ("touched", "")),
        _columns(
            _cells(store["pair"]),
            _cells(store["pair_rest_gap"], 1e3),
            _cells(store["pair_required_separation"], 1e3),
            _cells(store["pair_margin"], 1e3),
            ["yes" if value else "no" for value in store["pair_touched"].values],
        ),
    )


def _facing(store: xr.Dataset) -> Table:
    return Table(
        "facing_floors",
        "Floors that face each other and are in no contact pair: closest approach",
        (
            *(("floor", ""), ("faces", ""), ("level", "m"), ("distance at rest", "mm")),
            *(("smallest distance", "mm"), ("at", "s"), ("overlap", "")),
        ),
        _columns(
            _cells(store["facing_a"]),
            _cells(store["facing_b"]),
            _cells(store["facing_level"]),
            _cells(store["facing_rest_gap"], 1e3),
            _cells(store["facing_distance_min"], 1e3),
            _cells(store["facing_time"]),
            ["yes" if value < 0.0 else "no" for value in store["facing_distance_min"].values],
        ),
    )


def _calibration(store: xr.Dataset) -> Table:
    f, f_target = store["calibrated_frequency"], store["target_frequency"]
    m, m_target = store["calibrated_effective_mass"], store["target_effective_mass"]
    return Table(
        "calibration",
        "Calibration of the sticks on the case's targets",
        (
            ("building", ""),
            ("mode", ""),
            ("frequency", "Hz"),
            ("target", "Hz"),
            ("error", "%"),
            ("effective mass", "t"),
            ("target", "t"),
            ("error", "%"),
        ),
        _columns(
            _cells(store["target_building"]),
            [int(value) for value in store["target_mode"].values],
            _cells(f),
            _cells(f_target),
            _cells(f / f_target - 1.0, 100.0),
            _cells(m, 1e-3),
            _cells(m_target, 1e-3),
            _cells(m / m_target - 1.0, 100.0),
        ),
    )
