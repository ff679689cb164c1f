"""The checks of the stage `building` in words: mesh, masses and modes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from impactfem.stages.check import Check
from impactfem.stages.stores import open_store

MASS = 1e-9
"""Largest relative difference of the masses of floors and base from the mass matrix."""
RESIDUAL = 1e-6
"""Largest residual of a mode that counts as converged."""


def building_checks(folder: Path) -> list[Check]:
    """The checks of the stage.

    Args:
        folder: The run's folder, with `building.nc`.
    """
    with open_store(folder / "building.nc") as store:
        mesh = [(False, f"mesh: {warning}") for warning in store["mesh_warning"].values]
        return [*mesh, _masses(store), _modes(store), *_bending(store)]


def _masses(store: xr.Dataset) -> Check:
    total = float(store["total_mass"].sel(direction="y"))
    floors = float(store["floor_mass"].sum())
    base = float(store["base_mass"])
    off = abs((floors + base) / total - 1.0)
    line = (
        f"building: {floors / 1e3:.0f} t on the floors and {base / 1e3:.0f} t at the base; "
        f"the mass matrix differs by {off:.1e}, {MASS:g} allowed"
    )
    return off < MASS, line


def _modes(store: xr.Dataset) -> Check:
    worst = float(store["residual"].max())
    frequency = store["frequency"].values
    line = (
        f"building: {frequency.size} modes from {frequency[0]:.3f} to {frequency[-1]:.3f} Hz, "
        f"none missed by the Sturm count, largest residual {worst:.1e}, "
        f"{RESIDUAL:g} allowed"
    )
    return worst < RESIDUAL, line


def _bending(store: xr.Dataset) -> list[Check]:
    direction = str(store.attrs["bending_direction"])
    chosen = store.sel(mode=store["bending_mode"].values)
    total = float(store["total_mass"].sel(direction=direction))
    share = chosen["effective_mass"].sel(direction=direction).values / total
    modes = ", ".join(
        f"{f:.3f} Hz ({100.0 * part:.1f} %)"
        for f, part in zip(chosen["frequency"].values, share, strict=True)
    )
    line = f"building: modes bending along {direction}, with their part of the mass: {modes}"
    return [(bool(np.size(share)), line if np.size(share) else f"{line}none")]
