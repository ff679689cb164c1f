"""The checks of the stage `design` in words: points of the floors, members, their forces."""

from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.stages.check import Check, limited
from impactfem.stages.design.products import ALONE, share_reached
from impactfem.stages.stores import names_of, of_run, open_store
from impactfem.system.scalar import values_of

COVERED = 0.95
"""Part of the envelope of all vertices of a floor that its points must have at every frequency."""
SAME = 1e-9
"""Largest relative difference of a member's impact forces from those of the stage `ensemble`."""


def design_checks(folder: Path) -> list[Check]:
    """The checks of the stage, from `design.nc` of a run's folder."""
    with open_store(folder / "design.nc") as store:
        checks: list[Check] = []
        for direction in names_of(store, "direction"):
            if not store["vertex_count"].sel(direction=direction).any():
                continue
            # From the fields alone: the points are better sampled in the design spectra, which
            # would hide what they lack.
            share = share_reached(store).sel(direction=direction).dropna("station", how="all")
            worst = share.isel(share.argmin(["station", "whole_frequency"]))
            at = float(worst["whole_frequency"])
            where = f"at {at:.3g} Hz" if np.isfinite(at) else "of the peak acceleration"
            low = share["station_floor"].values[(share < COVERED).any("whole_frequency")]
            text = f"design: along {direction}, of the envelope of all vertices the points have"
            met, text = limited(text, float(worst), COVERED, "%", least=True)
            text += f" on floor {worst['station_floor'].item()}, {where}"
            if low.size:
                text += f"; too little on {', '.join(f'floor {floor}' for floor in low)}"
            checks.append((met, text))
        checks = checks or [(False, f"design: {ALONE}")]
        if "motion" in store.dims:
            values = values_of(store)
            failed = values["ensemble3d.failed"]
            count = f"{values['ensemble3d.members']:.0f} motions on the 3D model"
            checks.append((failed == 0.0, f"design: {count}, {failed:.0f} failed"))
            checks += _forces(of_run(folder, "ensemble.nc"), store)
    return checks


def _forces(path: Path, store: xr.Dataset) -> list[Check]:
    """Whether members have the impact forces that they have in the stage `ensemble`."""
    if not path.is_file():
        return []
    force = store["member_impact_force"]
    scalars = [f"pounding.peak_force.floor_{floor}" for floor in force["edge"].values]
    with open_store(path) as ensemble:
        both = [name for name in names_of(store, "motion") if name in names_of(ensemble, "motion")]
        same = ensemble.attrs["studied_building"] == store.attrs["building"]
        if not same or not both or not set(scalars) <= set(names_of(ensemble, "scalar")):
            return []
        known = ensemble["value"].sel(motion=both, scalar=scalars).transpose("motion", ...).values
    differences = np.abs(force.sel(motion=both).values - known) / np.maximum(known, 1.0)
    worst = float(differences.max(initial=0.0))
    text = "design: difference of the impact forces of the members from those of stage ensemble"
    return [limited(text, worst, SAME)]
