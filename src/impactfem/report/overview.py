"""What a run found, for the page that is read in a minute."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pint
import xarray as xr

from impactfem.report.run_files import RunFiles
from impactfem.spectra.statistics import over_members
from impactfem.stages.device import selection as of_device
from impactfem.stages.device.verdict import anchors, shortfall
from impactfem.stages.stores import names_of
from impactfem.stages.transient.selection import floors_of, known, shown

UNITS: pint.UnitRegistry[float] = pint.UnitRegistry()
PREFIXED = {
    "N": "newton",
    "N s": "newton * second",
    "N/m": "newton / metre",
    "Pa": "pascal",
    "s": "second",
    "m": "metre",
}
GAPS = ["pair_rest_gap", "pair_required_separation"]
BENDING = r"building\.frequency\.(\d+)"
"""Names of the frequencies of the modes of a 3D model that bend."""
FLOORS = 3
"""Number of floors that are shown where not all that are hit are."""


@dataclass(frozen=True)
class Facts:
    """A short table: its title, names of the columns with units, cells, and a note below it."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


def _facts(title: str, columns: str, rows: Iterable[Sequence[Any]], note: str = "") -> Facts:
    """A table with columns like "height [m] {:.2f}; floors {}", each with the format of a cell."""
    parts = [re.split(r" (?=± \{|\{)", column.strip(), maxsplit=1) for column in columns.split(";")]
    cells = [[f.format(v) for (_, f), v in zip(parts, row, strict=True)] for row in rows]
    return Facts(title, [name for name, _ in parts], cells, note)


def facts(run: RunFiles) -> list[Facts]:
    """The buildings, what hits what, the governing spectra and the device forces of a run."""
    found = [_buildings(run)]
    if run.has("pounding.nc"):
        found.append(_impacts(run))
        found.append(_stick_spectra(run))
    for one in (run, *(run.of(name) for name in run.further)):
        if one.has("transient.nc"):
            found.append(_structure_spectra(one))
        if one.has("device.nc"):
            found.append(_devices(one))
        if "ensemble3d.members" in one.values:
            found.append(_carried(one))
    return found


def _buildings(run: RunFiles) -> Facts:
    rows = []
    first = [run.case["structure"]["building"]] if run.case["structure"] else []
    models = dict(
        zip([*first, *run.further], (run, *(run.of(name) for name in run.further)), strict=False)
    )
    for building in run.case["buildings"]:
        name, floors = building["name"], building["floors"]
        mass, height = (sum(floor[key] for floor in floors) for key in ("mass", "storey_height"))
        modes = _modes(run, rf"sticks\.{re.escape(name)}\.frequency\.(\d+)") or "not computed"
        model = "stick and 3D model" if name in models else "stick"
        rows.append((name, len(floors), 1e-3 * mass, height, modes, model))
    columns = (
        "building {}; floors {}; mass of floors [t] {:,.0f}; height [m] {:.2f}; "
        "first modes [Hz] {}; model {}"
    )
    notes = [
        f"3D model of {name}: {one.values['building.elements']:,.0f} shells and beams, "
        f"{one.values['building.dofs']:,.0f} degrees of freedom; modes that bend at "
        f"{_modes(one, BENDING)} Hz."
        for name, one in models.items()
        if "building.dofs" in one.values
    ]
    return _facts("The buildings", columns, rows, " ".join(notes))


def _modes(run: RunFiles, pattern: str) -> str:
    """The first three frequencies [Hz] whose names match."""
    return ", ".join(f"{f:.2f}" for f in list(_series(run.values, pattern).values())[:3])


