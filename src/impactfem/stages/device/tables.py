"""Tables of the stage `device`: the paper's values (tables 6 to 9) beside ours, and the verdict."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from impactfem.plot.table import Cell, Table
from impactfem.stages.device.verdict import verdict
from impactfem.stages.device.view import ROTATIONS, WITH, WITHOUT, XYZ, DeviceView
from impactfem.stages.stores import open_store
from impactfem.system.log import LOGGER

Published = Mapping[str, float]
Columns = tuple[tuple[str, str], ...]

LOADS = {WITHOUT: "without", WITH: "with"}
SMALL = 1e-4
"""Parts of a force below this part of the largest one are left out."""
PRINTED = "printed"
"""End of the names of published restitutions in the order in which the paper prints them."""


def device_tables(folder: Path, published: Published) -> list[Path]:
    """Write the tables of the stage into `tables/` and into the log.

    Args:
        folder: The run's folder, with `device.nc`.
        published: Published values in SI by the name of the result.

    Returns:
        The files.

    Raises:
        ImpactfemError: A file cannot be written.
    """
    with open_store(folder / "device.nc") as store:
        view = DeviceView(store)
        tables = [
            _modes(view, published),
            _demand(view, published),
            _dampings(view, published),
            _study(view, published),
            _analyses(view),
            _anchors(view),
            verdict(view),
        ]
        if view.ordinates(0, WITH) is not None:
            tables.append(_shares(view))
    target = folder / "tables"
    target.mkdir(exist_ok=True)
    for table in tables:
        LOGGER.debug("\n%s", table.as_text())
    return [table.write_csv(target) for table in tables]


def _ratio(ours: float | None, theirs: float | None) -> float | None:
    return ours / theirs if ours is not None and theirs else None


def _percent(value: float | None) -> float | None:
    return None if value is None else 100.0 * value


def _modes(view: DeviceView, published: Published) -> Table:
    """Table 6 of the paper.

    Its modes of one frequency come in the order y, x, with the same values for both.
    """
    rows: list[tuple[Cell, ...]] = []
    for d, device in enumerate(view.devices):
        mass = view.effective_mass(d)
        for k, frequency in enumerate(view.mode_frequency(d)):
            axis = int(mass[:3, k].argmax())
            names = [f"{view.start(d)}.{word}.{k + 1}" for word in ("frequency", "effective_mass")]
            theirs = [published.get(name) for name in names]
            rows.append(
                (
                    device,
                    k + 1,
                    float(frequency),
                    theirs[0],
                    XYZ[axis],
                    float(mass[axis, k]),
                    theirs[1],
                    100.0 * float(mass[axis, k] / mass[axis].sum()),
                    *(float(m) for m in mass[3:, k]),
                    100.0 * float(view.mode_damping(d)[k]),
                )
            )
    return Table(
        "device_modes",
        "Modes of the devices; of one frequency in the order x, y",
        (
            ("device", ""),
            ("mode", ""),
            ("f", "Hz"),
            ("published f", "Hz"),
            ("along", ""),
            ("effective mass", "kg"),
            ("published mass", "kg"),
            ("of the modes along it", "%"),
            ("about x", "kg m2"),
            ("about y", "kg m2"),
            ("about z", "kg m2"),
            ("damping", "%"),
        ),
        tuple(rows),
    ).comparing({"published f", "published mass"}, ", beside the published ones")


def _demand(view: DeviceView, published: Published) -> Table:
    """Table 7: the loading demand, and as the paper has it over the sum of effective masses."""
    axis = view.direction
    rows: list[tuple[Cell, ...]] = []
    for d, device in enumerate(view.devices):
        mass = view.modal_mass(d)
        theirs_mass = _published_mass(view, d, published)
        for label, choice in (("detailed", None), *_headlines(view)):
            key = {None: "detailed", view.headline: "rsa"}.get(choice)
            forces = [
                view.detailed(d, k) if choice is None else view.by_spectrum(d, k, choice=choice)
                for k in (WITHOUT, WITH)
            ]
            for impact, force in zip((WITHOUT, WITH), forces, strict=True):
                if choice is not None and not view.done(d, impact, 0, choice):
                    continue
                theirs = published.get(view.name(d, f"f{axis}.{key}", impact, 0)) if key else None
                rows.append(
                    (
                        device,
                        LOADS[impact],
                        label,
                        force,
                        theirs,
                        _ratio(force, theirs),
                        _ratio(force, mass),
                        _ratio(theirs, theirs_mass),
                        None
                        if choice is None
                        else _percent(view.difference(d, impact, choice=choice)),
                        _percent(published.get(view.name(d, "relative_difference", impact, 0)))
                        if key == "rsa"
                        else None,
                    )
                )
    return Table(
        "device_demand",
        f"Largest force of the devices along {axis} on the floor: in the 3D model in detail and by "
        "response spectrum analysis (RSA); equivalent acceleration: over the sum of the effective "
        f"masses along {axis}; difference: from detailed, over it, positive where RSA is too low",
        (
            ("device", ""),
            ("impacts", ""),
            ("analysis", ""),
            ("force", "N"),
            ("published", "N"),
            ("over published", ""),
            ("equivalent", "m/s2"),
            ("published equivalent", "m/s2"),
            ("difference", "%"),
            ("published difference", "%"),
        ),
        tuple(rows),
    ).comparing(
        {"published", "over published", "published equivalent", "published difference"},
        "; beside the published values",
    )


def _headlines(view: DeviceView) -> list[tuple[str, str]]:
    """The headline analysis, and those with rotations and other rigid parts: labels and names."""
    found = (view.headline, view.variant(ROTATIONS), *view.rigid_variants().values())
    return [(f"RSA, {name.replace('.', ', ')}", name) for name in found if name is not None]


def _published_mass(view: DeviceView, device: int, published: Published) -> float | None:
    """Sum of the published effective masses of the modes along the shown direction [kg]."""
    names = [f"{view.start(device)}.effective_mass.{k + 1}" for k in view.shown_modes(device)]
    found = [published[name] for name in names if name in published]
    return sum(found) if found else None


def _dampings(view: DeviceView, published: Published) -> Table:
    """Table 8, whose restitutions are printed in one order and described in the other.

    The text says that ε grows as damping falls; the printed row falls with it.
    """
    modes = view.shown_modes(0)
    shown = sorted({float(f"{view.mode_frequency(0)[k]:.3g}") for k in modes})[:2]
    rows: list[tuple[Cell, ...]] = []
    for c, case in enumerate(view.cases):
        name = f"calibration.epsilon.{case}" if c else "calibration.epsilon"
        described = published.get(name)
        damping = view.damping(c)
        epsilon = view.epsilon(c)
        source = "contact laws" if epsilon is None else "given"
        rows.append(
            (
                case,
                damping.alpha,
                damping.beta,
                *(100.0 * float(view.damping(c).ratio(f)) for f in shown),
                epsilon,
                "calibrated" if view.calibrated(c) else source,
                described,
                # One that is not printed elsewhere is the same in both orders.
                published.get(f"{name}.{PRINTED}", described),
                1e-6 * float(view.impact_force[c]),
            )
        )
    return Table(
        "device_dampings",
        "Dampings of the buildings and restitution of their impacts (calibrated: by the wall, on "
        "the reduced model of this stage, so that it is not quite that of wall_damping.csv), with "
        "the largest impact force as resampled to the steps of the 3D model",
        (
            ("damping", ""),
            ("alpha", "1/s"),
            ("beta", "s"),
            *((f"xi at {f:g} Hz", "%") for f in shown),
            ("epsilon", "-"),
            ("where from", ""),
            ("by the text", "-"),
            ("as printed", "-"),
            ("impact force", "MN"),
        ),
        tuple(rows),
    ).comparing(
        {"by the text", "as printed"},
        "; beside the published values in the order that the text describes and as printed",
    )


def _study(view: DeviceView, published: Published) -> Table:
    """Table 9: detailed and response spectrum analysis by damping, the paper's behind ours."""
    axis = view.direction
    turned = view.variant(ROTATIONS)
    rows: list[tuple[Cell, ...]] = []
    for d, device in enumerate(view.devices):
        for c, case in enumerate(view.cases):
            for impact, load in LOADS.items():
                names = [
                    view.name(d, word, impact, c)
                    for word in (f"f{axis}.detailed", f"f{axis}.rsa", "relative_difference")
                ]
                theirs = [published.get(name) for name in names]
                more = (
                    (
                        view.by_spectrum(d, impact, c, turned),
                        _percent(view.difference(d, impact, c, turned)),
                    )
                    if turned
                    else (None, None)
                )
                rows.append(
                    (
                        device,
                        case,
                        load,
                        view.detailed(d, impact, c),
                        theirs[0],
                        view.by_spectrum(d, impact, c),
                        theirs[1],
                        _percent(view.difference(d, impact, c)),
                        _percent(theirs[2]),
                        *more,
                    )
                )
    return Table(
        "device_damping_study",
        f"Largest force of the devices along {axis} on the floor by the damping of the buildings: "
        f"in detail and by response spectrum analysis (RSA, {view.headline}); difference: from "
        "detailed, over it, positive where RSA is too low",
        (
            ("device", ""),
            ("damping", ""),
            ("impacts", ""),
            ("detailed", "N"),
            ("published detailed", "N"),
            ("RSA", "N"),
            ("published RSA", "N"),
            ("difference", "%"),
            ("published difference", "%"),
            ("RSA with rotations", "N"),
            ("its difference", "%"),
        ),
        tuple(rows),
    ).comparing(
        {"published detailed", "published RSA", "published difference"},
        "; beside the published values",
    )


