"""The first screen of the page: what a decision needs, whatever the case has."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import xarray as xr

from impactfem.plot.curves import Curve, CurveFigure, Panel
from impactfem.plot.figure import figure
from impactfem.plot.style import BLUE, GREEN, ORANGE, RED
from impactfem.report.governing import (
    MODEL,
    PLACES,
    STICK,
    Spectrum,
    governing,
)
from impactfem.report.overview import (
    SMALL,
    Facts,
    anchor_forces,
    forces_table,
    in_3d,
    quantity,
    wall_is_used,
)
from impactfem.report.run_files import SPECTRA, RunFiles
from impactfem.report.verdicts import given, verdict_summary
from impactfem.stages.check import HALVED
from impactfem.stages.device import selection as of_device
from impactfem.stages.stores import names_of
from impactfem.stages.transient.selection import known
from impactfem.stages.verdict import pair_words

G = 9.80665
MAIN_FORCE = "pounding.main_impact_band_force"
KEY_RESULTS = 10
"""Number of results at the end of a run."""
PURPLE = "#7a4fa3"
NEAR = 5e-4
"""Differences below it are 0.0 % in print."""
COUNTS = 0.1
"""Least ratio of an ordinate to the governing one, for the largest ratio of the first screen."""


@dataclass(frozen=True)
class Answer:
    """An answer of the first screen."""

    question: str
    value: str  #: the answer in a number or a word
    text: str  #: what it is
    mark: str = ""  #: "good", "warn", or "" where there is no limit
    link: str = ""  #: id of the section with the details
    result: str = ""  #: name of the result in `summary.json`, which failed checks may concern


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
    if (verdict := verdict_summary(run.verdicts)) is not None:
        value, text = verdict
        mark = "warn" if any(one["passed"] is False for one in given(run.verdicts)) else "good"
        found.append(Answer("Verdicts", value, text, mark, "verdicts"))
    if spectra:
        one = spectra[0]
        value = f"{one.peak:.3g} m/s² at {one.at:.3g} Hz"
        text = (
            f"{one.words}, direction {one.direction}, {100.0 * one.damping:.3g} % damping; "
            f"{one.peak / G:.3g} g; ZPA {one.zpa:.3g} m/s². Resolved band: up to {one.end:.4g} Hz"
        )
        text += f", limited by: {one.cause}" if one.cause else ""
        if math.isfinite(one.structural_damping):
            text += f"; damping ratio of the building at {one.at:.3g} Hz: "
            text += f"{100.0 * one.structural_damping:.3g} %"
        if one.at >= one.end:
            text += "; the peak is at the end of this band, and may be larger above it"
        name = "Governing floor response spectrum"
        found.append(Answer(name, value, text, "", "spectra", one.result))
        found += [] if untouched(run) else _amplification(one)
    found += _gap(run) + _anchors(run)
    force = next((one for one in run.summary if one["name"] == MAIN_FORCE), None)
    if force is not None and force["value"] is not None:
        where = pair_words(force["note"].removeprefix("pair "))
        value = quantity(force["value"], force["unit"], digits=4)
        count = run.values.get("pounding.impacts", 0.0)
        text = f"force up to 100 Hz (low-pass filter), {where}; number of impacts: {count:.0f}"
        # The peak is for information: it depends on the contact law and on the time step.
        for name, words in (
            ("pounding.mean_force_5ms", "largest mean over 5 ms"),
            ("pounding.main_impact_force", "peak without a filter"),
        ):
            if (found_force := run.values.get(name)) is not None:
                text += f"; {words} {quantity(found_force, 'N', digits=3)}"
        text += _by_steps(run)
        found.append(Answer("Largest impact", value, text, "", "stage_pounding", MAIN_FORCE))
    elif "pounding.required_separation" in run.values and untouched(run):
        text = "the buildings do not touch"
        found.append(Answer("Largest impact", "no impact", text, link="stage_pounding"))
    found = [_doubted(run, answer) for answer in found]
    passed = [check["passed"] for check in run.checks]
    limits, missed = len(passed) - passed.count(None), passed.count(False)
    value = f"{missed} of {limits} failed" if missed else f"all {limits} passed"
    text = "read the failed checks below before using the results" if missed else ""
    found.append(Answer("Checks", value, text, "warn" if missed else "good", "checks"))
    return found


def _doubted(run: RunFiles, answer: Answer) -> Answer:
    """Mark an answer whose number failed checks make doubtful, with their quantities."""
    failed = [
        check["quantity"]
        for check in run.checks
        if check["passed"] is False
        and any(fnmatchcase(answer.result, pattern) for pattern in check.get("concerns", ()))
    ]
    if not failed:
        return answer
    text = f"{answer.text}; doubtful, failed checks: {', '.join(dict.fromkeys(failed))}"
    return replace(answer, text=text, mark="warn")


def _amplification(one: Spectrum) -> list[Answer]:
    """Return the ratio of the peaks with / without impact of the governing spectrum.

    The largest ratio of ordinates comes second. A ratio appears only where the value without impact
    is not small.
    """
    if one.free is None:
        return []
    where = f"{one.words}, direction {one.direction}, {100.0 * one.damping:.3g} % damping"
    text = f"{one.peak:.3g} m/s² with and {one.free_peak:.3g} m/s² without impact: {where}"
    question = "Amplification due to pounding"
    if not math.isfinite(one.peak_ratio):
        text += f"; the peak without impact is below {100.0 * SMALL:g} % of its ZPA"
        return [Answer(question, "no ratio", text, "", "spectra")]
    times, at = one.largest_ratio(COUNTS * one.peak)
    if math.isfinite(at):
        hit, quiet = (float(psa.sel(frequency=at)) for psa in (one.psa, one.free))
        text += f"; largest ratio at one frequency × {times:.3g} at {at:.3g} Hz"
        text += f" ({hit:.3g} and {quiet:.3g} m/s²)"
    text = f"ratio of the peaks, {text}"
    return [Answer(question, f"× {one.peak_ratio:.3g}", text, "", "spectra", one.result)]


def _gap(run: RunFiles) -> list[Answer]:
    if not run.ran("pounding"):
        return []
    with run.store("pounding.nc") as store:
        pairs = names_of(store, "pair")
        if not pairs:
            return [Answer("Gap", "no contact pairs", "the case defines no contact pairs")]
        margin = store["pair_margin"].values
        k = int(margin.argmin())
        there, needed = (
            1e3 * float(store[name][k]) for name in ("pair_rest_gap", "pair_required_separation")
        )
        most = 1e3 * float(store["pair_required_separation"].max())
    text = f"between {pair_words(pairs[k])}"
    band = [run.values.get(f"ensemble.p{q}.pounding.required_separation") for q in ("05", "95")]
    if needed < most:
        text += f"; other pairs, with larger gaps, require up to {most:.3g} mm"
    elif (low := band[0]) is not None and (high := band[1]) is not None:
        count = run.values["ensemble.members"]
        text += (
            f"; 5th to 95th percentile of {count:.0f} motions: {1e3 * low:.3g} to "
            f"{1e3 * high:.3g} mm required"
        )
    value = f"{needed:.3g} mm required, {there:.3g} mm provided"
    mark = "good" if margin[k] >= 0.0 else "warn"
    return [Answer("Gap required to avoid contact", value, text, mark, "stage_pounding")]


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
        least = SMALL * float(quiet.components()[:3].max())
        times = f" (× {hit.detailed / quiet.detailed:.3g})" if quiet.detailed > least else ""
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
        value, mark = "net tension unknown", ""
    elif up:
        count = f" at {up} of {len(pulled)}" if len(pulled) > 1 else ""
        value, mark = f"net tension{count}", "warn"
        texts[key] += (
            f"; tension in the most highly loaded anchor {1e-3 * pulled[key]:.3g} kN / n for n "
            "equally spaced anchors"
        )
    else:
        value, mark = "no net tension", "" if unknown else "good"
    if known_ones and unknown:
        more, (_, name) = max((bare[one], one) for one in pulled if one not in known_ones)
        texts[key] += (
            f"; unknown for {unknown} of {len(pulled)} devices whose weight is not given: without "
            f"weight up to {1e-3 * more:.3g} kN / n, at {name}"
        )
    return [Answer("Anchors", value, texts[key], mark, link, f"device.{key[1]}")]


def _by_steps(run: RunFiles) -> str:
    """State how much a doubled time step changes the largest force, where that is much."""
    change = run.values.get("pounding.doubled_step_force_change", 0.0)
    text = f" (a doubled time step changes it by up to {100.0 * change:.2g} %)"
    return text if change > HALVED else ""


def at_wall(run: RunFiles) -> float | None:
    """The restitution of the building that hits the rigid wall; None without one."""
    found = (one.values.get("calibration.epsilon") for one in run.models.values())
    return next((value for value in found if value is not None), None)


@figure(SPECTRA, "Summary", "Governing floor response spectra")
def spectra_figure(run: RunFiles, spectra: list[Spectrum]) -> Path | None:
    """Draw the governing spectra of a building, and of an anchor or of a second building."""
    anchors = [one for one in spectra if one.at_anchor]
    buildings = dict.fromkeys(one.building for one in spectra if not one.at_anchor)
    panels = [_building_panel(run, spectra, name) for name in [*buildings][: 1 if anchors else 2]]
    for one in anchors[:1]:
        whole = one.psa if one.whole is None else one.whole
        curves = [_curve(whole, "with impacts", GREEN, "-")]
        if one.free is not None:
            curves.append(_curve(one.free, "without impact", GREEN, "--"))
        title = f"Anchor of {one.model}, {one.building}, direction {one.direction}"
        if math.isfinite(one.damping):
            title += f", {100.0 * one.damping:.3g} % damping"
        panels.append(_panel(curves, title, one.end))
    if not panels:
        return None
    caption = (
        "Governing floor response spectra with impact (solid) and without impact (dashed). "
        + ("Hatched: above the resolved band. " if any(p.hatched for p in panels) else "")
        + " ".join(f"({'ab'[k]}) {panel.title}." for k, panel in enumerate(panels))
    )
    size = (5.5 * len(panels), 3.3)
    path = run.folder / "figures" / f"{SPECTRA}.svg"
    CurveFigure(caption, panels, len(panels), size).write(path)
    return path


def _building_panel(run: RunFiles, spectra: list[Spectrum], building: str) -> Panel:
    """Return the spectra of the governing floor of a building along the governing direction."""
    # If a point on no floor governs: the point, and the governing floor of the stick.
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
        whole = first.psa if first.whole is None else first.whole
        curves.append(_curve(whole, f"3D model, {first.place}", PURPLE, "-"))
        if first.free is not None:
            curves.append(_curve(first.free, f"3D model, {first.place}, without", PURPLE, "--"))
    title = f"{building}, floor {floor}, " if floor else f"{building}, "
    title = f"{title}direction {first.direction}, {100.0 * first.damping:.3g} % damping"
    return _panel(curves, title, first.end)


def _curve(spectrum: xr.DataArray, label: str, colour: str, dash: str) -> Curve:
    return Curve(spectrum["frequency"].values, spectrum.values, label, colour, dash, width=1.3)


def _panel(curves: list[Curve], title: str, resolved_end: float) -> Panel:
    """Return a panel of spectra that is hatched above the resolved band."""
    axes: dict[str, Any] = {"log": "x", "bottom": 0.0, "legend": "best"}
    last = max(float(curve.x[-1]) for curve in curves)
    if last > resolved_end:
        axes["hatched"] = (resolved_end, last)
    return Panel("frequency [Hz]", "pseudo-acceleration [m/s²]", curves, title, **axes)


def _differences(run: RunFiles) -> list[tuple[str, str]]:
    """Return how far response spectrum analysis is off for the first device, by load."""
    found = []
    for store, device in devices(run):
        for impact, words in of_device.LOADS.items():
            load = of_device.Load(store, device, impact)
            off, moment = load.difference(), load.moment()
            if off is None or (impact == of_device.WITH and untouched(run)):
                continue
            side = "" if abs(off) < NEAR else ", unconservative" if off > 0.0 else ", conservative"
            text = f"difference of response spectrum analysis{side}:"
            text += f" F{of_device.direction(store)} of {device}, {words}"
            if moment is not None and moment[1] > NEAR:
                text += f"; {moment[0]} unconservative by {100.0 * moment[1]:.1f} %"
            found.append((f"{100.0 * abs(off):.1f} %", text))
        break
    return found


def key_results(run: RunFiles) -> list[tuple[str, str]]:
    """Return up to ten results of a run with their descriptions: the first screen, and more."""
    spectra = governing(run)
    every = answers(run, spectra)[:-1]  # the console has counted the checks already
    found = [(one.value, f"{one.question.lower()}: {one.text}") for one in every]
    if (epsilon := at_wall(run)) is not None:
        used = "" if wall_is_used(run.case) else ": not used, the case file gives the contact law"
        used = used if run.case["contact_laws"] else ": not used, the case has no contact law"
        found.append((f"{epsilon:.3g}", f"restitution of the 3D model at a rigid wall{used}"))
    found += _differences(run)
    # Then further spectra, the largest first, displacements, storey shear and ground acceleration.
    for one in spectra[1:]:
        text = f"floor spectrum of {one.words}, direction {one.direction}, at {one.at:.3g} Hz"
        found.append((f"{one.peak:.3g} m/s²", text))
    start = "pounding.peak_displacement."
    for name in (name for name in run.values if name.startswith(start)):
        free = run.values.get(name.replace("displacement.", "displacement_no_contact."), math.nan)
        text = f"largest displacement of {name.removeprefix(start)}"
        if run.values.get("pounding.impacts"):
            text += f"; {1e2 * free:.3g} cm without contact"
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
        text = f"peak ground acceleration{f', direction {largest}' * bool(largest)}"
        found.append((quantity(ground[largest], "m/s²", digits=4), text))
    return found[:KEY_RESULTS]
