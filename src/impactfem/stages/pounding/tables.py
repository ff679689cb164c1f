"""Tables of the stage `pounding`: modes, contact parameters, impacts, separation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.plot.table import Table, columns_of, write_tables
from impactfem.stages.stores import names_of, open_store, time_step

TITLES = {
    "contact_parameters": "Contact parameters; durations of the laws with the effective mass of "
    "the pair",
    "impacts": "Impacts",
    "impact_checks": "What each impact asks of the buildings; linear analysis needs ratios below 1",
    "separation": "Required separation: largest approach without contact",
    "calibration": "Calibration of the sticks on the case's targets",
    "foundations": "First modes on soil and on a clamped base",
    "soil": "Soil under the rafts, about the middle of the underside",
    "facing_floors": "Floors that face each other and are in no contact pair: closest approach",
}
COLUMNS = {
    # Table 5 of the paper, with the step rule of its equation 7.
    "contact_parameters": (
        ("pair", "pair", ""),
        ("pair_young_modulus", "E", "GPa"),
        ("pair_poisson_ratio", "nu", "-"),
        ("pair_law", "law", ""),
        ("pair_asked", "restitution requested", "-"),
        ("pair_restitution", "of the law", "-"),
        ("pair_damping_ratio", "damping ratio", "-"),
        ("pair_stiffness", "stiffness", "N/m, N/m^1.5"),
        ("pair_dashpot", "dashpot", "N s/m"),
        ("pair_onset_force", "onset force", "MN"),
        ("pair_effective_mass", "effective mass", "t"),
        ("pair_rest_gap", "gap", "mm"),
        ("pair_law_duration", "duration of the law", "ms"),
        ("time_step", "time step", "ms"),
        ("steps_in_it", "steps in it", "-"),
    ),
    "impacts": (
        ("impact_pair", "pair", ""),
        ("impact_peak_time", "peak at", "s"),
        ("impact_peak_force", "peak force", "MN"),
        ("impact_impulse", "impulse", "kN s"),
        ("impact_duration", "duration", "ms"),
        ("impact_approach", "approach", "m/s"),
        ("impact_separation", "separation", "m/s"),
        ("impact_restitution", "restitution", "-"),
        ("impact_building_restitution", "of the whole buildings", "-"),
        ("impact_penetration", "penetration", "mm"),
        ("impact_steps", "steps", "-"),
    ),
    # Whether linear analysis is still meant in each impact.
    "impact_checks": (
        ("impact_pair", "pair", ""),
        ("impact_peak_time", "peak at", "s"),
        ("impact_bearing_pressure", "mean bearing pressure", "MPa"),
        ("impact_bearing_ratio", "over strength", "-"),
        ("impact_storey_shear", "largest storey shear", "MN"),
        ("impact_shear_stress", "shear stress", "MPa"),
        ("impact_cracking_ratio", "over tensile strength", "-"),
        ("impact_dissipated", "energy dissipated", "kJ"),
        ("impact_defect", "defect of the scheme", "kJ"),
    ),
    "separation": (
        ("pair", "pair", ""),
        ("pair_rest_gap", "gap", "mm"),
        ("pair_required_separation", "required", "mm"),
        ("pair_margin", "margin", "mm"),
        ("pair_touched", "touched", ""),
    ),
    "calibration": (
        ("target_building", "building", ""),
        ("target_mode", "mode", ""),
        ("calibrated_frequency", "frequency", "Hz"),
        ("target_frequency", "target", "Hz"),
        ("frequency_error", "error", "%"),
        ("calibrated_effective_mass", "effective mass", "t"),
        ("target_effective_mass", "target", "t"),
        ("effective_mass_error", "error", "%"),
    ),
    "foundations": (
        ("foundation", "building", ""),
        ("foundation_direction", "direction", ""),
        ("foundation_clamped_frequency", "clamped", "Hz"),
        ("foundation_frequency", "on soil", "Hz"),
        ("period_ratio", "period over clamped", "-"),
        ("foundation_clamped_ratio", "damping clamped", "%"),
        ("foundation_ratio", "on soil", "%"),
    ),
    "soil": (
        ("foundation", "building", ""),
        ("foundation_component", "component", ""),
        ("foundation_stiffness", "stiffness at rest", "N/m, N m/rad"),
        ("foundation_dashpot", "dashpot at the first frequency", "N s/m, N m s/rad"),
        ("foundation_stiffness_error", "error of the stiffness", "%"),
        ("foundation_damping_error", "error of the damping", "%"),
    ),
    "facing_floors": (
        ("facing_a", "floor", ""),
        ("facing_b", "faces", ""),
        ("facing_level", "level", "m"),
        ("facing_rest_gap", "distance at rest", "mm"),
        ("facing_distance_min", "smallest distance", "mm"),
        ("facing_time", "at", "s"),
        ("overlap", "overlap", ""),
    ),
}
"""Columns of each table, as `columns_of` takes them."""


def stick_tables(folder: Path) -> list[Path]:
    """Write the tables of `pounding.nc` into `tables/` and into the log; returns the files."""
    with open_store(folder / "pounding.nc") as store:
        modes, dt = _modes(store), time_step(store)
        content = store.assign(
            time_step=("pair", np.full(store.sizes["pair"], dt)),
            steps_in_it=store["pair_law_duration"] / dt,
        )
        names = list(COLUMNS)[:4]
        if "target" in store.dims:
            names.append("calibration")
            for of in ("frequency", "effective_mass"):
                error = store[f"calibrated_{of}"] / store[f"target_{of}"] - 1.0
                content[f"{of}_error"] = error
        if "foundation" in store.dims:
            names += ["foundations", "soil"]
            content["period_ratio"] = (
                store["foundation_clamped_frequency"] / store["foundation_frequency"]
            )
        if "facing" in store.dims:
            names.append("facing_floors")
            content["overlap"] = store["facing_distance_min"] < 0.0
        tables = [modes]
        for name in names:
            rows = content[[variable for variable, _, _ in COLUMNS[name]]]
            if len(rows.dims) > 1:  # a row for each pair of places
                rows = xr.Dataset.from_dataframe(rows.to_dataframe().reset_index())
            tables.append(columns_of(rows, name, TITLES[name], COLUMNS[name]))
    return write_tables(folder, tables)


def _modes(store: xr.Dataset) -> Table:
    """Tables 2 to 4 of the paper: modes of each building by family."""
    mass = store["mode_effective_mass"]
    # What is left of rounding is zero.
    mass = mass.where(mass > 1e-9 * mass.sel(mode_direction="x").sum("mode"), 0.0)
    of_modes = xr.Dataset(
        {
            "family": store["mode_family"],
            "frequency": store["mode_frequency"],
            **{f"mass_{d}": mass.sel(mode_direction=d, drop=True) for d in ("x", "y", "z")},
        }
    )
    frame = of_modes.to_dataframe(dim_order=["building", "mode"]).reset_index()
    # A lower building has fewer modes.
    frame = frame[frame["family"] != ""]
    # Buildings in the order of the case, modes in natural order.
    frame["number"] = frame.groupby(["building", "family"]).cumcount() + 1
    model = store["building_model"]
    in_3d = names_of(store.isel(building=(model == "structure").values), "building")
    other = f"; not as a stick, but with its 3D model, pounds: {', '.join(in_3d)}" if in_3d else ""
    return columns_of(
        xr.Dataset.from_dataframe(frame.reset_index(drop=True)),
        "modes",
        f"Modes of the sticks on a clamped base{other}",
        [
            ("building", "building", ""),
            ("family", "family", ""),
            ("number", "number in family", ""),
            ("frequency", "frequency", "Hz"),
            *((f"mass_{d}", f"effective mass {d}", "t") for d in ("x", "y", "z")),
        ],
    )