def _analyses(view: DeviceView) -> Table:
    """Every response spectrum analysis of every device, load and damping, all components."""
    store = view.store
    found = store["spectrum_force"].values
    detailed = store["largest_force"].values
    rows: list[tuple[Cell, ...]] = []
    for d, device in enumerate(view.devices):
        for c, case in enumerate(view.cases):
            for impact in (WITHOUT, WITH):
                start: tuple[Cell, ...] = (device, case, LOADS[impact])
                exact = (float(v) for v in detailed[c, impact, d])
                rows.append((*start, "detailed", *exact, None))
                for k, choice in enumerate(view.choices):
                    if not view.done(d, impact, c, choice):
                        continue
                    rows.append(
                        (
                            *start,
                            choice.replace(".", ", "),
                            *(float(v) for v in found[c, impact, d, k]),
                            _percent(view.difference(d, impact, c, choice)),
                        )
                    )
    components: Columns = tuple((f"F{a}", "N") for a in XYZ) + tuple((f"M{a}", "N m") for a in XYZ)
    return Table(
        "device_analyses",
        "Largest forces and moments of the devices on the floor: in the 3D model in detail, and by "
        "all response spectrum analyses: combination of the modes; envelope: of the spectra of the "
        "anchor and further points; envelope-dampings: over all dampings; given: spectra of a "
        "file; spectra of the anchor's rotations as input; broadened peaks; supports: combination "
        "of several anchors where it is not the first that was asked; difference of the force "
        f"along {view.direction}",
        (
            ("device", ""),
            ("damping", ""),
            ("impacts", ""),
            ("analysis", ""),
            *components,
            ("difference", "%"),
        ),
        tuple(rows),
    )


