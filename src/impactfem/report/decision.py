"""The first screen of the page: what a decision needs, whatever the case has."""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED
from impactfem.report.overview import (
    RESIDUAL,
    Facts,
    anchor_forces,
    digits,
    forces_table,
    in_3d,
    quantity,
    table,
    wall_is_used,
)
from impactfem.report.run_files import SPECTRA, RunFiles
from impactfem.stages.check import HALVED, QUIET
from impactfem.stages.device import selection as of_device
from impactfem.stages.stores import names_of
from impactfem.stages.transient.selection import known

STICK, MODEL = "stick", "3D model"
G = 9.80665
MAIN_FORCE = "pounding.main_impact_force"
KEY_RESULTS = 10
"""Number of results at the end of a run."""
PLACES = {"centre": "mass centre", "edge": "impact edge", "line": "on the line across"}
"""Kinds of probes in words."""
PURPLE = "#7a4fa3"
SLIGHT = 0.05
"""Least ratio of the largest ordinate without impact to that of the building along all directions,
for the factor of the first screen."""
NEAR = 5e-4
"""Differences below it are 0.0 % in print."""
COUNTS = 0.1
"""Least ratio of an ordinate to that which governs, for the same."""


@dataclass(frozen=True)
class Answer:
    """An answer of the first screen."""

    question: str
    value: str  #: the answer in a number or a word
    text: str  #: what it is
    mark: str = ""  #: "good", "warn", or "" where there is no limit
    link: str = ""  #: id of the section with the details


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The floor spectrum with the largest ordinate of a body along a direction."""

    building: str
    model: str  #: `STICK`, `MODEL`, or name of the device at whose anchor it is
    floor: int  #: its number; 0 for a point on none
    place: str
    direction: str
    damping: float  #: of the oscillators [-]; nan where not known
    psa: xr.DataArray  #: by frequency [m/s2]
    pfa: float  #: peak acceleration [m/s2]
    free: xr.DataArray | None  #: the same without impact; None where that was not computed

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
    def still(self) -> float:
        """The largest ordinate without impact [m/s2]; 0 where that was not computed."""
        return 0.0 if self.free is None else float(self.free.max())

    @property
    def factors(self) -> tuple[float, float]:
        """Its peak over that without impact, and the ratio at the frequency of the former.

        nan where impacts alone move the point: what is left without them is rounding.
        """
        if self.free is None or self.still <= RESIDUAL * self.peak:
            return math.nan, math.nan
        there = self.free.sel(frequency=self.at, method="nearest")
        with np.errstate(divide="ignore", invalid="ignore"):
            both = self.peak / np.array([self.still, float(there)])
        return float(both[0]), float(both[1])

    def largest_factor(self, least: float) -> tuple[float, float]:
        """The largest ratio to that without impact of ordinates of at least so much, and where."""
        if self.free is None or self.still <= RESIDUAL * self.peak:
            return 0.0, math.nan
        counts = (self.psa >= least) & (self.free > RESIDUAL * self.psa)
        ratio = (self.psa / self.free).where(counts, 0.0)
        return float(ratio.max()), float(ratio.idxmax("frequency"))

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
    return sorted(found, key=lambda one: (one.at_anchor, -one.peak))


def _of_sticks(run: RunFiles) -> list[Spectrum]:
    """Of each floor along each direction, as it pounded."""
    found, touched = [], in_3d(run.case)
    with run.store("pounding.nc") as store:
        one = store[["psa", "psa_free", "pfa"]].isel(damping=0).load()
        for k, name in enumerate(one["station_building"].values.tolist()):
            model, place = (MODEL, PLACES["centre"]) if name in touched else (STICK, "")
            for direction in names_of(store, "direction"):
                at = one.isel(station=k).sel(direction=direction)
                floor, ratio = int(at["station_floor"]), float(at["damping"])
                values = at["psa"], float(at["pfa"]), at["psa_free"]
                found.append(Spectrum(name, model, floor, place, direction, ratio, *values))
    return _moving(found)


def _of_model(run: RunFiles) -> list[Spectrum]:
    """The largest along each direction: over whole floors, if stage `design` has looked there."""
    found = []
    if run.ran("design"):
        with run.store("design.nc") as store:
            one = known(store[["psa", "zpa"]].isel(damping=0)).load()
            place = f"largest {'over the floor' if 'vertex' in store.dims else 'of its probes'}"
            for direction in names_of(store, "direction"):
                at = _largest(one.sel(direction=direction), "station")
                floor, ratio = int(at["station_floor"]), float(at["damping"])
                where = (str(store.attrs["building"]), MODEL, floor, place, direction, ratio)
                found.append(Spectrum(*where, at["psa"], float(at["zpa"]), None))
            kept = names_of(store, "elsewhere")  # on no floor
    with run.store("transient.nc") as store:
        one = known(store[["psa", "pfa"]].isel(damping=0)).load()
        one = one.sel(probe=kept) if found else one
        for direction in names_of(store, "component") if one.sizes["probe"] else []:
            at = _largest(one.sel(component=direction), "probe")
            place = PLACES.get(str(at["probe_kind"].item()), str(at["probe"].item()))
            floor, ratio = int(at["probe_floor"]), float(at["damping"])
            where = (str(store.attrs["building"]), MODEL, floor, place, direction, ratio)
            found.append(Spectrum(*where, at["psa"], float(at["pfa"]), None))
    found.sort(key=lambda one: -one.peak)
    return _moving(list({one.direction: one for one in reversed(found)}.values()))


def _largest(some: xr.Dataset, dim: str) -> xr.Dataset:
    """Of spectra over places that with the largest ordinate."""
    return some.isel({dim: int(np.argmax(some["psa"].max("frequency").values))})


def _of_anchors(run: RunFiles) -> list[Spectrum]:
    """Of each anchor along the direction with the largest ordinate."""
    found = []
    with run.store("device.nc") as store:
        for device in names_of(store, "device"):
            loads = {impact: of_device.Load(store, device, impact) for impact in of_device.LOADS}
            hit, quiet = (loads[impact].of("psa").load() for impact in ("with", "without"))
            axis = str(hit.max("frequency").idxmax("axis").item())
            moved = loads["with"].of("anchor_acceleration", component=axis)
            _, floor, _ = of_device.anchor_of(store, device)
            damping = float(of_device.modes_of(store, device)["mode_damping"][:1].sum())
            where = (str(store.attrs["building"]), device, floor, "", axis, damping or math.nan)
            pfa = float(abs(moved).max())
            found.append(Spectrum(*where, hit.sel(axis=axis), pfa, quiet.sel(axis=axis)))
    return found


def _moving(found: list[Spectrum]) -> list[Spectrum]:
    """Those of which more is seen than the numbers behind the point."""
    largest = max((one.peak for one in found), default=0.0)
    return [one for one in found if one.peak > QUIET * largest]


def spectra_table(spectra: list[Spectrum]) -> Facts:
    """The spectra that govern, a row each."""
    columns = (
        "where {}; along {}; damping [%] {:.3g}; peak [m/s²] {:.4g}; at [Hz] {:.1f}; "
        "PFA [m/s²] {:.4g}; peak without impact [m/s²] {}; factor of the peak {}; factor at its "
        "frequency {}"
    )
    rows = []
    for one in spectra:
        free = "" if one.free is None else digits(float(one.free.max()), 4)
        factors = (digits(f, 3) if math.isfinite(f) else "" for f in one.factors)
        own = (one.words, one.direction, 100.0 * one.damping, one.peak, one.at, one.pfa)
        rows.append((*own, free, *factors))
    note = "The largest ordinates of each body along each direction; at anchors along one."
    if any(one.free is None for one in spectra):
        note += " Where a 3D model has no peak without impact, it was not computed without."
    return table("Floor spectra that govern", columns, rows, note)


def devices(run: RunFiles) -> Iterator[tuple[xr.Dataset, str]]:
    """The devices of all 3D models, each with the open store that has it."""
    for one in run.models.values():
        if one.ran("device"):
            with one.store("device.nc") as store:
                for device in names_of(store, "device"):
                    yield store, device


def untouched(run: RunFiles) -> bool:
    """Whether the run knows its impacts and has none."""
    return run.values.get("pounding.impacts") == 0.0


def anchors_table(run: RunFiles) -> Facts | None:
    """Largest forces of all devices on their floors by component; None without devices."""
    rows, direction = [], ""
    for store, device in devices(run):
        direction = of_device.direction(store)
        rows += [[device, *row] for row in anchor_forces(store, device)]
    return forces_table("Forces on the anchors", ["device"], rows, direction) if rows else None


def answers(run: RunFiles, spectra: list[Spectrum]) -> list[Answer]:
    """What the first screen answers, as far as the case has it."""
    found = []
    if spectra:
        one = spectra[0]
        text = f"{one.words}, along {one.direction}, {100.0 * one.damping:.3g} % damping"
        text += f"; {one.peak / G:.3g} g, peak acceleration (ZPA) {one.pfa:.3g} m/s²"
        text += _by_steps(run, "pfa") if one.model == MODEL else ""
        value = f"{one.peak:.3g} m/s² at {one.at:.3g} Hz"
        if one.at >= float(one.psa["frequency"][-1]):
            text += "; at the end of the range, beyond which it may be larger"
        found.append(Answer("Floor spectrum that governs", value, text, link="spectra"))
        # Of all floors: the impact may be felt most where another one governs.
        every = (*(_of_sticks(run) if run.ran("pounding") else ()), *spectra)
        top, factors = COUNTS * max(other.peak for other in every), []
        for name in dict.fromkeys(other.building for other in every):
            own = [other for other in every if other.building == name]
            # A direction in which the ground hardly moves it would have a factor without meaning.
            least = SLIGHT * max(other.still for other in own)
            factors += [
                (*other.largest_factor(top), other) for other in own if other.still >= least
            ]
        times, at, one = max(factors, key=lambda factor: factor[0], default=(0.0, math.nan, one))
        if times > 0.0 and one.free is not None and not untouched(run):
            hit, quiet = (float(psa.sel(frequency=at)) for psa in (one.psa, one.free))
            text = f"{one.words}, along {one.direction}, {100.0 * one.damping:.3g} % damping: "
            text += f"{hit:.3g} against {quiet:.3g} m/s² there; "
            text += f"largest ordinates {one.peak:.3g} against {one.still:.3g} m/s²"
            value = f"× {times:.3g} at {at:.3g} Hz"
            found.append(Answer("Over the case without impact", value, text, link="spectra"))
    found += _gap(run) + _anchors(run)
    force = next((one for one in run.summary if one["name"] == MAIN_FORCE), None)
    if force is not None and force["value"] is not None:
        where = force["note"].replace("-", " and ").replace("_", " ")
        value = quantity(force["value"], force["unit"], digits=4)
        count = run.values.get("pounding.impacts", 0.0)
        text = f"{where}; {count:.0f} impact{'s' if count > 1 else ''} in all"
        if by_steps := _by_steps(run, "force"):
            mean = quantity(run.values["pounding.mean_force_5ms"], "N", digits=3)
            text += f"{by_steps}; largest mean over 5 ms {mean}"
        found.append(Answer("Largest impact", value, text, link="stage_pounding"))
    elif "pounding.required_separation" in run.values and untouched(run):
        found.append(Answer("Largest impact", "none", "nothing touches", link="stage_pounding"))
    good = [check["good"] for check in run.checks]
    limits, missed = sum(one is not None for one in good), good.count(False)
    value = f"{missed} of {limits} not met" if missed else f"all {limits} met"
    text = "listed below: they decide whether the rest may be used" if missed else ""
    found.append(Answer("Checks", value, text, "warn" if missed else "good", "checks"))
    return found


def _gap(run: RunFiles) -> list[Answer]:
    if not run.ran("pounding"):
        return []
    with run.store("pounding.nc") as store:
        pairs = names_of(store, "pair")
        if not pairs:
            return [Answer("Gap", "no contacts", "nothing can touch: the case has no contacts")]
        margin = store["pair_margin"].values
        k = int(margin.argmin())
        there, needed = (
            1e3 * float(store[name][k]) for name in ("pair_rest_gap", "pair_required_separation")
        )
        most = 1e3 * float(store["pair_required_separation"].max())
    text = f"there {there:.3g} mm, between {pairs[k].replace('-', ' and ').replace('_', ' ')}"
    band = [run.values.get(f"ensemble.p{q}.pounding.required_separation") for q in ("05", "95")]
    if needed < most:
        text += f"; other pairs, with larger gaps, need up to {most:.3g} mm"
    elif (low := band[0]) is not None and (high := band[1]) is not None:
        count = run.values["ensemble.members"]
        text += f"; under {count:.0f} motions {1e3 * low:.3g} to {1e3 * high:.3g} mm (5 to 95 %)"
    value = f"{needed:.3g} mm needed"
    mark = "good" if margin[k] >= 0.0 else "warn"
    return [Answer("Gap that prevents contact", value, text, mark, "stage_pounding")]


def _anchors(run: RunFiles) -> list[Answer]:
    """Of all devices, with the words for the one that is pulled most."""
    pulled: dict[tuple[str, str], float] = {}
    bare: dict[tuple[str, str], float] = {}  # without weight
    texts = {}
    for store, device in devices(run):
        axis = of_device.direction(store)
        quiet, hit = (of_device.Load(store, device, i) for i in of_device.LOADS)
        _, floor, _ = of_device.anchor_of(store, device)
        key = (str(store.attrs["building"]), device)
        pulled[key] = max(quiet.tension(), hit.tension())
        bare[key] = max(quiet.pull(), hit.pull())
        moment = f"M{'y' if axis == 'x' else 'x'}"
        turned = float(hit.components().sel(component=f"r{moment[1]}"))
        factor = hit.detailed / quiet.detailed if quiet.detailed > 0.0 else math.nan
        times = f" (× {factor:.3g})" if math.isfinite(factor) else ""
        texts[key] = (
            f"{device} on floor {floor} of {key[0]}: F{axis} {1e-3 * hit.detailed:.4g} kN"
            f"{times}, Fz {1e-3 * float(hit.components().sel(component='z')):.3g} kN, "
            f"{moment} {1e-3 * turned:.3g} kN m"
        )
    if not pulled:
        return []
    known_ones = {key: value for key, value in pulled.items() if math.isfinite(value)}
    key = max(known_ones or pulled, key=lambda one: pulled[one])
    up = sum(value > 0.0 for value in known_ones.values())
    link, unknown = f"device_{key[1]}", len(pulled) - len(known_ones)
    if not known_ones:
        value, mark = "net tension not known", ""
    elif up:
        count = f" at {up} of {len(pulled)}" if len(pulled) > 1 else ""
        value, mark = f"net tension{count}", "warn"
        texts[key] += f"; {1e-3 * pulled[key]:.3g} kN/n in the most loaded of n anchors"
    else:
        value, mark = "no net tension", "" if unknown else "good"
    if known_ones and unknown:
        more, (_, name) = max((bare[one], one) for one in pulled if one not in known_ones)
        texts[key] += (
            f"; not known at {unknown} of {len(pulled)}: weight not given; neglecting it "
            f"up to {1e-3 * more:.3g} kN/n, at {name}"
        )
    return [Answer("Anchors", value, texts[key], mark, link)]


def _by_steps(run: RunFiles, what: str) -> str:
    """How much steps twice as long change a value, at most, where it depends on them."""
    change = run.values.get(f"pounding.doubled_step_{what}_change", 0.0)
    text = f" (steps twice as long change it by up to {100.0 * change:.2g} %)"
    return text if change > HALVED else ""


def at_wall(run: RunFiles) -> float | None:
    """The restitution of the building that hits the rigid wall; None without one."""
    found = (one.values.get("calibration.epsilon") for one in run.models.values())
    return next((value for value in found if value is not None), None)


def spectra_figure(run: RunFiles, spectra: list[Spectrum]) -> Path | None:
    """Draw `decision_spectra.svg`: of the building that governs, and an anchor or another one."""
    anchors = [one for one in spectra if one.at_anchor]
    buildings = dict.fromkeys(one.building for one in spectra if not one.at_anchor)
    panels = [_building_panel(run, spectra, name) for name in [*buildings][: 1 if anchors else 2]]
    for one in anchors[:1]:
        curves = [_curve(one.psa, "with impacts", GREEN, "-")]
        if one.free is not None:
            curves.append(_curve(one.free, "without impact", GREEN, "--"))
        title = f"Anchor of {one.model}, {one.building}, along {one.direction}"
        if math.isfinite(one.damping):
            title += f", {100.0 * one.damping:.3g} % damping"
        panels.append(_panel(curves, title))
    if not panels:
        return None
    caption = (
        "Floor spectra that govern, with and without impact. Solid: with impacts; dashed: without. "
        + " ".join(f"({'ab'[k]}) {panel.title}." for k, panel in enumerate(panels))
    )
    size = (5.5 * len(panels), 3.3)
    drawn = CurveFigure(SPECTRA, caption, panels, len(panels), size)
    return drawn.write(run.folder / "figures")


def _building_panel(run: RunFiles, spectra: list[Spectrum], building: str) -> Panel:
    """Spectra of the floor of a building that governs, along the direction that governs."""
    # Where a point on no floor governs, of the point and of the stick's floor that governs.
    own = [one for one in spectra if one.building == building and not one.at_anchor]
    first = own[0]
    along = (one for one in own if (one.model, one.direction) == (STICK, first.direction))
    floor, curves = first.floor or next(along, first).floor, []
    touched = in_3d(run.case)
    with run.store("pounding.nc") as store:
        one = store[["psa", "psa_free"]].isel(damping=0)
        here = (one["station_building"] == building) & (one["station_floor"] == floor)
        if first.direction in names_of(store, "direction"):
            pounded = one.isel(station=here.values).sel(direction=first.direction)
            model = f"{MODEL}, {PLACES['centre']}" if building in touched else STICK
            for name, dash, words in (("psa", "-", "with impacts"), ("psa_free", "--", "without")):
                curves += [_curve(psa, f"{model}, {words}", BLUE, dash) for psa in pounded[name]]
    if building in run.models and run.models[building].ran("transient"):
        with run.models[building].store("transient.nc") as store:
            one = known(store[["psa"]].isel(damping=0)).sel(component=first.direction)
            kinds = {"centre": ORANGE, "edge": RED}
            if building in touched:
                del kinds["centre"]  # as it pounded
            for kind, colour in kinds.items():
                here = (one["probe_kind"] == kind) & (one["probe_floor"] == floor)
                at = one["psa"].isel(probe=here.values)
                curves += [_curve(psa, f"3D model, {PLACES[kind]}", colour, "-") for psa in at]
    if first.model == MODEL and first.place not in (PLACES["centre"], PLACES["edge"]):
        curves.append(_curve(first.psa, f"3D model, {first.place}", PURPLE, "-"))
    title = f"{building}, floor {floor}, " if floor else f"{building}, "
    return _panel(curves, f"{title}along {first.direction}, {100.0 * first.damping:.3g} % damping")


def _curve(spectrum: xr.DataArray, label: str, colour: str, dash: str) -> Curve:
    return Curve(spectrum["frequency"].values, spectrum.values, label, colour, dash, width=1.3)


def _panel(curves: list[Curve], title: str) -> Panel:
    axes: Mapping[str, Any] = {"log": "x", "bottom": 0.0, "legend": "upper left"}
    return Panel("frequency [Hz]", "pseudo-acceleration [m/s²]", curves, title, **axes)


def _first_device(run: RunFiles, impact: str, words: str) -> str:
    """What is compared of the first device, and how far RSA is low in its overturning moment."""
    for store, device in devices(run):
        text = f"F{of_device.direction(store)} of the first device, {device}, {words}"
        moment = of_device.Load(store, device, impact).moment()
        if moment is not None and moment[1] > NEAR:
            text += f"; RSA underestimates {moment[0]} by {100.0 * moment[1]:.1f} %"
        return text
    return f"the force of the first device, {words}"


def key_results(run: RunFiles) -> list[tuple[str, str]]:
    """Up to ten numbers of any run, each with what it is: those of the first screen, and more."""
    spectra = governing(run)
    every = answers(run, spectra)[:-1]  # the console has counted the checks already
    found = [(one.value, f"{one.question.lower()}: {one.text}") for one in every]
    if (epsilon := at_wall(run)) is not None:
        used = "" if wall_is_used(run.case) else "; not used here, the case gives the law"
        used = used if run.case["contact_laws"] else "; nothing touches in this case"
        found.append((f"{epsilon:.3g}", f"restitution ε of the 3D model at a rigid wall{used}"))
    for impact, words in of_device.LOADS.items():
        if impact == of_device.WITH and untouched(run):
            continue
        name = f"device.relative_difference.{of_device.IN_NAMES[impact]}"
        if (low := run.values.get(name)) is not None:
            text = f"by which RSA {'under' if low >= 0.0 else 'over'}estimates"
            if abs(low) < NEAR:
                text = "difference between RSA and"
            text += f" {_first_device(run, impact, words)}"
            found.append((f"{100.0 * abs(low):.1f} %", text))
    # What is left of ten: further spectra, the largest first, displacements, shear, the ground.
    for one in spectra[1:]:
        text = f"floor spectrum of {one.words}, along {one.direction}, at {one.at:.3g} Hz"
        found.append((f"{one.peak:.3g} m/s²", text))
    start = "pounding.peak_displacement."
    for name in (name for name in run.values if name.startswith(start)):
        free = run.values.get(name.replace("displacement.", "displacement_no_contact."), math.nan)
        text = f"largest displacement of {name.removeprefix(start)}"
        if run.values.get("pounding.impacts"):
            text += f"; {1e2 * free:.3g} without contact"
        found.append((f"{1e2 * run.values[name]:.3g} cm", text))
    if (shear := run.values.get("pounding.storey_shear_max")) is not None:
        found.append((quantity(shear, "N", digits=4), "largest storey shear in impacts"))
    ground = {
        name.removeprefix("motion").removesuffix("pga").strip("."): value
        for name, value in run.values.items()
        if re.fullmatch(r"motion(\.[xyz])?\.pga", name)
    }
    if ground:
        largest = max(ground, key=lambda one: ground[one])
        text = f"peak ground acceleration{f', along {largest}' * bool(largest)}"
        found.append((quantity(ground[largest], "m/s²", digits=4), text))
    return found[:KEY_RESULTS]
