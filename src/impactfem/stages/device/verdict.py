"""The device study in words: what pounding and damping do, what RSA lacks, what anchors bear."""

import math

import xarray as xr

from impactfem.case.damping import OWN
from impactfem.plot.table import Table, heads
from impactfem.stages.device.selection import (
    BROADENED,
    INPUTS,
    LOADS,
    RIGID,
    RIGID_WORDS,
    ROTATIONS,
    Load,
    direction,
    headline,
    input_variants,
    modes_of,
    rigid_variants,
    shown_modes,
    variant,
)
from impactfem.stages.stores import names_of

ALL = "all"
SAME = 0.005
"""Differences are the same when they differ by less than this part of the detailed force."""
UNCHANGED = 1e-6
"""What changes the force by less than this part of the detailed one changes nothing."""
MOST = 0.5
"""What removes more than this part of what RSA lacks explains it."""
STIFF = 0.1
"""A mode follows the floor whose pseudo-acceleration is within this part of the ZPA."""
TURNED = "rotations of the floor"
SQUARED = "what of the modes follows the floor in step and is combined as if it did not"
STILL = "nothing moves the device"


def verdict(store: xr.Dataset) -> Table:
    """The verdict as a table: a row for each device, damping and question."""
    rows: list[tuple[str, str, str, str]] = []
    for device in names_of(store, "device"):
        for case in names_of(store, "case"):
            answers = [("does pounding lower the error of RSA", pounding(store, device, case))]
            if variant(store, ROTATIONS):
                answers.append(("what do rotations explain", _rotations(store, device, case)))
            answers += [
                ("what is the shortfall made of", text) for text in shortfall(store, device, case)
            ]
            if (text := anchors(store, device, case)) is not None:
                answers.append(("is there net tension at the anchor", text))
            rows += [(device, case, *answer) for answer in answers]
        if store.sizes["case"] > 1:
            rows.append((device, ALL, "what does damping do", _dampings(store, device)))
        rows += [
            (device, ALL, "does response spectrum analysis cover the detailed force", text)
            for text in _covered(store, device)
        ]
    return Table(
        "device_verdict",
        "Response spectrum analysis (RSA) against the detailed analysis in words; difference = "
        "(detailed - RSA)/detailed",
        heads("device; damping; question; finding"),
        tuple(rows),
    )


def pounding(store: xr.Dataset, device: str, case: str = OWN) -> str:
    """The error of RSA without impact and with impacts, and which is the smaller one."""
    quiet, pounded = (Load(store, device, impact, case) for impact in LOADS)
    without, with_impacts = quiet.difference(), pounded.difference()
    if without is None or with_impacts is None:
        return STILL
    axis = direction(store)
    if not store["impact_force"].sel(case=case) > 0.0:
        return f"there is no impact; {_amount(axis, without)}"
    errors = [round(-100.0 * one, 1) + 0.0 for one in (without, with_impacts)]  # no -0.0
    change = abs(with_impacts) - abs(without)
    word = "smaller" if change < 0.0 else "larger"
    return (
        f"RSA error of F{axis}: {errors[0]:+.1f} % without impact, {errors[1]:+.1f} % with impacts "
        "(force x "
        f"{pounded.detailed / quiet.detailed:.3g}): "
        f"{'the same' if abs(change) < SAME else word} with impacts"
    )