def _anchors(view: DeviceView) -> Table:
    """Forces and moments at the anchor beside the weight: is it pulled, and how much."""
    rows: list[tuple[Cell, ...]] = []
    for d, device in enumerate(view.devices):
        for c, case in enumerate(view.cases):
            for impact, load in LOADS.items():
                pull = view.pull(d, impact, c)
                for label, choice in (("detailed", None), *_headlines(view)):
                    if choice is not None and not view.done(d, impact, c, choice):
                        continue
                    found = view.components(d, impact, c, choice)
                    if pull is None:
                        less: tuple[Cell, ...] = (None, None, None)
                    elif choice is None:
                        less = (pull.weight, pull.uplift, pull.tension)
                    else:
                        tension = view.tension_by_spectrum(d, impact, c, choice)
                        less = (pull.weight, float(found[2]) - pull.weight, tension)
                    rows.append((device, case, load, label, *(float(v) for v in found), *less))
    components: Columns = tuple((f"F{a}", "N") for a in XYZ) + tuple((f"M{a}", "N m") for a in XYZ)
    return Table(
        "device_anchors",
        "Largest forces and moments of the devices on the floor by their motion, and with their "
        "weight: net uplift, the force upward less the weight, lifts all of the base where it is "
        "positive; net tension, that and 2 M / r with the overturning moment M and the radius r of "
        "the device's anchors, is n times the pull of the most loaded of n anchors evenly on the "
        "circle, under a rigid plate that bears pressure by them alone. In detail at each instant, "
        "by response spectrum analysis (RSA) with all largest values at one instant",
        (
            ("device", ""),
            ("damping", ""),
            ("impacts", ""),
            ("analysis", ""),
            *components,
            ("weight", "N"),
            ("net uplift", "N"),
            ("net tension", "N"),
        ),
        tuple(rows),
    )


def _shares(view: DeviceView) -> Table:
    """What each mode gives to the force, and the displacement that its oscillator has.

    A mode with the effective mass M along the direction and M_i along or about the component i of
    the anchor gives √(M M_i) S to the force under the pseudo-acceleration S of that component.
    """
    rows: list[tuple[Cell, ...]] = []
    for d, device in enumerate(view.devices):
        mass, frequency = view.effective_mass(d), view.mode_frequency(d)
        for c, case in enumerate(view.cases):
            for impact, load in LOADS.items():
                S = view.ordinates(d, impact, c)
                if S is None:
                    raise ValueError("the store has no ordinates of the modes")
                force = np.sqrt(mass[view.column] * mass) * np.nan_to_num(S)
                whole = float((force**2).sum())
                for i, k in zip(*np.nonzero(force > SMALL * force.max()), strict=True):
                    rows.append(
                        (
                            device,
                            case,
                            load,
                            str(view.store["component"].values[i]),
                            int(k) + 1,
                            float(frequency[k]),
                            float(S[i, k]),
                            1e3 * float(S[i, k] / (2.0 * math.pi * frequency[k]) ** 2),
                            float(force[i, k]),
                            100.0 * float(force[i, k] ** 2) / whole,
                        )
                    )
    return Table(
        "device_shares",
        f"What each mode and each component of the anchor gives to the force along "
        f"{view.direction} by response spectrum analysis, without the missing mass; pseudo-"
        "acceleration and relative displacement of its oscillator; of several anchors each by "
        "its own motion; part: of the sum of squares",
        (
            ("device", ""),
            ("damping", ""),
            ("impacts", ""),
            ("component", ""),
            ("mode", ""),
            ("f", "Hz"),
            ("pseudo-acceleration", "m/s2 or rad/s2"),
            ("displacement", "mm or mrad"),
            ("force", "N"),
            ("part", "%"),
        ),
        tuple(rows),
    )
