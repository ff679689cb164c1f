"""The checks of the stage `device` in words: balance, basis, impacts, restitution, verdict."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from impactfem.stages.check import Check
from impactfem.stages.device.verdict import LOADS, anchors, pounding, shortfall
from impactfem.stages.device.view import DeviceView
from impactfem.stages.stores import open_store

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
    with open_store(folder / "device.nc") as store:
        view = DeviceView(store)
        return [
            *_verdict(view),
            *_anchors(view),
            *_tension(view),
            *_balance(view),
            *_basis(view),
            *_impacts(view),
            *_notes(view),
        ]


def _verdict(view: DeviceView) -> list[Check]:
    """With the building's own damping; the table has that of all dampings."""
    lines: list[Check] = []
    for d, name in enumerate(view.devices):
        demand = ", ".join(
            f"{1e-3 * view.detailed(d, k):.4g} kN {load}" for k, load in LOADS.items()
        )
        force = f"F{view.direction}"
        lines.append((None, f"device: {force} of {name} on the floor: {demand}"))
        lines += [(None, f"device: {text}") for text in shortfall(view, d)]
        lines.append((None, f"device: does pounding lower the difference: {pounding(view, d)}"))
    return lines


def _anchors(view: DeviceView) -> list[Check]:
    lines: list[Check] = []
    for d, name in enumerate(view.devices):
        _, floor, nodes = view.anchor(d)
        text = (
            f"device: {name} is anchored to {nodes} node{'s' * (nodes > 1)} of floor {floor}, "
            f"at least {NODES} asked"
        )
        if nodes < NODES:
            text += ", which spread it over the slab: refine the mesh around its anchor"
        lines.append((nodes >= NODES, text))
    return lines


def _tension(view: DeviceView) -> list[Check]:
    """Whether the weight holds every device down, with any damping; else it needs its anchors."""
    lines: list[Check] = []
    for d, name in enumerate(view.devices):
        text = anchors(view, d)
        if text is None:
            # An older store says nothing; a table of modes has no weight.
            if "net_tension" in view.store:
                lines.append((None, f"device: the weight of {name} is not known, nor its tension"))
            continue
        pulls = [view.pull(d, k, c) for k in LOADS for c in range(len(view.cases))]
        held = not any(pull.tension > 0.0 for pull in pulls if pull is not None)
        words = "its weight holds it down" if held else "it needs anchors in tension"
        lines.append((held, f"device: {name}: {words}; net tension at the anchor: {text}"))
    return lines


def _balance(view: DeviceView) -> list[Check]:
    found = view.store["imbalance"].values
    lines: list[Check] = []
    for d, name in enumerate(view.devices):
        own = found[:, :, d]
        if not np.isfinite(own).any():
            text = f"device: {name} has no free spring, its base forces cannot be compared"
            lines.append((None, text))
            continue
        case, impact = np.unravel_index(int(np.nanargmax(own)), own.shape)
        worst = float(own[case, impact])
        text = (
            f"device: action and reaction at the anchor of {name} within {worst:.1e}, "
            f"{IMBALANCE:g} asked"
        )
        if worst > IMBALANCE:
            text += f"; with the damping {view.cases[case]} {LOADS[int(impact)]}"
        lines.append((worst <= IMBALANCE, text))
    return lines


def _basis(view: DeviceView) -> list[Check]:
    values = view.values
    error = values["device.basis_error"]
    text = (
        f"device: transfer functions of the reduced basis of {values['device.basis_vectors']:.0f} "
        f"vectors within {100.0 * error:.2g} %, {100.0 * BASIS:g} % asked"
    )
    return [(error <= BASIS, text)]


def _impacts(view: DeviceView) -> list[Check]:
    """The largest impact force is told; without an impact there is nothing to compare."""
    lines: list[Check] = []
    for c, case in enumerate(view.cases):
        peak, epsilon = float(view.impact_force[c]), view.epsilon(c)
        if epsilon is None:
            which = "the restitution of the contact laws"
        else:
            which = f"ε = {epsilon:.3g}, {'calibrated' if view.calibrated(c) else 'given'}"
        text = f"device: damping {case}: {which}; "
        if peak > 0.0:
            lines.append((None, f"{text}largest impact force {1e-6 * peak:.4g} MN"))
        else:
            lines.append((False, f"{text}no impact happens, both loads are the same"))
    return lines


def _notes(view: DeviceView) -> list[Check]:
    """What the response spectrum analyses assumed."""
    notes = str(view.store.attrs["notes"]) if "notes" in view.store.attrs else ""
    return [(None, f"device: {note}") for note in notes.splitlines()]
