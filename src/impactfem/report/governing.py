"""The governing floor response spectra: those with the largest ordinates in the resolved band."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from impactfem.report.buildings import in_3d
from impactfem.report.facts import RESIDUAL, SMALL, Facts, digits, table
from impactfem.report.run_files import RunFiles
from impactfem.spectra.resolved import BANDS, band_peaks
from impactfem.stages.check import QUIET
from impactfem.stages.device import selection as of_device
from impactfem.stages.stores import damping_of, names_of
from impactfem.stages.transient.selection import known, resolved

STICK, MODEL = "stick", "3D model"
PLACES = {"centre": "mass centre", "edge": "impact edge", "line": "on the line across"}
"""Kinds of probes in words."""
FREE = "psa_free"


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The floor spectrum with the largest ordinate of a body along a direction, in resolved band.

    The resolved band ends at the last frequency of `psa`.
    """

    building: str
    model: str  #: `STICK`, `MODEL`, or name of the device at whose anchor it is
    floor: int  #: its number; 0 for a point on none
    place: str
    direction: str
    damping: float  #: of the oscillators [-]; nan where not known
    psa: xr.DataArray  #: by frequency [m/s2]
    free: xr.DataArray | None  #: the same without impact; None where that was not computed
    #: Largest ZPA without impact of the place along any direction [m/s2].
    free_zpa: float = 0.0
    zpa: float = math.nan  #: zero-period acceleration in the resolved band [m/s2]
    #: The spectrum at all valid frequencies [m/s2]; None if all are resolved.
    whole: xr.DataArray | None = None
    cause: str = ""  #: what limits the resolved band
    #: Damping ratio of the building by frequency [Hz]; None where not known.
    ratio_at: Callable[[float], Any] | None = None

    @property
    def at_anchor(self) -> bool:
        """Whether it is at the anchor of a device."""
        return self.model not in (STICK, MODEL)

    @property
    def peak(self) -> float:
        """Its largest ordinate [m/s2]."""
        return float(self.psa.max())

    @property
    def at(self) -> float:
        """Frequency of its largest ordinate [Hz]."""
        return float(self.psa.idxmax("frequency"))

    @property
    def end(self) -> float:
        """Highest frequency of the resolved band [Hz]."""
        return float(self.psa["frequency"][-1])

    @property
    def structural_damping(self) -> float:
        """Damping ratio of the building at the frequency of the largest ordinate [-]; or nan."""
        return math.nan if self.ratio_at is None else float(self.ratio_at(self.at))

    @property
    def band_peaks(self) -> list[tuple[float, float]]:
        """Peak [m/s2] and its frequency [Hz] in each band; those above 100 Hz as information."""
        whole = self.psa if self.whole is None else self.whole
        resolved = band_peaks(self.psa["frequency"].values, self.psa.values)
        return [*resolved[:-1], band_peaks(whole["frequency"].values, whole.values)[-1]]

    @property
    def free_peak(self) -> float:
        """Largest ordinate without impact [m/s2]; 0 where that was not computed."""
        return 0.0 if self.free is None else float(self.free.max())

    @property
    def least(self) -> float:
        """Ordinate without impact up to which no ratio is formed [m/s2]."""
        return max(SMALL * self.free_zpa, RESIDUAL * self.peak)

    @property
    def peak_ratio(self) -> float:
        """Ratio of the peaks with / without impact [-]; nan where the latter is small."""
        return self.peak / self.free_peak if self.free_peak > self.least else math.nan

    def largest_ratio(self, counts: float) -> tuple[float, float]:
        """Return the largest ratio with / without impact [-] and its frequency [Hz].

        Only ordinates with impact of at least `counts` [m/s2] and ordinates without impact that are
        not small count; 0 and nan where there is none.
        """
        if self.free is None:
            return 0.0, math.nan
        both = (self.psa >= counts) & (self.free > self.least)
        ratio = (self.psa / self.free).where(both, 0.0)
        largest = float(ratio.max())
        return largest, float(ratio.idxmax("frequency")) if largest > 0.0 else math.nan

    @property
    def result(self) -> str:
        """Name of its peak in `summary.json`, or of the results of its device."""
        if self.at_anchor:
            return f"device.{self.model}"
        return "frs.largest" if self.model == STICK else "design.frs.largest"

    @property
    def words(self) -> str:
        """Where it is."""
        model = f"anchor of {self.model}" if self.at_anchor else self.model
        floor = f"floor {self.floor}, " if self.floor else ""
        place = f"{self.place}, " if self.place else ""
        return f"{self.building}, {floor}{place}{model}"


