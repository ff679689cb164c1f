"""The device study in words: what pounding and damping do, what RSA lacks, what anchors bear."""

from __future__ import annotations

import xarray as xr

from impactfem.case.damping import OWN
from impactfem.plot.table import Table
from impactfem.stages.device.input_figures import WORDS, input_choices
from impactfem.stages.device.selection import (
    BROADENED,
    RIGID,
    ROTATIONS,
    WITH,
    WITHOUT,
    Pull,
    detailed_force,
    followed,
    force_by_spectrum,
    headline,
    pull_of,
    relative_difference,
    rigid_variants,
    stiff,
    variant,
    was_done,
    with_signs,
)
from impactfem.stages.stores import names_of

Row = tuple[str, str, str, str]

ALL = "all"
LOADS = {WITHOUT: "without impact", WITH: "with impacts"}
SAME = 0.005
"""Differences are the same when they differ by less than this part of the detailed force."""
MOST = 0.5
"""What removes more than this part of what RSA lacks explains it."""
TURNED = "rotations of the floor"
SQUARED = "what of the modes follows the floor in step and is combined as if it did not"


def verdict(store: xr.Dataset) -> Table:
    """The verdict as a table: a row for each device, damping and question."""
    rows: list[Row] = []
    for device in names_of(store, "device"):
        for case in names_of(store, "case"):
            what = "does pounding lower the difference"
            rows.append((device, case, what, pounding(store, device, case)))
            if variant(store, ROTATIONS):
                what = "what do rotations explain"
                rows.append((device, case, what, rotations(store, device, case)))
            what = "what is the shortfall made of"
            rows += [(device, case, what, text) for text in shortfall(store, device, case)]
            if (text := anchors(store, device, case)) is not None:
                rows.append((device, case, "is there net tension at the anchor", text))
        if store.sizes["case"] > 1:
            rows.append((device, ALL, "what does damping do", _dampings(store, device)))
        rows += [
            (device, ALL, "does response spectrum analysis cover the detailed force", text)
            for text in _covered(store, device)
        ]
    return Table(
        "device_verdict",
        "Response spectrum analysis (RSA) against the detailed analysis in words; difference: from "
        "detailed, over it",
        (("device", ""), ("damping", ""), ("question", ""), ("finding", "")),
        tuple(rows),
    )


def pounding(store: xr.Dataset, device: str, case: str = OWN) -> str:
    """Whether the difference of both analyses falls when impacts are considered."""
    without, with_impacts = (relative_difference(store, device, k, case) for k in (WITHOUT, WITH))
    if without is None or with_impacts is None:
        return "nothing moves the device"
    if not store["impact_force"].sel(case=case) > 0.0:
        return f"there is no impact; {_amount(without)}"
    change = abs(with_impacts) - abs(without)
    if abs(change) < SAME:
        word = "no, the difference stays"
    else:
        word = "yes, the difference falls" if change < 0.0 else "no, the difference grows"
    return (
        f"{word}: {_amount(without)} without impact, {_amount(with_impacts)} with impacts, where "
        f"the force is {_ratio(store, device, case)} as large"
    )


def shortfall(store: xr.Dataset, device: str, case: str = OWN) -> list[str]:
    """What removes how much of what RSA lacks: a line without and one with impacts.

    The rigid part of the modes and the rotations of the floor, each alone; and whether the modes
    follow the floor, so that their forces add with their signs and not by their squares.
    """
    return [
        f"{load}: {_made_of(store, device, case, impact)}"
        for impact, load in LOADS.items()
        if detailed_force(store, device, impact, case) > 0.0
    ]


def _made_of(store: xr.Dataset, device: str, case: str, impact: str) -> str:
    detailed = detailed_force(store, device, impact, case)
    own = force_by_spectrum(store, device, impact, case)
    lacking = detailed - own
    if lacking <= SAME * detailed:
        return f"{_amount(1.0 - own / detailed)}, nothing is lacking"
    shares: dict[str, float] = {}
    for method, choice in rigid_variants(store).items():
        if method in RIGID and was_done(store, device, impact, case, choice):
            force = force_by_spectrum(store, device, impact, case, choice)
            shares[f"rigid part of the modes ({RIGID[method]})"] = (force - own) / lacking
    turned = variant(store, ROTATIONS)
    if turned is not None:
        force = force_by_spectrum(store, device, impact, case, turned)
        shares[TURNED] = (force - own) / lacking
    parts = [_amount(lacking / detailed)]
    if shares:
        found = ", ".join(f"{what} {_percent(share)}" for what, share in shares.items())
        parts.append(f"of that {found}")
    parts += _following(store, device, case, impact)
    most = max(shares, key=lambda what: shares[what], default=None)
    if most is None:
        return "; ".join(parts)
    if shares[most] > MOST:
        parts.append(f"so most of it comes from {TURNED if most == TURNED else SQUARED}")
    else:
        left = min(1.0, 1.0 - shares[most]) * lacking / detailed
        parts.append(f"none of these explains it: {100.0 * left:.1f} % of the force is left")
    return "; ".join(parts)


def rigid_words(method: str) -> str:
    """An analysis by the method of the rigid part of its modes."""
    return f"rigid part by {RIGID[method]}" if method in RIGID else "no rigid part"


def _percent(share: float) -> str:
    """Two digits below ten per cent, whole numbers above."""
    return f"{100.0 * share:.2g} %" if abs(share) < 0.1 else f"{100.0 * share:.0f} %"


