"""Tables of the stage `device`: the paper's values (tables 6 to 9) beside ours, and the verdict."""

import math
from collections.abc import Mapping
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.plot.table import Cell, Table, heads, write_tables
from impactfem.stages.device.selection import (
    LOADS,
    MOVES,
    ROTATIONS,
    Load,
    direction,
    headline,
    loaded,
    loads_of,
    modes_of,
    restitution,
    rigid_variants,
    scalar_start,
    shown_modes,
    variant,
)
from impactfem.stages.device.verdict import verdict
from impactfem.stages.stores import damping_of, names_of, open_store

Published = Mapping[str, float]
Rows = list[tuple[Cell, ...]]

COMPONENTS = "Fx [N]; Fy [N]; Fz [N]; Mx [N m]; My [N m]; Mz [N m]"
LOAD = "device; damping; impacts"
SMALL = 1e-4
"""Parts of a force below this part of the largest one are left out."""
PRINTED = "printed"
"""End of the names of published restitutions in the order in which the paper prints them."""


def device_tables(folder: Path, published: Published) -> list[Path]:
    """Write the tables of the stage into `tables/` and into the log; gives the files.

    Published values are in SI by the name of the result. ImpactfemError where a file cannot be
    written.
    """
    with open_store(folder / "device.nc") as opened:
        store = loaded(opened)
        tables = [
            _modes(store, published),
            _demand(store, published),
            _dampings(store, published),
            _study(store, published),
            _analyses(store),
            _anchors(store),
            verdict(store),
            _shares(store),
        ]
    return write_tables(folder, tables)


def _percent(value: float | None) -> float | None:
    return None if value is None else 100.0 * value


def _analyses_shown(store: xr.Dataset) -> list[tuple[str, str | None]]:
    """The detailed analysis, and the headline with rotations and other rigid parts: what they are.

    The name is that of a response spectrum analysis; None for the detailed one.
    """
    names = (headline(store), variant(store, ROTATIONS), *rigid_variants(store).values())
    found = [(f"RSA, {name.replace('.', ', ')}", name) for name in names if name is not None]
    return [("detailed", None), *found]


def _modes(store: xr.Dataset, published: Published) -> Table:
    """Table 6 of the paper."""
    # Its modes of one frequency come in the order y, x, with the same values for both.
    rows: Rows = []
    for device in names_of(store, "device"):
        modes = modes_of(store, device)
        along = modes["effective_mass"].sel(component=["x", "y", "z"])
        axes = along.idxmax("component")
        for mode in modes["mode"]:
            one, axis = modes.sel(mode=mode), axes.sel(mode=mode).item()
            mass, start = one["effective_mass"], f"{scalar_start(store, device)}."
            carried, whole = (float(m.sel(component=axis).sum()) for m in (mass, along))
            # A mode that only turns moves along no axis.
            moves = carried > MOVES * whole
            rows.append(
                (
                    device,
                    mode.item(),
                    one["mode_frequency"].item(),
                    published.get(f"{start}frequency.{mode.item()}"),
                    axis if moves else "",
                    carried if moves else None,
                    published.get(f"{start}effective_mass.{mode.item()}"),
                    100.0 * carried / whole if moves else None,
                    *mass.sel(component=["rx", "ry", "rz"]).values.tolist(),
                    100.0 * one["mode_damping"].item(),
                )
            )
    return Table(
        "device_modes",
        "Modes of the devices; of one frequency in the order x, y",
        heads(
            "device; mode; f [Hz]; published f [Hz]; along; effective mass [kg]; "
            "published mass [kg]; of the modes along it [%]; about x [kg m2]; about y [kg m2]; "
            "about z [kg m2]; damping [%]"
        ),
        tuple(rows),
    ).comparing({"published f", "published mass"}, ", beside the published ones")