def governing(run: RunFiles) -> list[Spectrum]:
    """Of each stick and 3D model along each direction, the largest first; then those of anchors."""
    floors = sorted(_of_sticks(run), key=lambda one: one.peak) if run.ran("pounding") else []
    found = list({(one.building, one.direction): one for one in floors}.values())
    for one in run.models.values():
        found += _of_model(one) if one.ran("transient") else []
        found += _of_anchors(one) if one.ran("device") else []
    laws = _laws(run) if run.ran("pounding") else {}
    found = [replace(one, ratio_at=laws.get(one.building)) for one in found]
    return sorted(found, key=lambda one: (one.at_anchor, -one.peak))


def _laws(run: RunFiles) -> dict[str, Callable[[float], Any]]:
    """Return the damping ratio by frequency of each building by its name."""
    with run.store("pounding.nc") as store:
        if "mass_coefficient" not in store:
            return {}
        return {
            name: damping_of(store.sel(building=name)).ratio for name in names_of(store, "building")
        }


def _spectrum(
    at: xr.Dataset, made: Callable[..., Spectrum], cause: str, free_zpa: float
) -> Spectrum:
    """Return the spectrum of one place along one direction, at all valid frequencies.

    `made` knows building, model, floor, place, direction and damping of the oscillators; the
    attributes of the dataset have the end of the resolved band.
    """
    part = resolved(at)
    return made(
        psa=part["psa"],
        free=part.get(FREE),
        free_zpa=free_zpa,
        zpa=float(at[zpa_of(at)]),
        whole=at["psa"],
        cause=cause,
    )


def zpa_of(store: xr.Dataset) -> str:
    """Return the name of the ZPA in the resolved band: in `design.nc` `zpa` is a peak."""
    return "resolved_zpa" if "resolved_zpa" in store else "zpa"


def _of_sticks(run: RunFiles) -> list[Spectrum]:
    """Of each floor along each direction, as it pounded."""
    found, touched = [], in_3d(run.case)
    with run.store("pounding.nc") as store:
        one, cause = spectra_of(store), _cause(store)
        for k, name in enumerate(one["station_building"].values.tolist()):
            model, place = (MODEL, PLACES["centre"]) if name in touched else (STICK, "")
            free_zpa = float(one["zpa_free"].isel(station=k).max())
            for direction in names_of(store, "direction"):
                at = one.isel(station=k).sel(direction=direction)
                floor, ratio = int(at["station_floor"]), float(at["damping"])
                made = partial(
                    Spectrum,
                    building=name,
                    model=model,
                    floor=floor,
                    place=place,
                    direction=direction,
                    damping=ratio,
                )
                found.append(_spectrum(at, made, cause, free_zpa))
    return _moving(found)


def _cause(store: xr.Dataset) -> str:
    """Return what limits the resolved band of a results file."""
    return str(store.attrs.get("resolved_by", ""))


def _of_model(run: RunFiles) -> list[Spectrum]:
    """The largest along each direction: over whole floors, if stage `design` has looked there."""
    found = []
    if run.ran("design"):
        with run.store("design.nc") as store:
            one = spectra_of(store)
            place = f"largest {'over the floor' if 'vertex' in store.dims else 'of its probes'}"
            for direction in names_of(store, "direction"):
                at, free_zpa = _largest(one, "direction", direction, "station")
                floor, ratio = int(at["station_floor"]), float(at["damping"])
                made = partial(
                    Spectrum,
                    building=str(store.attrs["building"]),
                    model=MODEL,
                    floor=floor,
                    place=place,
                    direction=direction,
                    damping=ratio,
                )
                found.append(_spectrum(at, made, _cause(store), free_zpa))
            kept = names_of(store, "elsewhere")  # on no floor
    with run.store("transient.nc") as store:
        one = known(spectra_of(store))
        one = one.sel(probe=kept) if found else one
        for direction in names_of(store, "component") if one.sizes["probe"] else []:
            at, free_zpa = _largest(one, "component", direction, "probe")
            place = PLACES.get(str(at["probe_kind"].item()), str(at["probe"].item()))
            floor, ratio = int(at["probe_floor"]), float(at["damping"])
            made = partial(
                Spectrum,
                building=str(store.attrs["building"]),
                model=MODEL,
                floor=floor,
                place=place,
                direction=direction,
                damping=ratio,
            )
            found.append(_spectrum(at, made, _cause(store), free_zpa))
    found.sort(key=lambda one: -one.peak)
    return _moving(list({one.direction: one for one in reversed(found)}.values()))


def spectra_of(store: xr.Dataset) -> xr.Dataset:
    """Return the spectra at the first damping; those without impact if they were computed."""
    zpa = zpa_of(store)
    names = [name for name in ("psa", FREE, zpa, f"{zpa}_free") if name in store]
    return store[names].isel(damping=0).load()


