"""Tables of the stage `device`: modes, forces and analyses, with tables 6 to 9 of the paper."""

import math
from collections.abc import Mapping
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.plot.table import Cell, Table, columns_of, heads, variables, write_tables
from impactfem.stages.device.selection import (
    DETAILED,
    MOVES,
    ROTATIONS,
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
from impactfem.sticks.element import COMPONENTS

Published = Mapping[str, float]

FORCES = "Fx [N]; Fy [N]; Fz [N]; Mx [N m]; My [N m]; Mz [N m]"
LOAD = "device; case as damping; impact as impacts"
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
        results = _results(store, published)
        tables = [
            _modes(store, published),
            _demand(store, results, published),
            _dampings(store, published),
            _study(store, results),
            _analyses(store, results),
            _anchors(store, results),
            verdict(store),
            _shares(store),
        ]
    return write_tables(folder, tables)


def _results(store: xr.Dataset, published: Published) -> xr.Dataset:
    """Return forces, net tension and published values by load and analysis; nan if unknown."""
    axis, force = direction(store), store["peak_force"]
    kinds = {DETAILED: f"f{axis}.detailed", headline(store): f"f{axis}.rsa"}
    found: dict[str, xr.DataArray] = {
        name: force.sel(component=component, drop=True)
        for (name, _), component in zip(heads(FORCES), COMPONENTS, strict=True)
    }
    found["force"] = force.sel(component=axis, drop=True)
    for name, quantities in (
        ("published", kinds),
        ("published_difference", {headline(store): "relative_difference"}),
    ):
        values = [
            published.get(load.scalar(quantities.get(analysis, "")), math.nan)
            for load, analysis in product(loads_of(store), names_of(store, "analysis"))
        ]
        sizes = {dim: store.sizes[dim] for dim in ("device", "case", "impact", "analysis")}
        found[name] = xr.DataArray(np.reshape(values, list(sizes.values())), dims=list(sizes))
    names = ["relative_difference", "net_uplift", "net_tension", "weight"]
    return store[names].assign(found).reset_coords(drop=True)


def _rows(results: xr.Dataset, *dimensions: str) -> xr.Dataset:
    """Return results with these dimensions as one, without analyses that were not done."""
    rows = results.stack(row=dimensions, create_index=False)
    return rows.isel(row=np.isfinite(rows["force"].values))


def _shown(store: xr.Dataset, results: xr.Dataset) -> xr.Dataset:
    """Select the detailed analysis, and the headline, with rotations and other rigid parts."""
    names = (headline(store), variant(store, ROTATIONS), *rigid_variants(store).values())
    labels = {DETAILED: DETAILED} | {name: f"RSA, {name}" for name in names if name is not None}
    return results.sel(analysis=list(labels)).assign_coords(analysis=list(labels.values()))


def _modes(store: xr.Dataset, published: Published) -> Table:
    """Table 6 of the paper, whose modes of one frequency come in the order y, x."""
    names = ["mode_frequency", "mode_damping", "mode_mass", "effective_mass"]
    modes = store[names].stack(row=("device", "mode"), create_index=False)
    modes = modes.isel(row=np.isfinite(modes["mode_frequency"].values))
    total, mass = store["effective_mass"].sum("mode"), modes["effective_mass"]
    along = mass.sel(component=["x", "y", "z"]).idxmax("component")
    whole = total.sel(component=along, device=modes["device"]).values
    # A mode that only turns moves along no axis.
    moves = modes["mode_mass"] > MOVES * whole
    starts = [scalar_start(store, device) for device in modes["device"].values]
    places = list(zip(starts, modes["mode"].values, strict=True))
    for quantity in ("frequency", "effective_mass"):
        found = [published.get(f"{start}.{quantity}.{mode}", math.nan) for start, mode in places]
        modes[f"published_{quantity}"] = ("row", found)
    turned = {f"r{axis}": mass.sel(component=f"r{axis}", drop=True) for axis in "xyz"}
    rows = modes.assign(turned).assign(
        along=along.where(moves, ""),
        mode_mass=modes["mode_mass"].where(moves),
        share=(modes["mode_mass"] / whole).where(moves),
    )
    return columns_of(
        rows,
        "device_modes",
        "Modes of the devices; of one frequency in the order x, y",
        variables(
            "device; mode; mode_frequency as f [Hz]; published_frequency as published f [Hz]; "
            "along; mode_mass as effective mass [kg]; published_effective_mass as published mass "
            "[kg]; share as of the modes along it [%]; rx as about x [kg m2]; ry as about y "
            "[kg m2]; rz as about z [kg m2]; mode_damping as damping [%]"
        ),
    ).comparing({"published f", "published mass"}, ", beside the published ones")


def _demand(store: xr.Dataset, results: xr.Dataset, published: Published) -> Table:
    """Table 7: the loading demand, and as the paper has it over the sum of effective masses."""
    axis, masses = direction(store), []
    for device in names_of(store, "device"):
        start = f"{scalar_start(store, device)}.effective_mass"
        names = [f"{start}.{k}" for k in shown_modes(store, device)["mode"].values]
        masses.append(sum(published[name] for name in names if name in published))
    mass = store["effective_mass"].sel(component=axis, drop=True).sum("mode")
    own = results.assign(
        over=results["force"] / results["published"],
        equivalent=results["force"] / mass,
        published_equivalent=results["published"] / xr.DataArray(masses, dims="device"),
    )
    return columns_of(
        _rows(_shown(store, own.isel(case=0)), "device", "analysis", "impact"),
        "device_demand",
        f"Largest force of the devices along {axis} on the floor: in the 3D model in detail and by "
        "response spectrum analysis (RSA); equivalent acceleration: over the sum of the effective "
        f"masses along {axis}; difference = (detailed - RSA)/detailed, positive where RSA "
        "underestimates",
        variables(
            "device; impact as impacts; analysis; force [N]; published [N]; over as over "
            "published; equivalent [m/s2]; published_equivalent as published equivalent [m/s2]; "
            "relative_difference as difference [%]; published_difference as published difference "
            "[%]"
        ),
    ).comparing(
        {"published", "over published", "published equivalent", "published difference"},
        "; beside the published values",
    )


def _dampings(store: xr.Dataset, published: Published) -> Table:
    """Table 8, whose restitutions are printed in one order and described in the other.

    The text says that ε grows as damping falls; the printed row falls with it.
    """
    first, *_ = names_of(store, "device")
    frequencies = shown_modes(store, first)["mode_frequency"].values
    shown = sorted({float(f"{f:.3g}") for f in frequencies})[:2]
    cases, own = names_of(store, "case"), "calibration.epsilon"
    names = [own, *(f"{own}.{case}" for case in cases[1:])]
    described = [published.get(name, math.nan) for name in names]
    # A restitution that is not printed elsewhere is the same in both orders.
    printed = [
        published.get(f"{name}.{PRINTED}", value)
        for name, value in zip(names, described, strict=True)
    ]
    laws = [damping_of(store.sel(case=case)) for case in cases]
    ratios = {
        f"ratio_{k}": ("case", [float(law.ratio(f)) for law in laws]) for k, f in enumerate(shown)
    }
    of_modes = "".join(f"ratio_{k} as xi at {f:g} Hz [%]; " for k, f in enumerate(shown))
    return columns_of(
        store.assign(ratios).assign(
            origin=("case", [restitution(store, case)[1] for case in cases]),
            described=("case", described),
            printed=("case", printed),
        ),
        "device_dampings",
        "Dampings of the buildings and restitution of their impacts (calibrated: by the wall, as "
        "in wall_damping.csv), with the largest impact force as resampled to the steps of the 3D "
        "model",
        variables(
            "case as damping; mass_coefficient as alpha [1/s]; stiffness_coefficient as beta [s]; "
            f"{of_modes}epsilon [-]; origin as where from; described as by the text [-]; printed "
            "as as printed [-]; impact_force as impact force [MN]"
        ),
    ).comparing(
        {"by the text", "as printed"},
        "; beside the published values in the order that the text describes and as printed",
    )


def _study(store: xr.Dataset, results: xr.Dataset) -> Table:
    """Table 9: detailed and response spectrum analysis by damping, with the paper's values."""
    axis, rsa, turned = direction(store), headline(store), variant(store, ROTATIONS)
    detailed, by_rsa = (results.sel(analysis=name, drop=True) for name in (DETAILED, rsa))
    rotations = results.sel(analysis=turned or rsa, drop=True).where(turned is not None)
    of_load = by_rsa.assign(
        detailed=detailed["force"],
        published_detailed=detailed["published"],
        rotations=rotations["force"],
        rotations_difference=rotations["relative_difference"],
    )
    return columns_of(
        _rows(of_load, "device", "case", "impact"),
        "device_damping_study",
        f"Largest force of the devices along {axis} on the floor by the damping of the buildings: "
        f"in detail and by response spectrum analysis (RSA, {rsa}); difference = "
        "(detailed - RSA)/detailed, positive where RSA underestimates",
        variables(
            f"{LOAD}; detailed [N]; published_detailed as published detailed [N]; force as RSA "
            "[N]; published as published RSA [N]; relative_difference as difference [%]; "
            "published_difference as published difference [%]; rotations as RSA with rotations "
            "[N]; rotations_difference as its difference [%]"
        ),
    ).comparing(
        {"published detailed", "published RSA", "published difference"},
        "; beside the published values",
    )


def _analyses(store: xr.Dataset, results: xr.Dataset) -> Table:
    """Every response spectrum analysis of every device, load and damping, all components."""
    return columns_of(
        _rows(results, "device", "case", "impact", "analysis"),
        "device_analyses",
        "Largest forces and moments of the devices on the floor: in the 3D model in detail, and by "
        "all response spectrum analyses: combination of the modes; envelope: of the spectra of the "
        "anchor and further points; envelope-dampings: over all dampings; given: spectra of a "
        "file; spectra of the anchor's rotations as input; broadened peaks; supports: combination "
        "of several anchors where it is not the one requested first; difference of the force "
        f"along {direction(store)}",
        variables(f"{LOAD}; analysis; {FORCES}; relative_difference as difference [%]"),
    )


def _anchors(store: xr.Dataset, results: xr.Dataset) -> Table:
    """Forces and moments at the anchor with the weight: net uplift and net tension."""
    return columns_of(
        _rows(_shown(store, results), "device", "case", "impact", "analysis"),
        "device_anchors",
        "Largest forces and moments of the devices on the floor by their motion, and with their "
        "weight: net uplift, the force upward less the weight, lifts all of the base where it is "
        "positive; net tension, that and 2 M / r with the overturning moment M and the radius r of "
        "the device's anchors, is n times the pull of the most loaded of n anchors evenly on the "
        "circle, under a rigid plate that bears pressure by them alone. In detail at each instant, "
        "by response spectrum analysis (RSA) with all largest values at one instant",
        variables(
            f"{LOAD}; analysis; {FORCES}; weight [N]; net_uplift as net uplift [N]; "
            "net_tension as net tension [N]"
        ),
    )


def _shares(store: xr.Dataset) -> Table:
    """What each mode gives to the force, and the displacement that its oscillator has."""
    # A mode with the effective mass M along the direction and M_i along or about the component i of
    # the anchor gives √(M M_i) S to the force under the pseudo-acceleration S of that component.
    rows: list[tuple[Cell, ...]] = []
    for load in loads_of(store):
        modes = modes_of(store, load.device)
        mass, ω = modes["effective_mass"], 2.0 * math.pi * modes["mode_frequency"].values
        S = load.ordinates.transpose("component", "mode").values
        both = (mass.sel(component=direction(store)) * mass).transpose("component", "mode")
        force = np.sqrt(both.values) * np.nan_to_num(S)
        whole = float((force**2).sum())
        where = load.device, load.case, load.impact
        for i, k in zip(*np.nonzero(force > SMALL * force.max()), strict=True):
            part = 100.0 * force[i, k] ** 2 / whole
            frequency = float(modes["mode_frequency"][k])
            values = (frequency, S[i, k], 1e3 * S[i, k] / ω[k] ** 2, force[i, k], part)
            rows.append((*where, COMPONENTS[i], int(k) + 1, *map(float, values)))
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
