"""Tables of the stage `pounding`: modes, contact parameters, impacts, separation."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from impactfem.coupling.impacts import Impact, ImpactCheck, Separation
from impactfem.plot.table import Table, columns_of, write_tables
from impactfem.stages.results import outputs
from impactfem.stages.stores import names_of, open_store, time_step

TITLES = {
    "contact_parameters": "Contact parameters; durations of the laws with the effective mass of "
    "the pair",
    "impacts": "Impacts",
    "impact_checks": "Demands of each impact; linear analysis requires ratios below 1",
    "separation": "Required separation: largest approach without contact",
    "calibration": "Calibration of the sticks on the case's targets",
    "foundations": "First modes on soil and on a clamped base",
    "soil": "Soil under the rafts, about the middle of the underside",
    "facing_floors": "Floors that face each other and are in no contact pair: closest approach",
}
COLUMNS = {
    # Table 5 of the paper, with the step rule of its equation 7.
    "contact_parameters": "pair pair_young_modulus pair_poisson_ratio pair_law pair_asked "
    "pair_restitution pair_damping_ratio pair_stiffness pair_dashpot pair_onset_force "
    "pair_effective_mass pair_rest_gap pair_law_duration time_step steps_in_it",
    "impacts": " ".join(["impact_pair", *outputs(Impact, prefix="impact_")]),
    # Validity of linear analysis in each impact.
    "impact_checks": " ".join(
        ["impact_pair", "impact_peak_time", *outputs(ImpactCheck, prefix="impact_")]
    ),
    "separation": " ".join(["pair", "pair_rest_gap", *outputs(Separation, prefix="pair_")]),
    "calibration": "target_building target_mode calibrated_frequency target_frequency "
    "frequency_error calibrated_effective_mass target_effective_mass effective_mass_error",
    "foundations": "foundation foundation_direction foundation_clamped_frequency "
    "foundation_frequency foundation_period_ratio foundation_clamped_ratio foundation_ratio",
    "soil": "foundation foundation_component foundation_stiffness foundation_dashpot "
    "foundation_stiffness_error foundation_damping_error",
    "facing_floors": "facing_a facing_b facing_level facing_rest_gap facing_distance_min "
    "facing_time",
}
"""Variables of each table, separated by blanks."""


def stick_tables(folder: Path) -> list[Path]:
    """Write the tables of `pounding.nc` into `tables/` and into the log; returns the files."""
    with open_store(folder / "pounding.nc") as store:
        modes, dt = _modes(store), time_step(store)
        # The step rule of equation 7.
        duration = store["pair_law_duration"]
        step = xr.full_like(duration, dt).assign_attrs(long_name="time step")
        count = duration.copy(data=duration.values / dt)
        count.attrs = {"long_name": "steps in it", "units": "-"}
        content = store.assign(time_step=step, steps_in_it=count)
        names = list(COLUMNS)[:4]
        names += ["calibration"] if "target" in store.dims else []
        names += ["foundations", "soil"] if "foundation" in store.dims else []
        names += ["facing_floors"] if "facing" in store.dims else []
        tables = [modes]
        for name in names:
            rows = content[COLUMNS[name].split()]
            if len(rows.dims) > 1:  # a row for each pair of places
                rows = rows.stack(row=list(rows.dims))
            tables.append(columns_of(rows, name, TITLES[name], COLUMNS[name].split()))
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
