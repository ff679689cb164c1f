"""The checks of the stage `device` in words: balance, basis, impacts, restitution, verdict."""

from pathlib import Path

import xarray as xr

from impactfem.stages.check import Check, limited
from impactfem.stages.device.selection import LOADS, Load, anchor_of, direction, loaded, restitution
from impactfem.stages.device.verdict import anchors, pounding, shortfall
from impactfem.stages.stores import names_of, open_store
from impactfem.system.scalar import values_of

IMBALANCE = 1e-8
"""Largest difference of action and reaction at an anchor, of the largest force."""
BASIS = 0.005
"""Largest error of the transfer functions of the reduced basis."""
NODES = 3
"""Least number of floor nodes that spread an anchor; fewer hold it at a point or along a line."""


def device_checks(folder: Path) -> list[Check]:
    """The checks of the stage, from `device.nc` of a run's folder."""
    with open_store(folder / "device.nc") as opened:
        store = loaded(opened)
        lines = [line for name in names_of(store, "device") for line in _of_device(store, name)]
        values = values_of(store)
        error, vectors = values["device.basis_error"], values["device.basis_vectors"]
        basis = f"error of the reduced basis of {vectors:.0f} vectors"
        lines += [limited(basis, error, BASIS, "%"), *_impacts(store)]
        # What the response spectrum analyses assumed.
        lines += [(None, str(note)) for note in store["note"].values]
    return [(good, f"device: {text}") for good, text in lines]


def _of_device(store: xr.Dataset, name: str) -> list[Check]:
    """What holds with the building's own damping in words, and of its anchor with any damping."""
    demand = ", ".join(
        f"{1e-3 * Load(store, name, impact).detailed:.4g} kN {words}"
        for impact, words in LOADS.items()
    )
    lines: list[Check] = [(None, f"F{direction(store)} of {name} on the floor: {demand}")]
    lines += [
        (None, f"{name}: {text}") for text in (*shortfall(store, name), pounding(store, name))
    ]

    _, floor, nodes = anchor_of(store, name)
    text = f"{name} on floor {floor}: nodes that it is anchored to"
    met, text = limited(text, nodes, NODES, least=True)
    more = "; fewer do not spread it over the slab: refine the mesh around its anchor"
    lines.append((met, text if met else text + more))

    # Whether the weight holds the device down, with any damping; else it needs its anchors.
    if (pulled := anchors(store, name)) is None:
        lines.append((None, f"the weight of {name} is not known, nor its tension"))
    else:
        held = not bool((store["net_tension"].sel(device=name) > 0.0).any())
        words = "its weight holds it down" if held else "it needs anchors in tension"
        lines.append((held, f"{name}: {words}; net tension at the anchor: {pulled}"))

    imbalance = store["imbalance"].sel(device=name)
    if not imbalance.notnull().any():
        lines.append((None, f"{name} has no free spring, its base forces cannot be compared"))
        return lines
    largest = imbalance.isel(imbalance.argmax(...))
    worst = float(largest)
    text = f"{name}: difference of action and reaction at the anchor"
    met, text = limited(text, worst, IMBALANCE)
    where = f", damping {largest['case'].item()}, {LOADS[largest['impact'].item()]}"
    lines.append((met, text if met else text + where))
    return lines


def _impacts(store: xr.Dataset) -> list[Check]:
    """The largest impact force; without an impact there is nothing to compare."""
    lines: list[Check] = []
    for case in names_of(store, "case"):
        peak = float(store["impact_force"].sel(case=case))
        epsilon, source = restitution(store, case)
        which = "the restitution of the contact laws"
        if epsilon is not None:
            which = f"ε = {epsilon:.3g}, {source}"
        happens = f"largest impact force {1e-6 * peak:.4g} MN"
        if not peak > 0.0:
            happens = "no impact happens, both loads are the same"
        lines.append((None if peak > 0.0 else False, f"damping {case}: {which}; {happens}"))
    return lines