def _demand(store: xr.Dataset, published: Published) -> Table:
    """Table 7: the loading demand, and as the paper has it over the sum of effective masses."""
    axis = direction(store)
    rows: Rows = []
    for device in names_of(store, "device"):
        mass = float(modes_of(store, device)["effective_mass"].sel(component=axis).sum())
        start = f"{scalar_start(store, device)}.effective_mass"
        names = [f"{start}.{k}" for k in shown_modes(store, device)["mode"].values]
        theirs_mass = sum(published[name] for name in names if name in published)
        loads = [Load(store, device, impact) for impact in LOADS]
        for (label, choice), load in product(_analyses_shown(store), loads):
            if not load.was_done(choice):
                continue
            key = {None: "detailed", headline(store): "rsa"}.get(choice)
            theirs = published.get(load.scalar(f"f{axis}.{key}")) if key else None
            force = float(load.components(choice).sel(component=axis))
            gap = published.get(load.scalar("relative_difference")) if key == "rsa" else None
            rows.append(
                (
                    *(device, load.impact, label, force, theirs),
                    force / theirs if theirs else None,
                    force / mass if mass else None,
                    theirs / theirs_mass if theirs is not None and theirs_mass else None,
                    None if choice is None else _percent(load.difference(choice)),
                    _percent(gap),
                )
            )
    return Table(
        "device_demand",
        f"Largest force of the devices along {axis} on the floor: in the 3D model in detail and by "
        "response spectrum analysis (RSA); equivalent acceleration: over the sum of the effective "
        f"masses along {axis}; difference = (detailed - RSA)/detailed, positive where RSA "
        "underestimates",
        heads(
            "device; impacts; analysis; force [N]; published [N]; over published; "
            "equivalent [m/s2]; published equivalent [m/s2]; difference [%]; "
            "published difference [%]"
        ),
        tuple(rows),
    ).comparing(
        {"published", "over published", "published equivalent", "published difference"},
        "; beside the published values",
    )


def _dampings(store: xr.Dataset, published: Published) -> Table:
    """Table 8, whose restitutions are printed in one order and described in the other."""
    # The text says that ε grows as damping falls; the printed row falls with it.
    first, *_ = names_of(store, "device")
    frequencies = shown_modes(store, first)["mode_frequency"].values
    shown = sorted({float(f"{f:.3g}") for f in frequencies})[:2]
    own, *_ = names_of(store, "case")
    rows: Rows = []
    for case in names_of(store, "case"):
        name = "calibration.epsilon" if case == own else f"calibration.epsilon.{case}"
        described = published.get(name)
        damping, (epsilon, source) = damping_of(store.sel(case=case)), restitution(store, case)
        rows.append(
            (
                *(case, *damping.coefficients),
                *(100.0 * float(damping.ratio(f)) for f in shown),
                epsilon,
                source,
                described,
                # One that is not printed elsewhere is the same in both orders.
                published.get(f"{name}.{PRINTED}", described),
                1e-6 * float(store["impact_force"].sel(case=case)),
            )
        )
    ratios = "".join(f"xi at {f:g} Hz [%]; " for f in shown)
    return Table(
        "device_dampings",
        "Dampings of the buildings and restitution of their impacts (calibrated: by the wall, as "
        "in wall_damping.csv), with the largest impact force as resampled to the steps of the 3D "
        "model",
        heads(
            f"damping; alpha [1/s]; beta [s]; {ratios}epsilon [-]; where from; by the text [-]; "
            "as printed [-]; impact force [MN]"
        ),
        tuple(rows),
    ).comparing(
        {"by the text", "as printed"},
        "; beside the published values in the order that the text describes and as printed",
    )


def _study(store: xr.Dataset, published: Published) -> Table:
    """Table 9: detailed and response spectrum analysis by damping, the paper's behind ours."""
    axis, turned = direction(store), variant(store, ROTATIONS)
    rows: Rows = []
    for load in loads_of(store):
        words = (f"f{axis}.detailed", f"f{axis}.rsa", "relative_difference")
        detailed, by_spectrum, difference = (published.get(load.scalar(word)) for word in words)
        rows.append(
            (
                *(load.device, load.case, load.impact),
                *(load.detailed, detailed),
                *(load.by_spectrum(), by_spectrum),
                *(_percent(load.difference()), _percent(difference)),
                load.by_spectrum(turned) if turned else None,
                _percent(load.difference(turned)) if turned else None,
            )
        )
    return Table(
        "device_damping_study",
        f"Largest force of the devices along {axis} on the floor by the damping of the buildings: "
        f"in detail and by response spectrum analysis (RSA, {headline(store)}); difference = "
        "(detailed - RSA)/detailed, positive where RSA underestimates",
        heads(
            "device; damping; impacts; detailed [N]; published detailed [N]; RSA [N]; "
            "published RSA [N]; difference [%]; published difference [%]; "
            "RSA with rotations [N]; its difference [%]"
        ),
        tuple(rows),
    ).comparing(
        {"published detailed", "published RSA", "published difference"},
        "; beside the published values",
    )


