"""The checks of the stage `design` in words: points of the floors, members, their forces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.results.check import Check
from impactfem.results.design_view import DesignView
from impactfem.results.open_store import open_store
from impactfem.scalar import from_json

COVERED = 0.8
"""Part of the peak of a floor's vertices that its points must reach."""
NOTABLE = 0.1
"""Part of the largest peak of a direction below which a floor is not told of."""
SAME = 1e-9
"""Largest relative difference of a member's impact forces from those of the stage `ensemble`."""


def design_checks(folder: Path) -> list[Check]:
    """The checks of the stage.

    Args:
        folder: The run's folder, with `design.nc`.
    """
    with open_store(folder / "design.nc") as store:
        view = DesignView(store)
        checks = [one for x in range(len(view.directions)) for one in _coverage(view, x)]
        if "motion" in store.dims:
            values = {s.name: s.value for s in from_json(store.attrs["scalars"])}
            failed = values["ensemble3d.failed"]
            count = f"{values['ensemble3d.members']:.0f} motions through the 3D model"
            checks.append((failed == 0.0, f"design: {count}, {failed:.0f} failed"))
            checks += _forces(folder / "ensemble.nc", store)
    return checks


def _coverage(view: DesignView, x: int) -> list[Check]:
    """Whether the points of the floors reach what their vertices do along a direction."""
    source = view.case
    peaks = []
    for s in range(len(source.stations)):
        whole = view.whole(0, s, x)
        if whole is None:
            return []
        peaks.append((float(source.psa[0, 0, s, x].max()), float(whole[1].max())))
    largest = max(vertices for _, vertices in peaks)
    shares = {
        station.label: points / vertices
        for station, (points, vertices) in zip(source.stations, peaks, strict=True)
        if vertices > NOTABLE * largest
    }
    if not shares:
        return []
    worst = min(shares, key=lambda label: shares[label])
    low = [label for label, share in shares.items() if share < COVERED]
    text = (
        f"design: along {view.directions[x]} the points of the floors reach "
        f"{100.0 * shares[worst]:.0f} % of the peak over all vertices at least ({worst})"
    )
    if low:
        text += f"; below {100.0 * COVERED:.0f} % on {', '.join(low)}: further probes would tell"
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
