"""Whether the stick that gives the impact forces sways as the 3D model that takes them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.stages.check import Check
from impactfem.stages.open_store import open_store

APART = 0.2
"""Largest relative difference of the two frequencies.

Sections taken as cracked have half the stiffness (EN 1998-1, 4.3.1(7)) and so a frequency 29 %
lower: models that differ in this, or in a factor or a unit, are told from models that differ in
mesh, rigid zones and joints."""


def stick_against_model(folder: Path) -> list[Check]:
    """The check of the fundamental modes along the direction that is shown.

    Nothing fits a stick to the 3D model unless the case asks for it. One that is too stiff or too
    soft hits at other times and with other speeds than the building that its forces are put on.

    Args:
        folder: The run's folder, with `building.nc` and `pounding.nc`.

    Returns:
        The check; nothing for a vertical direction, along which nothing bends.
    """
    with (
        open_store(folder / "building.nc") as building,
        open_store(folder / "pounding.nc") as sticks,
    ):
        name, direction = str(building.attrs["building"]), str(sticks.attrs["shown_direction"])
        if direction == "z":
            return []
        model, stick = _of_model(building, direction), _of_stick(sticks, name, direction)
    off = stick / model - 1.0
    text = (
        f"transient: the stick of {name} sways along {direction} at {stick:.3g} Hz, its 3D model "
        f"at {model:.3g} Hz: {100 * off:+.3g} %, {100 * APART:g} % asked"
    )
    if abs(off) <= APART:
        return [(True, text)]
    return [
        (
            False,
            f"{text}; the impact forces are those of another building than the 3D model: give the "
            "stick the stiffness of the 3D model, as a [calibration] with from_structure = true "
            "does",
        )
    ]


def _of_model(building: xr.Dataset, direction: str) -> float:
    # The most mass, not the lowest: a mode that twists may be lower, and moves some mass, too.
    mass = building["effective_mass"].sel(direction=direction).values
    return float(building["frequency"].values[np.argmax(mass)])


def _of_stick(sticks: xr.Dataset, name: str, direction: str) -> float:
    row = list(sticks["building"].values).index(name)
    along = list(sticks["mode_direction"].values).index(direction)
    mass = sticks["mode_effective_mass"].values[row, along]
    return float(sticks["mode_frequency"].values[row, np.nanargmax(mass)])