def _impacts(run: RunFiles) -> Facts:
    with run.store("pounding.nc") as store:
        pairs = names_of(store, "pair")
        gaps = store[GAPS].to_dataframe()
        impacts = store[[name for name in store if store[name].dims == ("impact",)]].to_dataframe()
    rows, apart = [], []
    for name in reversed(pairs):
        hits = impacts[impacts["impact_pair"] == name]
        words = name.replace("-", " and ")
        if hits.empty:
            apart.append(words)
            continue
        main = hits.iloc[hits["impact_peak_force"].to_numpy().argmax()]
        rows.append(
            (
                *(words, len(hits), _number(1e-6 * main["impact_peak_force"], 4)),
                *(main["impact_peak_time"], 1e3 * main["impact_duration"]),
                *(_number(main["impact_approach"], 3), 1e3 * main["impact_penetration"]),
                *(1e3 * gaps.loc[name, column] for column in GAPS),
            )
        )
    columns = (
        "what hits what {}; impacts {}; largest force [MN] {}; at [s] {:.3f}; for [ms] {:.1f}; "
        "approach [m/s] {}; penetration [mm] {:.2f}; gap [mm] {:.0f}; gap needed [mm] {:.0f}"
    )
    note = f"Without impact: {', '.join(apart)}." if apart else ""
    if not pairs:
        note = "Nothing can touch: the case has no contacts."
    return _facts("What hits what, and how hard", columns, rows, note)


def _stick_spectra(run: RunFiles) -> Facts:
    with run.store("pounding.nc") as store:
        building, direction = store.attrs["studied_building"], store.attrs["shown_direction"]
        spectra = store.sel(direction=direction).isel(damping=0)
        floors = spectra.isel(station=(spectra["station_building"] == building).values)
        forces = _series(run.values, r"pounding\.peak_force\.floor_(\d+)")
        hit = {number for number, force in forces.items() if force > 0.0}
        damping, rows = store["damping"].values[0], []
        for k in reversed(range(floors.sizes["station"])):
            one = floors.isel(station=k)
            if hit and one["station_floor"].item() not in hit:
                continue
            psa, free = one["psa"], one["psa_free"]
            shown = (psa.max(), psa.idxmax("frequency"), one["pfa"], free.max(), one["pfa_free"])
            rows.append((one["station_floor"].item(), *(value.item() for value in shown)))
    columns = (
        "floor {}; peak [m/s²] {:.1f}; at [Hz] {:.1f}; PFA [m/s²] {:.1f}; "
        "peak, no contact [m/s²] {:.1f}; PFA, no contact [m/s²] {:.1f}"
    )
    title = f"Floor spectra of the stick of {building} along {direction}, {100 * damping:g} %"
    return _facts(title, columns, rows, _others(rows, floors.sizes["station"]))


def _structure_spectra(run: RunFiles) -> Facts:
    places = {"centre": "mass centre", "edge": "impact edge"}
    with run.store("transient.nc") as store:
        response = known(shown(store))
        force = response["edge_force"]
        hit = force["edge_floor"].values[(abs(force) > 0.0).any("time").values]
        floors = floors_of(response, "centre")[::-1]
        rows = []
        for floor in floors:
            if hit.size and floor not in hit:
                continue
            for probe in response["psa"].isel(probe=(response["probe_floor"] == floor).values):
                if place := places.get(probe["probe_kind"].item()):
                    at = response.sel(probe=probe["probe"]).isel(probe.argmax(...))
                    values = (at[name].item() for name in ("psa", "psa_band", "frequency", "pfa"))
                    rows.append((floor, place, *values))
        title = (
            f"Floor spectra of the 3D model of {store.attrs['building']} along "
            f"{response['component'].item()}, {100 * response['damping'].item():g} %"
        )
    columns = (
        "floor {}; place {}; peak [m/s²] {:.1f}; error band [m/s²] ± {:.2g}; at [Hz] {:.1f}; "
        "PFA [m/s²] {:.1f}"
    )
    return _facts(title, columns, rows, _others({row[0] for row in rows}, len(floors)))


