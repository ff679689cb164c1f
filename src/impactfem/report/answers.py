"""The answers of the first page."""

import math
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase

from impactfem.report.checks import count
from impactfem.report.devices import devices
from impactfem.report.facts import SMALL, quantity
from impactfem.report.governing import Spectrum
from impactfem.report.impacts import untouched
from impactfem.report.run_files import RunFiles
from impactfem.report.verdicts import verdict_summary
from impactfem.stages.check import HALVED
from impactfem.stages.device import selection as of_device
from impactfem.stages.stores import names_of
from impactfem.stages.verdict import pair_words

G = 9.80665
MAIN_FORCE = "pounding.main_impact_band_force"
COUNTS = 0.1
"""Least ratio of an ordinate to the governing one, for the largest ratio of the first page."""


@dataclass(frozen=True)
class Answer:
    """An answer of the first page."""

    question: str
    value: str  #: the answer in a number or a word
    text: str  #: what it is
    mark: str = ""  #: "good", "warn", or "" where there is no limit
    link: str = ""  #: id of the section with the details
    result: str = ""  #: name of the result in `summary.json`, which failed checks may concern


def answers(run: RunFiles, spectra: list[Spectrum]) -> list[Answer]:
    """Return the answers of the first page that the case has."""
    found = []
    if (verdict := verdict_summary(run.verdicts)) is not None:
        value, text = verdict
        mark = "warn" if any(one["passed"] is False for one in run.verdicts) else "good"
        found.append(Answer("Verdicts by given capacities", value, text, mark, "verdict"))
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
        found.append(Answer(name, value, text, "", "floors", one.result))
        found += [] if untouched(run) else _amplification(one)
    found += _gap(run) + _anchors(run)
    force = next((one for one in run.summary if one["name"] == MAIN_FORCE), None)
    if force is not None and force["value"] is not None:
        where = pair_words(force["note"].removeprefix("pair "))
        value = quantity(force["value"], force["unit"], digits=4)
        number = run.values.get("pounding.impacts", 0.0)
        text = f"force up to 100 Hz (low-pass filter), {where}; number of impacts: {number:.0f}"
        # The peak is for information: it depends on the contact law and on the time step.
        for name, words in (
            ("pounding.mean_force_5ms", "largest mean over 5 ms"),
            ("pounding.main_impact_force", "peak without a filter"),
        ):
            if (found_force := run.values.get(name)) is not None:
                text += f"; {words} {quantity(found_force, 'N', digits=3)}"
        text += _by_steps(run)
        found.append(Answer("Largest impact", value, text, "", "impacts", MAIN_FORCE))
    elif "pounding.required_separation" in run.values and untouched(run):
        text = "the buildings do not touch"
        found.append(Answer("Largest impact", "no impact", text, link="impacts"))
    found = [_doubted(run, answer) for answer in found]
    every = count(run.checks)
    text = f"{every.passed} passed, {every.information} for information"
    if every.invalid:
        text = f"do not use the results that the invalid checks name; {text}"
    mark = "warn" if every.failed else "good"
    found.append(Answer("Checks", every.words, text, mark, "checks"))
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
        return [Answer(question, "no ratio", text, "", "floors")]
    times, at = one.largest_ratio(COUNTS * one.peak)
    if math.isfinite(at):
        hit, quiet = (float(psa.sel(frequency=at)) for psa in (one.psa, one.free))
        text += f"; largest ratio at one frequency × {times:.3g} at {at:.3g} Hz"
        text += f" ({hit:.3g} and {quiet:.3g} m/s²)"
    text = f"ratio of the peaks, {text}"
    return [Answer(question, f"× {one.peak_ratio:.3g}", text, "", "floors", one.result)]


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
        members = run.values["ensemble.members"]
        text += (
            f"; 5th to 95th percentile of {members:.0f} motions: {1e3 * low:.3g} to "
            f"{1e3 * high:.3g} mm required"
        )
    value = f"{needed:.3g} mm required, {there:.3g} mm provided"
    mark = "good" if margin[k] >= 0.0 else "warn"
    return [Answer("Gap required to avoid contact", value, text, mark, "impacts")]


def _anchors(run: RunFiles) -> list[Answer]:
    """Return the net tension of the anchors, with the forces of the device with the largest."""
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
    unknown = len(pulled) - len(known_ones)
    if not known_ones:
        value, mark = "net tension unknown", ""
    elif up:
        share = f" at {up} of {len(pulled)}" if len(pulled) > 1 else ""
        value, mark = f"net tension{share}", "warn"
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
    return [Answer("Anchors", value, texts[key], mark, "equipment", f"device.{key[1]}")]


def _by_steps(run: RunFiles) -> str:
    """State how much a doubled time step changes the largest force, where that is much."""
    change = run.values.get("pounding.doubled_step_force_change", 0.0)
    text = f" (a doubled time step changes it by up to {100.0 * change:.2g} %)"
    return text if change > HALVED else ""
