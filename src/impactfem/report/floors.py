"""Spectra of the floors: of the pounding, of a 3D model, and over several motions."""

import math
from typing import Any

import numpy as np
import xarray as xr

from impactfem.report.buildings import in_3d
from impactfem.report.facts import RESIDUAL, SMALL, Facts, digits, table
from impactfem.report.governing import FREE, PLACES, spectra_of, zpa_of
from impactfem.report.run_files import RunFiles
from impactfem.spectra.statistics import over_members
from impactfem.stages.stores import names_of
from impactfem.stages.transient.selection import floors_of, resolved, resolved_end
from impactfem.stages.transient.selection import shown as along_shown

COLUMNS = (
    "peak [m/s²] {}; at [Hz] {}; ZPA [m/s²] {}; peak without impact [m/s²] {}; "
    "ZPA without impact [m/s²] {}; ratio of the peaks, with / without impact {}"
)
"""Columns of a spectrum in the resolved band."""
FLOORS = 3
"""Number of floors that are shown where not all that are hit are."""


def pounding_spectra(run: RunFiles, building: str, *, shown: bool) -> Facts:
    """Return the spectra of all floors of a building in the pounding, in the resolved band.

    Along the shown direction, or along all others.
    """
    with run.store("pounding.nc") as store:
        one = spectra_of(store)
        one = one.isel(station=(one["station_building"] == building).values)
        first = str(store.attrs["shown_direction"])
        directions = [x for x in names_of(store, "direction") if (x == first) is shown]
        rows = [
            (
                int(at["station_floor"]),
                direction,
                *_with_and_without(at.sel(direction=direction), at),
            )
            for direction in directions
            for at in (one.isel(station=k) for k in reversed(range(one.sizes["station"])))
        ]
        what = "Mass centres of the 3D model" if building in in_3d(run.case) else "Stick"
        title = f"{what} of {building}, direction {', '.join(directions)}, {_damping(one)}"
        title += f", up to {resolved_end(store):.4g} Hz"
    return table(title, f"floor {{}}; direction {{}}; {COLUMNS}", rows)


def structure_spectra(run: RunFiles) -> Facts:
    """Return the spectra of the floors of a 3D model along the shown direction.

    Of each floor the largest over the floor, if the stage `design` computed it. Of floors with
    impacts also those of the mass centre and of the impact edge.
    """
    fractiles, rows = _centre_fractiles(run), list[tuple[Any, ...]]()
    with run.store("transient.nc") as store:
        axis = str(store.attrs["shown_direction"])
        response, one = along_shown(store), spectra_of(store).rename(component="direction")
        force = response["impact_force"]
        on_floor = np.array([str(k).startswith("floor") for k in force["edge"].values], dtype=bool)
        hit = force["edge_floor"].values[(abs(force) > 0.0).any("time").values & on_floor]
        floors = floors_of(response, "centre")[::-1]
        for floor in floors:
            if hit.size and floor not in hit:
                continue
            here = one.isel(probe=(one["probe_floor"] == floor).values)
            for at in (here.isel(probe=k) for k in range(here.sizes["probe"])):
                kind = at["probe_kind"].item()
                if kind in ("centre", "edge"):
                    high = fractiles.get(floor) if kind == "centre" else None
                    spread = "" if high is None else f"{high:.1f}"
                    cells = _with_and_without(at.sel(direction=axis), at)
                    rows.append((floor, PLACES[kind], *cells, spread))
        end, damping = resolved_end(store), _damping(one)
    rows += _whole_floors(run, axis)
    rows.sort(key=lambda row: -row[0])
    title = (
        f"3D model of {response.attrs['building']}, direction {axis}, {damping}, up to {end:.4g} Hz"
    )
    columns = f"floor {{}}; place {{}}; {COLUMNS}; peak, 84 % of the motions [m/s²] {{}}"
    if not any(row[-1] for row in rows):
        columns, rows = columns.rpartition(";")[0], [row[:-1] for row in rows]
    return table(title, columns, rows)


def _whole_floors(run: RunFiles, axis: str) -> list[tuple[Any, ...]]:
    """Return a row for each floor with its largest spectrum; none without the stage `design`."""
    if not run.ran("design"):
        return []
    with run.store("design.nc") as store:
        if axis not in names_of(store, "direction"):
            return []
        one = spectra_of(store)
        return [
            (
                int(at["station_floor"]),
                "whole floor",
                *_with_and_without(at.sel(direction=axis), at),
                "",
            )
            for at in (one.isel(station=k) for k in range(one.sizes["station"]))
        ]