def _analyses(store: xr.Dataset) -> Table:
    """Every response spectrum analysis of every device, load and damping, all components."""
    rows: Rows = []
    for load in loads_of(store):
        start = (load.device, load.case, load.impact)
        rows.append((*start, "detailed", *load.components().values.tolist(), None))
        rows += [
            (
                *(*start, choice.replace(".", ", ")),
                *load.components(choice).values.tolist(),
                _percent(load.difference(choice)),
            )
            for choice in names_of(store, "choice")
            if load.was_done(choice)
        ]
    return Table(
        "device_analyses",
        "Largest forces and moments of the devices on the floor: in the 3D model in detail, and by "
        "all response spectrum analyses: combination of the modes; envelope: of the spectra of the "
        "anchor and further points; envelope-dampings: over all dampings; given: spectra of a "
        "file; spectra of the anchor's rotations as input; broadened peaks; supports: combination "
        "of several anchors where it is not the one requested first; difference of the force "
        f"along {direction(store)}",
        heads(f"{LOAD}; analysis; {COMPONENTS}; difference [%]"),
        tuple(rows),
    )


def _anchors(store: xr.Dataset) -> Table:
    """Forces and moments at the anchor beside the weight: is it pulled, and how much."""
    rows: Rows = [
        (
            *(load.device, load.case, load.impact, label),
            *load.components(choice).values.tolist(),
            *(
                value if math.isfinite(value) else None
                for value in (load.weight, load.uplift(choice), load.tension(choice))
            ),
        )
        for load in loads_of(store)
        for label, choice in _analyses_shown(store)
        if load.was_done(choice)
    ]
    return Table(
        "device_anchors",
        "Largest forces and moments of the devices on the floor by their motion, and with their "
        "weight: net uplift, the force upward less the weight, lifts all of the base where it is "
        "positive; net tension, that and 2 M / r with the overturning moment M and the radius r of "
        "the device's anchors, is n times the pull of the most loaded of n anchors evenly on the "
        "circle, under a rigid plate that bears pressure by them alone. In detail at each instant, "
        "by response spectrum analysis (RSA) with all largest values at one instant",
        heads(
            f"device; damping; impacts; analysis; {COMPONENTS}; weight [N]; net uplift [N]; "
            "net tension [N]"
        ),
        tuple(rows),
    )


def _shares(store: xr.Dataset) -> Table:
    """What each mode gives to the force, and the displacement that its oscillator has."""
    # A mode with the effective mass M along the direction and M_i along or about the component i of
    # the anchor gives √(M M_i) S to the force under the pseudo-acceleration S of that component.
    rows: Rows = []
    for load in loads_of(store):
        modes = modes_of(store, load.device)
        mass, ω = modes["effective_mass"], 2.0 * math.pi * modes["mode_frequency"].values
        S = load.ordinates.transpose("component", "mode").values
        both = (mass.sel(component=direction(store)) * mass).transpose("component", "mode")
        force = np.sqrt(both.values) * np.nan_to_num(S)
        whole = float((force**2).sum())
        names = names_of(store, "component")
        for i, k in zip(*np.nonzero(force > SMALL * force.max()), strict=True):
            part = 100.0 * force[i, k] ** 2 / whole
            values = (S[i, k], 1e3 * S[i, k] / ω[k] ** 2, force[i, k], part)
            start = (load.device, load.case, load.impact, names[i], int(k) + 1)
            rows.append((*start, float(modes["mode_frequency"][k]), *map(float, values)))
    return Table(
        "device_shares",
        f"What each mode and each component of the anchor gives to the force along "
        f"{direction(store)} by response spectrum analysis, without the missing mass; pseudo-"
        "acceleration and relative displacement of its oscillator; of several anchors each by "
        "its own motion; part: of the sum of squares",
        heads(
            "device; damping; impacts; component; mode; f [Hz]; "
            "pseudo-acceleration [m/s2 or rad/s2]; displacement [mm or mrad]; force [N]; part [%]"
        ),
        tuple(rows),
    )
