"""The scalar results of the stage `design`, by the names of `summary.json`.

Spectra are those at the first damping along the shown direction, enveloped over the points of each
floor: its probes, and the vertices that govern. `ensemble3d.STATISTIC.X` is a statistic over the
members of their X; X has the name that it has for the case's own motion, `design.X` for `frs.*`.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from impactfem.spectra.statistics import STATISTICS, over_members
from impactfem.stages.stores import names_of
from impactfem.system.scalar import Scalar

Array = NDArray[np.float64]


def design_scalars(store: xr.Dataset) -> list[Scalar]:
    """All scalars of the stage, from the content of `design.nc` with all directions."""
    axis, members = str(store.attrs["shown_direction"]), "motion" in store.dims
    shown = store.isel(damping=0).sel(direction=axis)
    own: list[Scalar] = []
    ensemble: list[Scalar] = []
    if members:
        failed = names_of(store, "failed")
        error = float(store["member_basis_error"].max())
        ensemble = [
            Scalar("ensemble3d.members", float(store.sizes["motion"]), "-"),
            Scalar("ensemble3d.failed", float(len(failed)), "-", "; ".join(failed)),
            Scalar("ensemble3d.basis_error", error, "-", "transfer functions at the points"),
        ]
    for s, number in enumerate(store["station_floor"].values):
        one, name = shown.isel(station=s), f"frs.floor_{number}"
        note = _points(one, int(one["vertex_count"]))
        own += [
            Scalar(f"design.{name}.peak", float(one["psa"].max()), "m/s2", note),
            Scalar(f"design.{name}.peak_frequency", float(one["psa"].idxmax()), "Hz", note),
            Scalar(f"design.{name}.zpa", float(one["zpa"]), "m/s2", note),
        ]
        if members:
            note = _points(one, round(float(one["member_vertices"].mean())))
            peaks = one["member_psa"].max("frequency").values
            ensemble += _statistics(f"{name}.peak", peaks, "m/s2", note)
            ensemble += _statistics(f"{name}.zpa", one["member_zpa"].values, "m/s2", note)
            at_centre = one["member_centre_peak"].values
            ensemble += _statistics(f"transient.{name}.peak", at_centre, "m/s2", "mass centre")
    if members:
        ensemble += _statistics("impact_force", largest_impact(store), "N", "largest one, sticks")
    for d, device in enumerate(names_of(store, "device") if "device" in store.dims else ()):
        force = store.isel(device=d).sel(component=axis)
        name = "device" if d == 0 else f"device.{device}"
        detailed, rsa = (force[f"member_device_{k}"].values for k in ("force", "spectrum"))
        analysis = f"{device}, {store.attrs['analysis']}"
        ensemble += _statistics(f"{name}.f{axis}.detailed.impact", detailed, "N", device)
        ensemble += _statistics(f"{name}.f{axis}.rsa.impact", rsa, "N", analysis)
        if np.all(detailed > 0.0):
            difference, what = 1.0 - rsa / detailed, f"{name}.relative_difference.impact"
            ensemble += _statistics(what, difference, "-", analysis)
    return own + ensemble


def largest_impact(store: xr.Dataset) -> Array:
    """Largest force of the sticks on the building, shape (n_m,) [N]; 0 without contact pairs."""
    return np.asarray(store["member_impact_force"].values.max(axis=1, initial=0.0))


def _points(station: xr.Dataset, vertices: int) -> str:
    """What is enveloped, in words."""
    probes = f"envelope of {int(station['probe_count'])} probes"
    return probes + (f" and {vertices} vertices" if vertices else " alone")


def _statistics(name: str, values: Array, unit: str, note: str) -> list[Scalar]:
    # Differences and forces that are zero have no logarithm.
    known = [key for key in STATISTICS if key != "p84_lognormal" or np.all(values > 0.0)]
    note = f"{note}; over {len(values)} members"
    return [
        Scalar(f"ensemble3d.{key}.{name}", float(over_members(values, key)), unit, note)
        for key in known
    ]
