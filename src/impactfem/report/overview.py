"""What a run found, in short tables for the sections of the page."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pint
import xarray as xr

from impactfem.report.run_files import RunFiles
from impactfem.spectra.statistics import over_members
from impactfem.stages.device import selection as of_device
from impactfem.stages.patches import contact_patches
from impactfem.stages.stage import Stage
from impactfem.stages.stores import names_of
from impactfem.stages.transient.selection import floors_of, known, resolved, shown

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
RESIDUAL = 1e-9
"""Part of a spectrum with impacts up to which that without them is rounding."""
SMALL = 0.1
"""Part of the ZPA, or of the largest force, without impact up to which no ratio is formed."""


@dataclass(frozen=True)
class Facts:
    """A short table: its title, names of the columns with units, cells, and a note below it."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


def table(title: str, columns: str, rows: Iterable[Sequence[Any]], note: str = "") -> Facts:
    """A table with columns like "height [m] {:.2f}; floors {}", each with the format of a cell."""
    parts = [re.split(r" (?=± \{|\{)", column.strip(), maxsplit=1) for column in columns.split(";")]
    cells = [[f.format(v) for (_, f), v in zip(parts, row, strict=True)] for row in rows]
    return Facts(title, [name for name, _ in parts], cells, note)


def buildings(run: RunFiles) -> Facts:
    """The buildings of the case and their models."""
    rows = []
    models, pounding = run.models, in_3d(run.case)
    for building in run.case["buildings"]:
        name, floors = building["name"], building["floors"]
        mass, height = (sum(floor[key] for floor in floors) for key in ("mass", "storey_height"))
        # Of the model that pounds.
        known = _modes(models[name], BENDING) if name in pounding else ""
        modes = known or _modes(run, rf"sticks\.{re.escape(name)}\.frequency\.(\d+)")
        if name in pounding:
            model = "3D model, which pounds"
        else:
            model = "stick and 3D model" if name in models else "stick"
        rows.append((name, len(floors), 1e-3 * mass, height, modes or "not computed", model))
    clamped = ", clamped" if any(one.get("soil") for one in run.case["buildings"]) else ""
    columns = (
        "building {}; floors {}; mass of floors [t] {:,.0f}; height [m] {:.2f}; "
        f"first bending modes{clamped} [Hz] {{}}; model {{}}"
    )
    notes = [
        f"3D model of {name}: {one.values['building.elements']:,.0f} shells and beams, "
        f"{one.values['building.dofs']:,.0f} degrees of freedom; modes that bend at "
        f"{_modes(one, BENDING)} Hz."
        for name, one in models.items()
        if "building.dofs" in one.values
    ]
    return table("The buildings", columns, rows, " ".join(notes))


def _modes(run: RunFiles, pattern: str) -> str:
    """The first three frequencies [Hz] whose names match."""
    return ", ".join(f"{f:.2f}" for f in list(_series(run.values, pattern).values())[:3])


def impacts(run: RunFiles) -> Facts:
    """What hits what, pair by pair, the highest first."""
    with run.store("pounding.nc") as store:
        pairs = names_of(store, "pair")
        gaps = store[GAPS].to_dataframe()
        every = store[[name for name in store if store[name].dims == ("impact",)]].to_dataframe()
    rows, apart = [], []
    for name in reversed(pairs):
        hits = every[every["impact_pair"] == name]
        words = name.replace("-", " and ")
        if hits.empty:
            apart.append(words)
            continue
        main = hits.iloc[hits["impact_peak_force"].to_numpy().argmax()]
        rows.append(
            (
                words,
                len(hits),
                digits(1e-6 * main["impact_band_force"], 4),
                digits(1e-6 * main["impact_peak_force"], 4),
                main["impact_peak_time"],
                1e3 * main["impact_duration"],
                digits(main["impact_approach"], 3),
                1e3 * main["impact_penetration"],
                *(1e3 * gaps.loc[name, column] for column in GAPS),
            )
        )
    columns = (
        "what hits what {}; impacts {}; force up to 100 Hz [MN] {}; peak [MN] {}; at [s] {:.3f}; "
        "for [ms] {:.1f}; approach [m/s] {}; penetration [mm] {:.2f}; gap [mm] {:.0f}; "
        "gap needed [mm] {:.0f}"
    )
    note = f"Without impact: {', '.join(apart)}." if apart else ""
    if not pairs:
        note = "Nothing can touch: the case has no contacts."
    note = " ".join([note, *(f"{patch}." for patch in contact_patches(run.case))]).strip()
    return table("What hits what", columns, rows, note)