def _devices(run: RunFiles) -> Facts:
    with run.store("device.nc") as store:
        headline, direction = of_device.headline(store), of_device.direction(store)
        choices: dict[str, str | None] = {"3D model": None, f"RSA, {headline}": headline}
        for method, name in of_device.rigid_variants(store).items():
            choices[f"RSA, {of_device.RIGID_WORDS[method]}"] = name
        rows, notes = [], []
        for device in names_of(store, "device"):
            for impact, words in of_device.LOADS.items():
                load = of_device.Load(store, device, impact)
                for label, choice in choices.items():
                    if not load.was_done(choice):
                        continue
                    off = None if choice is None else load.difference(choice)
                    tension = load.tension(choice)
                    rows.append(
                        [
                            *(device, words, label),
                            *(f"{1e-3 * value:.2f}" for value in load.components(choice).values),
                            "" if off is None else f"{100.0 * off:+.1f}",
                            f"{1e-3 * tension:.2f}" if math.isfinite(tension) else "not known",
                        ]
                    )
            notes += [f"{device}: {text}." for text in shortfall(store, device)]
            if (pulled := anchors(store, device)) is not None:
                notes.append(f"{device}, net tension at the anchor: {pulled}.")
    head = ["device", "load", "analysis", *(f"F{a} [kN]" for a in "xyz")]
    head += [f"M{a} [kN m]" for a in "xyz"]
    head += [f"difference of F{direction} [%]", "net tension [kN]"]
    note = (
        "Largest values, the weight not in them. Difference: from the 3D model, over it; positive "
        "where response spectrum analysis (RSA) gives too little. Net tension, less the weight: n "
        "times the pull of the most loaded of n anchors (tables/device_anchors.csv). "
    )
    return Facts("Forces of the devices on the floor", head, rows, note + " ".join(notes))


def _carried(run: RunFiles) -> Facts:
    """What an ensemble of motions gives in the 3D model and on the first device."""
    values = run.values
    with run.store("design.nc") as store:
        rows, note = _carried_floors(store)
        building = store.attrs["building"]
    top = max(_series(values, r"ensemble3d\.mean\.transient\.frs\.floor_(\d+)\.peak"), default=None)
    if top is not None:
        name = f"transient.frs.floor_{top}.peak"
        words = f"floor {top}, mass centre, peak of the spectrum [m/s²]"
        rows.append(_spread(words, *_of_all(values, name, 1.0)))
    for name in values:
        if name.startswith("ensemble3d.mean.device.f") and name.count(".") == 5:
            own = name.removeprefix("ensemble3d.mean.")
            _, force, analysis, _ = own.split(".")
            words = f"first device, {force.capitalize()}, {analysis} [kN]"
            rows.append(_spread(words, *_of_all(values, own, 1e-3)))
    title = f"Over {values['ensemble3d.members']:.0f} motions through the 3D model"
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


def _of_all(values: dict[str, float], name: str, factor: float) -> tuple[float, ...]:
    """A result of this motion, and its mean and fractile; nan where one is not known."""
    found = (name, f"ensemble3d.mean.{name}", f"ensemble3d.p84.{name}")
    return tuple(factor * values.get(one, math.nan) for one in found)


def _spread(words: str, own: float, mean: float, fractile: float) -> list[str]:
    ratio = f"{fractile / own:.2f}" if own > 0.0 and np.isfinite(fractile) else ""
    return [words, *(_number(value, 4) for value in (own, mean, fractile)), ratio]


def _others(shown: Collection[object], whole: int) -> str:
    return "" if len(shown) == whole else "The floors that are hit; the others are further below."


def _series(values: dict[str, Any], pattern: str) -> dict[int, float]:
    """Values whose names end in a number, by that number and in its order."""
    found = {int(m[1]): v for name, v in values.items() if (m := re.fullmatch(pattern, name))}
    return dict(sorted(found.items()))


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}g}" if np.isfinite(value) else "not known"


