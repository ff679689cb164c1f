"""Caveats of a run: a single motion, its damping, contact laws that were chosen."""

import math

import numpy as np
import xarray as xr

from impactfem.report.buildings import at_wall, wall_is_used
from impactfem.report.devices import devices
from impactfem.report.governing import MODEL, STICK, Spectrum
from impactfem.report.impacts import untouched
from impactfem.report.run_files import RunFiles
from impactfem.spectra.statistics import over_members
from impactfem.stages.device import selection as of_device
from impactfem.stages.stores import names_of
from impactfem.stages.transient.selection import known, of_kind
from impactfem.system.arrays import Array

NOTED = 0.05
"""Relative increase of a device's force by another damping from which on it is reported."""


def flags(run: RunFiles, spectra: list[Spectrum]) -> list[str]:
    """Return sentences on restitution, damping and motions that would change the results."""
    found = []
    epsilon = at_wall(run)
    if epsilon is not None and run.ran("pounding") and not wall_is_used(run.case):
        with run.store("pounding.nc") as store:
            laws = np.unique(store["pair_restitution"].dropna("pair").values.round(3))
        given = " to ".join(f"{value:.3g}" for value in laws[[0, -1][: len(laws)]])
        if given:
            found.append(
                f"The contact laws have a restitution of {given}; the impact of the 3D model on a "
                f"rigid wall gives {epsilon:.3g}, which is not used."
            )
    found += [] if untouched(run) else _of_dampings(run)
    for one in spectra:
        if (other := _of_many(run, one)) is not None:
            count, high, words = other
            found.append(
                f"Record-to-record variability: the 84th percentile of {count} motions is "
                f"{high:.2f} times the result of this motion (peak of the spectrum of floor "
                f"{one.floor} of {one.building}, direction {one.direction}, {words})."
            )
            break
    return found


def _of_dampings(run: RunFiles) -> list[str]:
    """Name the damping case that increases the force on a device most, by more than `NOTED`."""
    found: list[tuple[float, str]] = []
    for store, device in devices(run):
        axis, own = of_device.direction(store), of_device.Load(store, device, of_device.WITH)
        for case in names_of(store, "case"):
            other = of_device.Load(store, device, of_device.WITH, case)
            if case == own.case or not other.detailed > own.detailed * (1.0 + NOTED):
                continue
            increased, before = (1e-3 * load.detailed for load in (other, own))
            text = (
                f"Damping: with the damping case {case!r} the force F{axis} of {device} with "
                f"impacts is {increased:.4g} kN instead of {before:.4g} kN"
            )
            pull, pull_before = (1e-3 * load.tension() for load in (other, own))
            if pull > 0.0:
                text += (
                    f", and the tension in the most highly loaded of n anchors {pull:.3g} kN / n "
                    f"instead of {max(pull_before, 0.0):.3g} kN / n"
                )
            found.append((increased / before if before > 0.0 else math.inf, f"{text}."))
    return [max(found)[1]] if found else []


def _of_many(run: RunFiles, one: Spectrum) -> tuple[int, float, str] | None:
    """Return how many motions an ensemble has, the ratio of a percentile, and the model.

    The ratio is the 84th percentile of the peak over the peak of this motion. For a 3D model the
    spectrum of the mass centre is used. None without an ensemble.
    """
    model = run.models.get(one.building)
    if one.model == STICK and run.ran("ensemble"):
        with run.store("ensemble.nc") as store:
            of_it = store.isel(station=(store["station_building"] == one.building).values)
            peaks = _of_members(of_it, of_it["psa"].isel(damping=0).max("frequency"), one)
        if len(peaks):
            return len(peaks), float(np.percentile(peaks, 84.0)) / one.peak, one.model
    elif one.model == MODEL and model is not None and model.ran("design"):
        with model.store("design.nc") as store:
            if "motion" not in store.dims:
                return None
            peaks = _of_members(store, store["member_centre_peak"].isel(damping=0), one)
        with model.store("transient.nc") as store:
            centre = of_kind(known(store[["psa"]].isel(damping=0)), "centre")
            centre = centre.isel(probe=(centre["probe_floor"] == one.floor).values)
            own = float(centre["psa"].sel(component=one.direction).values.max(initial=0.0))
        if len(peaks) and own > 0.0:
            high = float(over_members(peaks, "p84"))
            return len(peaks), high / own, f"{one.model}, mass centre"
    return None


def _of_members(store: xr.Dataset, peaks: xr.DataArray, one: Spectrum) -> Array:
    """Select the peaks by motion of a floor along a direction, shape (n,)."""
    if one.direction not in names_of(store, "direction"):
        return np.zeros(0)
    here = peaks.isel(station=(store["station_floor"] == one.floor).values)
    return np.asarray(here.sel(direction=one.direction).values.ravel())