def in_3d(case: Mapping[str, Any]) -> set[str]:
    """Names of the buildings whose 3D models pound."""
    return {name for name, model in case["pounding"]["models"].items() if model == "structure"}


def stick_spectra(run: RunFiles, building: str) -> Facts:
    """Return the spectra of all floors in the resolved band, with and without impact."""
    with run.store("pounding.nc") as store:
        names = ["psa", "psa_free", "zpa", "zpa_free"]
        one = resolved(store[names].isel(damping=0)).load()
        one = one.isel(station=(one["station_building"] == building).values)
        damping, rows = float(one["damping"]), []
        free_zpa = one["zpa_free"].max("direction")
        for direction in names_of(store, "direction"):
            for k in reversed(range(one.sizes["station"])):
                at = one.isel(station=k).sel(direction=direction)
                psa, free = at["psa"], at["psa_free"]
                shown = (psa.max(), psa.idxmax("frequency"), at["zpa"], free.max(), at["zpa_free"])
                values = [value.item() for value in shown]
                least = max(SMALL * float(free_zpa[k]), RESIDUAL * values[0])
                ratio = digits(values[0] / values[3], 3) if values[3] > least else ""
                rows.append((at["station_floor"].item(), direction, *values, ratio))
        end = float(one["frequency"][-1])
    columns = (
        "floor {}; direction {}; peak [m/s²] {:.1f}; at [Hz] {:.1f}; ZPA [m/s²] {:.1f}; "
        "peak without impact [m/s²] {:.1f}; ZPA without impact [m/s²] {:.1f}; "
        "ratio of the peaks, with / without impact {}"
    )
    what = "mass centres of the 3D model" if building in in_3d(run.case) else "stick"
    title = f"Floor spectra of the {what} of {building}, {100 * damping:g} %, up to {end:.4g} Hz"
    return table(title, columns, rows)


def structure_spectra(run: RunFiles) -> Facts:
    """Spectra of the floors of a 3D model that are hit, and their spread over an ensemble."""
    places, fractiles = {"centre": "mass centre", "edge": "impact edge"}, _centre_fractiles(run)
    with run.store("transient.nc") as store:
        response = known(shown(store))
        force = response["impact_force"]
        on_floor = np.array([str(k).startswith("floor") for k in force["edge"].values], dtype=bool)
        hit = force["edge_floor"].values[(abs(force) > 0.0).any("time").values & on_floor]
        floors = floors_of(response, "centre")[::-1]
        rows = []
        for floor in floors:
            if hit.size and floor not in hit:
                continue
            for probe in response["psa"].isel(probe=(response["probe_floor"] == floor).values):
                if place := places.get(probe["probe_kind"].item()):
                    at = response.sel(probe=probe["probe"]).isel(probe.argmax(...))
                    values = (at[name].item() for name in ("psa", "frequency", "pfa"))
                    high = fractiles.get(floor) if place == places["centre"] else None
                    spread = "" if high is None else f"{high:.1f}"
                    rows.append((floor, place, *values, spread))
        title = (
            f"Floor spectra of the 3D model of {store.attrs['building']} along "
            f"{response['component'].item()}, {100 * response['damping'].item():g} %"
        )
    columns = (
        "floor {}; place {}; peak [m/s²] {:.1f}; at [Hz] {:.1f}; PFA [m/s²] {:.1f}; "
        "peak, 84 % of the motions [m/s²] {}"
    )
    others = {row[0] for row in rows} != set(floors)
    note = "The floors that are hit; the others are in the tables below." if others else ""
    if not any(row[-1] for row in rows):
        columns, rows = columns.rpartition(";")[0], [row[:-1] for row in rows]
    return table(title, columns, rows, note)


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


