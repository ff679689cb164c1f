"""The verdict of the device study in words: what pounding, rotations, damping, broadening do."""

from __future__ import annotations

from impactfem.results.device_inputs import WORDS, input_choices
from impactfem.results.device_view import BROADENED, ROTATIONS, WITH, WITHOUT, DeviceView
from impactfem.results.table import Table

Row = tuple[str, str, str, str]

ALL = "all"
LOADS = {WITHOUT: "without impact", WITH: "with impacts"}
SAME = 0.005
"""Differences are the same when they differ by less than this part of the detailed force."""


def verdict(view: DeviceView) -> Table:
    """The verdict as a table: a row for each device, damping and question."""
    rows: list[Row] = []
    for d, device in enumerate(view.devices):
        for c, case in enumerate(view.cases):
            rows.append((device, case, "does pounding lower the difference", pounding(view, d, c)))
            if view.variant(ROTATIONS):
                what = "what do rotations explain"
                rows.append((device, case, what, rotations(view, d, c)))
        if len(view.cases) > 1:
            rows.append((device, ALL, "what does damping do", _dampings(view, d)))
        rows += [
            (device, ALL, "does response spectrum analysis cover the detailed force", text)
            for text in _covered(view, d)
        ]
    return Table(
        "device_verdict",
        "Response spectrum analysis (RSA) against the detailed analysis in words; difference: from "
        "detailed, over it",
        (("device", ""), ("damping", ""), ("question", ""), ("finding", "")),
        tuple(rows),
    )


def pounding(view: DeviceView, device: int, case: int = 0) -> str:
    """Whether the difference of both analyses falls when impacts are considered."""
    without, with_impacts = (view.difference(device, k, case) for k in (WITHOUT, WITH))
    if without is None or with_impacts is None:
        return "nothing moves the device"
    if not view.impact_force[case] > 0.0:
        return f"there is no impact; {_amount(without)}"
    change = abs(with_impacts) - abs(without)
    if abs(change) < SAME:
        word = "no, the difference stays"
    else:
        word = "yes, the difference falls" if change < 0.0 else "no, the difference grows"
    return (
        f"{word}: {_amount(without)} without impact, {_amount(with_impacts)} with impacts, where "
        f"the force is {_ratio(view, device, case)} as large"
    )


def rotations(view: DeviceView, device: int, case: int = 0) -> str:
    """How much of the difference goes when the anchor's rotations are an input, too."""
    turned = view.variant(ROTATIONS)
    if turned is None:
        raise ValueError("the store has no analysis with rotations")
    return "; ".join(
        f"{load}: {_explained(view, device, case, impact, turned)}"
        for impact, load in LOADS.items()
    )


def _explained(view: DeviceView, device: int, case: int, impact: int, turned: str) -> str:
    detailed = view.detailed(device, impact, case)
    straight = view.by_spectrum(device, impact, case)
    both = view.by_spectrum(device, impact, case, turned)
    if not detailed > 0.0:
        return "nothing moves the device"
    after = 1.0 - both / detailed
    lacking, raised = detailed - straight, both / straight - 1.0 if straight > 0.0 else 0.0
    text = f"rotations raise RSA by {100.0 * raised:.3g} %"
    if lacking <= SAME * detailed:
        return f"{text}, which lacked nothing; {_amount(after)} with them"
    share = (both - straight) / lacking
    if share > 1.0:
        return f"{text}, by more than it lacks; {_amount(after)} with them"
    return f"{text}, {100.0 * share:.2g} % of what it lacks; {_amount(after)} with them"


def _dampings(view: DeviceView, device: int) -> str:
    parts = []
    for impact, load in LOADS.items():
        known = [
            (found, c)
            for c in range(len(view.cases))
            if (found := view.difference(device, impact, c)) is not None
        ]
        if not known:
            return "nothing moves the device"
        (low, _), (high, _) = min(known), max(known)
        farthest = max(known, key=lambda pair: abs(pair[0]))[1]
        forces = [view.detailed(device, impact, c) for c in range(len(view.cases))]
        parts.append(
            f"{load} the difference lies between {100.0 * low:.1f} and {100.0 * high:.1f} %, "
            f"farthest from zero with the damping {view.cases[farthest]}, and the detailed force "
            f"between {_kilonewton(min(forces))} and {_kilonewton(max(forces))}"
        )
    return "; ".join(parts)


def _covered(view: DeviceView, device: int) -> list[str]:
    variants: dict[str, str | None] = {
        "spectra as computed": view.headline,
        "broadened peaks": view.variant(BROADENED),
        "rotations": view.variant(ROTATIONS),
        "rotations and broadened peaks": view.variant(ROTATIONS, BROADENED),
    }
    variants |= input_choices(view, device)
    del variants[WORDS[""]]  # the spectra as computed, once more
    count = len(view.cases)
    found = []
    for label, choice in variants.items():
        if choice is None:
            continue
        parts = []
        for impact, load in LOADS.items():
            gaps = [view.difference(device, impact, c, choice) or 0.0 for c in range(count)]
            enough = sum(gap <= 0.0 for gap in gaps)
            worst = max(gaps)
            least = f", {100.0 * worst:.1f} % too low at most" if worst > 0.0 else ""
            parts.append(f"{load} in {enough} of {count} dampings{least}")
        found.append(f"with {label}: {'; '.join(parts)}")
    return found


def _amount(difference: float) -> str:
    if abs(difference) < 0.0005:
        return "RSA agrees within 0.05 %"
    return f"RSA is {100.0 * abs(difference):.1f} % too {'low' if difference > 0.0 else 'high'}"


def _ratio(view: DeviceView, device: int, case: int) -> str:
    return f"{view.detailed(device, WITH, case) / view.detailed(device, WITHOUT, case):.3g} times"


def _kilonewton(force: float) -> str:
    return f"{1e-3 * force:.3g} kN"