def _following(store: xr.Dataset, device: str, case: str, impact: str) -> list[str]:
    """Pseudo-accelerations of the modes beside the ZPA, and the sum of their forces with signs."""
    found, summed = followed(store, device, impact, case), with_signs(store, device, impact, case)
    if found is None or len(found) < 2:
        return []
    ratios = ", ".join(f"{ratio:.2f} at {f:.3g} Hz" for f, ratio in found)
    text = f"pseudo-acceleration of the modes over the floor's ZPA: {ratios}"
    if not stiff(store, device, impact, case):
        return [f"{text}: not all of them follow the floor"]
    off = 100.0 * (summed / detailed_force(store, device, impact, case) - 1.0)
    return [
        f"{text}: they follow the floor, and their forces added with signs are "
        f"{1e-3 * summed:.4g} kN, {off:+.1f} % from the detailed one"
    ]


def anchors(store: xr.Dataset, device: str, case: str = OWN) -> str | None:
    """Whether the anchors are pulled, and how much; None where the weight is not known."""
    pulls = {load: pull_of(store, device, impact, case) for impact, load in LOADS.items()}
    known = {load: pull for load, pull in pulls.items() if pull is not None}
    if not known:
        return None
    first = next(iter(known.values()))
    parts = "; ".join(f"{load} {_pulled(pull)}" for load, pull in known.items())
    return (
        f"{'yes' if any(pull.tension > 0.0 for pull in known.values()) else 'no'}: {parts} (weight "
        f"{_kilonewton(first.weight)}, n anchors evenly on a circle of {first.radius:g} m)"
    )


def _pulled(pull: Pull) -> str:
    lifted = (
        f"all of the base lifted by {_kilonewton(pull.uplift)}"
        if pull.uplift > 0.0
        else f"{_kilonewton(-pull.uplift)} of the weight left"
    )
    if pull.tension <= 0.0:
        return f"none, {lifted}"
    return f"{_kilonewton(pull.tension)}/n in the most loaded one, {lifted}"


def rotations(store: xr.Dataset, device: str, case: str = OWN) -> str:
    """How much of the difference goes when the anchor's rotations are an input, too."""
    turned = variant(store, ROTATIONS)
    if turned is None:
        raise ValueError("the store has no analysis with rotations")
    return "; ".join(
        f"{load}: {_explained(store, device, case, impact, turned)}"
        for impact, load in LOADS.items()
    )


def _explained(store: xr.Dataset, device: str, case: str, impact: str, turned: str) -> str:
    detailed = detailed_force(store, device, impact, case)
    straight = force_by_spectrum(store, device, impact, case)
    both = force_by_spectrum(store, device, impact, case, turned)
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


def _dampings(store: xr.Dataset, device: str) -> str:
    parts, cases = [], names_of(store, "case")
    for impact, load in LOADS.items():
        known = [
            (found, case)
            for case in cases
            if (found := relative_difference(store, device, impact, case)) is not None
        ]
        if not known:
            return "nothing moves the device"
        (low, _), (high, _) = min(known), max(known)
        farthest = max(known, key=lambda pair: abs(pair[0]))[1]
        forces = [detailed_force(store, device, impact, case) for case in cases]
        parts.append(
            f"{load} the difference lies between {100.0 * low:.1f} and {100.0 * high:.1f} %, "
            f"farthest from zero with the damping {farthest}, and the detailed force between "
            f"{_kilonewton(min(forces))} and {_kilonewton(max(forces))}"
        )
    return "; ".join(parts)


def _covered(store: xr.Dataset, device: str) -> list[str]:
    variants: dict[str, str | None] = {
        "spectra as computed": headline(store),
        "broadened peaks": variant(store, BROADENED),
        "rotations": variant(store, ROTATIONS),
        "rotations and broadened peaks": variant(store, ROTATIONS, BROADENED),
    }
    variants |= {rigid_words(method): name for method, name in rigid_variants(store).items()}
    variants |= input_choices(store, device)
    del variants[WORDS[""]]  # the spectra as computed, once more
    cases, found = names_of(store, "case"), []
    for label, choice in variants.items():
        if choice is None:
            continue
        parts = []
        for impact, load in LOADS.items():
            done = [case for case in cases if was_done(store, device, impact, case, choice)]
            if not done:
                parts.append(f"{load} not done")
                continue
            gaps = [relative_difference(store, device, impact, one, choice) or 0.0 for one in done]
            enough = sum(gap <= 0.0 for gap in gaps)
            worst = max(gaps)
            least = f", {100.0 * worst:.1f} % too low at most" if worst > 0.0 else ""
            left = f", not done in {len(cases) - len(done)}" if len(done) < len(cases) else ""
            parts.append(f"{load} in {enough} of {len(cases)} dampings{least}{left}")
        found.append(f"with {label}: {'; '.join(parts)}")
    return found


def _amount(difference: float) -> str:
    if abs(difference) < 0.0005:
        return "RSA agrees within 0.05 %"
    return f"RSA is {100.0 * abs(difference):.1f} % too {'low' if difference > 0.0 else 'high'}"


def _ratio(store: xr.Dataset, device: str, case: str) -> str:
    both = (detailed_force(store, device, impact, case) for impact in (WITH, WITHOUT))
    with_impacts, without = both
    return f"{with_impacts / without:.3g} times"


def _kilonewton(force: float) -> str:
    return f"{1e-3 * force:.3g} kN"