def shortfall(store: xr.Dataset, device: str, case: str = OWN) -> list[str]:
    """What removes how much of what RSA lacks: a line without and one with impacts.

    The rigid part of the modes and the rotations of the floor, each alone; and whether the modes
    follow the floor, so that their forces add with their signs and not by their squares.
    """
    lines, axis = [], direction(store)
    for impact, words in LOADS.items():
        load = Load(store, device, impact, case)
        detailed, own = load.detailed, load.by_spectrum()
        if not detailed > 0.0:
            continue
        lacking = detailed - own
        if lacking <= SAME * detailed:
            text = f"{words}: {_amount(axis, 1.0 - own / detailed)}, nothing is lacking there"
            moment = load.moment()
            if moment is not None and moment[1] > SAME:
                text += f"; RSA underestimates {moment[0]} by {100.0 * moment[1]:.1f} %"
            lines.append(text)
            continue
        further = {
            f"rigid part of the modes ({RIGID[method]})": choice
            for method, choice in rigid_variants(store).items()
            if method in RIGID and load.was_done(choice)
        }
        if (turned := variant(store, ROTATIONS)) is not None:
            further[TURNED] = turned
        shares = {what: (load.by_spectrum(name) - own) / lacking for what, name in further.items()}
        parts = [f"{words}: {_amount(axis, lacking / detailed)}"]
        if shares:
            # Two digits below ten per cent, whole numbers above.
            percent = (
                f"{what} {100.0 * share:{'.2g' if abs(share) < 0.1 else '.0f'}} %"
                for what, share in shares.items()
            )
            parts.append(f"of that {', '.join(percent)}")
        said, summed = _following(load)
        parts += said
        most = max(shares, key=lambda what: shares[what], default="")
        if most and shares[most] > MOST:
            parts.append(f"so most of it comes from {TURNED if most == TURNED else SQUARED}")
        elif abs(detailed - summed) < (1.0 - MOST) * lacking:
            parts.append(f"so most of it comes from {SQUARED}")
        elif most:
            left = min(1.0, 1.0 - shares[most]) * lacking / detailed
            parts.append(f"none of these explains it: {100.0 * left:.1f} % of the force is left")
        lines.append("; ".join(parts))
    return lines


def _following(load: Load) -> tuple[list[str], float]:
    """Pseudo-accelerations of the modes, the ZPA, and the sum of their forces with signs [N].

    In words, and the sum of modes that follow the floor; 0 of others.
    """
    # Modes follow the floor that are all above the peak of its spectrum, and at its ZPA. With their
    # signs the forces by the spectrum along the shown direction are M_i S_i, the missing mass left
    # out.
    axis = direction(load.store)
    zpa = float(abs(load.of("anchor_acceleration", component=axis)).max())
    modes = shown_modes(load.store, load.device)
    if modes.sizes["mode"] < 2 or not zpa > 0.0:
        return [], 0.0
    along = load.ordinates.sel(component=axis, mode=modes["mode"]) / zpa
    found = list(zip(modes["mode_frequency"].values, along.values, strict=True))
    ratios = ", ".join(f"{ratio:.2f} at {f:.3g} Hz" for f, ratio in found)
    text = f"pseudo-acceleration of the modes over the floor's ZPA: {ratios}"
    peak = float(load.psa.idxmax("frequency"))
    if not all(f > peak and abs(ratio - 1.0) <= STIFF for f, ratio in found):
        return [f"{text}: not all of them follow the floor"], 0.0
    forces = load.ordinates * modes_of(load.store, load.device)["effective_mass"]
    summed = float(forces.sel(component=axis).sum())
    off = 100.0 * (summed / load.detailed - 1.0)
    text += ": they follow the floor, and their forces added with signs are "
    return [f"{text}{1e-3 * summed:.4g} kN, {off:+.1f} % from the detailed one"], summed


def anchors(store: xr.Dataset, device: str, case: str = OWN) -> str | None:
    """Whether the anchors are pulled, and how much; None where the weight is not known."""
    loads = {words: Load(store, device, impact, case) for impact, words in LOADS.items()}
    known = {words: one for words, one in loads.items() if math.isfinite(one.weight)}
    if not known:
        return None
    parts = []
    for words, one in known.items():
        lifted = (
            f"all of the base lifted by {_kilonewton(one.uplift())}"
            if one.uplift() > 0.0
            else f"{_kilonewton(-one.uplift())} of the weight left"
        )
        pulled = "none"
        if one.tension() > 0.0:
            pulled = f"{_kilonewton(one.tension())}/n in the most loaded one"
        parts.append(f"{words} {pulled}, {lifted}")
    weight = next(iter(known.values())).weight
    return (
        f"{'yes' if any(one.tension() > 0.0 for one in known.values()) else 'no'}: "
        f"{'; '.join(parts)} (weight {_kilonewton(weight)}, n anchors evenly on a circle of radius "
        f"{float(store['anchor_radius'].sel(device=device)):g} m)"
    )