def tiles(run: RunFiles) -> list[tuple[str, str]]:
    """The few numbers that a run is remembered by."""
    values = run.values
    found = []
    for entry in run.summary:
        if entry["name"] == "pounding.main_impact_force" and entry["value"] is not None:
            where = entry["note"].replace("-", " and ").replace("_", " ")
            force = quantity(entry["value"], entry["unit"], digits=4)
            found.append((force, f"largest impact force of the sticks, {where}"))
    if "pounding.impacts" in values:
        found.append((f"{values['pounding.impacts']:.0f}", "impacts"))
    if "pounding.required_separation" in values:
        gap = 100.0 * values["pounding.required_separation"]
        text = "gap that would prevent contact under this motion"
        band = [values.get(f"ensemble.p{q}.pounding.required_separation") for q in ("05", "95")]
        if (low := band[0]) is not None and (high := band[1]) is not None:
            count = values["ensemble.members"]
            text += f"; {100.0 * low:.3g} to {100.0 * high:.3g} cm under 5 to 95 % of {count:.0f}"
        found.append((f"{gap:.3g} cm", text))
    edges = {n: v for n, v in values.items() if re.fullmatch(r"transient\.pfa\.edge_\d+\.max", n)}
    if edges:
        name = max(edges, key=lambda n: edges[n])
        floor = name.removesuffix(".max").rpartition("_")[2]
        where = f"largest acceleration along an impact edge, floor {floor}"
        found.append((f"{edges[name]:.3g} m/s²", where))
    if "calibration.epsilon" in values:
        used = "" if wall_is_used(run.case) else "; not used here, the case gives the law"
        text = f"restitution ε of the 3D model at a rigid wall{used}"
        found.append((f"{values['calibration.epsilon']:.3g}", text))
    # The first of them is that along the shown direction.
    names = [name for name in values if re.fullmatch(r"device\.f[xyz]\.detailed\.impact", name)]
    if names:
        found.append((f"{1e-3 * values[names[0]]:.4g} kN", "force on the first device's anchor"))
    return found


def key_results(run: RunFiles) -> list[tuple[str, str]]:
    """Up to ten numbers of any run: its tiles, and its governing floor spectra and forces.

    A store of a stage that the run did not reach is of an earlier run, of other inputs maybe.
    """
    found = tiles(run)
    if "pounding" in run.stages and (spectra := _stick_spectra(run)).rows:
        floor, peak, at, _, free, _ = spectra.rows[0]
        what = spectra.title.removeprefix("Floor spectra of ")
        text = f"peak of the floor spectrum of {what}, floor {floor}, at {at} Hz"
        found.append((f"{peak} m/s²", f"{text}; {free} without contact"))
    if "transient" in run.stages and (spectra := _structure_spectra(run)).rows:
        floor, place, peak, _, at, _ = max(spectra.rows, key=lambda row: float(row[2]))
        what = spectra.title.removeprefix("Floor spectra of ")
        found.append((f"{peak} m/s²", f"the same of {what}, floor {floor}, {place}, at {at} Hz"))
    for name in sorted(run.values):
        if m := re.fullmatch(r"device\.relative_difference\.(no_impact|impact)", name):
            words = "without impact" if m[1] == "no_impact" else "with impacts"
            low = 100.0 * run.values[name]
            way = "low" if low >= 0.0 else "high"
            text = f"by which response spectrum analysis of the first device is too {way}, {words}"
            found.append((f"{abs(low):.1f} %", text))
    return found


def wall_is_used(case: Mapping[str, Any]) -> bool:
    """Whether a contact law of a case takes a value from the impact on the rigid wall."""
    laws = case["contact_laws"].values()
    return any("calibrated" in (law.get("stiffness"), law.get("restitution")) for law in laws)


def number(value: float | None, digits: int = 5) -> str:
    """A value with so many digits; a dash for none."""
    if value is None:
        return "–"
    if value != 0.0 and not 1e-3 <= abs(value) < 1e6:
        return f"{value:.{digits - 1}g}" if math.isfinite(value) else "–"
    return f"{value:.{digits}g}"


def quantity(value: float | None, unit: str, *, digits: int = 5) -> str:
    """A value with its unit, with a prefix where the unit takes one, and so many digits.

    Whole numbers without a unit, as counts, have all their digits.
    """
    if value is not None and unit == "-" and float(value).is_integer():
        return f"{value:,.0f}"
    if value is None or unit == "-":
        return number(value, digits)
    if unit in PREFIXED and value != 0.0:
        compact = UNITS.Quantity(value, PREFIXED[unit]).to_compact()
        return f"{compact.magnitude:.{digits}g} {compact.units:~D}".replace(" * ", " ").replace(
            " / ", "/"
        )
    return f"{number(value, digits)} {unit}"
