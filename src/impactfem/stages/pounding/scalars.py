"""The scalar results of the stage `pounding`, by the names of `summary.json`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from impactfem.stages.results import scalars
from impactfem.stages.stores import names_of
from impactfem.system.scalar import Scalar

SINGLE = (
    "steps_per_impact_min steps_per_impact_observed energy_residual required_separation "
    "contact_points complementarity contact_energy_defect penetration_over_gap mean_force_5ms"
)
MAIN_IMPACT = (
    "main_impact_band_force=impact_band_force main_impact_force=impact_peak_force "
    "main_impact_time=impact_peak_time "
    "main_impact_duration=impact_duration main_impact_impulse=impact_impulse "
    "main_impact_approach_velocity=impact_approach main_impact_restitution=impact_restitution"
)
DEMANDS = (
    "bearing_pressure_max=impact_bearing_pressure bearing_ratio_max=impact_bearing_ratio "
    "storey_shear_max=impact_storey_shear shear_stress_max=impact_shear_stress "
    "cracking_ratio_max=impact_cracking_ratio"
)
MOTION = (
    "pga time_of_pga pgv arias_intensity duration_5_95 sa_max sa_max_frequency misfit_rms "
    "over_target pga_over_target"
)
MOTION_DETAILS = "pgd end_velocity end_displacement misfit_largest misfit_smallest"
BENDING = "frequency=bending_frequency effective_mass=bending_mass"
CALIBRATED = "stiffness_factor rigid_below=rigid_depth_below rigid_above=rigid_depth_above"
PASSAGE = "delay=passage_delay apart=passage_apart left=passage_left"
FLOOR_DETAILS = "pfa_no_contact peak_frequency peak_over_pfa"
RATIOS = "force_over_acceleration penetration_over_force"
SOIL_MODES = (
    "frequency=foundation_frequency period_ratio=foundation_period_ratio damping=foundation_ratio"
)
SOIL = (
    "radiated=foundation_radiated least_pressure=foundation_least_pressure "
    "least_pressure_ratio=foundation_least_pressure_ratio "
    "stiffness_error=foundation_stiffness_error damping_error=foundation_damping_error"
)


def selected_scalars(store: xr.Dataset, motion: xr.Dataset) -> list[Scalar]:
    """Select the scalars of the stage from `pounding.nc` and `motion.nc`.

    Names without a building are those of the first building of the case file, the one that is
    studied; `floor_k` in `pounding.*` covers the contact pairs on its floor k.
    """
    studied = str(store.attrs["studied_building"])
    stations = [
        f"floor_{floor}" if building == studied else f"{building}.floor_{floor}"
        for building, floor in zip(
            names_of(store, "station_building"), store["station_floor"].values, strict=True
        )
    ]
    floors = store.assign_coords(station=stations)
    own = floors.isel(station=(store["station_building"] == studied).values)
    touching = own.isel(station=np.isfinite(own["peak_force"].values))
    pressed = own.isel(station=(own["peak_force"] > 0.0).values)
    later = store.isel(building=np.isfinite(store["passage_delay"].values))
    impacts = store[[str(name) for name in store if store[name].dims == ("impact",)]]
    soil = store.max("foundation_component", keep_attrs=True) if "foundation" in store else store
    return [
        *_motions(motion),
        *mode_scalars(store),
        *scalars(store, "sticks.{variable}", CALIBRATED),
        *scalars(store, "sticks.{variable}.{storey}", "storey_height", detail=True),
        *scalars(later, "motion.passage.{building}.{variable}", PASSAGE),
        *scalars(touching, "pounding.{variable}.{station}", "peak_force"),
        *scalars(touching, "pounding.{variable}.{station}", "penetration", detail=True),
        *scalars(own, "pounding.{variable}.{station}", "peak_acceleration", detail=True),
        *scalars(pressed, "pounding.{variable}.{station}", RATIOS, detail=True),
        *scalars(store, "pounding.{variable}.{building}", "peak_displacement"),
        *scalars(store, "pounding.{variable}.{building}", "peak_displacement_no_contact"),
        *scalars(store.max("building", keep_attrs=True), "pounding.{variable}", "swing_at_end"),
        *_main_impact(impacts),
        Scalar("pounding.impacts", float(store.sizes["impact"]), "-", "number of impacts"),
        *scalars(soil, "soil.{foundation}.{variable}.{foundation_direction}", SOIL_MODES),
        *scalars(soil, "soil.{foundation}.{variable}", SOIL),
        *scalars(store, "pounding.{variable}", SINGLE),
        *scalars(store, "pounding.{comparison}_{changed}_{variable}", "change"),
        *_demands(impacts),
        *_nearest(store),
        *_spectra(floors),
    ]


def _motions(motion: xr.Dataset) -> list[Scalar]:
    first, others = motion.isel(motion=0), motion.isel(motion=slice(1, None))
    others = others.swap_dims(motion="direction")
    return [
        *scalars(first, "motion.{variable}", MOTION),
        *scalars(first, "motion.{variable}", MOTION_DETAILS, detail=True),
        *scalars(others, "motion.{direction}.{variable}", MOTION),
        *scalars(others, "motion.{direction}.{variable}", MOTION_DETAILS, detail=True),
    ]


def mode_scalars(store: xr.Dataset) -> list[Scalar]:
    """Masses and first modes of the sticks along the direction of calibration or pounding."""
    names = "sticks.{building}.{variable}.{family_mode}", BENDING
    first = store.isel(family_mode=slice(None, 4)), store.isel(family_mode=slice(4, None))
    return [
        *scalars(first[0], *names),
        *scalars(first[1], *names, detail=True),
        *scalars(store, "sticks.{building}.{variable}", "mass=total_mass", detail=True),
    ]


def _main_impact(impacts: xr.Dataset) -> list[Scalar]:
    """The impact with the largest force, its pair in the notes; no values without an impact."""
    if not impacts.sizes["impact"]:
        none = impacts.drop_vars("impact_pair", errors="ignore").pad(impact=(0, 1)).isel(impact=0)
        return scalars(none, "pounding.{variable}", MAIN_IMPACT)
    main = impacts.isel(impact=impacts["impact_peak_force"].argmax("impact"))
    note = f"pair {main['impact_pair'].item()}"
    return [replace(one, note=note) for one in scalars(main, "pounding.{variable}", MAIN_IMPACT)]


def _demands(impacts: xr.Dataset) -> list[Scalar]:
    """The largest demands of all impacts; none where a material has no strength."""
    if not impacts.sizes["impact"]:
        return []
    largest = scalars(impacts.max("impact", keep_attrs=True), "pounding.{variable}", DEMANDS)
    return [one for one in largest if one.value is not None]


def _nearest(store: xr.Dataset) -> list[Scalar]:
    if "facing" not in store.dims:
        return []
    return scalars(
        store.min("facing", keep_attrs=True), "pounding.{variable}", "facing_distance_min"
    )


def _spectra(floors: xr.Dataset) -> list[Scalar]:
    """Peaks of the floor spectra, and the largest ordinate in the resolved band."""
    resolved = float(floors.attrs["resolved_frequency"])
    direction = str(floors.attrs["shown_direction"])
    shown = floors.isel(damping=0).sel(direction=direction)
    psa = shown["psa"]
    peaks = xr.Dataset(
        {
            "peak": psa.max("frequency").assign_attrs(units="m/s2"),
            "pfa": shown["pfa"].assign_attrs(units="m/s2"),
            "peak_no_contact": shown["psa_free"].max("frequency").assign_attrs(units="m/s2"),
            "pfa_no_contact": shown["pfa_free"].assign_attrs(units="m/s2"),
            "peak_frequency": psa.idxmax("frequency").assign_attrs(units="Hz"),
            "peak_over_pfa": (psa.max("frequency") / shown["pfa"]).assign_attrs(units="-"),
        }
    )
    own = [not name.count(".") for name in names_of(floors, "station")]
    first = peaks.isel(station=own)
    band = floors["frequency"] <= resolved * (1.0 + 1e-9)
    every = floors["psa"].isel(damping=0, frequency=band.values)
    at = every.isel(every.argmax(...))
    note = f"{at['station_building'].item()}, floor {at['station_floor'].item()}, direction "
    note += f"{at['direction'].item()}; of all floors, in the resolved band"
    return [
        *scalars(first, "frs.{station}.{variable}", "peak pfa peak_no_contact"),
        *scalars(first, "frs.{station}.{variable}", FLOOR_DETAILS, detail=True),
        *scalars(
            peaks.isel(station=np.logical_not(own)),
            "frs.{station}.{variable}",
            "peak pfa peak_no_contact pfa_no_contact peak_frequency peak_over_pfa",
            detail=True,
        ),
        Scalar("frs.largest", float(at), "m/s2", note),
        Scalar("frs.resolved_frequency", resolved, "Hz"),
        *scalars(floors, "frs.{variable}", "points_per_cycle peak_error_bound", detail=True),
    ]