def _with_and_without(at: xr.Dataset, every: xr.Dataset) -> list[str]:
    """Return the cells of `COLUMNS` of a place along a direction.

    Args:
        at: Spectra of the place along the direction.
        every: The same along every direction.
    """
    zpa, part = zpa_of(at), resolved(at)
    peak = float(part["psa"].max())
    cells = [
        f"{peak:.1f}",
        f"{float(part['psa'].idxmax('frequency')):.1f}",
        f"{float(at[zpa]):.1f}",
    ]
    if FREE not in part:
        return [*cells, "", "", ""]
    free = float(part[FREE].max())
    least = max(SMALL * float(every[f"{zpa}_free"].max()), RESIDUAL * peak)
    ratio = digits(peak / free, 3) if free > least else ""
    return [*cells, f"{free:.1f}", f"{float(at[f'{zpa}_free']):.1f}", ratio]


def _damping(spectra: xr.Dataset) -> str:
    return f"{100.0 * float(spectra['damping']):g} % damping"


def _centre_fractiles(run: RunFiles) -> dict[int, float]:
    """84 % fractiles of the spectral peaks at the mass centres by floor; empty without members."""
    if not run.ran("design"):
        return {}
    with run.store("design.nc") as store:
        direction = str(store.attrs["shown_direction"])
        if "statistic" not in store.dims or direction not in names_of(store, "direction"):
            return {}
        peaks = store["statistic_centre_peak"].isel(damping=0)
        peaks = peaks.sel(statistic="p84", direction=direction)
        return dict(zip(store["station_floor"].values.tolist(), peaks.values.tolist(), strict=True))


def carried(run: RunFiles) -> Facts:
    """Summarise an ensemble of motions in the 3D model and on the first device."""
    values = run.values
    with run.store("design.nc") as store:
        rows, note = _carried_floors(store)
        building, axis = store.attrs["building"], str(store.attrs["shown_direction"])
        both = store.sel(statistic=["mean", "p84"])
        if axis in names_of(store, "direction"):
            top = both.sel(direction=axis).isel(station=int(store["station_floor"].values.argmax()))
            floor = top["station_floor"].item()
            words = f"floor {floor}, mass centre, peak of the spectrum [m/s²]"
            own = values.get(f"transient.frs.floor_{floor}.peak", math.nan)
            rows.append(_spread(words, own, *top["statistic_centre_peak"].isel(damping=0).values))
        for kind, analysis in (("force", "detailed"), ("spectrum", "rsa")):
            if "device" not in store.dims:
                continue
            force = both[f"statistic_device_{kind}"].isel(device=0).sel(component=axis)
            own = values.get(f"device.f{axis}.{analysis}.impact", math.nan)
            words = f"first device, F{axis}, {analysis} [kN]"
            rows.append(_spread(words, 1e-3 * own, *(1e-3 * force.values)))
    title = f"Over {values['ensemble3d.members']:.0f} motions on the 3D model"
    if run.further:
        title += f" of {building}"
    return Facts(title, ["result", "this motion", "mean", "84 %", "84 % / this motion"], rows, note)


def _carried_floors(store: xr.Dataset) -> tuple[list[list[str]], str]:
    """Peaks of the envelopes of the floors: this motion, mean and fractile, and what is left out.

    Along the shown direction all floors that a motion hits, along the others those of them on which
    the fractile is highest above this motion; of all floors where none is hit.
    """
    own = store["psa"].values[0].max(axis=-1)
    every = store["member_psa"].values[:, 0].max(axis=-1)
    mean, fractile = over_members(every, "mean"), over_members(every, "p84")
    ratio = np.divide(fractile, own, out=np.zeros_like(own), where=own > 0.0)
    floors = store["station_floor"].values
    hit = store["edge"].values[store["member_impact_force"].values.max(axis=0, initial=0.0) > 0.0]
    shown, directions = str(store.attrs["shown_direction"]), store["direction"].values.tolist()
    pool = np.flatnonzero(np.isin(floors, hit)) if hit.size else np.arange(floors.size)
    rows = []
    for direction in sorted(directions, key=lambda one: one != shown):
        x = directions.index(direction)
        most = pool[np.argsort(ratio[pool, x])[-FLOORS:]]
        for s in sorted(pool if direction == shown and hit.size else most, reverse=True):
            words = f"floor {floors[s]}, {direction}, peak of the envelope [m/s²]"
            rows.append(_spread(words, own[s, x], mean[s, x], fractile[s, x]))
    if hit.size:
        note = f"All floors that one of the motions hits along {shown}; along other directions the "
        note += f"{FLOORS} of them on which the 84 % are highest above this motion."
    else:
        note = f"The {FLOORS} floors on which the 84 % are highest above this motion."
    return rows, f"{note} products/design_ensemble.csv has all floors."


def _spread(words: str, own: float, mean: float, fractile: float) -> list[str]:
    ratio = f"{fractile / own:.2f}" if own > 0.0 and np.isfinite(fractile) else ""
    return [words, *(digits(value, 4) for value in (own, mean, fractile)), ratio]
