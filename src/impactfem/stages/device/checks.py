"""The checks of the stage `device` in words: balance, basis, impacts, restitution, verdict."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from impactfem.stages.check import Check
from impactfem.stages.device.selection import (
    anchor_of,
    detailed_force,
    direction,
    is_calibrated,
    loaded,
    pull_of,
    restitution,
)
from impactfem.stages.device.verdict import LOADS, anchors, pounding, shortfall
from impactfem.stages.stores import names_of, open_store
from impactfem.system.scalar import values_of

IMBALANCE = 1e-8
"""Largest difference of action and reaction at an anchor, of the largest force."""
BASIS = 0.005
"""Largest error of the transfer functions of the reduced basis."""
NODES = 3
"""Least number of floor nodes that spread an anchor; fewer hold it at a point or along a line."""


def device_checks(folder: Path) -> list[Check]:
    """The checks of the stage.

    Args:
        folder: The run's folder, with `device.nc`.
    """
    with open_store(folder / "device.nc") as opened:
        store = loaded(opened)
        return [
            *_verdict(store),
            *_anchors(store),
            *_tension(store),
            *_balance(store),
            *_basis(store),
            *_impacts(store),
            *_notes(store),
        ]


def _verdict(store: xr.Dataset) -> list[Check]:
    """With the building's own damping; the table has that of all dampings."""
    lines: list[Check] = []
    for name in names_of(store, "device"):
        demand = ", ".join(
            f"{1e-3 * detailed_force(store, name, k):.4g} kN {load}" for k, load in LOADS.items()
        )
        force = f"F{direction(store)}"
        lines.append((None, f"device: {force} of {name} on the floor: {demand}"))
        lines += [(None, f"device: {text}") for text in shortfall(store, name)]
        lines.append((None, f"device: does pounding lower the difference: {pounding(store, name)}"))
    return lines


def _anchors(store: xr.Dataset) -> list[Check]:
    lines: list[Check] = []
    for name in names_of(store, "device"):
        _, floor, nodes = anchor_of(store, name)
        text = (
            f"device: {name} is anchored to {nodes} node{'s' * (nodes > 1)} of floor {floor}, "
            f"at least {NODES} asked"
        )
        if nodes < NODES:
            text += ", which spread it over the slab: refine the mesh around its anchor"
        lines.append((nodes >= NODES, text))
    return lines


def _tension(store: xr.Dataset) -> list[Check]:
    """Whether the weight holds every device down, with any damping; else it needs its anchors."""
    lines: list[Check] = []
    for name in names_of(store, "device"):
        text = anchors(store, name)
        if text is None:
            lines.append((None, f"device: the weight of {name} is not known, nor its tension"))
            continue
        pulls = [pull_of(store, name, k, case) for k in LOADS for case in names_of(store, "case")]
        held = not any(pull.tension > 0.0 for pull in pulls if pull is not None)
        words = "its weight holds it down" if held else "it needs anchors in tension"
        lines.append((held, f"device: {name}: {words}; net tension at the anchor: {text}"))
    return lines


def _balance(store: xr.Dataset) -> list[Check]:
    lines: list[Check] = []
    for name in names_of(store, "device"):
        own = store["imbalance"].sel(device=name)
        if not own.notnull().any():
            text = f"device: {name} has no free spring, its base forces cannot be compared"
            lines.append((None, text))
            continue
        largest = own.isel(own.argmax(...))
        worst = float(largest)
        text = (
            f"device: action and reaction at the anchor of {name} within {worst:.1e}, "
            f"{IMBALANCE:g} asked"
        )
        if worst > IMBALANCE:
            text += f"; with the damping {largest['case'].item()} {LOADS[largest['impact'].item()]}"
        lines.append((worst <= IMBALANCE, text))
    return lines


def _basis(store: xr.Dataset) -> list[Check]:
    values = values_of(store)
    error = values["device.basis_error"]
    text = (
        f"device: transfer functions of the reduced basis of {values['device.basis_vectors']:.0f} "
        f"vectors within {100.0 * error:.2g} %, {100.0 * BASIS:g} % asked"
    )
    return [(error <= BASIS, text)]


def _impacts(store: xr.Dataset) -> list[Check]:
    """The largest impact force is told; without an impact there is nothing to compare."""
    lines: list[Check] = []
    for case in names_of(store, "case"):
        peak, epsilon = float(store["impact_force"].sel(case=case)), restitution(store, case)
        if epsilon is None:
            which = "the restitution of the contact laws"
        else:
            which = f"ε = {epsilon:.3g}, {'calibrated' if is_calibrated(store, case) else 'given'}"
        text = f"device: damping {case}: {which}; "
        if peak > 0.0:
            lines.append((None, f"{text}largest impact force {1e-6 * peak:.4g} MN"))
        else:
            lines.append((False, f"{text}no impact happens, both loads are the same"))
    return lines


def _notes(store: xr.Dataset) -> list[Check]:
    """What the response spectrum analyses assumed."""
    return [(None, f"device: {note}") for note in store["note"].values]