def _rotations(store: xr.Dataset, device: str, case: str) -> str:
    """How much of the difference goes when the anchor's rotations are an input, too."""
    parts = []
    for impact, words in LOADS.items():
        load = Load(store, device, impact, case)
        detailed, straight = load.detailed, load.by_spectrum()
        both = load.by_spectrum(variant(store, ROTATIONS))
        if not detailed > 0.0:
            parts.append(f"{words}: {STILL}")
            continue
        raised = both / straight - 1.0 if straight > 0.0 else 0.0
        axis, now = direction(store), 1.0 - straight / detailed
        if abs(both - straight) < UNCHANGED * detailed:
            parts.append(f"{words}: {_amount(axis, now)}; floor rotations change nothing")
            continue
        if (lacking := detailed - straight) <= SAME * detailed:
            share = "raise it"
        elif both - straight > lacking:
            share = "explain more than that"
        else:
            share = f"explain {100.0 * (both - straight) / lacking:.2g} % of that"
        parts.append(
            f"{words}: {_amount(axis, now)}; floor rotations {share} (RSA {100.0 * raised:+.3g} %);"
            f" {_amount(axis, 1.0 - both / detailed)} with them"
        )
    return "; ".join(parts)


def _dampings(store: xr.Dataset, device: str) -> str:
    parts = []
    for impact, words in LOADS.items():
        loads = {case: Load(store, device, impact, case) for case in names_of(store, "case")}
        gaps = {case: gap for case, one in loads.items() if (gap := one.difference()) is not None}
        if not gaps:
            return STILL
        forces = [one.detailed for one in loads.values()]
        parts.append(
            f"{words} the difference lies between {100.0 * min(gaps.values()):.1f} and "
            f"{100.0 * max(gaps.values()):.1f} %, farthest from zero with the damping "
            f"{max(gaps, key=lambda case: abs(gaps[case]))}, and the detailed force between "
            f"{_kilonewton(min(forces))} and {_kilonewton(max(forces))}"
        )
    return "; ".join(parts)


def _covered(store: xr.Dataset, device: str) -> list[str]:
    variants = {
        "spectra as computed": headline(store),
        "broadened peaks": variant(store, BROADENED),
        "rotations": variant(store, ROTATIONS),
        "rotations and broadened peaks": variant(store, ROTATIONS, BROADENED),
    }
    variants |= {RIGID_WORDS[method]: name for method, name in rigid_variants(store).items()}
    variants |= input_variants(store, device)
    del variants[INPUTS[""]]  # the spectra as computed, once more
    cases, found = names_of(store, "case"), []
    for label, choice in variants.items():
        if choice is None:
            continue
        parts = []
        for impact, words in LOADS.items():
            loads = [Load(store, device, impact, case) for case in cases]
            gaps = [one.difference(choice) or 0.0 for one in loads if one.was_done(choice)]
            if not gaps:
                parts.append(f"{words} not done")
                continue
            worst = max(gaps)
            least = f", {100.0 * worst:.1f} % underestimated at most" if worst > 0.0 else ""
            left = f", not done in {len(cases) - len(gaps)}" if len(gaps) < len(cases) else ""
            enough = sum(gap <= 0.0 for gap in gaps)
            parts.append(f"{words} in {enough} of {len(cases)} dampings{least}{left}")
        found.append(f"with {label}: {'; '.join(parts)}")
    return found


def _amount(axis: str, difference: float) -> str:
    if abs(difference) < 0.0005:
        return f"RSA agrees in F{axis} within 0.05 %"
    under = "under" if difference > 0.0 else "over"
    return f"RSA {under}estimates F{axis} by {100.0 * abs(difference):.1f} %"


def _kilonewton(force: float) -> str:
    return f"{1e-3 * force:.3g} kN"
