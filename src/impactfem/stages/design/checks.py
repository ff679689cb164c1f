"""The checks of the stage `design` in words: points of the floors, members, their forces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.stages.check import Check
from impactfem.stages.design.view import ALONE, DesignView
from impactfem.stages.stores import open_store
from impactfem.system.scalar import values_of

COVERED = 0.95
"""Part of the envelope of all vertices of a floor that its points must have at every frequency."""
SAME = 1e-9
"""Largest relative difference of a member's impact forces from those of the stage `ensemble`."""


def design_checks(folder: Path) -> list[Check]:
    """The checks of the stage.

    Args:
        folder: The run's folder, with `design.nc`.
    """
    with open_store(folder / "design.nc") as store:
        view = DesignView(store)
        checks: list[Check] = [(False, f"design: {ALONE}")]
        if view.places:
            checks = [one for x in range(len(view.directions)) for one in _coverage(view, x)]
        if "motion" in store.dims:
            values = values_of(store)
            failed = values["ensemble3d.failed"]
            count = f"{values['ensemble3d.members']:.0f} motions through the 3D model"
            checks.append((failed == 0.0, f"design: {count}, {failed:.0f} failed"))
            checks += _forces(folder / "ensemble.nc", store)
    return checks


def _coverage(view: DesignView, x: int) -> list[Check]:
    """Whether the points of the floors have what their vertices have along a direction.

    Both are from the fields over the floors: the points are better sampled in the design spectra,
    which would hide what they lack.
    """
    found = {}
    for s, direction in view.places:
        if direction == x:
            frequency, share = view.reached(s, x)
            worst = int(np.argmin(share))
            found[view.case.stations[s].label] = (float(share[worst]), float(frequency[worst]))
    if not found:
        return []
    label = min(found, key=lambda one: found[one][0])
    least, at = found[label]
    where = f"at {at:.3g} Hz" if np.isfinite(at) else "of the peak acceleration"
    low = [one for one, (share, _) in found.items() if share < COVERED]
    text = (
        f"design: along {view.directions[x]} the points have at least {100.0 * least:.3g} % of the "
        f"envelope of all vertices of a floor at every frequency ({label}, {where}); at least "
        f"{100.0 * COVERED:g} % is asked"
    )
    if low:
        text += f", missed on {', '.join(low)}"
    return [(not low, text)]


def _forces(path: Path, store: xr.Dataset) -> list[Check]:
    """Whether members have the impact forces that they have in the stage `ensemble`."""
    if not path.is_file():
        return []
    with open_store(path) as ensemble:
        names = [str(name) for name in ensemble["scalar"].values]
        motions = [str(name) for name in ensemble["motion"].values]
        floors = [int(floor) for floor in store["edge"].values]
        scalars = [f"pounding.peak_force.floor_{floor}" for floor in floors]
        same = str(ensemble.attrs["studied_building"]) == str(store.attrs["building"])
        both = [str(name) for name in store["motion"].values if str(name) in motions]
        if not same or not both or any(name not in names for name in scalars):
            return []
        rows = [motions.index(name) for name in both]
        known = ensemble["value"].values[rows][:, [names.index(name) for name in scalars]]
        found = store["member_impact_force"].sel(motion=both).values
    differences = np.abs(found - known) / np.maximum(known, 1.0)
    worst = float(differences.max(initial=0.0))
    text = f"design: impact forces of the members as in the stage ensemble within {worst:.1e}"
    return [(worst < SAME, text)]
