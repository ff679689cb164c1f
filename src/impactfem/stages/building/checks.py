"""The checks of the stage `building` in words: mesh, masses and modes."""

from __future__ import annotations

from pathlib import Path

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
        checks: list[Check] = [(False, f"mesh: {text}") for text in store["mesh_warning"].values]
        total = store["total_mass"]
        floors, base = float(store["floor_mass"].sum()), float(store["base_mass"])
        off = abs((floors + base) / float(total.sel(direction="y")) - 1.0)
        line = (
            f"building: {floors / 1e3:.0f} t on the floors and {base / 1e3:.0f} t at the base; "
            f"the mass matrix differs by {off:.1e}, {MASS:g} allowed"
        )
        checks.append((off < MASS, line))
        worst, frequency = float(store["residual"].max()), store["frequency"].values
        line = (
            f"building: {frequency.size} modes from {frequency[0]:.3f} to {frequency[-1]:.3f} Hz, "
            f"none missed by the Sturm count, largest residual {worst:.1e}, {RESIDUAL:g} allowed"
        )
        checks.append((worst < RESIDUAL, line))
        direction = str(store.attrs["bending_direction"])
        bending = store.sel(mode=store["bending_mode"].values, direction=direction)
        share = bending["effective_mass"].values / float(total.sel(direction=direction))
        modes = ", ".join(
            f"{f:.3f} Hz ({100.0 * part:.1f} %)"
            for f, part in zip(bending["frequency"].values, share, strict=True)
        )
        line = f"building: modes bending along {direction}, with their part of the mass: "
        checks.append((bool(modes), line + (modes or "none")))
        return checks