def anchor_forces(store: xr.Dataset, device: str) -> list[list[str]]:
    """Largest forces of a device by load and analysis, and the factor of the impacts."""
    headline = of_device.headline(store)
    analyses = {"3D model": of_device.DETAILED, f"RSA, {headline}": headline}
    for method, name in of_device.rigid_variants(store).items():
        analyses[f"RSA, {of_device.RIGID_WORDS[method]}"] = name
    rows = []
    loads = {words: of_device.Load(store, device, i) for i, words in of_device.LOADS.items()}
    for words, load in loads.items():
        for label, analysis in analyses.items():
            if not load.was_done(analysis):
                continue
            off, tension = load.difference(analysis), load.tension(analysis)
            rows.append(
                [
                    words,
                    label,
                    *(f"{1e-3 * value:.2f}" for value in load.components(analysis).values),
                    "" if off is None else f"{100.0 * off:+.1f}",
                    f"{1e-3 * tension:.2f}" if math.isfinite(tension) else "not known",
                ]
            )
    quiet, hit = (load.components().values for load in loads.values())
    # Forces are compared with the largest force, moments with the largest moment.
    least = SMALL * np.repeat([quiet[:3].max(), quiet[3:].max()], 3)
    both = zip(quiet, hit, least, strict=True)
    ratios = (f"{b / a:.1f}" if a > small else "" for a, b, small in both)
    return [*rows, ["ratio with / without impact", "3D model", *ratios, "", ""]]


def forces_table(title: str, first: Sequence[str], rows: list[list[str]], direction: str) -> Facts:
    """A table of `anchor_forces`, with what stands in front of its columns."""
    head = [*first, "load", "analysis", *(f"F{a} [kN]" for a in "xyz")]
    head += [f"M{a} [kN m]" for a in "xyz"]
    head += [f"difference of F{direction} [%]", "net tension [kN]"]
    note = (
        "Largest values, the weight not in them. Difference = (3D - RSA)/3D; positive where "
        "response spectrum analysis (RSA) underestimates. Net tension, less the weight: n "
        "times the pull of the most loaded of n anchors."
    )
    return Facts(title, head, rows, note)


def device_verdict(run: RunFiles, device: str) -> Facts:
    """Return the largest forces of a device by every analysis."""
    with run.store("device.nc") as store:
        rows, direction = anchor_forces(store, device), of_device.direction(store)
        _, floor, _ = of_device.anchor_of(store, device)
        title = f"Forces of {device} on floor {floor} of {store.attrs['building']}"
    return forces_table(title, (), rows, direction)


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


def _series(values: dict[str, Any], pattern: str) -> dict[int, float]:
    """Values whose names end in a number, by that number and in its order."""
    found = {int(m[1]): v for name, v in values.items() if (m := re.fullmatch(pattern, name))}
    return dict(sorted(found.items()))


def digits(value: float, count: int) -> str:
    """A value with so many digits."""
    return f"{value:.{count}g}" if np.isfinite(value) else "not known"


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


def headlines(stage: Stage, results: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the lines of a stage with its results, without those that lack a result.

    In a line, ``{name}`` stands for a result with its unit; a name with * for the largest of those
    that it matches, one with ? for the first one, whose letter stands in place of each ? of the
    line. The results are those of `summary.json`.
    """
    values = {one["name"]: (one["value"], one["unit"]) for one in results}
    lines = []
    for line in stage.headlines:
        words: str | None = line
        for name in re.findall(r"\{([^}]+)\}", line):
            pattern = re.escape(name).replace(r"\*", r"[\w.]*").replace(r"\?", r"(\w)")
            matches = ((re.fullmatch(pattern, n), v) for n, v in values.items() if v[0] is not None)
            found = [(match, v) for match, v in matches if match]
            if words is None or not found:
                words = None
                break
            value = found[0][1] if "?" in name else max(v for _, v in found)
            words = words.replace(f"{{{name}}}", quantity(*value, digits=4))
            words = words.replace("?", found[0][0][1]) if "?" in name else words
        lines += [] if words is None else [words.replace("m/s2", "m/s²")]
    return lines