def _largest(some: xr.Dataset, along: str, direction: str, dim: str) -> tuple[xr.Dataset, float]:
    """Of spectra over places along a direction that with the largest resolved ordinate.

    The second value is the largest ZPA without impact there along any direction [m/s2].
    """
    part = resolved(some)
    k = int(np.argmax(part["psa"].sel({along: direction}).max("frequency").values))
    zpa = f"{zpa_of(some)}_free"
    free_zpa = float(part[zpa].isel({dim: k}).max()) if zpa in part else 0.0
    return some.sel({along: direction}).isel({dim: k}), free_zpa


def _of_anchors(run: RunFiles) -> list[Spectrum]:
    """Of each anchor along the direction with the largest ordinate."""
    found = []
    with run.store("device.nc") as store:
        for device in names_of(store, "device"):
            hit, quiet = (
                {
                    name: of_device.Load(store, device, impact).of(name).load().drop_vars("impact")
                    for name in ("psa", "zpa")
                }
                for impact in (of_device.WITH, of_device.WITHOUT)
            )
            free = {f"{name}_free": values for name, values in quiet.items()}
            both = xr.Dataset(hit | free, attrs=store.attrs)
            part = resolved(both)
            axis = str(part["psa"].max("frequency").idxmax("axis").item())
            _, floor, _ = of_device.anchor_of(store, device)
            damping = float(of_device.modes_of(store, device)["mode_damping"][:1].sum())
            made = partial(
                Spectrum,
                building=str(store.attrs["building"]),
                model=device,
                floor=floor,
                place="",
                direction=axis,
                damping=damping or math.nan,
            )
            free_zpa = float(both["zpa_free"].max())
            found.append(_spectrum(both.sel(axis=axis), made, _cause(store), free_zpa))
    return found


def _moving(found: list[Spectrum]) -> list[Spectrum]:
    """Those of which more is seen than the numbers behind the point."""
    largest = max((one.peak for one in found), default=0.0)
    return [one for one in found if one.peak > QUIET * largest]


def spectra_table(spectra: list[Spectrum]) -> Facts:
    """Return the governing spectra, a row each."""
    columns = (
        "place {}; direction {}; damping [%] {:.3g}; resolved band up to [Hz] {:.4g}; "
        "peak [m/s²] {:.4g}; at [Hz] {:.1f}; damping of the building there [%] {}; ZPA [m/s²] "
        "{:.4g}; peak without impact [m/s²] {}; ratio of the peaks, with / without impact {}"
    )
    rows = []
    for one in spectra:
        free = "" if one.free is None else digits(one.free_peak, 4)
        ratio = digits(one.peak_ratio, 3) if math.isfinite(one.peak_ratio) else ""
        known_law = math.isfinite(one.structural_damping)
        structural = digits(100.0 * one.structural_damping, 3) if known_law else ""
        peak = (one.end, one.peak, one.at, structural, one.zpa)
        rows.append((one.words, one.direction, 100.0 * one.damping, *peak, free, ratio))
    note = (
        "The largest ordinates of each model along each direction, within the resolved band. The "
        "ZPA is the peak acceleration in this band. A ratio appears only if the peak without "
        f"impact exceeds {100.0 * SMALL:g} % of the ZPA without impact."
    )
    if any(one.free is None for one in spectra):
        note += " The full-order 3D model has no run without impact."
    return table("Governing floor response spectra", columns, rows, note)


def band_limits(spectra: list[Spectrum]) -> list[str]:
    """Return the end of the resolved band of each model in words."""
    ends = {
        f"{one.building}, {one.model if not one.at_anchor else f'anchor of {one.model}'}": one
        for one in reversed(spectra)
    }
    return [
        f"Results above {one.end:.4g} Hz are information only: {place}"
        + (f" (limited by: {one.cause})." if one.cause else ".")
        for place, one in sorted(ends.items())
    ]


def bands_table(spectra: list[Spectrum]) -> Facts:
    """Return the peaks of the governing spectra in each band, a row each."""
    low, high = (f"{end:g}" for end in BANDS)
    columns = (
        f"place {{}}; direction {{}}; peak below {low} Hz [m/s²] {{}}; "
        f"peak from {low} to {high} Hz [m/s²] {{}}; "
        f"information: peak above {high} Hz [m/s²] {{}}; "
        "resolved band up to [Hz] {:.4g}; limited by {}"
    )
    rows = []
    for one in spectra:
        peaks = [
            f"{digits(peak, 4)} at {at:.1f} Hz" if math.isfinite(peak) else "not resolved"
            for peak, at in one.band_peaks
        ]
        rows.append((one.words, one.direction, *peaks, one.end, one.cause))
    note = f"Up to {high} Hz the peaks are those in the resolved band."
    return table("Peaks in frequency bands", columns, rows, note)
